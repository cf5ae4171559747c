//! Densities that stress the sampling pass: what each kind of kernel makes of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sglow_measure::cache::{Cache, Key, sha256};
use sglow_oracle::fis::stress::{Random, Stress};
use sglow_runtime::density;
use sglow_runtime::device::Gpu;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Kernel, Solver};

use crate::failure::Result;
use crate::json::{Check, Relation, Report};
use crate::say;
use crate::shot::Numbers;
use crate::table;

/// Width and height of the densities that stress the sampling pass, and the number of kernels on them.
const STRESS_SIZE: u32 = 256;
const STRESS_COUNT: u32 = 1024;

/// The kernels, and how their size is found.
const KERNELS: [(Kernel, Solver); 3] = [
    (Kernel::Previous, Solver::None),
    (Kernel::Modified, Solver::Bisection),
    (Kernel::Modified, Solver::Bracketed),
];

/// What one method makes of one density.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(super) struct OnDensity {
    density: String,
    kernel: String,
    solver: String,
    /// Summed power of the lights over that of the photons.
    power_ratio: f64,
    /// Power of the brightest light times their number, over that of the photons: 1 is ideal.
    brightest: f64,
    milliseconds: f64,
}

/// Measures every kind of kernel on every density, or takes what was measured before.
pub(super) fn stress(
    gpu: &Gpu,
    package: &Package,
    numbers: &Numbers,
    cache: &Cache,
    report: &mut Report,
) -> Result<Vec<OnDensity>> {
    let mut texts = String::new();
    for id in package.variants().filter(|id| id.starts_with("sample-") || id.starts_with("mip-")) {
        texts.push_str(package.text(id)?);
    }
    let key = Key::new(&[("what", "densities"), ("iterations", &numbers.iterations.to_string())])
        .on("shaders", sha256(texts.as_bytes()))
        .on("adapter", &gpu.adapter.name)
        .on("driver", &gpu.adapter.driver);
    let rows = cache.get(&key, || measure(gpu, package, numbers))?;
    let mut table = table::new(["density", "kernel", "power", "brightest x N", "ms"]);
    for row in &rows {
        let what = if row.solver == "none" {
            row.kernel.clone()
        } else {
            format!("{} {}", row.kernel, row.solver)
        };
        table.add_row([
            row.density.clone(),
            what.clone(),
            format!("{:.4}", row.power_ratio),
            format!("{:.1}", row.brightest),
            format!("{:.3}", row.milliseconds),
        ]);
        if ["ring", "noise-2"].contains(&row.density.as_str()) {
            let error = (row.power_ratio - 1.0).abs();
            let (relation, note) = if row.kernel == Kernel::Modified.name() {
                (Relation::AtMost, "keeps the power")
            } else {
                (Relation::AtLeast, "does not keep it, which is why")
            };
            let text = format!("power of {what} kernels on {}, off by", row.density);
            report.check(Check::new(text, error, "of the total", relation, 0.03).note(note));
        }
    }
    say::line(format!(
        "\ndensities of {STRESS_SIZE} squared, {STRESS_COUNT} kernels, exact filter\n{table}"
    ));
    // Per density the kernels stand side by side, the previous ones first.
    for (index, (_, solver)) in KERNELS.into_iter().enumerate().skip(1) {
        let ratios: Vec<f64> = rows
            .chunks_exact(KERNELS.len())
            .map(|row| row[index].milliseconds / row[0].milliseconds)
            .collect();
        let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
        let most = ratios.iter().copied().fold(0.0, f64::max);
        say::line(format!(
            "sampling pass, modified by {solver} over previous: {least:.2} to {most:.2} times"
        ));
        report.detail(&format!("sampling_time_{solver}_over_previous"), ratios)?;
    }
    Ok(rows)
}

fn measure(gpu: &Gpu, package: &Package, numbers: &Numbers) -> Result<Vec<OnDensity>> {
    let mut rows = Vec::new();
    for (name, stress) in Stress::ALL {
        let density = stress.texels(STRESS_SIZE as usize, 1);
        // Power that follows the density but for a reflectance: with the density itself Eq. (5) is exact by construction.
        let mut random = Random::new(2);
        let power: Vec<f32> =
            density.iter().map(|weight| weight * (0.4 + 0.4 * random.uniform() as f32)).collect();
        for (kernel, solver) in KERNELS {
            let settings = Settings {
                rsm_size: STRESS_SIZE,
                count: STRESS_COUNT,
                iterations: numbers.iterations,
                kernel,
                solver,
                ..Settings::default()
            };
            let sampled = density::sample(gpu, package, &settings, &density, &power)?;
            let total = sampled.total.max(f64::MIN_POSITIVE);
            let brightest = sampled.powers.iter().copied().fold(0.0, f64::max);
            rows.push(OnDensity {
                density: name.to_owned(),
                kernel: kernel.name().to_owned(),
                solver: solver.name().to_owned(),
                power_ratio: sampled.powers.iter().sum::<f64>() / total,
                brightest: brightest * f64::from(STRESS_COUNT) / total,
                milliseconds: sampled.time.as_secs_f64() * 1e3,
            });
        }
    }
    Ok(rows)
}

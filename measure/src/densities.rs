//! Densities that stress the sampling pass: what each kind of kernel makes of them.

use sglow_oracle::fis::stress::{Random, Stress};
use sglow_renderer::density;
use sglow_renderer::device::Gpu;
use sglow_results::densities::{COUNT, OnDensity, SIZE};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Kernel, Solver};

use crate::cache::{Cache, Key, sha256};
use crate::frontier::subject::FrontierError;

/// The kernels, and how their size is found.
pub const KERNELS: [(Kernel, Solver); 3] = [
    (Kernel::Previous, Solver::None),
    (Kernel::Modified, Solver::Bisection),
    (Kernel::Modified, Solver::Bracketed),
];

/// Every kind of kernel on every density, the kinds side by side; or what was measured before.
///
/// # Errors
///
/// When a variant or the device does not allow it, or the result cannot be kept.
pub fn densities(
    gpu: &Gpu,
    package: &Package,
    iterations: u32,
    cache: &Cache,
) -> Result<Vec<OnDensity>, FrontierError> {
    let mut texts = String::new();
    for id in package.variants().filter(|id| id.starts_with("sample-") || id.starts_with("mip-")) {
        texts.push_str(package.text(id)?);
    }
    let key = Key::new(&[("what", "densities"), ("iterations", &iterations.to_string())])
        .on("shaders", sha256(texts.as_bytes()))
        .on("adapter", &gpu.adapter.name)
        .on("driver", &gpu.adapter.driver);
    cache.get(&key, || measure(gpu, package, iterations))
}

fn measure(gpu: &Gpu, package: &Package, iterations: u32) -> Result<Vec<OnDensity>, FrontierError> {
    let mut rows = Vec::new();
    for (name, stress) in Stress::ALL {
        let density = stress.texels(SIZE as usize, 1);
        // Power that follows the density but for a reflectance: with the density itself Eq. (5) is exact by construction.
        let mut random = Random::new(2);
        let power: Vec<f32> =
            density.iter().map(|weight| weight * (0.4 + 0.4 * random.uniform() as f32)).collect();
        for (kernel, solver) in KERNELS {
            let settings = Settings {
                map: SIZE,
                lights: COUNT,
                iterations,
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
                brightest: brightest * f64::from(COUNT) / total,
                milliseconds: sampled.time.as_secs_f64() * 1e3,
            });
        }
    }
    Ok(rows)
}

//! `report`: error against run time.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use serde::Serialize;
use sglow_oracle::fis::stress::{Random, Stress};
use sglow_oracle::metrics;
use sglow_oracle::shade::shade;
use sglow_oracle::surface::SurfaceTexel;
use sglow_runtime::density;
use sglow_runtime::device::Gpu;
use sglow_runtime::frame::{Frame, Renderer};
use sglow_runtime::package::Package;
use sglow_runtime::reference;
use sglow_runtime::settings::Settings;
use sglow_shaders::{
    Density, Diffuse, Draw, Filter, Kernel, Lobes, Ndf, Precision, Solver, Space, Specular,
    Visibility,
};

use crate::command::render::{brute_force, package, paths};
use crate::failure::{Failure, Result};
use crate::json::{Check, Relation, Report};
use crate::progress;
use crate::say;
use crate::shot::{self, Numbers, Shot};
use crate::table;

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask report --scene cornell
  cargo xtask report --scene cornell --scene caustic --size 240x135 --out out/report

For each scene, every variant of the sampling and of the shading pass is rendered with the others at their defaults:
its error against virtual point lights (without visibility), its rounding against the oracle, and the time of its pass.
Then the sampling pass meets densities that stress it. Everything also stands in report.json.";

/// Options of `report`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A built-in scene, or a file: .gltf, .glb, .obj; may be given more than once
    #[arg(long, value_name = "FILE|NAME", default_value = "cornell-glossy")]
    scene: Vec<String>,
    /// Pixels of the pictures that are compared
    #[arg(long, value_name = "WxH", default_value = "160x90", value_parser = shot::size)]
    size: [u32; 2],
    /// The folder that receives report.json
    #[arg(long, value_name = "DIR", default_value = "out/report")]
    out: PathBuf,
    /// A package that `gen-shaders --out` wrote [default: made from the library, every variant]
    #[arg(long, value_name = "DIR")]
    package: Option<PathBuf>,
    #[command(flatten)]
    numbers: Numbers,
}

/// Timed frames; one more before them compiles.
const RUNS: usize = 5;

/// Width and height of the densities that stress the sampling pass, and the number of kernels on them.
const STRESS_SIZE: u32 = 256;
const STRESS_COUNT: u32 = 1024;

/// A median and its spread.
#[derive(Clone, Copy, Debug, Serialize)]
struct Time {
    median_ms: f64,
    minimum_ms: f64,
    maximum_ms: f64,
}

impl Time {
    fn of(mut times: Vec<Duration>) -> Option<Self> {
        times.sort();
        let milliseconds = |time: &Duration| time.as_secs_f64() * 1e3;
        Some(Self {
            median_ms: milliseconds(times.get(times.len() / 2)?),
            minimum_ms: milliseconds(times.first()?),
            maximum_ms: milliseconds(times.last()?),
        })
    }
}

/// One variant of one pass in one scene.
#[derive(Clone, Debug, Serialize)]
struct Measurement {
    variant: String,
    /// Whether the scene needs what the variant offers.
    needed: bool,
    /// Against virtual point lights; relative to the mean of the reference.
    picture_rmse_over_mean: f64,
    picture_relative_mse: f64,
    picture_bias: f64,
    /// Device against oracle with the same lights, RMS over mean on a sample of pixels.
    /// None with visibility, whose maps the tests hold.
    rounding_rms_over_mean: Option<f64>,
    time: Time,
}

/// Measures.
///
/// # Errors
///
/// When a scene, a variant or the device does not allow it, or a promise is not kept.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let package = package(arguments.package.as_deref())?;
    let shots = arguments
        .scene
        .iter()
        .map(|scene| Shot::new(scene, &[], arguments.size, &arguments.numbers))
        .collect::<Result<Vec<_>>>()?;
    let gpu = shot::gpu(&arguments.numbers)?;
    let mut report = Report::new();
    report.adapter.clone_from(&gpu.adapter.name);
    report.driver.clone_from(&gpu.adapter.driver);
    let mut scenes = BTreeMap::new();
    for shot in &shots {
        let measured = scene(&gpu, &package, shot, &mut report)?;
        scenes.insert(shot.scene.name.clone(), measured);
    }
    report.detail("scenes", scenes)?;
    let densities = stress(&gpu, &package, &arguments.numbers, &mut report)?;
    report.detail("densities", densities)?;
    report.detail("does_not_show", DOES_NOT_SHOW)?;
    say::line(format!("\n{}", report.table()));
    say::line(format!(
        "{}, {}; medians of {RUNS}. {DOES_NOT_SHOW}",
        gpu.adapter.name, gpu.adapter.driver
    ));
    let path = arguments.out.join("report.json");
    report.write(&path)?;
    say::line(path.display());
    report.verdict()
}

/// What must not be concluded.
const DOES_NOT_SHOW: &str = "But for the variants with visibility, whose reference are paths with it, neither side has \
                             visibility, so that the error is that of the lights and of their reflection alone; the \
                             reference has the discretisation of the same map. Times on a \
                             software driver compare variants and promise nothing about GPUs.";

/// The kernels, and how their size is found.
const KERNELS: [(Kernel, Solver); 3] = [
    (Kernel::Previous, Solver::None),
    (Kernel::Modified, Solver::Bisection),
    (Kernel::Modified, Solver::Bracketed),
];

/// The variants of both passes, those that this scene needs first: every one of the sampling pass; of the shading pass
/// those that differ from the scene's own in the diffuse or in the specular form, in the lobes, in the precision or in
/// visibility. Densities, draws and clusters take the place of the sampling pass's own, one at a time.
fn variants(base: &Settings) -> Vec<(bool, bool, Settings)> {
    let mut all = Vec::new();
    let full = base.specular != Specular::None;
    for lobes in [Lobes::Both, Lobes::Diffuse] {
        for (kernel, solver) in KERNELS {
            for filter in Filter::ALL {
                for precision in Precision::ALL {
                    let needed = lobes == base.lobes;
                    let settings =
                        Settings { kernel, solver, filter, lobes, precision, ..base.clone() };
                    all.push((true, needed, settings));
                }
            }
        }
    }
    let others = [
        Settings { density: Density::Reflectance, ..base.clone() },
        Settings { density: Density::Bidirectional, ..base.clone() },
        Settings { draw: Draw::Metropolis, ..base.clone() },
        Settings { space: Space::Image, ..base.clone() },
        Settings { space: Space::World, ..base.clone() },
    ];
    all.extend(others.map(|settings| (true, true, settings)));
    for visibility in [Visibility::ShadowMap, Visibility::Imperfect] {
        all.push((false, true, Settings { visibility, ..base.clone() }));
    }
    for lobes in [Lobes::Both, Lobes::Diffuse] {
        let mut forms = vec![Settings { precision: Precision::F16, ..base.clone() }];
        forms.extend(Diffuse::ALL.map(|diffuse| Settings { diffuse, ..base.clone() }));
        for specular in Specular::ALL {
            forms.extend(Ndf::ALL.map(|ndf| Settings { specular, ndf, ..base.clone() }));
        }
        let mut seen = BTreeSet::new();
        for form in forms {
            let settings = Settings { lobes, ..form };
            let needed = lobes == base.lobes && (full || settings.specular == Specular::None);
            if settings.shade().excluded().is_none() && seen.insert(settings.shade().id()) {
                all.push((false, needed, settings));
            }
        }
    }
    all.sort_by_key(|&(sampling, needed, _)| (!sampling, !needed));
    all
}

/// What a measurement is called: its variant, and what else is unlike the default.
fn name(sampling: bool, settings: &Settings) -> String {
    if !sampling {
        return settings.shade().id().to_string();
    }
    let id = match settings.space {
        Space::None => settings.sample().id().to_string(),
        space @ (Space::Image | Space::World) => format!("k-means clusters, space {space}"),
    };
    match settings.density {
        Density::Power => id,
        density @ (Density::Reflectance | Density::Bidirectional) => {
            format!("{id}, density {density}")
        }
    }
}

/// Paths per pixel of the reference with visibility.
const PATHS: u32 = 256;

fn scene(
    gpu: &Gpu,
    package: &Package,
    shot: &Shot,
    report: &mut Report,
) -> Result<serde_json::Value> {
    let base = &shot.settings;
    let full = base.specular != Specular::None;
    let variants: Vec<_> = variants(base)
        .into_iter()
        .filter(|(_, _, settings)| settings.filter == Filter::Exact || gpu.filters_float32())
        .collect();
    let mut references: BTreeMap<(bool, bool), Frame> = BTreeMap::new();
    let bar = progress::bar(format!("{}: variants", shot.scene.name), variants.len());
    let mut tables = [
        table::new(["sampling variant", "needed", "RMSE", "rel. MSE", "bias", "rounding", "ms"]),
        table::new(["shading variant", "needed", "RMSE", "rel. MSE", "bias", "rounding", "ms"]),
    ];
    let mut measurements = [Vec::new(), Vec::new()];
    let mut clock = String::new();
    let mut not_finite = 0;
    for (sampling, needed, settings) in variants {
        let renderer = Renderer::new(gpu, package, &shot.scene, &settings, 0)?;
        renderer.render()?;
        let mut times = Vec::new();
        let pass = if sampling { "sample" } else { "shade" };
        for _ in 0..RUNS {
            let frame = renderer.render()?;
            clock = frame.clock.to_string();
            // Chains and clusters have passes of their own in the sampling pass's place.
            let counts = |label: &str| {
                label == pass || sampling && (label == "centres" || label.starts_with("cluster "))
            };
            times.push(frame.passes.iter().filter(|one| counts(one.0)).map(|one| one.1).sum());
        }
        let frame = renderer.read()?;
        // Without specular reflection in the scene one reference serves all.
        let beckmann = full && settings.ndf == Ndf::Beckmann;
        let visible = settings.visibility != Visibility::None;
        if let Entry::Vacant(entry) = references.entry((beckmann, visible)) {
            // The reference holds both terms, whatever this variant renders.
            let all = Frame {
                indirect_diffuse: Some(Vec::new()),
                indirect_specular: Some(Vec::new()),
                ..frame.clone()
            };
            entry.insert(if visible {
                paths(&renderer, &shot.scene, &all, PATHS)?.frame
            } else {
                brute_force(&renderer, &all)?
            });
        }
        let (ours, theirs) = terms(&frame, &references[&(beckmann, visible)]);
        let compared = metrics::compare(&ours, &theirs)
            .ok_or_else(|| Failure::new("there is nothing to compare"))?;
        not_finite += compared.not_finite;
        let over_mean = |value: f64| {
            if compared.reference_mean > 0.0 { value / compared.reference_mean } else { value }
        };
        let time =
            Time::of(times).ok_or_else(|| Failure::new(format!("pass {pass} has no time")))?;
        let measurement = Measurement {
            variant: name(sampling, &settings),
            needed,
            picture_rmse_over_mean: over_mean(compared.rmse),
            picture_relative_mse: compared.relative_mse,
            picture_bias: compared.bias,
            rounding_rms_over_mean: if visible {
                None
            } else {
                Some(rounding(gpu, &renderer, &frame)?)
            },
            time,
        };
        let which = usize::from(!sampling);
        tables[which].add_row([
            measurement.variant.clone(),
            if needed { "yes" } else { "no" }.to_owned(),
            percent(measurement.picture_rmse_over_mean),
            format!("{:.2e}", measurement.picture_relative_mse),
            percent(measurement.picture_bias),
            measurement
                .rounding_rms_over_mean
                .map_or_else(|| "–".to_owned(), |rounding| format!("{rounding:.1e}")),
            format!("{:.3} ({:.3}-{:.3})", time.median_ms, time.minimum_ms, time.maximum_ms),
        ]);
        measurements[which].push(measurement);
        bar.inc(1);
    }
    bar.finish_and_clear();
    report.check(Check::new(
        format!("{}: numbers that are not finite, in all variants", shot.scene.name),
        not_finite as f64,
        "numbers",
        Relation::Equal,
        0.0,
    ));
    if references.values().all(is_dark) {
        say::line(format!(
            "\n{}: no light reaches anything that the camera sees; indirect light is black, and errors are absolute",
            shot.scene.name
        ));
    }
    let [width, height] = base.size;
    say::line(format!(
        "\n{}: {} triangles, {width} x {height}, map of {} squared, {} lights, {clock}",
        shot.scene.name,
        shot.scene.triangle_count(),
        base.rsm_size,
        base.count
    ));
    for table in &tables {
        say::line(format!("{table}\n"));
    }
    let [sampling, shading] = measurements;
    Ok(serde_json::json!({
        "size": base.size,
        "rsm_size": base.rsm_size,
        "lights": base.count,
        "iterations": base.iterations,
        "clock": clock,
        "dark": references.values().all(is_dark),
        "sampling": sampling,
        "shading": shading,
    }))
}

/// Whether a frame has no indirect light.
fn is_dark(frame: &Frame) -> bool {
    let terms = [&frame.indirect_diffuse, &frame.indirect_specular];
    terms.into_iter().flatten().flatten().all(|pixel| pixel[..3] == [0.0; 3])
}

/// The numbers of the terms that a frame has, and of the same terms of its reference. Pixels without a surface count
/// in neither.
fn terms(ours: &Frame, theirs: &Frame) -> (Vec<f32>, Vec<f32>) {
    let (mut left, mut right) = (Vec::new(), Vec::new());
    for index in 0..ours.direct.len() {
        if ours.gbuffer.position[index][3] < 0.0 {
            continue;
        }
        for channel in 0..3 {
            let mut sums = [0.0; 2];
            for (mine, other) in [
                (&ours.indirect_diffuse, &theirs.indirect_diffuse),
                (&ours.indirect_specular, &theirs.indirect_specular),
            ] {
                if let (Some(mine), Some(other)) = (mine, other) {
                    sums[0] += mine[index][channel];
                    sums[1] += other[index][channel];
                }
            }
            left.push(sums[0]);
            right.push(sums[1]);
        }
    }
    (left, right)
}

/// Reflection on the device against the oracle's f64, with the lights that the device made: RMS over mean, on 64
/// pixels spread over the picture.
fn rounding(gpu: &Gpu, renderer: &Renderer<'_>, frame: &Frame) -> Result<f64> {
    let indirect = renderer.indirect();
    let lights = reference::lights::<f64>(gpu, indirect)?;
    let model = reference::model(indirect.settings());
    let eye = reference::vector(renderer.eye());
    let surfaces: Vec<SurfaceTexel> = reference::texels(&frame.gbuffer);
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for index in (0..surfaces.len()).step_by(surfaces.len().div_ceil(64)) {
        let reflected = shade(&surfaces[index], eye, lights.iter().copied(), &model);
        for (pixels, expected) in [
            (&frame.indirect_diffuse, reflected.diffuse),
            (&frame.indirect_specular, reflected.specular),
        ] {
            if let Some(pixels) = pixels {
                ours.extend(pixels[index][..3].iter().copied());
                theirs.extend(expected.to_array());
            }
        }
    }
    let compared = metrics::compare(&ours, &theirs)
        .ok_or_else(|| Failure::new("the sample of pixels is empty"))?;
    Ok(if compared.reference_mean > 0.0 {
        compared.rmse / compared.reference_mean
    } else {
        compared.rmse
    })
}

/// What one method makes of one density.
#[derive(Clone, Debug, Serialize)]
struct OnDensity {
    density: &'static str,
    kernel: &'static str,
    solver: &'static str,
    /// Summed power of the lights over that of the photons.
    power_ratio: f64,
    /// Power of the brightest light times their number, over that of the photons: 1 is ideal.
    brightest: f64,
    milliseconds: f64,
}

fn stress(
    gpu: &Gpu,
    package: &Package,
    numbers: &Numbers,
    report: &mut Report,
) -> Result<Vec<OnDensity>> {
    let mut rows = Vec::new();
    let mut table = table::new(["density", "kernel", "power", "brightest x N", "ms"]);
    for (name, stress) in Stress::ALL {
        let density = stress.texels(STRESS_SIZE as usize, 1);
        // Power that follows the density but for a reflectance: with the density itself Eq. (5) is exact by construction.
        let mut random = Random::new(2);
        let power: Vec<f32> =
            density.iter().map(|weight| weight * (0.4 + 0.4 * random.uniform() as f32)).collect();
        for (kernel, solver) in KERNELS {
            let what = match kernel {
                Kernel::Previous => kernel.to_string(),
                Kernel::Modified => format!("{kernel} {solver}"),
            };
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
            let row = OnDensity {
                density: name,
                kernel: kernel.name(),
                solver: solver.name(),
                power_ratio: sampled.powers.iter().sum::<f64>() / total,
                brightest: brightest * f64::from(STRESS_COUNT) / total,
                milliseconds: sampled.time.as_secs_f64() * 1e3,
            };
            table.add_row([
                name.to_owned(),
                what.clone(),
                format!("{:.4}", row.power_ratio),
                format!("{:.1}", row.brightest),
                format!("{:.3}", row.milliseconds),
            ]);
            if ["ring", "noise-2"].contains(&name) {
                let error = (row.power_ratio - 1.0).abs();
                let (relation, note) = match kernel {
                    Kernel::Modified => (Relation::AtMost, "keeps the power"),
                    Kernel::Previous => (Relation::AtLeast, "does not keep it, which is why"),
                };
                let text = format!("power of {what} kernels on {name}, off by");
                report.check(Check::new(text, error, "of the total", relation, 0.03).note(note));
            }
            rows.push(row);
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

/// A share as a person reads it.
fn percent(share: f64) -> String {
    if share.is_finite() { format!("{:+.2} %", 100.0 * share) } else { "no light".to_owned() }
}

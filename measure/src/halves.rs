//! What 16-bit precision saves and costs: a scene rendered with both precisions, lights and pictures compared.

use std::time::Duration;

use sglow_oracle::vsgl::{Lobe, Vsgl};
use sglow_oracle::{metrics, vmf};
use sglow_renderer::device::Gpu;
use sglow_renderer::frame::{Frame, FrameError, Renderer, Times};
use sglow_renderer::{readback, reference};
use sglow_results::progress::Progress;
use sglow_results::stability::halves::{HalfCheck, HalvesReport};
use sglow_results::stability::report::ExtremeReport;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shaders::Precision;

use crate::bound::{HALF_MEAN_LENGTH, HALF_NOT_FINITE, HALF_PICTURE, HALF_POWER};
use crate::extreme::{self, ExtremeError};

/// Built-in scenes that are rendered in both precisions: diffuse, glossy, and large with a sun.
pub const SCENES: [&str; 3] = ["cornell", "cornell-glossy", "atrium"];

/// The whole pipeline in every extreme case and in both precisions.
///
/// # Errors
///
/// When a scene does not render.
pub fn pipeline(
    gpu: &Gpu,
    package: &Package,
    progress: &dyn Progress,
) -> Result<(Vec<ExtremeReport>, Vec<HalvesReport>), ExtremeError> {
    let names = extreme::names();
    let (mut extremes, mut halves) = (Vec::new(), Vec::new());
    progress.start("extremes", names.len() + SCENES.len());
    for name in names {
        extremes.extend(extreme::attempt(gpu, package, name)?);
        progress.done(extremes.len());
    }
    for scene in SCENES {
        halves.push(in_scene(gpu, package, scene)?);
        progress.done(extremes.len() + halves.len());
    }
    progress.end();
    Ok((extremes, halves))
}

/// Renders a built-in scene in both precisions.
///
/// # Errors
///
/// When there is no such scene, or it does not render.
pub fn in_scene(
    gpu: &Gpu,
    package: &Package,
    scene: &'static str,
) -> Result<HalvesReport, ExtremeError> {
    let settings = Settings { size: [96, 54], ..Settings::default() };
    let halved = measure(gpu, package, &Scene::builtin(scene)?, &settings, 5)?;
    let check = |bound: HalfCheck, value: f64| HalfCheck { value, ..bound };
    let milliseconds = |time: Duration| time.as_secs_f64() * 1e3;
    let passes = halved.passes.iter();
    Ok(HalvesReport {
        scene,
        bytes: halved.bytes,
        axis: halved.direction,
        passes: passes
            .map(|(pass, times)| (pass.clone(), times.map(|time| time.map(milliseconds))))
            .collect(),
        checks: vec![
            check(HALF_PICTURE, halved.picture),
            check(HALF_POWER, halved.power),
            check(HALF_MEAN_LENGTH, halved.mean_length),
            check(HALF_NOT_FINITE, halved.not_finite as f64),
        ],
    })
}

/// What f16 leaves of f32, in this order wherever there are two.
#[derive(Clone, Debug)]
pub struct Halved {
    /// Bytes of moments and density with their mips, and of the virtual lights.
    pub bytes: [u64; 2],
    /// The largest relative error of a channel of a lobe's power.
    pub power: f64,
    /// The largest angle between the axes of a lobe whose sharpness is at least 1, in radians.
    pub direction: f64,
    /// The largest error of the mean length of a lobe's directions.
    pub mean_length: f64,
    /// The indirect light's RMSE over its mean.
    pub picture: f64,
    /// Numbers of the f16 picture that are not finite.
    pub not_finite: usize,
    /// The median time of each pass; none of a pass that is left out.
    pub passes: Vec<(String, [Option<Duration>; 2])>,
}

/// Renders a scene with both precisions, `repeats` times after a warm-up, lit by its first light.
///
/// Lobes and channels with less than a millionth of the mean power of a light's lobe are not compared.
pub fn measure(
    gpu: &Gpu,
    package: &Package,
    scene: &Scene,
    settings: &Settings,
    repeats: usize,
) -> Result<Halved, FrameError> {
    let [full, halved] = [Precision::F32, Precision::F16]
        .map(|precision| Settings { precision, ..settings.clone() })
        .map(|settings| Renderer::new(gpu, package, scene, &settings, 0));
    let renderers = [full?, halved?];
    let mut times = [Vec::new(), Vec::new()];
    for repeat in 0..=repeats {
        // In turns, so that what else the machine does falls upon both; the first ones compile.
        for (renderer, times) in renderers.iter().zip(&mut times) {
            let time = renderer.render()?;
            if repeat > 0 {
                times.push(time);
            }
        }
    }
    let mut passes: Vec<(String, [Option<Duration>; 2])> = Vec::new();
    for (index, times) in times.iter().enumerate() {
        for (label, time) in medians(times) {
            let at = passes.iter().position(|pass| pass.0 == label).unwrap_or_else(|| {
                passes.push((label, [None; 2]));
                passes.len() - 1
            });
            passes[at].1[index] = Some(time);
        }
    }
    let mut bytes = [0; 2];
    let mut lights = Vec::new();
    let mut pictures = Vec::new();
    for (renderer, bytes) in renderers.iter().zip(&mut bytes) {
        let kept = ["moments", "half_moments", "density", "vsgls"];
        let all = readback::bytes(renderer.indirect());
        *bytes = all.iter().filter(|one| kept.contains(&one.0.as_str())).map(|one| one.1).sum();
        lights.push(reference::lights::<f64>(gpu, renderer.indirect())?);
        pictures.push(indirect(&renderer.read()?));
    }
    let [power, direction, mean_length] = compare(&lights[0], &lights[1]);
    let (picture, not_finite) = match metrics::compare_exact(&pictures[1], &pictures[0]) {
        Some(metrics) => (metrics.rmse_over_mean().value, metrics.not_finite),
        None => (f64::INFINITY, 3 * pictures[1].len()),
    };
    Ok(Halved { bytes, power, direction, mean_length, picture, not_finite, passes })
}

fn medians(times: &[Times]) -> Vec<(String, Duration)> {
    let labels = times.first().map(|times| times.passes.as_slice()).unwrap_or_default();
    let median = |index: usize| {
        let mut all: Vec<_> = times.iter().map(|times| times.passes[index].1).collect();
        all.sort();
        all[all.len() / 2]
    };
    labels.iter().enumerate().map(|(index, pass)| (pass.0.clone(), median(index))).collect()
}

/// Diffusely and specularly reflected indirect light.
fn indirect(frame: &Frame) -> Vec<[f64; 3]> {
    let mut sum = vec![[0.0; 3]; frame.radiance.len()];
    for pixels in [&frame.indirect_diffuse, &frame.indirect_specular].into_iter().flatten() {
        for (sum, pixel) in sum.iter_mut().zip(pixels) {
            sum.iter_mut().zip(pixel).for_each(|(sum, &channel)| *sum += f64::from(channel));
        }
    }
    sum
}

/// The largest errors of power, direction and mean length.
fn compare(full: &[Vsgl], halved: &[Vsgl]) -> [f64; 3] {
    let lobes = |lights: &[Vsgl]| -> Vec<Lobe> {
        lights
            .iter()
            .flat_map(|light| std::iter::once(light.diffuse).chain(light.specular))
            .collect()
    };
    let (full, halved) = (lobes(full), lobes(halved));
    let mean = full.iter().map(|lobe| lobe.power().luminance()).sum::<f64>() / full.len() as f64;
    let mut largest = [0.0_f64; 3];
    for (full, halved) in full.iter().zip(&halved) {
        let powers = full.power().to_array().into_iter().zip(halved.power().to_array());
        for (full, halved) in powers.filter(|pair| pair.0 > 1e-6 * mean) {
            largest[0] = largest[0].max((halved / full - 1.0).abs());
        }
        if full.power().luminance() > 1e-6 * mean {
            if full.sharpness >= 1.0 {
                let chord = (full.axis.normalized() - halved.axis.normalized()).length();
                largest[1] = largest[1].max(2.0 * (0.5 * chord).min(1.0).asin());
            }
            let [halved, full] = [halved, full].map(|lobe| vmf::mean_length(lobe.sharpness));
            largest[2] = largest[2].max((halved - full).abs());
        }
    }
    largest
}

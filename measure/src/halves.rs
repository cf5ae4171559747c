//! What 16-bit precision saves and costs in whole scenes.

use serde::Serialize;
use sglow_runtime::device::Gpu;
use sglow_runtime::halves;
use sglow_runtime::package::Package;
use sglow_runtime::scene::Scene;
use sglow_runtime::settings::Settings;

use crate::bound::{HALF_NOT_FINITE, HALF_PICTURE, HALF_POWER, HALF_SHARPNESS};
use crate::extreme::ExtremeError;

/// What f16 leaves of f32 in one scene. Where there are two numbers they are of f32 and of f16.
#[derive(Clone, Debug, Serialize)]
pub struct HalvesReport {
    /// The scene.
    pub scene: &'static str,
    /// Bytes of moments and density with their mips, and of the virtual lights.
    pub bytes: [u64; 2],
    /// The largest angle between the axes of a lobe whose sharpness is at least 1, in radians.
    pub axis: f64,
    /// Milliseconds of each pass, median; nothing of a pass that is left out.
    pub passes: Vec<(&'static str, [Option<f64>; 2])>,
    /// Each error against its bound.
    pub checks: Vec<HalfCheck>,
}

/// An error against its bound.
#[derive(Clone, Debug, Serialize)]
pub struct HalfCheck {
    /// What is wrong by so much.
    pub name: &'static str,
    /// By how much.
    pub value: f64,
    /// The most that it may be.
    pub at_most: f64,
    /// Why this much and no more.
    pub reason: &'static str,
}

impl HalfCheck {
    /// Whether the bound holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.value <= self.at_most
    }
}

/// Built-in scenes that are rendered in both precisions: diffuse, glossy, and large with a sun.
pub const SCENES: [&str; 3] = ["cornell", "cornell-glossy", "atrium"];

/// Renders a built-in scene in both precisions.
///
/// # Errors
///
/// When there is no such scene, or it does not render.
pub fn compare(
    gpu: &Gpu,
    package: &Package,
    scene: &'static str,
) -> Result<HalvesReport, ExtremeError> {
    let settings = Settings { size: [96, 54], ..Settings::default() };
    let halved = halves::measure(gpu, package, &Scene::builtin(scene)?, &settings, 5)?;
    let check = |bound: HalfCheck, value: f64| HalfCheck { value, ..bound };
    let milliseconds = |time: std::time::Duration| time.as_secs_f64() * 1e3;
    let passes = halved.passes.iter();
    Ok(HalvesReport {
        scene,
        bytes: halved.bytes,
        axis: halved.direction,
        passes: passes
            .map(|(pass, times)| (*pass, times.map(|time| time.map(milliseconds))))
            .collect(),
        checks: vec![
            check(HALF_PICTURE, halved.picture),
            check(HALF_POWER, halved.power),
            check(HALF_SHARPNESS, halved.sharpness),
            check(HALF_NOT_FINITE, halved.not_finite as f64),
        ],
    })
}

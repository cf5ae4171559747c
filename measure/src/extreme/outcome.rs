//! Renders an extreme case, and compares its mean with the expected one.

use sglow_oracle::Vector3;
use sglow_oracle::vsgl::{Lobe, Vsgl};
use sglow_renderer::device::{DeviceError, Gpu};
use sglow_renderer::frame::{Frame, FrameError, Renderer};
use sglow_renderer::reference;
use sglow_results::stability::report::ExtremeVariant;
use sglow_runtime::package::{Package, PackageError};
use sglow_runtime::settings::{Settings, SettingsError};
use sglow_scene::{Scene, SceneError};
use thiserror::Error;

/// Why a case could not be tried.
#[derive(Debug, Error)]
pub enum ExtremeError {
    /// A built-in scene is not there.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A variant cannot be set.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// It does not render.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The device fails.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The package lacks a variant.
    #[error(transparent)]
    Package(#[from] PackageError),
}

/// Statistics of a frame.
pub(super) struct Outcome {
    pub(super) not_finite: usize,
    pub(super) negative: usize,
    /// The mean of the indirect light.
    pub(super) mean: f64,
}

/// Renders a scene.
pub(super) fn render(
    gpu: &Gpu,
    package: &Package,
    scene: &Scene,
    settings: &Settings,
) -> Result<Outcome, ExtremeError> {
    let renderer = Renderer::new(gpu, package, scene, settings, 0)?;
    renderer.render()?;
    let frame = renderer.read()?;
    let mut outcome = of_frame(&frame);
    let lights = reference::lights::<f64>(gpu, renderer.indirect())?;
    outcome.not_finite += lights.iter().map(not_finite).sum::<usize>();
    Ok(outcome)
}

/// Numbers of a light that are not finite.
fn not_finite(light: &Vsgl) -> usize {
    let vector = |vector: Vector3| vector.to_array();
    let lobe = |lobe: &Lobe| {
        [&[lobe.sharpness][..], &vector(lobe.axis), &vector(lobe.coefficient)].concat()
    };
    let lobes = core::iter::once(&light.diffuse).chain(&light.specular).flat_map(lobe);
    let place = vector(light.position).into_iter().chain([light.variance]);
    place.chain(lobes).filter(|number| !number.is_finite()).count()
}

fn of_frame(frame: &Frame) -> Outcome {
    let mut outcome = Outcome { not_finite: 0, negative: 0, mean: 0.0 };
    let mut count = 0_u32;
    let layers = [&frame.indirect_diffuse, &frame.indirect_specular];
    for (index, radiance) in frame.radiance.iter().enumerate() {
        let parts = layers.into_iter().flatten().flat_map(|layer| &layer[index][..3]);
        for value in parts.clone().chain(&radiance[..3]) {
            outcome.not_finite += usize::from(!value.is_finite());
            outcome.negative += usize::from(*value < 0.0);
        }
        outcome.mean += parts.map(|value| f64::from(*value)).sum::<f64>() / 3.0;
        count += 1;
    }
    outcome.mean /= f64::from(count.max(1));
    outcome
}

/// Compares the mean of an outcome with the expected one; `bound` is the maximum relative deviation.
pub(super) fn verdict(
    name: String,
    outcome: &Outcome,
    expected: Option<f64>,
    bound: Option<f64>,
) -> ExtremeVariant {
    let deviation = expected
        .map(|expected| if expected == 0.0 { outcome.mean } else { outcome.mean / expected - 1.0 });
    let within = match (deviation, bound) {
        (Some(deviation), Some(bound)) => deviation.abs() <= bound,
        _ => true,
    };
    ExtremeVariant {
        variant: name,
        not_finite: outcome.not_finite,
        negative: outcome.negative,
        mean: outcome.mean,
        expected,
        deviation,
        holds: outcome.not_finite == 0 && outcome.negative == 0 && within,
    }
}

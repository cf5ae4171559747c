//! Where filtering kernels lie on a density, and what lies within them.

use sglow_oracle::fis::{Footprints, all_roots, kernel_mass};
use sglow_oracle::rsm::{Pyramid, PyramidError};
use sglow_renderer::density;
use sglow_renderer::device::Gpu;
use sglow_renderer::frame::FrameError;
use sglow_renderer::request::derivation::contradictions;
use sglow_results::kernels::{Placed, Sizing};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::Kernel;
use thiserror::Error;

/// Errors of kernels on a density.
#[derive(Debug, Error)]
pub enum KernelsError {
    /// Settings that there are not, or that are not possible.
    #[error("{}", .0.join("\n"))]
    Settings(Vec<String>),
    /// The density has no mip chain.
    #[error(transparent)]
    Size(#[from] PyramidError),
    /// The device or a variant does not allow it.
    #[error(transparent)]
    Frame(#[from] FrameError),
}

/// The requested settings, `axis=value` each, and the kinds of kernels: the one that is named, or all.
///
/// # Errors
///
/// All that is wrong.
pub fn requested(base: Settings, set: &[String]) -> Result<(Settings, Vec<Kernel>), KernelsError> {
    let mut settings = base;
    let mut wrong = contradictions(set.iter());
    let mut kinds = Kernel::ALL.to_vec();
    for setting in set {
        match setting.split_once('=') {
            None => wrong.push(format!("`{setting}` is not AXIS=VALUE")),
            Some((axis, value)) => match settings.set(axis, value) {
                Err(error) => wrong.push(error.to_string()),
                Ok(()) if axis == "kernel" => kinds = vec![settings.kernel],
                Ok(()) => {}
            },
        }
    }
    if wrong.is_empty() { Ok((settings, kinds)) } else { Err(KernelsError::Settings(wrong)) }
}

/// Draws kernels on a density of any size and looks at what lies within each.
///
/// # Errors
///
/// When a variant or the device does not allow it.
pub fn place(
    gpu: &Gpu,
    package: &Package,
    settings: &Settings,
    size: [usize; 2],
    texels: &[f32],
) -> Result<Sizing, KernelsError> {
    let (side, square) = density::padded(size, texels);
    let pyramid = &Pyramid::build(side, square.iter().copied().map(f64::from).collect())?;
    let sampled = density::sample(gpu, package, settings, &square, &square)?;
    let footprints = Footprints::new(size, texels);
    let (count, side) = (f64::from(settings.lights), f64::from(settings.map));
    // Without density every share of it is 0.
    let share = |value: f64, whole: f64| if whole > 0.0 { value / whole } else { 0.0 };
    let kernels: Vec<Placed> = sampled
        .kernels
        .iter()
        .zip(&sampled.powers)
        .map(|(kernel, &power)| {
            let place = kernel.centre.map(f64::from);
            let level = f64::from(kernel.level);
            let centre = place.map(|part| part * side);
            Placed {
                centre,
                level,
                side: level.exp2(),
                mass: count * share(footprints.mass(centre, level.exp2()), footprints.total()),
                filtered_mass: count * kernel_mass(pyramid, place, level),
                weight: f64::from(kernel.scale),
                power: share(power, sampled.total),
                roots: all_roots(pyramid, place, settings.lights, f64::from(settings.size_factor)),
            }
        })
        .collect();
    let largest = |value: fn(&Placed) -> f64| kernels.iter().map(value).fold(0.0, f64::max);
    let of_all = |test: fn(&Placed) -> bool| {
        kernels.iter().filter(|one| test(one)).count() as f64 / kernels.len().max(1) as f64
    };
    Ok(Sizing {
        kernel: settings.kernel.name(),
        mass_variation: variation(kernels.iter().map(|one| one.mass)),
        largest_mass: largest(|one| one.mass),
        brightest: count * largest(|one| one.power),
        power: kernels.iter().map(|one| one.power).sum(),
        without_root: of_all(|one| one.roots.is_empty()),
        several_roots: of_all(|one| one.roots.len() > 1),
        kernels,
    })
}

/// Standard deviation over mean; 0 where the mean is.
fn variation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    let variance = values.map(|value| (value - mean).powi(2)).sum::<f64>() / count;
    if mean > 0.0 { variance.sqrt() / mean } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_kinds_are_shown_unless_one_is_requested() {
        let of = |set: &[&str]| {
            let set: Vec<_> = set.iter().map(|&word| word.to_owned()).collect();
            requested(Settings { lights: 8, ..Settings::default() }, &set)
        };
        let (both, kinds) = of(&[]).unwrap();
        assert_eq!((both.lights, kinds), (8, vec![Kernel::Previous, Kernel::Modified]));
        assert_eq!(of(&["kernel=previous"]).unwrap().1, [Kernel::Previous]);
        let text = of(&["kernel=cubic", "colour=red", "x"]).unwrap_err().to_string();
        for part in ["previous, modified", "unknown axis 'colour'", "`x` is not AXIS=VALUE"] {
            assert!(text.contains(part), "{text}");
        }
    }

    #[test]
    fn the_variation_is_relative_and_never_nan() {
        let of = |values: &[f64]| variation(values.iter().copied());
        assert!((of(&[1.0, 3.0]) - 0.5).abs() < 1e-15);
        assert_eq!((of(&[2.0, 2.0]), of(&[0.0, 0.0]), of(&[])), (0.0, 0.0, 0.0));
    }
}

//! How wrong one picture is: against its reference, against the oracle with the same lights, and that oracle against the
//! sum over all points.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sglow_oracle::flip::{PIXELS_PER_DEGREE, decoded, flip};
use sglow_oracle::shade::shade;
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::vsgl::Vsgl;
use sglow_oracle::{Vector3, metrics};
use sglow_runtime::frame::{Frame, Surfaces};
use sglow_runtime::reference;
use sglow_runtime::settings::Settings;
use sglow_shaders::Visibility;

use super::document::{PictureError, Radiance, Rounding, Worst};
use super::subject::{Subject, worst};
use super::truth::Truth;
use crate::display::Exposure;

/// How wrong one picture is.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Evaluation {
    /// What is seen.
    pub picture: PictureError,
    /// The device against the oracle.
    pub rounding: Option<Rounding>,
    /// The oracle against all points.
    pub model_rms_over_mean: Option<f64>,
    /// Numbers that are not finite.
    pub not_finite: usize,
}

/// A reference with all that is needed to evaluate pictures by it.
pub struct Evaluator<'a> {
    truth: &'a Truth,
    surfaces: &'a Surfaces,
    /// Radiance that no way changes: direct light and emission.
    fixed: Radiance,
    eye: Vector3,
    sample: Vec<SurfaceTexel>,
    width: u32,
    size: [usize; 2],
    exposure: Exposure,
    /// What a screen shows of the reference.
    reference: Vec<Vector3>,
}

impl<'a> Evaluator<'a> {
    /// An evaluator of pictures of a subject, of which `frame` is one.
    #[must_use]
    pub fn new(subject: &Subject<'_>, truth: &'a Truth, frame: &'a Frame, eye: glam::Vec3) -> Self {
        let emission = frame.emission.as_deref().unwrap_or_default();
        let fixed: Radiance = frame
            .direct
            .iter()
            .enumerate()
            .map(|(at, direct)| {
                let emitted = emission.get(at).copied().unwrap_or_default();
                std::array::from_fn(|channel| direct[channel] + emitted[channel])
            })
            .collect();
        let surfaces: Vec<SurfaceTexel> = reference::texels(&frame.gbuffer);
        let reference = whole(&fixed, &truth.indirect);
        let exposure = Exposure::automatic(&reference);
        Self {
            sample: truth.sample.iter().map(|&at| surfaces[at]).collect(),
            surfaces: &frame.gbuffer,
            eye: reference::vector(eye),
            width: subject.base.size[0],
            size: subject.base.size.map(|side| side as usize),
            reference: displayed(&reference, exposure),
            exposure,
            fixed,
            truth,
        }
    }

    /// The whole picture of which `indirect` is the indirect light.
    #[must_use]
    pub fn whole(&self, indirect: &Radiance) -> Radiance {
        whole(&self.fixed, indirect)
    }

    /// What is found of the picture that settings gave with these lights.
    #[must_use]
    pub fn evaluate(
        &self,
        settings: &Settings,
        indirect: &Radiance,
        lights: &[Vsgl<f64>],
    ) -> Evaluation {
        let (picture, not_finite) = self.picture(indirect);
        if settings.visibility != Visibility::None {
            return Evaluation { picture, rounding: None, model_rms_over_mean: None, not_finite };
        }
        let oracle = self.by_oracle(settings, lights);
        let device: Vec<[f64; 3]> =
            self.truth.sample.iter().map(|&at| indirect[at].map(f64::from)).collect();
        let (rms, at) = apart(&device, &oracle);
        let rounding = Rounding {
            rms_over_mean: over_mean(rms, &oracle),
            worst: at.map_or_else(Worst::default, |at| {
                let pixel = self.truth.sample[at];
                worst(self.surfaces, self.width, pixel, device[at], oracle[at])
            }),
        };
        let model = over_mean(apart(&oracle, &self.truth.points).0, &self.truth.points);
        Evaluation {
            picture,
            rounding: Some(rounding),
            model_rms_over_mean: Some(model),
            not_finite,
        }
    }

    /// What the oracle reflects of lights on the sample of pixels.
    #[must_use]
    pub fn by_oracle(&self, settings: &Settings, lights: &[Vsgl<f64>]) -> Vec<[f64; 3]> {
        let model = reference::model(settings);
        let reflected = self.sample.par_iter().map(|surface| {
            shade(surface, self.eye, lights.iter().copied(), &model).total().to_array()
        });
        reflected.collect()
    }

    /// What is seen of a picture, and how many of its numbers are not finite.
    #[must_use]
    pub fn picture(&self, indirect: &Radiance) -> (PictureError, usize) {
        let at_present = |radiance: &Radiance| -> Vec<[f64; 3]> {
            self.truth.present.iter().map(|&at| radiance[at].map(f64::from)).collect()
        };
        let (found, expected) = (at_present(indirect), at_present(&self.truth.indirect));
        let flat = |pixels: &[[f64; 3]]| pixels.iter().flatten().copied().collect::<Vec<f64>>();
        let not_finite = found.iter().flatten().filter(|value| !value.is_finite()).count();
        let Some(compared) = metrics::compare(&flat(&found), &flat(&expected)) else {
            let nothing = PictureError { rmse_over_mean: f64::MAX, ..PictureError::default() };
            return (nothing, not_finite);
        };
        let lit = compared.reference_mean > 0.0;
        let error = PictureError {
            rmse_over_mean: over_mean(compared.rmse, &expected),
            relative_mse: compared.relative_mse,
            bias: if lit { compared.bias } else { 0.0 },
            flip: self.flip(indirect),
            worst: apart(&found, &expected).1.map_or_else(Worst::default, |at| {
                let pixel = self.truth.present[at];
                worst(self.surfaces, self.width, pixel, found[at], expected[at])
            }),
        };
        (error, not_finite)
    }

    /// The mean of the FLIP map of whole pictures, 1 if there is none since a number is not finite.
    fn flip(&self, indirect: &Radiance) -> f64 {
        let shown = displayed(&self.whole(indirect), self.exposure);
        flip(&self.reference, &shown, self.size, PIXELS_PER_DEGREE).map_or(1.0, |flip| flip.mean)
    }
}

/// The FLIP map of a whole picture against its reference, 0 to 1 each pixel, as both are shown with the reference's
/// exposure; 1 everywhere if a number is not finite.
#[must_use]
pub fn flip_map(reference: &Radiance, picture: &Radiance, size: [u32; 2]) -> Vec<f32> {
    let exposure = Exposure::automatic(reference);
    let shown = [reference, picture].map(|radiance| displayed(radiance, exposure));
    let size = size.map(|side| side as usize);
    match flip(&shown[0], &shown[1], size, PIXELS_PER_DEGREE) {
        Ok(flip) => flip.errors.into_iter().map(|error| error as f32).collect(),
        Err(_) => vec![1.0; picture.len()],
    }
}

/// What a screen shows of radiance, as light again: linear, 0 to 1.
#[must_use]
pub fn displayed(radiance: &Radiance, exposure: Exposure) -> Vec<Vector3> {
    let linear = |value: f32| decoded(f64::from(value));
    let shown = radiance.iter().map(|&pixel| exposure.shown(pixel).map(linear));
    shown.map(|[r, g, b]| Vector3::new(r, g, b)).collect()
}

fn whole(fixed: &Radiance, indirect: &Radiance) -> Radiance {
    fixed
        .iter()
        .zip(indirect)
        .map(|(fixed, indirect)| std::array::from_fn(|channel| fixed[channel] + indirect[channel]))
        .collect()
}

/// The root mean square difference of finite numbers, and which of the pixels is furthest off.
#[must_use]
pub fn apart(found: &[[f64; 3]], expected: &[[f64; 3]]) -> (f64, Option<usize>) {
    let mut sum = 0.0;
    let mut furthest = None;
    let mut most = -1.0;
    for (at, (found, expected)) in found.iter().zip(expected).enumerate() {
        let square: f64 = found
            .iter()
            .zip(expected)
            .map(|(found, expected)| (found - expected).powi(2))
            .filter(|square| square.is_finite())
            .sum();
        sum += square;
        if square > most {
            (most, furthest) = (square, Some(at));
        }
    }
    ((sum / (3 * found.len()).max(1) as f64).sqrt(), furthest)
}

/// A number over the mean of pixels; itself where the mean is 0.
#[must_use]
pub fn over_mean(value: f64, pixels: &[[f64; 3]]) -> f64 {
    let mean = pixels.iter().flatten().sum::<f64>() / (3 * pixels.len()).max(1) as f64;
    if mean > 0.0 { value / mean } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_furthest_pixel_is_found() {
        let expected = vec![[1.0; 3]; 5];
        let mut found = expected.clone();
        assert_eq!(apart(&found, &expected).0, 0.0);
        found[3][1] = 4.0;
        found[4][0] = f64::NAN;
        let (rms, at) = apart(&found, &expected);
        assert_eq!(at, Some(3));
        assert!((rms - (9.0_f64 / 15.0).sqrt()).abs() < 1e-12);
        assert_eq!(over_mean(2.0, &expected), 2.0);
        assert_eq!(over_mean(2.0, &[[0.0; 3]]), 2.0, "in the dark an error is what it is");
        assert_eq!(over_mean(2.0, &[[4.0; 3]]), 0.5);
    }
}

//! How far one picture is off: against its reference, against the oracle with the same lights, and that oracle against
//! the sum over all points.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sglow_graph::description::Setting;
use sglow_oracle::Vector3;
use sglow_oracle::shade::shade;
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::vsgl::Vsgl;
use sglow_renderer::frame::{Frame, Surfaces};
use sglow_renderer::reference;
use sglow_results::display::Exposure;
use sglow_results::frontier::document::{PictureError, Radiance, Rounding, Worst};
use sglow_results::picture_error::{Display, Pair, compare};
use sglow_runtime::settings::Settings;
use sglow_shaders::{Cut, Visibility};

use super::references::References;
use super::subject::{Subject, worst};

/// How far one picture is off.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Evaluation {
    /// What is seen.
    pub picture: PictureError,
    /// The same against the reference without visibility, where the picture has none.
    pub unshadowed: Option<PictureError>,
    /// The pixel that is furthest off.
    pub worst: Worst,
    /// The device against the oracle.
    pub rounding: Option<Rounding>,
    /// The oracle against all points.
    pub model_rms_over_mean: Option<f64>,
    /// Numbers that are not finite.
    pub not_finite: usize,
}

/// A reference with all that is needed to evaluate pictures by it.
pub struct Evaluator<'a> {
    references: &'a References,
    surfaces: &'a Surfaces,
    /// Radiance that no configuration changes: direct light and emission.
    fixed: Radiance,
    eye: Vector3,
    sample: Vec<SurfaceTexel>,
    size: [u32; 2],
    others: BTreeMap<String, Setting>,
    exposure: Exposure,
    /// The whole pictures of the reference's halves.
    whole_halves: [Radiance; 2],
    /// Indirect light without visibility of every pixel, black where there is no surface; and the whole picture of it.
    unshadowed: [Radiance; 2],
}

impl<'a> Evaluator<'a> {
    /// An evaluator of pictures of a subject, of which `frame` is one.
    #[must_use]
    pub fn new(
        subject: &Subject<'_>,
        references: &'a References,
        frame: &'a Frame,
        eye: glam::Vec3,
    ) -> Self {
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
        let exposure = Exposure::automatic(&whole(&fixed, &references.indirect));
        let mut unshadowed = vec![[0.0; 3]; fixed.len()];
        for (&at, &pixel) in references.present.iter().zip(&references.unshadowed) {
            unshadowed[at] = pixel;
        }
        Self {
            sample: references.sample.iter().map(|&at| surfaces[at]).collect(),
            surfaces: &frame.gbuffer,
            eye: reference::vector(eye),
            size: subject.base.size,
            others: subject.base.others.clone(),
            whole_halves: references.halves.each_ref().map(|half| whole(&fixed, half)),
            unshadowed: [unshadowed.clone(), whole(&fixed, &unshadowed)],
            exposure,
            fixed,
            references,
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
        let picture = self.picture(indirect);
        let at_present = |radiance: &Radiance| -> Vec<[f64; 3]> {
            self.references.present.iter().map(|&at| radiance[at].map(f64::from)).collect()
        };
        let (found, expected) = (at_present(indirect), at_present(&self.references.indirect));
        let not_finite = found.iter().flatten().filter(|value| !value.is_finite()).count();
        let worst_of_all = apart(&found, &expected).1.map_or_else(Worst::default, |at| {
            let pixel = self.references.present[at];
            worst(self.surfaces, self.size[0], pixel, found[at], expected[at])
        });
        let seen = Evaluation {
            picture,
            unshadowed: None,
            worst: worst_of_all,
            rounding: None,
            model_rms_over_mean: None,
            not_finite,
        };
        // The oracle knows nothing of what is laid over the library.
        if settings.visibility != Visibility::None || settings.others != self.others {
            return seen;
        }
        let seen = Evaluation { unshadowed: Some(self.unshadowed(indirect)), ..seen };
        // It has the lights of a frame and not the nodes of a tree; tests/src/tile.rs compares these.
        if settings.cut != Cut::None {
            return seen;
        }
        let oracle = self.by_oracle(settings, lights);
        let device: Vec<[f64; 3]> =
            self.references.sample.iter().map(|&at| indirect[at].map(f64::from)).collect();
        let (rms, at) = apart(&device, &oracle);
        let rounding = Rounding {
            rms_over_mean: over_mean(rms, &oracle),
            worst: at.map_or_else(Worst::default, |at| {
                let pixel = self.references.sample[at];
                worst(self.surfaces, self.size[0], pixel, device[at], oracle[at])
            }),
        };
        let model = over_mean(apart(&oracle, &self.references.points).0, &self.references.points);
        Evaluation { rounding: Some(rounding), model_rms_over_mean: Some(model), ..seen }
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

    /// How far a picture is from the reference.
    #[must_use]
    pub fn picture(&self, indirect: &Radiance) -> PictureError {
        let [one, other] = &self.references.halves;
        let [whole_one, whole_other] = &self.whole_halves;
        self.against(indirect, [one, other], [whole_one, whole_other])
    }

    /// How far it is from the reference without visibility, which is exact.
    #[must_use]
    pub fn unshadowed(&self, indirect: &Radiance) -> PictureError {
        let [reference, whole] = &self.unshadowed;
        self.against(indirect, [reference; 2], [whole; 2])
    }

    fn against(
        &self,
        indirect: &Radiance,
        halves: [&Radiance; 2],
        whole_halves: [&Radiance; 2],
    ) -> PictureError {
        compare(&Pair {
            size: self.size,
            present: Some(&self.references.present),
            picture: indirect,
            halves,
            whole: &self.whole(indirect),
            whole_halves,
            display: Display::Exposed(self.exposure),
        })
    }
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

//! What pictures are compared with, and how far it may be off itself.

use serde::{Deserialize, Serialize};
use sglow_oracle::Vector3;
use sglow_oracle::estimate::{Estimate, Uncertainty};
use sglow_renderer::reference;
use sglow_results::frontier::document::{Radiance, Reference};
use sglow_results::progress::Progress;

use super::subject::{Drawn, FrontierError, Subject};
use crate::cache::Cache;

/// Pixels on which rounding and model are compared with the oracle, spread over the picture.
const SAMPLE: usize = 96;

/// Paths of each pixel, in both halves together.
const PATHS: u32 = 4096;

/// The seed of what is drawn: the same run gives the same numbers.
const SEED: u64 = 2016;

/// The reference of a scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct References {
    /// What it is.
    pub reference: Reference,
    /// Indirect light of every pixel: the mean of both halves.
    pub indirect: Radiance,
    /// Two references of half the samples each, from independent random numbers: the mean of (I - R1)(I - R2) over a
    /// picture I estimates its squared error without that of the reference.
    pub halves: [Radiance; 2],
    /// Pixels that show a surface.
    pub present: Vec<usize>,
    /// Some of them, on which the oracle is evaluated.
    pub sample: Vec<usize>,
    /// What the facets of the light's map bring there, without visibility.
    pub points: Vec<[f64; 3]>,
    /// The same of all of `present`, in its order: what indirect light without visibility is to be compared with.
    pub unshadowed: Radiance,
}

/// The reference of a subject, kept for the next time.
///
/// # Errors
///
/// When the scene does not render or cannot be traced, or the camera sees nothing.
pub fn references(
    subject: &Subject<'_>,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<References, FrontierError> {
    let key = subject.scene_key("reference")?.on("samples", format!("{PATHS} {SAMPLE} {SEED}"));
    cache.get(&key, || make(subject, progress))
}

fn make(subject: &Subject<'_>, progress: &dyn Progress) -> Result<References, FrontierError> {
    let drawn = subject.drawn()?;
    let Drawn { renderer, frame, .. } = drawn;
    let settings = renderer.indirect().settings();
    let surfaces = &frame.gbuffer;
    let present: Vec<usize> =
        (0..surfaces.position.len()).filter(|&at| surfaces.position[at][3] >= 0.0).collect();
    if present.is_empty() {
        return Err(FrontierError::NoSurface { scene: subject.scene.name.clone() });
    }
    let step = present.len().div_ceil(SAMPLE);
    let sample: Vec<usize> = present.iter().copied().step_by(step).collect();
    let report = |done, _| {
        progress.done(done);
        true
    };
    let pixels = surfaces.position.len();
    let (light, eye, scene) = (renderer.light(), renderer.eye(), subject.scene);
    progress.start(&format!("{}: reference of paths", scene.name), pixels);
    let halves =
        reference::path_halves(light, settings, scene, surfaces, eye, PATHS, SEED, report)?
            .unwrap_or_default();
    let estimates: Vec<Estimate> = halves.iter().map(Estimate::mean_of).collect();
    let seen: Vec<Estimate> = present.iter().filter_map(|&at| estimates.get(at).copied()).collect();
    let certain = Uncertainty::of(&seen);
    progress.start(&format!("{}: reference without visibility", scene.name), present.len());
    let unshadowed = unshadowed(drawn, &present, report);
    let sampled: Vec<[f64; 3]> = unshadowed.iter().copied().step_by(step).collect();
    Ok(References {
        reference: Reference {
            samples: PATHS,
            mean: certain.mean,
            noise_over_mean: if certain.mean > 0.0 {
                certain.noise / certain.mean
            } else {
                certain.noise
            },
            dark: certain.mean == 0.0,
        },
        indirect: radiance(estimates.iter()),
        halves: [0, 1].map(|half: usize| radiance(halves.iter().map(|both| &both[half]))),
        points: sampled,
        unshadowed: unshadowed.iter().map(|one| one.map(|value| value as f32)).collect(),
        present,
        sample,
    })
}

/// The indirect light of estimates.
fn radiance<'a>(estimates: impl Iterator<Item = &'a Estimate>) -> Radiance {
    estimates.map(|one| one.mean.total().to_array().map(|value| value as f32)).collect()
}

/// What the facets of the light's map bring to some pixels without visibility.
fn unshadowed(
    Drawn { renderer, frame, rsm }: &Drawn<'_>,
    pixels: &[usize],
    report: impl Fn(usize, usize) -> bool + Sync,
) -> Vec<[f64; 3]> {
    let settings = renderer.indirect().settings();
    let (light, eye, gbuffer) = (renderer.light(), renderer.eye(), &frame.gbuffer);
    let all = reference::unshadowed_at(light, settings, rsm, gbuffer, pixels, eye, report);
    all.unwrap_or_default().iter().map(|one| Vector3::to_array(one.total())).collect()
}

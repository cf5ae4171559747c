//! What pictures are compared with, and how far it may be off itself.

use serde::{Deserialize, Serialize};
use sglow_oracle::Vector3;
use sglow_oracle::estimate::Estimate;
use sglow_oracle::surface::SceneError;
use sglow_runtime::reference::{self, Choice, Kind};

use super::document::{Radiance, Reference, ReferenceKind};
use super::progress::Progress;
use super::subject::{Drawn, FrontierError, Subject};
use crate::cache::Cache;
use crate::rivals::flicker::of_pixels;

/// Pixels on which rounding and model are held against the oracle, spread over the picture.
const SAMPLE: usize = 96;

/// Paths of each pixel, in both halves together.
const PATHS: u32 = 2048;

/// Shadow rays of each pixel, in both halves together.
const RAYS: u32 = 256;

/// The seed of what is drawn: the same run gives the same numbers.
const SEED: u64 = 2016;

/// The reference of a scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Truth {
    /// What it is.
    pub reference: Reference,
    /// Indirect light of every pixel: the mean of both halves.
    pub indirect: Radiance,
    /// Two references of half the samples each, from independent random numbers: the mean of (I - R1)(I - R2) over a
    /// picture I estimates its squared error without that of the reference. Points share their discretisation.
    pub halves: [Radiance; 2],
    /// Indirect light of every pixel without visibility, if there is such a reference.
    pub unshadowed: Option<Radiance>,
    /// Pixels that show a surface.
    pub present: Vec<usize>,
    /// Some of them, on which the oracle is asked.
    pub sample: Vec<usize>,
    /// What the sum over all texels of the light's map gives there, without visibility.
    pub points: Vec<[f64; 3]>,
}

/// The reference of a subject, kept for the next time.
///
/// # Errors
///
/// When the scene does not render or cannot be traced, or the camera sees nothing.
pub fn truth(
    subject: &Subject<'_>,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<Truth, FrontierError> {
    let key =
        subject.scene_key("reference")?.on("samples", format!("{PATHS} {RAYS} {SAMPLE} {SEED}"));
    cache.get(&key, || make(subject, progress))
}

fn make(subject: &Subject<'_>, progress: &dyn Progress) -> Result<Truth, FrontierError> {
    let drawn = subject.drawn()?;
    let Drawn { renderer, frame, rsm } = drawn;
    let settings = renderer.indirect().settings();
    let surfaces = &frame.gbuffer;
    let present: Vec<usize> =
        (0..surfaces.position.len()).filter(|&at| surfaces.position[at][3] >= 0.0).collect();
    if present.is_empty() {
        return Err(FrontierError::NoSurface { scene: subject.scene.name.clone() });
    }
    let sample: Vec<usize> =
        present.iter().copied().step_by(present.len().div_ceil(SAMPLE)).collect();
    let told = |done, _| {
        progress.done(done);
        true
    };
    let pixels = surfaces.position.len();
    let (light, eye, scene) = (renderer.light(), renderer.eye(), subject.scene);
    // Both, for how far they are off hangs on a few pixels, which a pilot would miss.
    progress.start(&format!("{}: reference of paths", scene.name), 2 * pixels);
    let paths = halves(|seed, first| {
        let told = |done, all| told(first * pixels + done, all);
        reference::paths(light, settings, scene, surfaces, eye, PATHS / 2, seed, told)
    })?;
    progress.start(&format!("{}: reference of points", scene.name), 2 * pixels);
    let points = halves(|seed, first| {
        let told = |done, all| told(first * pixels + done, all);
        reference::points(light, settings, scene, rsm, surfaces, eye, RAYS / 2, seed, told)
    })?;
    let seen = |halves: &[Vec<Estimate>; 2]| -> Vec<Estimate> {
        let both = |&at: &usize| Some([*halves[0].get(at)?, *halves[1].get(at)?]);
        present.iter().filter_map(both).map(|both| Estimate::mean_of(&both)).collect()
    };
    let choice = Choice::of(&seen(&paths), &seen(&points));
    let (kind, samples, estimates, certain, other) = match choice.better {
        Kind::Paths => (ReferenceKind::Paths, PATHS, paths, choice.paths, choice.points),
        Kind::Points => (ReferenceKind::Points, RAYS, points, choice.points, choice.paths),
    };
    let over_mean = |value: f64| if certain.mean > 0.0 { value / certain.mean } else { value };
    Ok(Truth {
        reference: Reference {
            kind,
            samples,
            mean: certain.mean,
            noise_over_mean: over_mean(certain.noise),
            discretisation_over_mean: over_mean(certain.discretisation),
            floor_over_mean: over_mean(certain.total),
            other_floor_over_mean: Some(other.relative()).filter(|floor| floor.is_finite()),
            dark: certain.mean == 0.0,
        },
        indirect: radiance(
            estimates[0].iter().zip(&estimates[1]).map(|(&a, &b)| Estimate::mean_of(&[a, b])),
        ),
        halves: [0, 1].map(|half: usize| radiance(estimates[half].iter().copied())),
        unshadowed: None,
        points: unhidden(drawn, &sample),
        present,
        sample,
    })
}

/// Two independent references of a scene: of a seed, and of the number of the half.
fn halves(
    of: impl Fn(u64, usize) -> Result<Option<Vec<Estimate>>, SceneError>,
) -> Result<[Vec<Estimate>; 2], SceneError> {
    Ok([of(SEED, 0)?.unwrap_or_default(), of(SEED + 1, 1)?.unwrap_or_default()])
}

/// The indirect light of estimates.
fn radiance(estimates: impl Iterator<Item = Estimate>) -> Radiance {
    estimates.map(|one| one.mean.total().to_array().map(|value| value as f32)).collect()
}

/// The sum over all texels of the light's map at some pixels.
fn unhidden(Drawn { renderer, frame, rsm }: &Drawn<'_>, sample: &[usize]) -> Vec<[f64; 3]> {
    let settings = renderer.indirect().settings();
    let receivers = of_pixels(&frame.gbuffer, sample);
    let (light, eye) = (renderer.light(), renderer.eye());
    let all = reference::virtual_point_lights(light, settings, rsm, &receivers, eye, |_, _| true);
    all.unwrap_or_default().iter().map(|one| Vector3::to_array(one.total())).collect()
}

//! Which reference is the better one of a frame: the one that is more certain of itself.

use glam::Vec3;
use sglow_oracle::estimate::{Estimate, Uncertainty};
use sglow_oracle::fis::stress::Random;
use sglow_oracle::path::Paths;
use sglow_oracle::surface::{self, SceneError, SurfaceTexel};
use sglow_oracle::vpl::VisiblePoints;

use super::path::{SceneMaterials, facets};
use super::{light, ndf, point_lights, texels, vector};
use crate::frame::Surfaces;
use crate::light::LightView;
use crate::scene::Scene;
use crate::settings::Settings;

/// A reference with visibility.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Paths of one bounce: see [`super::paths`].
    Paths,
    /// Every texel of the light's map, and what hides it: see [`super::points()`].
    Points,
}

/// What both references are tried with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pilot {
    /// Pixels, at least 1, spread over the surfaces that are seen by chance.
    pub pixels: usize,
    /// Paths for each of them.
    pub samples: u32,
    /// Shadow rays for each of them.
    pub rays: u32,
    /// Other seeds give other pixels and other noise.
    pub seed: u64,
}

/// The better reference and what it was chosen by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// The one whose own error over its mean is smaller; paths if they are equal.
    pub better: Kind,
    /// What paths say of themselves.
    pub paths: Uncertainty,
    /// What points say of themselves.
    pub points: Uncertainty,
    /// The root mean square difference of both, in the unit of the picture. Where it is far above both totals one of them
    /// does not know its error: a few pixels of paths that hardly ever find what is bright say too little.
    pub difference: f64,
}

/// Tries both references on some pixels of a frame, each with as much work as it is to have on all of them.
///
/// # Errors
/// [`SceneError`] names a triangle that is not finite.
pub fn choose(
    view: &LightView,
    settings: &Settings,
    scene: &Scene,
    rsm: &Surfaces,
    gbuffer: &Surfaces,
    eye: Vec3,
    pilot: &Pilot,
) -> Result<Choice, SceneError> {
    let (triangles, materials) = (surface::Scene::new(facets(scene))?, SceneMaterials(scene));
    let Pilot { pixels, samples, rays, seed } = *pilot;
    let receivers = some(&texels(gbuffer), pixels, seed);
    let (eye, go_on) = (vector(eye), |_| true);
    let paths = Paths {
        scene: &triangles,
        materials: &materials,
        light: &light(view, settings.light),
        ndf: ndf(settings.ndf),
        samples,
        seed,
    };
    let lights = point_lights(view, settings, rsm);
    let points =
        VisiblePoints { lights: &lights, scene: &triangles, materials: &materials, rays, seed };
    // Nothing stops them.
    let paths = paths.reflect(&receivers, eye, &go_on).unwrap_or_default();
    let points = points.reflect(&receivers, eye, &go_on).unwrap_or_default();
    Ok(Choice::of(&paths, &points))
}

impl Choice {
    /// The choice between what paths and points find of the same pixels.
    #[must_use]
    pub fn of(paths: &[Estimate], points: &[Estimate]) -> Self {
        let square = |(one, other): (&Estimate, &Estimate)| {
            (one.mean.total() - other.mean.total()).length_squared()
        };
        let squares: f64 = paths.iter().zip(points).map(square).sum();
        let count = 3 * paths.len().min(points.len());
        let (paths, points) = (Uncertainty::of(paths), Uncertainty::of(points));
        let better = if points.relative() < paths.relative() { Kind::Points } else { Kind::Paths };
        Self { better, paths, points, difference: (squares / count.max(1) as f64).sqrt() }
    }
}

/// Surfaces drawn by chance, the same ones of a seed; none if there is none.
fn some(texels: &[SurfaceTexel], count: usize, seed: u64) -> Vec<SurfaceTexel> {
    let present: Vec<SurfaceTexel> = texels.iter().filter(|texel| texel.present).copied().collect();
    let mut random = Random::new(seed);
    let mut one = || present.get((random.uniform() * present.len() as f64) as usize).copied();
    (0..count).filter_map(|_| one()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sglow_oracle::Vector3;
    use sglow_oracle::shade::Reflected;

    fn estimate(mean: f64, noise: f64, discretisation: f64) -> Estimate {
        let diffusely =
            |value| Reflected { diffuse: Vector3::splat(value), specular: Vector3::zero() };
        Estimate {
            mean: diffusely(mean),
            standard_errors: diffusely(noise),
            standard_error: Vector3::splat(noise),
            discretisation: diffusely(discretisation),
        }
    }

    #[test]
    fn the_more_certain_one_is_chosen() {
        let noisy = [estimate(1.0, 0.1, 0.0), estimate(2.0, 0.1, 0.0)];
        let coarse = |error| [estimate(1.1, 0.01, error), estimate(2.1, 0.01, error)];
        let choice = Choice::of(&noisy, &coarse(0.05));
        assert_eq!(choice.better, Kind::Points);
        assert!((choice.difference - 0.1).abs() < 1e-12, "{choice:?}");
        // The lattice's error counts.
        assert_eq!(Choice::of(&noisy, &coarse(0.5)).better, Kind::Paths);
        // Of nothing the choice is that of paths, and nothing is divided by 0.
        assert_eq!(Choice::of(&[], &[]).better, Kind::Paths);
        assert_eq!(Choice::of(&[], &[]).difference, 0.0);
        assert_eq!(Choice::of(&noisy, &[Estimate::none(); 2]).better, Kind::Points);
    }
}

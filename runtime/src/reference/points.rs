//! The reference of points with visibility: every texel of the light's map, and a scene's triangles between.

use glam::Vec3;
use sglow_oracle::estimate::Estimate;
use sglow_oracle::surface::{self, SceneError};
use sglow_oracle::vpl::VisiblePoints;

use super::path::{SceneMaterials, facets};
use super::{growing, point_lights, texels, vector};
use crate::frame::Surfaces;
use crate::light::LightView;
use crate::scene::Scene;
use crate::settings::Settings;

/// The indirect light of a frame by every texel of the reflective shadow map, in f64, with `rays` shadow rays per pixel
/// to lights that are drawn: see [`VisiblePoints`]. The same `seed` gives the same numbers.
///
/// With `rays` 0 it is the sum without visibility, which is all there is to know where nothing can hide anything; its
/// discretisation error is stated all the same.
///
/// `progress` is told how many of the pixels are done, from several threads, and says whether to go on; the result is
/// `None` if it said no.
///
/// # Errors
/// [`SceneError`] names a triangle that is not finite.
#[expect(clippy::too_many_arguments, reason = "what a frame consists of, and how many rays")]
pub fn points(
    view: &LightView,
    settings: &Settings,
    scene: &Scene,
    rsm: &Surfaces,
    gbuffer: &Surfaces,
    eye: Vec3,
    rays: u32,
    seed: u64,
    progress: impl Fn(usize, usize) -> bool + Sync,
) -> Result<Option<Vec<Estimate>>, SceneError> {
    let points = VisiblePoints {
        lights: &point_lights(view, settings, rsm),
        scene: &surface::Scene::new(facets(scene))?,
        materials: &SceneMaterials(scene),
        rays,
        seed,
    };
    let receivers = texels(gbuffer);
    let progress = growing(receivers.len(), progress);
    Ok(points.reflect(&receivers, vector(eye), &progress))
}

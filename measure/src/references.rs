//! The estimated errors of the references on a scene: the facets of maps of several sizes against those of a fine one, and
//! the noise of paths. `docs/references.md` shows them.

use sglow_oracle::estimate::{Estimate, Uncertainty};
use sglow_oracle::metrics;
use sglow_oracle::path::Paths;
use sglow_oracle::surface::{self, SceneError, SurfaceTexel};
use sglow_renderer::device::Gpu;
use sglow_renderer::frame::{FrameError, Renderer, Surfaces};
use sglow_renderer::reference::{self, SceneMaterials};
use sglow_results::progress::Progress;
use sglow_results::references::{FINEST, MAPS, MapError, Noise, PATHS, ReferenceErrors, SIZE};
use sglow_runtime::light::LightView;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use thiserror::Error;

/// Errors of measuring references.
#[derive(Debug, Error)]
pub enum ReferenceError {
    /// The scene does not render.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Its triangles cannot be traced.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A scene cannot be loaded.
    #[error(transparent)]
    Load(#[from] sglow_scene::SceneError),
    /// Two pictures cannot be compared.
    #[error("{scene}: the camera sees no surface, or a number of a reference is not finite")]
    NotComparable {
        /// The scene.
        scene: String,
    },
}

/// A scene, the surfaces that the light and the camera see, and the references that are made of them.
pub struct Drawn {
    /// The scene.
    pub scene: Scene,
    /// The settings of the maps.
    pub settings: Settings,
    /// The light.
    pub light: LightView,
    /// The reflective shadow map.
    pub rsm: Surfaces,
    /// What the camera sees.
    pub gbuffer: Surfaces,
    /// The camera's position.
    pub eye: glam::Vec3,
}

impl Drawn {
    /// Draws both maps.
    ///
    /// # Errors
    /// [`FrameError`] when they do not render.
    pub fn new(
        gpu: &Gpu,
        package: &Package,
        scene: Scene,
        settings: &Settings,
    ) -> Result<Self, FrameError> {
        let renderer = Renderer::new(gpu, package, &scene, settings, 0)?;
        renderer.draw_maps()?;
        let (rsm, gbuffer) = (renderer.read_rsm()?, renderer.read_gbuffer()?);
        let (light, eye) = (renderer.light().clone(), renderer.eye());
        let settings = renderer.indirect().settings().clone();
        drop(renderer);
        Ok(Self { scene, settings, light, rsm, gbuffer, eye })
    }

    /// The pixels that show a surface.
    #[must_use]
    pub fn receivers(&self) -> Vec<SurfaceTexel> {
        let texels: Vec<SurfaceTexel> = reference::texels(&self.gbuffer);
        texels.into_iter().filter(|texel| texel.present).collect()
    }

    /// Independent halves of the reference by paths at the pixels that show a surface; `map` is the width of the light's
    /// map that guides them, 0 for directions alone.
    ///
    /// # Errors
    /// [`SceneError`] names a triangle that is not finite.
    pub fn halves(
        &self,
        samples: u32,
        map: usize,
        seed: u64,
    ) -> Result<Vec<[Estimate; 2]>, SceneError> {
        let traced = surface::Scene::new(reference::facets(&self.scene))?;
        let materials = SceneMaterials::new(&self.scene);
        let (receivers, eye) = (self.receivers(), reference::vector(self.eye));
        // Nothing comes back of paths that are interrupted, and these are not.
        let found = reference::path::of_each_light(&self.light, |_, light| {
            let paths = Paths {
                scene: &traced,
                materials: &materials,
                light,
                ndf: reference::ndf(self.settings.ndf),
                samples,
                map,
                seed,
            };
            paths.halves(&receivers, eye, &|_| true)
        });
        Ok(found.unwrap_or_default())
    }

    /// The sum over the facets of the light's map at the pixels that show a surface.
    #[must_use]
    pub fn facets(&self) -> Vec<[f64; 3]> {
        let (gbuffer, go_on) = (&self.gbuffer, |_, _| true);
        let found =
            reference::unshadowed(&self.light, &self.settings, &self.rsm, gbuffer, self.eye, go_on);
        let present = gbuffer.position.iter().map(|position| position[3] >= 0.0);
        let pixels = found.unwrap_or_default().into_iter().zip(present);
        pixels.filter(|(_, present)| *present).map(|(one, _)| one.total().to_array()).collect()
    }
}

/// Half the root mean square difference of both halves: the noise of their mean, whatever they state themselves.
#[must_use]
pub fn noise_of(halves: &[[Estimate; 2]]) -> f64 {
    let of = |half: usize| -> Vec<[f64; 3]> {
        halves.iter().map(|both| both[half].mean.total().to_array()).collect()
    };
    metrics::compare_exact(&of(0), &of(1)).map_or(f64::NAN, |found| 0.5 * found.rmse.value)
}

/// Texels on a side of the map that guides paths.
const GUIDE: u32 = 256;
/// The built-in scenes that are measured.
pub const SCENES: [&str; 5] = ["cornell", "columns", "caustic", "cornell-glossy", "atrium:75k"];

fn noise(halves: &[[Estimate; 2]]) -> Noise {
    let means: Vec<Estimate> = halves.iter().map(Estimate::mean_of).collect();
    let stated = Uncertainty::of(&means);
    Noise { stated: stated.relative(), by_halves: noise_of(halves) / stated.mean }
}

/// Measures the errors of both references on a scene.
///
/// # Errors
/// [`ReferenceError`] when the scene does not render, cannot be traced or shows nothing.
pub fn measure(
    gpu: &Gpu,
    package: &Package,
    name: &str,
    scene: &Scene,
) -> Result<ReferenceErrors, ReferenceError> {
    let drawn = |rsm_size: u32| {
        let settings = Settings { size: SIZE, map: rsm_size, lights: 8, ..Settings::default() };
        Drawn::new(gpu, package, scene.clone(), &settings)
    };
    let finest = drawn(FINEST)?.facets();
    let mut facets = Vec::with_capacity(MAPS.len());
    for map in MAPS {
        let found = metrics::compare_exact(&drawn(map)?.facets(), &finest)
            .ok_or_else(|| ReferenceError::NotComparable { scene: name.to_owned() })?;
        facets.push(MapError {
            map,
            rmse_over_mean: found.rmse_over_mean().value,
            median: found.median.value,
        });
    }
    let case = drawn(GUIDE)?;
    let noise = |map| Ok::<_, SceneError>(noise(&case.halves(PATHS, map, 5)?));
    Ok(ReferenceErrors {
        scene: name.to_owned(),
        facets,
        by_directions: noise(0)?,
        guided: noise(GUIDE as usize)?,
    })
}

/// Measures all of [`SCENES`].
///
/// # Errors
/// [`ReferenceError`] when a scene does not render or cannot be traced.
pub fn all(gpu: &Gpu, progress: &dyn Progress) -> Result<Vec<ReferenceErrors>, ReferenceError> {
    progress.start("references", SCENES.len());
    let mut all = Vec::new();
    for name in SCENES {
        all.push(measure(gpu, &Package::embedded(), name, &Scene::load(name)?)?);
        progress.done(all.len());
    }
    progress.end();
    Ok(all)
}

//! What is measured: a scene on a device, and the keys that its results are kept by.

use std::cell::{OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet};

use sglow_renderer::device::{DeviceError, Gpu};
use sglow_renderer::frame::{Frame, FrameError, Renderer, Surfaces};
use sglow_renderer::plan::{self, Plan};
use sglow_results::frontier::document::Worst;
use sglow_runtime::indirect::{IndirectError, PARTS};
use sglow_runtime::package::{Package, PackageError};
use sglow_runtime::points::GeometryError;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shaders::frame::part;
use sha2::{Digest as _, Sha256};
use thiserror::Error;

use super::depends::Depends;
use crate::cache::{CacheError, Key, sha256};
use crate::rivals::flicker::FlickerError;

/// Why nothing could be measured.
#[derive(Debug, Error)]
pub enum FrontierError {
    /// A frame does not render.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The settings are not possible.
    #[error(transparent)]
    Indirect(#[from] IndirectError),
    /// A variant is missing.
    #[error(transparent)]
    Package(#[from] PackageError),
    /// The scene's triangles cannot occlude virtual lights.
    #[error(transparent)]
    Occluders(#[from] GeometryError),
    /// The package describes no frame of these settings.
    #[error("{0}")]
    Description(String),
    /// The scene cannot be traced.
    #[error(transparent)]
    Scene(#[from] sglow_oracle::surface::SceneError),
    /// Mips read back are none.
    #[error(transparent)]
    Pyramid(#[from] sglow_oracle::rsm::PyramidError),
    /// The light cannot be followed.
    #[error(transparent)]
    Flicker(#[from] FlickerError),
    /// A result cannot be kept.
    #[error(transparent)]
    Cache(#[from] CacheError),
    /// The device fails.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// Nothing fits.
    #[error("no configuration remains to be measured on {scene}: {why}")]
    Nothing {
        /// The scene.
        scene: String,
        /// What left none.
        why: String,
    },
    /// The camera sees nothing.
    #[error("{scene}: the camera sees no surface; give it another one in a sidecar")]
    NoSurface {
        /// The scene.
        scene: String,
    },
}

/// A rendered frame with what it was rendered from.
pub struct Drawn<'a> {
    /// Draws the maps.
    pub renderer: Renderer<'a>,
    /// The frame, of the scene's default configuration.
    pub frame: Frame,
    /// The light's map.
    pub rsm: Surfaces,
}

/// A scene on a device.
pub struct Subject<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// The shaders.
    pub package: &'a Package,
    /// The scene, with the lights that are used.
    pub scene: &'a Scene,
    /// What the scene gets if nobody chooses.
    pub base: Settings,
    /// What the stages of its frames depend on.
    pub depends: Depends,
    surfaces: plan::Surfaces,
    hash: String,
    texts: RefCell<BTreeMap<String, String>>,
    drawn: OnceCell<Drawn<'a>>,
}

impl<'a> Subject<'a> {
    /// A scene to be measured. Nothing is drawn before it is needed.
    #[must_use]
    pub fn new(gpu: &'a Gpu, package: &'a Package, scene: &'a Scene, base: Settings) -> Self {
        Self {
            depends: Depends::of(package.description()),
            surfaces: plan::Surfaces::of(scene, base.complete),
            hash: scene_hash(scene),
            texts: RefCell::default(),
            drawn: OnceCell::new(),
            gpu,
            package,
            scene,
            base,
        }
    }

    /// What a frame with these settings runs and keeps.
    ///
    /// # Errors
    ///
    /// When the package describes no such frame.
    pub fn plan(&self, settings: &Settings) -> Result<Plan, FrontierError> {
        Ok(Plan::of(&self.evaluated(settings, None)?))
    }

    /// The variants that make, shadow and reflect lights.
    pub(super) fn variants(&self, settings: &Settings) -> Result<Vec<String>, FrontierError> {
        let frame = self.evaluated(settings, Some(&PARTS))?;
        Ok(frame.variants().into_iter().map(|variant| variant.id.clone()).collect())
    }

    /// The values on axes that settings and the scene's surfaces lead to.
    pub(super) fn axes(&self, settings: &Settings) -> BTreeMap<String, String> {
        self.configuration(settings).axes
    }

    fn configuration(&self, settings: &Settings) -> sglow_graph::Configuration {
        let own;
        let surfaces = if settings.complete == self.base.complete {
            &self.surfaces
        } else {
            own = plan::Surfaces::of(self.scene, settings.complete);
            &own
        };
        let mut configuration = settings.configuration();
        surfaces.describe(&mut configuration);
        configuration
    }

    /// The frame of settings, or parts of it.
    fn evaluated(
        &self,
        settings: &Settings,
        parts: Option<&[&str]>,
    ) -> Result<sglow_graph::Frame, FrontierError> {
        let mut configuration = self.configuration(settings);
        configuration.parts =
            parts.map(|parts| parts.iter().map(|part| (*part).to_owned()).collect());
        let missing = || FrontierError::Description("the package describes no frame".to_owned());
        let description = self.package.description().ok_or_else(missing)?;
        description
            .evaluate(&configuration)
            .map_err(|errors| FrontierError::Description(errors.to_string()))
    }

    /// The hash of what a frame runs on what, in these parts of it: steps with their numbers, and resources.
    fn steps(&self, settings: &Settings, parts: &[&str]) -> Result<String, FrontierError> {
        let mut frame = self.evaluated(settings, Some(parts))?;
        // Where the description has a step is nothing that a result depends on.
        frame.steps.iter_mut().for_each(|step| step.place.clear());
        frame.reads.clear();
        Ok(sha256(format!("{frame:?}").as_bytes()))
    }

    /// The maps and a frame, drawn at the first call.
    ///
    /// # Errors
    ///
    /// When the scene does not render.
    pub fn drawn(&self) -> Result<&Drawn<'a>, FrontierError> {
        if let Some(drawn) = self.drawn.get() {
            return Ok(drawn);
        }
        let renderer = Renderer::new(self.gpu, self.package, self.scene, &self.base, 0)?;
        renderer.render()?;
        let (frame, rsm) = (renderer.read()?, renderer.read_rsm()?);
        Ok(self.drawn.get_or_init(|| Drawn { renderer, frame, rsm }))
    }

    /// The key of a result of one configuration: `what` it is, on what it was measured, and the shaders that it runs.
    ///
    /// # Errors
    ///
    /// When the package lacks one of the shaders.
    pub fn key(&self, what: &str, name: &str, settings: &Settings) -> Result<Key, FrontierError> {
        self.key_on(what, name, settings, &[&[part::SURFACES], &PARTS[..]].concat())
    }

    /// The key of a result that hangs on no reflection.
    ///
    /// # Errors
    ///
    /// As [`Self::key`].
    pub fn key_of_lights(
        &self,
        what: &str,
        name: &str,
        settings: &Settings,
    ) -> Result<Key, FrontierError> {
        self.key_on(what, name, settings, &[part::SURFACES, part::LIGHTS])
    }

    fn key_on(
        &self,
        what: &str,
        name: &str,
        settings: &Settings,
        parts: &[&str],
    ) -> Result<Key, FrontierError> {
        let variants = Plan::of(&self.evaluated(settings, Some(parts))?).variants;
        let [width, height] = settings.size;
        let size = format!("{width}x{height}");
        let key = Key::new(&[
            ("scene", &self.scene.name),
            ("size", &size),
            ("what", what),
            ("configuration", name),
            ("lights", &settings.lights.to_string()),
            ("map", &settings.map.to_string()),
        ]);
        Ok(key
            .on("scene", &self.hash)
            .on("settings", format!("{settings:?}"))
            .on("steps", self.steps(settings, parts)?)
            .on("shaders", self.shaders(&variants)?)
            .on("adapter", &self.gpu.adapter.name)
            .on("driver", &self.gpu.adapter.driver))
    }

    /// The key of what depends on the scene, its maps and its direct light, and on no configuration.
    ///
    /// # Errors
    ///
    /// When the package lacks a shader that draws them.
    pub fn scene_key(&self, what: &str) -> Result<Key, FrontierError> {
        let parts = [part::SURFACES, part::PICTURE];
        let variants = Plan::of(&self.evaluated(&self.base, Some(&parts))?).variants;
        let Settings { size: [width, height], map: rsm_size, .. } = self.base;
        let (size, map) = (format!("{width}x{height}"), rsm_size.to_string());
        let what =
            [("scene", self.scene.name.as_str()), ("size", &size), ("map", &map), ("what", what)];
        Ok(Key::new(&what)
            .on("scene", &self.hash)
            .on("ndf", self.base.ndf.name())
            .on("steps", self.steps(&self.base, &parts)?)
            .on("shaders", self.shaders(&variants)?)
            .on("adapter", &self.gpu.adapter.name)
            .on("driver", &self.gpu.adapter.driver))
    }

    /// The hash of shaders.
    fn shaders(&self, variants: &BTreeSet<String>) -> Result<String, FrontierError> {
        let mut all = String::new();
        let mut texts = self.texts.borrow_mut();
        for id in variants {
            if !texts.contains_key(id) {
                texts.insert(id.clone(), sha256(self.package.text(id)?.as_bytes()));
            }
            all.push_str(id);
            all.push_str(&texts[id]);
        }
        Ok(sha256(all.as_bytes()))
    }
}

/// The hash of all that a scene is made of.
#[must_use]
pub fn scene_hash(scene: &Scene) -> String {
    fn floats<const N: usize>(hash: &mut Sha256, values: &[[f32; N]]) {
        hash.update((values.len() as u64).to_le_bytes());
        for value in values.iter().flatten() {
            hash.update(value.to_bits().to_le_bytes());
        }
    }
    let mut hash = Sha256::new();
    for mesh in &scene.meshes {
        floats(&mut hash, &mesh.positions);
        floats(&mut hash, &mesh.normals);
        floats(&mut hash, &mesh.uvs);
        floats(&mut hash, &mesh.detail.uvs);
        floats(&mut hash, &mesh.detail.colors);
        floats(&mut hash, &mesh.detail.tangents);
        hash.update((mesh.indices.len() as u64).to_le_bytes());
        for index in &mesh.indices {
            hash.update(index.to_le_bytes());
        }
        hash.update((mesh.material as u64).to_le_bytes());
    }
    for image in &scene.images {
        hash.update(format!("{image:?}"));
        hash.update(&image.rgba8);
    }
    hash.update(format!("{:?} {:?} {:?}", scene.materials, scene.lights, scene.camera));
    base16ct::lower::encode_string(&hash.finalize())
}

/// A pixel with what was shaded there, as a report has it.
#[must_use]
pub fn worst(
    surfaces: &Surfaces,
    width: u32,
    at: usize,
    found: [f64; 3],
    expected: [f64; 3],
) -> Worst {
    let bits = |texel: [f32; 4]| texel.map(|value| format!("{:08x}", value.to_bits()));
    let column = at as u32 % width.max(1);
    Worst {
        pixel: [column, at as u32 / width.max(1)],
        found,
        expected,
        surface: [&surfaces.position, &surfaces.normal, &surfaces.base_color]
            .map(|texels| bits(texels.get(at).copied().unwrap_or_default())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_a_scene_is_made_of_counts() {
        let scene = Scene::builtin("cornell").unwrap();
        let hash = scene_hash(&scene);
        assert_eq!(hash, scene_hash(&scene.clone()));
        let changes: [fn(&mut Scene); 9] = [
            |scene| scene.meshes[0].positions[0][1] += 1e-3,
            |scene| scene.meshes[0].indices.swap(0, 1),
            |scene| scene.meshes[0].material = 1,
            |scene| scene.meshes[0].detail.uvs.push([0.5; 2]),
            |scene| scene.meshes[0].detail.colors.push([0.5; 4]),
            |scene| scene.meshes[0].detail.tangents.push([0.5; 4]),
            |scene| scene.materials[0].roughness = 0.25,
            |scene| scene.lights[0].intensity[2] *= 2.0,
            |scene| scene.camera.position[0] += 1.0,
        ];
        for (index, change) in changes.iter().enumerate() {
            let mut other = scene.clone();
            change(&mut other);
            assert_ne!(scene_hash(&other), hash, "{index}");
        }
    }
}

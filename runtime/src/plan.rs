//! What a frame takes, without a device: the variants that it runs and the bytes that it keeps.

use std::collections::{BTreeMap, BTreeSet};

use sglow_shaders::{Diffuse, Emission, Material, Opacity, Specular};

use crate::frame::{SHADOW_SIZE, light_map_config, terms};
use crate::indirect::{camera_recipe, recipe, total};
use crate::raster::{SurfaceTargets, drawing, traits};
use crate::scene::Scene;
use crate::settings::Settings;

/// A part of a frame, in the order of the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// What is rasterised: the light's map, the camera's G-buffer, the shadow map of direct light. An engine has them
    /// already.
    Surfaces,
    /// What turns the light's map into reflected radiance: what [`crate::indirect::Indirect`] keeps.
    Indirect,
    /// The maps of the virtual lights.
    Visibility,
    /// Direct light, emission and the picture.
    Picture,
}

/// What memory is used as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Storage {
    /// A texture.
    Texture,
    /// A buffer.
    Buffer,
}

/// Something that is kept from pass to pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resource {
    /// Its part of the frame.
    pub part: Part,
    /// What it is.
    pub storage: Storage,
    /// Its name in [`crate::frame::Renderer::bytes`].
    pub name: &'static str,
    /// Its size in bytes.
    pub bytes: u64,
}

/// What surfaces are drawn with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Surfaces {
    /// Kinds of materials, and whether some of the kind emit.
    kinds: BTreeMap<(Material, Opacity), bool>,
    /// Whether emission is a part of the picture.
    emits: bool,
    positions: u64,
    indices: u64,
}

impl Surfaces {
    /// Those of a scene, drawn with the least that they need; or, if `complete`, with what can do everything.
    pub fn of(scene: &Scene, complete: bool) -> Self {
        let traits = traits(scene, complete);
        let mut kinds = BTreeMap::new();
        for traits in scene.meshes.iter().filter_map(|mesh| traits.get(mesh.material)) {
            let material = if traits.textured { Material::Textured } else { Material::Constant };
            let opacity = if traits.cutout { Opacity::Cutout } else { Opacity::Opaque };
            *kinds.entry((material, opacity)).or_insert(complete) |= traits.emits;
        }
        let emits = kinds.values().any(|&emits| emits);
        let sum = |of: fn(&crate::scene::Mesh) -> usize| scene.meshes.iter().map(of).sum::<usize>();
        Self {
            kinds,
            emits,
            positions: sum(|mesh| mesh.positions.len()) as u64,
            indices: sum(|mesh| mesh.indices.len()) as u64,
        }
    }

    /// The same triangles of materials of which some are of every kind that these values allow, as if some emitted
    /// where `emission` is seen. Kinds that nothing can be of are left out.
    #[must_use]
    pub fn with_kinds(
        &self,
        materials: &[Material],
        opacities: &[Opacity],
        emission: Emission,
    ) -> Self {
        let emits = emission == Emission::Seen;
        let drawn = |material: Material, opacity: Opacity| {
            sglow_shaders::surface::Surface { material, opacity }.is_legal()
        };
        let kinds = materials.iter().flat_map(|&material| {
            let legal = opacities.iter().filter(move |&&opacity| drawn(material, opacity));
            legal.map(move |&opacity| ((material, opacity), emits))
        });
        Self { kinds: kinds.collect(), emits, ..self.clone() }
    }

    /// What is of the kinds of either. The triangles are these.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let mut both = self.clone();
        for (kind, emits) in &other.kinds {
            *both.kinds.entry(*kind).or_insert(false) |= emits;
        }
        both.emits |= other.emits;
        both
    }
}

/// The variants that a [`crate::frame::Renderer`] asks its package for, and the memory that it keeps.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    /// Identifiers of variants.
    pub variants: BTreeSet<String>,
    /// Memory, part by part; parameters, which take some hundred bytes, and the scene itself are left out.
    pub resources: Vec<Resource>,
}

impl Plan {
    /// What a renderer takes with these settings. It takes the kind of its light from the scene; here it is that of the
    /// settings.
    pub fn new(settings: &Settings, surfaces: &Surfaces) -> Self {
        let mut plan = Self::default();
        plan.draw(settings, surfaces);
        plan.light_indirectly(settings);
        plan.hide(settings, surfaces);
        plan.add_up(settings, surfaces);
        plan
    }

    fn keep(&mut self, part: Part, storage: Storage, name: &'static str, bytes: u64) {
        self.resources.push(Resource { part, storage, name, bytes });
    }

    fn keep_all(&mut self, part: Part, storage: Storage, all: Vec<(&'static str, u64)>) {
        for (name, bytes) in all {
            self.keep(part, storage, name, bytes);
        }
    }

    fn draw(&mut self, settings: &Settings, surfaces: &Surfaces) {
        for (&(material, opacity), &emits) in &surfaces.kinds {
            let [surface, shadow, emission] = drawing(material, opacity);
            self.variants.extend([surface, shadow]);
            self.variants.extend(emits.then_some(emission));
        }
        let texels = u64::from(settings.rsm_size).pow(2);
        let of = |texels: u64| texels * SurfaceTargets::TEXEL;
        self.keep(Part::Surfaces, Storage::Texture, "reflective shadow map", of(texels));
        self.keep(Part::Surfaces, Storage::Texture, "G-buffer", of(pixels(settings)));
        let shadow_map = 4 * u64::from(SHADOW_SIZE).pow(2);
        self.keep(Part::Surfaces, Storage::Texture, "shadow map", shadow_map);
    }

    fn light_indirectly(&mut self, settings: &Settings) {
        let recipe = recipe(settings);
        self.variants.extend(recipe.variants());
        let [textures, buffers] = recipe.bytes();
        self.keep_all(Part::Indirect, Storage::Texture, textures);
        self.keep_all(Part::Indirect, Storage::Buffer, buffers);
        if let Some(camera) = camera_recipe(settings) {
            self.variants.extend(camera.variants());
            let [textures, buffers] = camera.bytes().map(total);
            self.keep(Part::Indirect, Storage::Texture, "camera textures", textures);
            self.keep(Part::Indirect, Storage::Buffer, "camera buffers", buffers);
        }
        self.variants.insert(settings.shade().id());
        let reflected = 16 * pixels(settings);
        if settings.diffuse != Diffuse::None {
            self.keep(Part::Indirect, Storage::Texture, "diffuse", reflected);
        }
        if settings.specular != Specular::None {
            self.keep(Part::Indirect, Storage::Texture, "specular", reflected);
        }
    }

    fn hide(&mut self, settings: &Settings, surfaces: &Surfaces) {
        let config = light_map_config(settings);
        let variants = config.variants();
        if variants.is_empty() {
            return;
        }
        self.variants.extend(variants);
        let (atlas, buffers) = config.bytes(surfaces.positions, surfaces.indices);
        self.keep(Part::Visibility, Storage::Texture, "light maps", atlas);
        self.keep_all(Part::Visibility, Storage::Buffer, buffers);
    }

    fn add_up(&mut self, settings: &Settings, surfaces: &Surfaces) {
        let Settings { light, ndf, .. } = *settings;
        self.variants.insert(sglow_shaders::direct::Direct { light, ndf }.id());
        let emission = if surfaces.emits { Emission::Seen } else { Emission::None };
        let indirect = terms(settings);
        self.variants.insert(sglow_shaders::compose::Compose { indirect, emission }.id());
        let radiance = 16 * pixels(settings);
        self.keep(Part::Picture, Storage::Texture, "direct", radiance);
        if surfaces.emits {
            self.keep(Part::Picture, Storage::Texture, "emission", 8 * pixels(settings));
        }
        self.keep(Part::Picture, Storage::Texture, "radiance", radiance);
    }

    /// What a frame takes that may be either: the variants of both, and of each memory the larger.
    #[must_use]
    pub fn or(mut self, other: Self) -> Self {
        self.variants.extend(other.variants);
        for resource in other.resources {
            match self.resources.iter_mut().find(|own| own.name == resource.name) {
                Some(own) => own.bytes = own.bytes.max(resource.bytes),
                None => self.resources.push(resource),
            }
        }
        self
    }

    /// The bytes of a kind of memory, in one part or, without, in all of them.
    pub fn bytes(&self, storage: Storage, part: Option<Part>) -> u64 {
        let counts = |resource: &&Resource| {
            resource.storage == storage && part.is_none_or(|part| resource.part == part)
        };
        self.resources.iter().filter(counts).map(|resource| resource.bytes).sum()
    }
}

fn pixels(settings: &Settings) -> u64 {
    settings.size.into_iter().map(u64::from).product()
}

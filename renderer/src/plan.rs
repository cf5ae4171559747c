//! What a frame takes, without a device: the variants that it runs and the bytes that it keeps.

use std::collections::{BTreeMap, BTreeSet};

use sglow_graph::frame::Kind;
use sglow_graph::{Configuration, Description, Errors, Frame};

use crate::raster::{axes, traits};
use sglow_runtime::host;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;

/// What memory is used as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Storage {
    /// A texture.
    Texture,
    /// A buffer.
    Buffer,
}

/// Something that is kept from pass to pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Resource {
    /// Its part of the frame.
    pub part: String,
    /// What it is.
    pub storage: Storage,
    /// Its name in [`crate::frame::Renderer::bytes`].
    pub name: String,
    /// Its size in bytes.
    pub bytes: u64,
}

/// What surfaces are drawn with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Surfaces {
    /// Kinds of materials: whether they have textures and alpha test, and whether some of the kind emit.
    kinds: BTreeMap<(String, String), bool>,
    /// Whether emission is a part of the picture.
    emits: bool,
    /// Numbers of vertices and of indices.
    counts: [u64; 2],
}

impl Surfaces {
    /// Those of a scene, drawn with the least that they need; or, if `complete`, with what can do everything.
    pub fn of(scene: &Scene, complete: bool) -> Self {
        let traits = traits(scene, complete);
        let mut kinds = BTreeMap::new();
        for traits in scene.meshes.iter().filter_map(|mesh| traits.get(mesh.material)) {
            let (material, opacity) = axes(traits);
            let kind = (material.to_string(), opacity.to_string());
            *kinds.entry(kind).or_insert(false) |= traits.emits;
        }
        let emits = complete || kinds.values().any(|&emits| emits);
        let sum = |of: fn(&sglow_scene::Mesh) -> usize| scene.meshes.iter().map(of).sum::<usize>();
        let counts = [sum(|mesh| mesh.positions.len()), sum(|mesh| mesh.indices.len())];
        Self { kinds, emits, counts: counts.map(|count| count as u64) }
    }

    /// The same triangles of materials of which some are of each of these kinds, as if some emitted where emission is seen.
    #[must_use]
    pub fn with_kinds(&self, kinds: &[(String, String)], emits: bool) -> Self {
        let kinds = kinds.iter().map(|kind| (kind.clone(), emits)).collect();
        Self { kinds, emits, ..self.clone() }
    }

    /// What is of the kinds of either. The triangles are these.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let mut both = self.clone();
        for (kind, emits) in &other.kinds {
            *both.kinds.entry(kind.clone()).or_insert(false) |= emits;
        }
        both.emits |= other.emits;
        both
    }

    /// Adds the axes and numbers that follow from the surfaces.
    pub fn describe(&self, configuration: &mut Configuration) {
        let emission = if self.emits { "seen" } else { "none" };
        configuration.axes.insert("emission".to_owned(), emission.to_owned());
        let drawn = |only_emitters: bool| {
            let kinds = self.kinds.iter().filter(|(_, emits)| **emits || !only_emitters);
            let axes = kinds.map(|((material, opacity), _)| {
                let axes = [("material", material), ("opacity", opacity)];
                axes.map(|(axis, value)| (axis.to_owned(), value.clone())).into()
            });
            axes.collect()
        };
        configuration.draws = [("surfaces", drawn(false)), ("emitters", drawn(true))]
            .map(|(name, axes)| (name.to_owned(), axes))
            .into();
        host::occluder_counts(configuration, self.counts);
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
    ///
    /// # Errors
    ///
    /// What the description says against the settings.
    pub fn new(
        description: &Description,
        settings: &Settings,
        surfaces: &Surfaces,
    ) -> Result<Self, Errors> {
        let mut configuration = settings.configuration();
        surfaces.describe(&mut configuration);
        Ok(Self::of(&description.evaluate(&configuration)?))
    }

    /// The same, with the variants that it takes at any other size: the lengths of mip chains choose some.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn of_any_size(
        description: &Description,
        settings: &Settings,
        surfaces: &Surfaces,
    ) -> Result<Self, Errors> {
        let mut plan = Self::new(description, settings, surfaces)?;
        // Lengths of chains repeat after three levels.
        for side in [8, 16, 32] {
            let other = Settings { size: [side; 2], map: side, ..settings.clone() };
            // Sizes that a library does not allow run nothing.
            if let Ok(other) = Self::new(description, &other, surfaces) {
                plan.variants.extend(other.variants);
            }
        }
        Ok(plan)
    }

    /// What a frame takes.
    pub fn of(frame: &Frame) -> Self {
        let resource = |one: &sglow_graph::frame::Resource| {
            let storage = match one.kind {
                Kind::Buffer { .. } => Storage::Buffer,
                Kind::Texture { .. } => Storage::Texture,
                Kind::Sampler { .. } => return None,
            };
            let (part, name) = (one.part.clone(), one.name.clone());
            Some(Resource { part, storage, name, bytes: one.bytes })
        };
        Self {
            variants: frame.variants().into_iter().map(|variant| variant.id.clone()).collect(),
            resources: frame.resources.iter().filter_map(resource).collect(),
        }
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

    /// The bytes of a kind of memory, in some parts or, without any, in all of them.
    pub fn bytes(&self, storage: Storage, parts: &[&str]) -> u64 {
        let counts = |resource: &&Resource| {
            resource.storage == storage
                && (parts.is_empty() || parts.contains(&resource.part.as_str()))
        };
        self.resources.iter().filter(counts).map(|resource| resource.bytes).sum()
    }
}

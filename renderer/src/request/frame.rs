//! The frame of what is requested, evaluated, and what its variants do with their bindings.

use std::collections::{BTreeMap, BTreeSet};

use sglow_graph::description::{DrawList, Parameter};
use sglow_graph::frame::Frame;
use sglow_graph::{Configuration, Description};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shader_gen::generate;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::manifest::{self, Resource};
use sglow_shader_gen::matrix::Facts;

use crate::plan::Surfaces;
use crate::request::RequestError;
use crate::request::derivation::{Derivation, Request, settle};

/// What a variant does with one of its bindings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// It reads.
    pub reads: bool,
    /// It writes.
    pub writes: bool,
}

/// The bindings of each variant by its identifier and their names.
pub type Bindings = BTreeMap<String, BTreeMap<String, Access>>;

/// A frame that was requested.
#[derive(Debug)]
pub struct RequestedFrame {
    /// The values that are not the defaults of the description, as `--set` takes them.
    pub changed: Vec<String>,
    /// All values.
    pub configuration: Configuration,
    /// Its resources and steps.
    pub frame: Frame,
    /// What each variant does with its bindings.
    pub bindings: Bindings,
}

impl RequestedFrame {
    /// The frame of a scene, or of none, as the package describes it, else the library.
    ///
    /// # Errors
    ///
    /// When the configuration is not possible, nothing describes a frame or a variant is missing.
    pub fn new(
        library: &Library,
        package: Option<&Package>,
        scene: Option<&Scene>,
        set: &[String],
        request: &Request,
    ) -> Result<Self, RequestError> {
        let settings = match scene {
            Some(scene) => Derivation::new(library, scene, set, request)?.settings,
            None => {
                let facts = Facts::new();
                let requested = request.settings(library, &facts, set)?;
                settle(library, &library.needed(&facts)?, set, &requested)?
            }
        };
        let description = match package {
            Some(package) => package.description(),
            None => library.frame().map(|frame| &frame.description),
        };
        let origin = package.map_or("library", Package::origin);
        let none = || RequestError::NoDescription(origin.to_owned());
        let description = description.ok_or_else(none)?;
        let configuration = configuration(&settings, scene, description);
        let frame = description.evaluate(&configuration)?;
        let bindings = match package {
            Some(package) => of_package(package, &frame)?,
            None => of_library(library, &frame)?,
        };
        let changed = changed(description, &configuration);
        Ok(Self { changed, configuration, frame, bindings })
    }
}

/// Settings in the words of the frame. Without a scene the host draws with the defaults of its lists' axes.
fn configuration(
    settings: &Settings,
    scene: Option<&Scene>,
    description: &Description,
) -> Configuration {
    let mut configuration = settings.configuration();
    if let Some(scene) = scene {
        Surfaces::of(scene, settings.complete).describe(&mut configuration);
        return configuration;
    }
    let kind = |list: &DrawList| {
        let default =
            |axis: &String| Some((axis.clone(), description.axes.get(axis)?.default.clone()));
        BTreeSet::from([list.axes.iter().filter_map(default).collect()])
    };
    let lists = description.draws.iter();
    configuration.draws = lists.map(|(name, list)| (name.clone(), kind(list))).collect();
    configuration
}

/// What is not the default of the description, as `--set` takes it.
fn changed(description: &Description, configuration: &Configuration) -> Vec<String> {
    let axes = configuration.axes.iter().filter(|(name, value)| {
        description.axes.get(*name).is_some_and(|axis| axis.default != **value)
    });
    let axes = axes.map(|(name, value)| format!("{name}={value}"));
    let numbers = configuration.parameters.iter().filter(|(name, number)| {
        let known = description.parameter.get(*name);
        // Settings hold real numbers in 32 bits.
        let same = |known: &Parameter| known.default.real() as f32 == number.real() as f32;
        // The title says the sizes of what the host has, and the scene.
        known.is_some_and(|known| !known.host && !same(known))
    });
    let numbers = numbers.map(|(name, number)| format!("{name}={}", number.real() as f32));
    axes.chain(numbers).collect()
}

/// What the variants of a frame bind, by the texts that are generated of them.
fn of_library(library: &Library, frame: &Frame) -> Result<Bindings, RequestError> {
    let mut variants = Vec::new();
    for variant in frame.variants() {
        let values: Vec<(&str, &str)> =
            variant.axes.iter().map(|(axis, value)| (axis.as_str(), value.as_str())).collect();
        variants.push(library.variant(&variant.pass, &values)?);
    }
    let mut bindings = Bindings::new();
    for one in generate::variants(library, &variants)? {
        let reflected = manifest::reflect(&one.text, &one.module, &one.info)?;
        let of = reflected.bindings.iter().filter_map(|binding| {
            let access = match &binding.resource {
                Resource::Storage { access, .. } | Resource::StorageTexture { access, .. } => {
                    let reads = *access != manifest::Access::Write;
                    Access { reads, writes: *access != manifest::Access::Read }
                }
                Resource::Uniform { .. } => return None,
                Resource::Texture { .. } | Resource::Sampler { .. } => READ,
            };
            Some((binding.name.clone(), access))
        });
        bindings.insert(one.variant.id(), of.collect());
    }
    Ok(bindings)
}

const READ: Access = Access { reads: true, writes: false };

/// What the variants of a frame bind, as a package says.
fn of_package(package: &Package, frame: &Frame) -> Result<Bindings, RequestError> {
    let mut bindings = Bindings::new();
    for variant in frame.variants() {
        let id = &variant.id;
        // A missing one is an error that names it.
        package.text(id)?;
        let bound = package.interface(id)?.bindings.iter();
        let of = bound.filter(|binding| binding.r#struct.is_none()).map(|binding| {
            let access = match binding.entry.ty {
                wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only },
                    ..
                } => Access { reads: true, writes: !read_only },
                wgpu::BindingType::StorageTexture { access, .. } => Access {
                    reads: access != wgpu::StorageTextureAccess::WriteOnly,
                    writes: access != wgpu::StorageTextureAccess::ReadOnly,
                },
                _ => READ,
            };
            (binding.name.clone(), access)
        });
        bindings.insert(id.clone(), of.collect());
    }
    Ok(bindings)
}

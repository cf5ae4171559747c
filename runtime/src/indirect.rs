//! Indirect light on textures that an engine already has: moments, density, mips, lights, shading.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, MutexGuard, PoisonError};

use glam::Vec3;
use sglow_graph::Configuration;
use sglow_shaders::{Density, Light, Precision, sample::Sample};
use thiserror::Error;

use crate::execute::{self, Executor, Fault, Faults, Lists};
use crate::generation::Recipe;
use crate::host;
use crate::light::LightView;
use crate::package::Package;
use crate::pipeline::PipelineError;
use crate::settings::{Settings, SettingsError};
use crate::timing::Timer;
use crate::visibility::Visibility;

/// Why there is no indirect light.
#[derive(Debug, Error)]
pub enum IndirectError {
    /// The settings cannot be.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Settings(Vec<SettingsError>),
    /// A variant does not become a pipeline.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// The package describes no frame, or one of which nothing comes.
    #[error("{0}; generate the package again: cargo xtask gen-shaders --out DIR")]
    Description(String),
    /// The frame cannot be executed.
    #[error(transparent)]
    Frame(Faults),
}

/// The three surface textures of a reflective shadow map or a G-buffer; what they hold stands in ARCHITECTURE.md.
#[derive(Clone, Copy)]
pub struct SurfaceViews<'a> {
    /// World position; dielectric reflectance in w, negative without a surface.
    pub position: &'a wgpu::TextureView,
    /// Unit normal; roughness alpha in w.
    pub normal: &'a wgpu::TextureView,
    /// Base colour; metallic in w.
    pub base_color: &'a wgpu::TextureView,
}

/// What one frame of indirect light reads.
pub struct Inputs<'a> {
    /// The reflective shadow map, `rsm_size` squared.
    pub rsm: SurfaceViews<'a>,
    /// The camera's G-buffer, of the picture's size.
    pub gbuffer: SurfaceViews<'a>,
    /// The light and its map.
    pub light: &'a LightView,
    /// The camera's position.
    pub eye: Vec3,
    /// The maps of the virtual lights, of the kind that the settings name; none where lights shine through walls.
    pub visibility: Option<&'a Visibility>,
}

/// What the light's virtual lights are made of.
pub(crate) fn recipe(settings: &Settings) -> Recipe {
    Recipe {
        size: [settings.rsm_size; 2],
        count: settings.count,
        light: settings.light,
        lobes: settings.lobes,
        specular_power: settings.specular_power(),
        precision: settings.precision,
        density: settings.density,
        sample: settings.sample(),
        emitter: settings.emitter,
        diffuse_mean_length: settings.diffuse_mean_length(),
        space: settings.space,
    }
}

/// What the camera's virtual lights are made of, if there are any.
pub(crate) fn camera_recipe(settings: &Settings) -> Option<Recipe> {
    let precision = Precision::F32;
    (settings.density == Density::Bidirectional).then(|| Recipe {
        size: settings.size,
        count: settings.camera_count,
        light: Light::Camera,
        precision,
        density: Density::Reflectance,
        sample: Sample { precision, ..settings.sample() },
        ..recipe(settings)
    })
}

/// The passes of indirect light, with all they keep between them.
///
/// Nothing that the settings leave out exists: without specular lobes there are no specular moments, no mips of them,
/// no fields for them in the lights, and no texture for their light; without the bidirectional density the camera has no
/// lights.
pub struct Indirect {
    settings: Settings,
    executor: Mutex<Executor>,
    textures: BTreeMap<&'static str, wgpu::Texture>,
    buffers: BTreeMap<&'static str, wgpu::Buffer>,
    bytes: Vec<(String, u64)>,
}

/// What others may read.
const TEXTURES: [&str; 8] = [
    "moments",
    "half_moments",
    "own_weights",
    "density",
    "camera_moments",
    "camera_density",
    "diffuse",
    "specular",
];
const BUFFERS: [&str; 9] = [
    "vsgls",
    "kernels",
    "chains",
    "camera_vsgls",
    "centres",
    "starts",
    "texels_keys",
    "texels_values.0",
    "texels_values.1",
];

impl From<Faults> for IndirectError {
    /// A single variant that is at fault stands for itself.
    fn from(Faults(mut faults): Faults) -> Self {
        match (faults.pop(), faults.is_empty()) {
            (Some(Fault::Pipeline(error)), true) => Self::Pipeline(error),
            (Some(Fault::Variant { error, .. }), true) => Self::Pipeline(error.into()),
            (last, _) => {
                faults.extend(last);
                Self::Frame(Faults(faults))
            }
        }
    }
}

impl Indirect {
    /// Indirect light by the embedded package.
    ///
    /// # Errors
    ///
    /// All the settings that cannot be, at once; or the variant that the device refuses.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        settings: &Settings,
    ) -> Result<Self, IndirectError> {
        Self::with_package(device, queue, settings, &Package::embedded())
    }

    /// Indirect light by a package of choice.
    pub fn with_package(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        settings: &Settings,
        package: &Package,
    ) -> Result<Self, IndirectError> {
        let faults = settings.faults(device);
        if !faults.is_empty() {
            return Err(IndirectError::Settings(faults));
        }
        let Some(description) = package.description() else {
            let text = format!("the package {} describes no frame", package.origin());
            return Err(IndirectError::Description(text));
        };
        let parts = Some(BTreeSet::from(["indirect".to_owned()]));
        let configuration = Configuration { parts, ..settings.configuration() };
        let frame = description
            .evaluate(&configuration)
            .map_err(|errors| IndirectError::Description(errors.to_string()))?;
        let executor = Executor::new(device, queue, package, &frame, &Lists::new())?;
        let textures =
            TEXTURES.into_iter().filter_map(|name| Some((name, executor.texture(name)?.clone())));
        let buffers =
            BUFFERS.into_iter().filter_map(|name| Some((name, executor.buffer(name)?.clone())));
        Ok(Self {
            settings: settings.clone(),
            textures: textures.collect(),
            buffers: buffers.collect(),
            bytes: executor.bytes().map(|(name, bytes)| (name.to_owned(), bytes)).collect(),
            executor: Mutex::new(executor),
        })
    }

    /// What a thread that panicked has left is as good as any.
    fn executor(&self) -> MutexGuard<'_, Executor> {
        self.executor.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn stage(
        &self,
        wanted: impl Fn(&str) -> bool,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &execute::Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) -> Result<(), IndirectError> {
        Ok(self.executor().encode_where(wanted, encoder, inputs, timer)?)
    }

    /// What the steps before the last one take.
    fn given<'a>(&self, inputs: &Inputs<'_>) -> execute::Inputs<'a> {
        let mut given = self.lit(inputs.light);
        host::eye_at(&mut given, inputs.eye);
        for (prefix, map) in [("rsm", inputs.rsm), ("gbuffer", inputs.gbuffer)] {
            let names: [&'static str; 3] = match prefix {
                "rsm" => ["rsm_position", "rsm_normal", "rsm_base_color"],
                _ => GBUFFER,
            };
            for (name, view) in names.into_iter().zip([map.position, map.normal, map.base_color]) {
                given.view(name, view);
            }
        }
        given
    }

    fn lit<'a>(&self, light: &LightView) -> execute::Inputs<'a> {
        let mut given = execute::Inputs::new();
        host::light(&mut given, light);
        given.set("diffuse_mean_length", self.settings.diffuse_mean_length());
        given
    }

    /// Encodes one frame: from the reflective shadow map to reflected radiance in [`Self::diffuse`] and
    /// [`Self::specular`].
    ///
    /// # Errors
    ///
    /// What of the inputs does not fit.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        mut timer: Option<&mut Timer<'_>>,
    ) -> Result<(), IndirectError> {
        let given = self.given(inputs);
        self.stage(|label| label != SHADE, encoder, &given, timer.as_deref_mut())?;
        let Inputs { gbuffer, eye, .. } = *inputs;
        if let Some(maps) = inputs.visibility {
            maps.encode(encoder, self.vsgls(), self.settings.count, timer.as_deref_mut());
        }
        self.encode_shade_with(encoder, gbuffer, eye, inputs.visibility, timer)
    }

    /// Before all: the camera's virtual lights. Nothing without the bidirectional density.
    /// [Ritschel 2011; Tokuyoshi 2016, Section 5]
    pub fn encode_camera(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) -> Result<(), IndirectError> {
        self.stage(|label| label.starts_with(CAMERA), encoder, &self.given(inputs), timer)
    }

    /// The first stage: what clusters of the reflective shadow map sum.
    pub fn encode_moments(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) -> Result<(), IndirectError> {
        self.stage(|label| label == "moments", encoder, &self.given(inputs), timer)
    }

    /// The second stage: level 0 of the density. Nothing with 16-bit moments drawn by power, whose own pass writes the
    /// weight that the density is.
    pub fn encode_density(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) -> Result<(), IndirectError> {
        self.stage(|label| label == "density", encoder, &self.given(inputs), timer)
    }

    /// In place of the second stage: level 0 of the density from another that has encoded it. Both have maps of the same
    /// size; copies as much as both hold.
    pub fn encode_density_of(&self, encoder: &mut wgpu::CommandEncoder, other: &Self) {
        let (from, to) = (other.density(), self.density());
        let size = wgpu::Extent3d {
            width: from.width().min(to.width()),
            height: from.height().min(to.height()),
            depth_or_array_layers: 1,
        };
        encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), size);
    }

    /// The third stage: the mip chains from their levels 0.
    pub fn encode_mips(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: Option<&mut Timer<'_>>,
    ) -> Result<(), IndirectError> {
        let mips = |label: &str| label.starts_with("mip ");
        self.stage(mips, encoder, &execute::Inputs::new(), timer)
    }

    /// The fourth stage: kernels, or clusters, and virtual lights. Markov chains, if they draw the centres, move before.
    pub fn encode_sample(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) -> Result<(), IndirectError> {
        self.stage(is_sample, encoder, &self.given(inputs), timer)
    }

    /// The fourth stage with kernels alone, which needs no map.
    pub(crate) fn encode_kernels(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        light: &LightView,
        timer: Option<&mut Timer<'_>>,
    ) -> Result<(), IndirectError> {
        self.stage(is_sample, encoder, &self.lit(light), timer)
    }

    /// The last stage: the virtual lights reflected towards the camera.
    pub fn encode_shade(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: SurfaceViews<'_>,
        eye: Vec3,
        timer: Option<&mut Timer<'_>>,
    ) -> Result<(), IndirectError> {
        self.encode_shade_with(encoder, gbuffer, eye, None, timer)
    }

    /// The last stage with visibility: what [`Self::encode_shade`] does, of lights that their maps show to be seen. The
    /// maps are encoded before, and are of the kind that the settings name.
    pub fn encode_shade_visible(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: SurfaceViews<'_>,
        eye: Vec3,
        visibility: &Visibility,
        timer: Option<&mut Timer<'_>>,
    ) -> Result<(), IndirectError> {
        self.encode_shade_with(encoder, gbuffer, eye, Some(visibility), timer)
    }

    fn encode_shade_with(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: SurfaceViews<'_>,
        eye: Vec3,
        visibility: Option<&Visibility>,
        timer: Option<&mut Timer<'_>>,
    ) -> Result<(), IndirectError> {
        let mut given = execute::Inputs::new();
        host::eye_at(&mut given, eye);
        let views = [gbuffer.position, gbuffer.normal, gbuffer.base_color];
        for (name, view) in GBUFFER.into_iter().zip(views) {
            given.view(name, view);
        }
        if let Some(maps) = visibility {
            host::light_maps(&mut given, maps.config().least_near, maps.config().bias());
            given.view("light_maps", maps.view());
        }
        self.stage(|label| label == SHADE, encoder, &given, timer)
    }

    /// Lets Markov chains begin again with the next frame.
    pub fn restart(&self) {
        self.executor().restart();
    }

    /// What it was made with.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Diffusely reflected radiance, rgba32float; nothing without diffuse reflection.
    pub fn diffuse(&self) -> Option<&wgpu::Texture> {
        self.textures.get("diffuse")
    }

    /// Specularly reflected radiance, rgba32float; nothing without specular reflection.
    pub fn specular(&self) -> Option<&wgpu::Texture> {
        self.textures.get("specular")
    }

    /// The moments with their mips, rgba32float, one layer for each: all of them, or those that 16 bits do not suffice
    /// for. A power-of-two square; texels beyond the reflective shadow map are 0. Clusters need no mips of them, and with
    /// the reflectance for density none at all.
    pub fn moments(&self) -> Option<&wgpu::Texture> {
        self.textures.get("moments")
    }

    /// The moments that 16 bits suffice for with their mips, rgba16float, in [`LightView::power_unit`]; nothing with
    /// 32-bit precision.
    pub fn half_moments(&self) -> Option<&wgpu::Texture> {
        self.textures.get("half_moments")
    }

    /// The weights with their mips, r32float, where they are neither in the moments (32-bit precision) nor the density
    /// (drawn by power).
    pub fn weights(&self) -> Option<&wgpu::Texture> {
        self.textures.get("own_weights")
    }

    /// The density with its mips, r32float.
    pub fn density(&self) -> &wgpu::Texture {
        &self.textures["density"]
    }

    /// The virtual lights: `SglowVsglBoth` or `SglowVsglDiffuse`, after the lobes; with 16-bit precision
    /// `SglowPackedVsglBoth` or `SglowPackedVsglDiffuse`.
    pub fn vsgls(&self) -> &wgpu::Buffer {
        &self.buffers["vsgls"]
    }

    /// The kernels that the lights were made of: `SglowKernel`; nothing with clusters.
    pub fn kernels(&self) -> Option<&wgpu::Buffer> {
        self.buffers.get("kernels")
    }

    /// The texels of the map in the order of their clusters, a word each; nothing with kernels.
    pub fn order(&self) -> Option<&wgpu::Buffer> {
        // As many digits were sorted by as the numbers of clusters have.
        let bits = u32::BITS - (self.settings.count - 1).leading_zeros();
        let names = ["texels_values.0", "texels_values.1"];
        self.buffers.get(names[bits.div_ceil(4) as usize % 2])
    }

    /// Where the texels of each cluster begin in [`Self::order`], and behind the last one where they all end.
    pub fn starts(&self) -> Option<&wgpu::Buffer> {
        self.buffers.get("starts")
    }

    /// The cluster of each texel, row by row: a word each; nothing with kernels.
    pub fn assignment(&self) -> Option<&wgpu::Buffer> {
        self.buffers.get("texels_keys")
    }

    /// Where the chains are that draw the centres, two floats each; nothing if they are drawn otherwise.
    pub fn chains(&self) -> Option<&wgpu::Buffer> {
        self.buffers.get("chains")
    }

    /// The camera's virtual lights, in 32 bits: `SglowVsglBoth` or `SglowVsglDiffuse`; nothing without the bidirectional
    /// density.
    pub fn camera_vsgls(&self) -> Option<&wgpu::Buffer> {
        self.buffers.get("camera_vsgls")
    }

    /// The moments of the camera's G-buffer, as [`Self::moments`]; nothing without the bidirectional density.
    pub fn camera_moments(&self) -> Option<&wgpu::Texture> {
        self.textures.get("camera_moments")
    }

    /// The density on the camera's G-buffer, as [`Self::density`]; nothing without the bidirectional density.
    pub fn camera_density(&self) -> Option<&wgpu::Texture> {
        self.textures.get("camera_density")
    }

    /// The bytes of each texture, with its mips, and of each buffer that it keeps between its passes; those of the
    /// parameters are left out.
    pub fn bytes(&self) -> Vec<(&'static str, u64)> {
        let sum = |group: &&'static str| {
            let own = self.bytes.iter().filter(|(name, _)| self.group(name) == *group);
            let bytes: u64 = own.map(|(_, bytes)| bytes).sum();
            (bytes > 0).then_some((*group, bytes))
        };
        GROUPS.iter().filter_map(sum).collect()
    }

    /// What the bytes of a resource are counted under.
    fn group(&self, name: &str) -> &'static str {
        match name {
            "half_moments" => "half moments",
            "own_weights" => "weights",
            "centres" | "centres_box" => "centres",
            "children" | "parents" | "leaves" | "boxes" => "cluster tree",
            "starts" => "sorted texels",
            _ if name.starts_with("codes_") => "cluster tree",
            _ if name.starts_with("texels_") => "sorted texels",
            _ if name.starts_with("camera_") => {
                let texture = ["moments", "density"].iter().any(|end| name.ends_with(end));
                if texture { "camera textures" } else { "camera buffers" }
            }
            _ => GROUPS.iter().find(|group| **group == name).copied().unwrap_or("others"),
        }
    }
}

/// What bytes are counted under, in the order of the frame.
const GROUPS: [&str; 14] = [
    "moments",
    "half moments",
    "weights",
    "density",
    "centres",
    "cluster tree",
    "sorted texels",
    "vsgls",
    "kernels",
    "chains",
    "camera textures",
    "camera buffers",
    "diffuse",
    "specular",
];

/// The label of the last stage.
const SHADE: &str = "shade";
/// What the labels of the camera's own stages begin with.
const CAMERA: &str = "camera ";
const GBUFFER: [&str; 3] = ["gbuffer_position", "gbuffer_normal", "gbuffer_base_color"];

/// Whether a label is one of the fourth stage's.
fn is_sample(label: &str) -> bool {
    !(label.starts_with(CAMERA)
        || label.starts_with("mip ")
        || [SHADE, "moments", "density"].contains(&label))
}

/// The sum of bytes.
pub(crate) fn total(bytes: Vec<(&'static str, u64)>) -> u64 {
    bytes.into_iter().map(|(_, bytes)| bytes).sum()
}

/// A texture that passes write, passes read, and the CPU can read back.
pub(crate) fn picture(
    device: &wgpu::Device,
    label: &str,
    size: [u32; 2],
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    let attachment = if format == wgpu::TextureFormat::Rgba32Float {
        wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::STORAGE_BINDING
    } else {
        wgpu::TextureUsages::RENDER_ATTACHMENT
    };
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: attachment
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

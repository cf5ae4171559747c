//! Indirect light on textures that an engine already has: moments, density, mips, lights, shading.

use glam::Vec3;
use sglow_shaders::{Density, Light, Precision, sample::Sample};

use crate::cluster::{ClusterError, Clusters};
use crate::generation::{Generation, Importance, Recipe};
use crate::labels::Labels;
use crate::light::LightView;
use crate::metropolis::Metropolis;
use crate::package::Package;
use crate::pipeline::PipelineError;
use crate::pyramid::texture_bytes;
use crate::settings::{Settings, SettingsError};
use crate::shading::{Shading, ShadingInputs};
use crate::timing::Timer;
use crate::visibility::Visibility;
use thiserror::Error;

/// Why there is no indirect light.
#[derive(Debug, Error)]
pub enum IndirectError {
    /// The settings cannot be.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Settings(Vec<SettingsError>),
    /// A variant does not become a pipeline.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// There are no clusters.
    #[error(transparent)]
    Clusters(#[from] ClusterError),
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

/// The camera's virtual lights, which the bidirectional density is made of.
struct Camera {
    generation: Generation,
}

/// The passes of indirect light, with all they keep between them.
///
/// Nothing that the settings leave out exists: without specular lobes there are no specular moments, no mips of them,
/// no fields for them in the lights, and no texture for their light; without the bidirectional density the camera has no
/// lights.
pub struct Indirect {
    settings: Settings,
    camera: Option<Camera>,
    generation: Generation,
    shading: Shading,
}

/// What the light's virtual lights are made of.
pub(crate) fn recipe(settings: &Settings) -> Recipe {
    Recipe {
        labels: Labels::LIGHT,
        size: [settings.rsm_size; 2],
        count: settings.count,
        size_factor: settings.size_factor,
        iterations: settings.iterations,
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
        labels: Labels::CAMERA,
        size: settings.size,
        count: settings.camera_count,
        light: Light::Camera,
        precision,
        density: Density::Reflectance,
        sample: Sample { precision, ..settings.sample() },
        ..recipe(settings)
    })
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
        let camera = match camera_recipe(settings) {
            Some(recipe) => {
                Some(Camera { generation: Generation::new(device, queue, recipe, package)? })
            }
            None => None,
        };
        Ok(Self {
            camera,
            generation: Generation::new(device, queue, recipe(settings), package)?,
            shading: Shading::new(device, queue, settings, package)?,
            settings: settings.clone(),
        })
    }

    /// Encodes one frame: from the reflective shadow map to reflected radiance in [`Self::diffuse`] and
    /// [`Self::specular`].
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        mut timer: Option<&mut Timer<'_>>,
    ) {
        self.encode_camera(encoder, inputs, timer.as_deref_mut());
        self.encode_moments(encoder, inputs, timer.as_deref_mut());
        self.encode_density(encoder, inputs, timer.as_deref_mut());
        self.encode_mips(encoder, timer.as_deref_mut());
        self.encode_sample(encoder, inputs, timer.as_deref_mut());
        let Inputs { gbuffer, eye, .. } = *inputs;
        match inputs.visibility {
            None => self.encode_shade(encoder, gbuffer, eye, timer),
            Some(maps) => {
                maps.encode(encoder, self.vsgls(), self.settings.count, timer.as_deref_mut());
                self.encode_shade_visible(encoder, gbuffer, eye, maps, timer);
            }
        }
    }

    /// Before all: the camera's virtual lights. Nothing without the bidirectional density.
    /// [Ritschel 2011; Tokuyoshi 2016, Section 5]
    pub fn encode_camera(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        mut timer: Option<&mut Timer<'_>>,
    ) {
        let Some(Camera { generation }) = &self.camera else { return };
        let view = inputs.light.of_camera(inputs.eye);
        generation.encode_moments(encoder, inputs.gbuffer, &view, timer.as_deref_mut());
        generation.encode_density(encoder, inputs.gbuffer, None, timer.as_deref_mut());
        generation.encode_mips(encoder, timer.as_deref_mut());
        generation.encode_sample(encoder, inputs.gbuffer, &view, timer);
    }

    /// The first stage: what clusters of the reflective shadow map sum.
    pub fn encode_moments(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) {
        self.generation.encode_moments(encoder, inputs.rsm, inputs.light, timer);
    }

    /// The second stage: level 0 of the density. Nothing with 16-bit moments drawn by power, whose own pass writes the
    /// weight that the density is.
    pub fn encode_density(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) {
        let importance = self.camera.as_ref().map(|camera| Importance {
            light: inputs.light.eye(),
            lights: camera.generation.vsgls(),
            count: self.settings.camera_count,
        });
        self.generation.encode_density(encoder, inputs.rsm, importance, timer);
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
    pub fn encode_mips(&self, encoder: &mut wgpu::CommandEncoder, timer: Option<&mut Timer<'_>>) {
        self.generation.encode_mips(encoder, timer);
    }

    /// The fourth stage: kernels, or clusters, and virtual lights. Markov chains, if they draw the centres, move before.
    pub fn encode_sample(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) {
        self.generation.encode_sample(encoder, inputs.rsm, inputs.light, timer);
    }

    /// The fourth stage with kernels alone, which needs no map.
    pub(crate) fn encode_kernels(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        light: &LightView,
        timer: Option<&mut Timer<'_>>,
    ) {
        self.generation.encode_kernels(encoder, light, timer);
    }

    /// The last stage: the virtual lights reflected towards the camera.
    pub fn encode_shade(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: SurfaceViews<'_>,
        eye: Vec3,
        timer: Option<&mut Timer<'_>>,
    ) {
        self.encode_shade_with(encoder, gbuffer, eye, None, timer);
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
    ) {
        self.encode_shade_with(encoder, gbuffer, eye, Some(visibility), timer);
    }

    fn encode_shade_with(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: SurfaceViews<'_>,
        eye: Vec3,
        visibility: Option<&Visibility>,
        timer: Option<&mut Timer<'_>>,
    ) {
        let (vsgls, count) = (self.vsgls(), self.settings.count);
        let inputs = ShadingInputs { gbuffer, eye, vsgls, count, visibility };
        self.shading.encode(encoder, &inputs, timer);
    }

    /// What it was made with.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Diffusely reflected radiance, rgba32float; nothing without diffuse reflection.
    pub fn diffuse(&self) -> Option<&wgpu::Texture> {
        self.shading.diffuse()
    }

    /// Specularly reflected radiance, rgba32float; nothing without specular reflection.
    pub fn specular(&self) -> Option<&wgpu::Texture> {
        self.shading.specular()
    }

    /// The moments with their mips, rgba32float, one layer for each: all of them, or those that 16 bits do not suffice
    /// for. A power-of-two square; texels beyond the reflective shadow map are 0. Clusters need no mips of them, and with
    /// the reflectance for density none at all.
    pub fn moments(&self) -> Option<&wgpu::Texture> {
        self.generation.moments()
    }

    /// The moments that 16 bits suffice for with their mips, rgba16float, in [`LightView::power_unit`]; nothing with
    /// 32-bit precision.
    pub fn half_moments(&self) -> Option<&wgpu::Texture> {
        self.generation.half_moments()
    }

    /// The weights with their mips, r32float, where they are neither in the moments (32-bit precision) nor the density
    /// (drawn by power).
    pub fn weights(&self) -> Option<&wgpu::Texture> {
        self.generation.weights()
    }

    /// The density with its mips, r32float.
    pub fn density(&self) -> &wgpu::Texture {
        self.generation.density()
    }

    /// The virtual lights: `SglowVsglBoth` or `SglowVsglDiffuse`, after the lobes; with 16-bit precision
    /// `SglowPackedVsglBoth` or `SglowPackedVsglDiffuse`.
    pub fn vsgls(&self) -> &wgpu::Buffer {
        self.generation.vsgls()
    }

    /// The kernels that the lights were made of: `SglowKernel`; nothing with clusters.
    pub fn kernels(&self) -> Option<&wgpu::Buffer> {
        self.generation.kernels()
    }

    /// The clusters that the lights were made of; nothing with kernels.
    pub fn clusters(&self) -> Option<&Clusters> {
        self.generation.clusters()
    }

    /// The chains that draw the centres of the kernels, if they are drawn so.
    pub fn metropolis(&self) -> Option<&Metropolis> {
        self.generation.metropolis()
    }

    /// The camera's virtual lights, in 32 bits: `SglowVsglBoth` or `SglowVsglDiffuse`; nothing without the bidirectional
    /// density.
    pub fn camera_vsgls(&self) -> Option<&wgpu::Buffer> {
        self.camera.as_ref().map(|camera| camera.generation.vsgls())
    }

    /// The moments of the camera's G-buffer, as [`Self::moments`]; nothing without the bidirectional density.
    pub fn camera_moments(&self) -> Option<&wgpu::Texture> {
        self.camera.as_ref().and_then(|camera| camera.generation.moments())
    }

    /// The density on the camera's G-buffer, as [`Self::density`]; nothing without the bidirectional density.
    pub fn camera_density(&self) -> Option<&wgpu::Texture> {
        self.camera.as_ref().map(|camera| camera.generation.density())
    }

    /// The bytes of each texture, with its mips, and of each buffer that it keeps between its passes; those of the
    /// parameters are left out.
    pub fn bytes(&self) -> Vec<(&'static str, u64)> {
        let mut bytes = self.generation.bytes().concat();
        if let Some(Camera { generation }) = &self.camera {
            let names = ["camera textures", "camera buffers"];
            bytes.extend(names.into_iter().zip(generation.bytes().map(total)));
        }
        bytes.extend(self.diffuse().map(|texture| ("diffuse", texture_bytes(texture))));
        bytes.extend(self.specular().map(|texture| ("specular", texture_bytes(texture))));
        bytes
    }
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

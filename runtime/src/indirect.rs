//! Indirect light on textures that an engine already has: moments, density, mips, lights, shading.

use glam::Vec3;
use sglow_shaders::{
    Diffuse, Filter, Kernel, Lobes, Precision, SglowKernel, SglowMomentsParametersF16,
    SglowMomentsParametersF32, SglowSampleParametersF16, SglowSampleParametersF32,
    SglowShadeParameters, Specular, Texel,
};

use crate::light::LightView;
use crate::package::Package;
use crate::pipeline::{ComputePass, Dispatch, PipelineError, uniform};
use crate::settings::{Settings, SettingsError};
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
}

/// A texture with its mip chain, and the views that its passes need.
struct Pyramid {
    texture: wgpu::Texture,
    all: wgpu::TextureView,
    levels: Vec<wgpu::TextureView>,
}

impl Pyramid {
    fn new(
        device: &wgpu::Device,
        label: &str,
        size: u32,
        layers: u32,
        format: wgpu::TextureFormat,
    ) -> Self {
        let levels = size.ilog2() + 1;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: layers },
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = |base_mip_level, mip_level_count| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                label: Some(label),
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                base_mip_level,
                mip_level_count,
                ..Default::default()
            })
        };
        let all = view(0, None);
        let levels = (0..levels).map(|level| view(level, Some(1))).collect();
        Self { texture, all, levels }
    }

    fn layers(&self) -> u32 {
        self.texture.depth_or_array_layers()
    }

    /// Dispatches that make every level from the one below it.
    fn encode_mips(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        pass: &ComputePass,
        timer: Option<&mut Timer<'_>>,
    ) {
        let bindings: Vec<_> = self
            .levels
            .windows(2)
            .map(|pair| {
                [
                    (0, wgpu::BindingResource::TextureView(&pair[0])),
                    (1, wgpu::BindingResource::TextureView(&pair[1])),
                ]
            })
            .collect();
        let dispatches: Vec<_> = bindings
            .iter()
            .enumerate()
            .map(|(level, bindings)| {
                let groups = (self.texture.width() >> (level + 1)).div_ceil(8);
                Dispatch { bindings, workgroups: [groups, groups, self.layers()] }
            })
            .collect();
        pass.encode(device, encoder, timer, &dispatches);
    }
}

/// The moments that 16 bits suffice for, and the pass of their mips.
struct Halves {
    moments: Pyramid,
    mip_pass: ComputePass,
}

/// The passes of indirect light, with all they keep between them.
///
/// Nothing that the settings leave out exists: without specular lobes there are no specular moments, no mips of them,
/// no fields for them in the lights, and no texture for their light.
pub struct Indirect {
    device: wgpu::Device,
    queue: wgpu::Queue,
    settings: Settings,
    moments: Pyramid,
    halves: Option<Halves>,
    density: Pyramid,
    vsgls: wgpu::Buffer,
    kernels: wgpu::Buffer,
    sampler: Option<wgpu::Sampler>,
    diffuse: Option<(wgpu::Texture, wgpu::TextureView)>,
    specular: Option<(wgpu::Texture, wgpu::TextureView)>,
    moments_parameters: wgpu::Buffer,
    sample_parameters: wgpu::Buffer,
    shade_parameters: wgpu::Buffer,
    moments_pass: ComputePass,
    density_pass: Option<ComputePass>,
    moments_mip_pass: ComputePass,
    density_mip_pass: ComputePass,
    sample_pass: ComputePass,
    shade_pass: ComputePass,
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
        let half = settings.precision == Precision::F16;
        let mip = |texel, label| {
            let id = sglow_shaders::mip::Mip { texel }.id();
            ComputePass::new(device, package, &id, label, &[])
        };
        let moments_id = sglow_shaders::moments::Moments {
            light: settings.light,
            lobes: settings.lobes,
            precision: settings.precision,
        }
        .id();
        let density_id = sglow_shaders::density::Density::default().id();
        let sample = sglow_shaders::sample::Sample {
            kernel: settings.kernel,
            filter: settings.filter,
            lobes: settings.lobes,
            precision: settings.precision,
        };
        let iterations = [("sglow_iterations", f64::from(settings.iterations))];
        let constants: &[_] = if settings.kernel == Kernel::Modified { &iterations } else { &[] };
        let buffer = |label, size: usize| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: u64::from(settings.count) * size as u64,
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_SRC
                    | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let vsgl_bytes = match (settings.precision, settings.lobes) {
            (Precision::F32, Lobes::Both) => size_of::<sglow_shaders::SglowVsglBoth>(),
            (Precision::F32, Lobes::Diffuse) => size_of::<sglow_shaders::SglowVsglDiffuse>(),
            (Precision::F16, Lobes::Both) => size_of::<sglow_shaders::SglowPackedVsglBoth>(),
            (Precision::F16, Lobes::Diffuse) => size_of::<sglow_shaders::SglowPackedVsglDiffuse>(),
        };
        let (moment_layers, half_layers) = match (settings.precision, settings.lobes) {
            (Precision::F32, Lobes::Both) => (5, 0),
            (Precision::F32, Lobes::Diffuse) => (3, 0),
            (Precision::F16, Lobes::Both) => (2, 3),
            (Precision::F16, Lobes::Diffuse) => (1, 2),
        };
        let halves = if half {
            let format = wgpu::TextureFormat::Rgba16Float;
            let size = settings.rsm_size;
            Some(Halves {
                moments: Pyramid::new(device, "sglow half moments", size, half_layers, format),
                mip_pass: mip(Texel::Rgba16float, "mip half moments")?,
            })
        } else {
            None
        };
        // With halves the moments pass writes the weight, which is the density, by itself.
        let density_pass = if half {
            None
        } else {
            Some(ComputePass::new(device, package, &density_id, "density", &[])?)
        };
        let output = |label| {
            let texture = picture(device, label, settings.size, wgpu::TextureFormat::Rgba32Float);
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            (texture, view)
        };
        Ok(Self {
            moments: Pyramid::new(
                device,
                "sglow moments",
                settings.rsm_size,
                moment_layers,
                wgpu::TextureFormat::Rgba32Float,
            ),
            halves,
            density: Pyramid::new(
                device,
                "sglow density",
                settings.rsm_size,
                1,
                wgpu::TextureFormat::R32Float,
            ),
            vsgls: buffer("sglow vsgls", vsgl_bytes),
            kernels: buffer("sglow kernels", size_of::<SglowKernel>()),
            sampler: (settings.filter == Filter::Hardware).then(|| {
                device.create_sampler(&wgpu::SamplerDescriptor {
                    label: Some("sglow trilinear"),
                    mag_filter: wgpu::FilterMode::Linear,
                    min_filter: wgpu::FilterMode::Linear,
                    mipmap_filter: wgpu::MipmapFilterMode::Linear,
                    ..Default::default()
                })
            }),
            diffuse: (settings.diffuse != Diffuse::None).then(|| output("sglow indirect diffuse")),
            specular: (settings.specular != Specular::None)
                .then(|| output("sglow indirect specular")),
            // Both precisions' parameters take the same room.
            moments_parameters: uniform::<SglowMomentsParametersF16>(
                device,
                "sglow moments parameters",
            ),
            sample_parameters: uniform::<SglowSampleParametersF16>(
                device,
                "sglow sample parameters",
            ),
            shade_parameters: uniform::<SglowShadeParameters>(device, "sglow shade parameters"),
            moments_pass: ComputePass::new(device, package, &moments_id, "moments", &[])?,
            density_pass,
            moments_mip_pass: mip(Texel::Rgba32float, "mip moments")?,
            density_mip_pass: mip(Texel::R32float, "mip density")?,
            sample_pass: ComputePass::new(device, package, &sample.id(), "sample", constants)?,
            shade_pass: ComputePass::new(device, package, &settings.shade().id(), "shade", &[])?,
            device: device.clone(),
            queue: queue.clone(),
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
        self.encode_moments(encoder, inputs, timer.as_deref_mut());
        self.encode_density(encoder, timer.as_deref_mut());
        self.encode_mips(encoder, timer.as_deref_mut());
        self.encode_sample(encoder, inputs.light, timer.as_deref_mut());
        self.encode_shade(encoder, inputs.gbuffer, inputs.eye, timer);
    }

    /// The first stage: what clusters of the reflective shadow map sum.
    pub fn encode_moments(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) {
        let (light, origin) = (inputs.light.uniform, inputs.light.origin.into());
        match self.settings.precision {
            Precision::F32 => {
                let rest = bytemuck::Zeroable::zeroed();
                let parameters = SglowMomentsParametersF32 { light, origin, ..rest };
                self.write(&self.moments_parameters, &parameters);
            }
            Precision::F16 => {
                let power_scale = 1.0 / inputs.light.power_unit;
                let parameters = SglowMomentsParametersF16 { light, origin, power_scale };
                self.write(&self.moments_parameters, &parameters);
            }
        }
        let mut bindings = vec![
            (0, self.moments_parameters.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(inputs.rsm.position)),
            (2, wgpu::BindingResource::TextureView(inputs.rsm.normal)),
            (3, wgpu::BindingResource::TextureView(inputs.rsm.base_color)),
            (4, wgpu::BindingResource::TextureView(&self.moments.levels[0])),
        ];
        if let Some(halves) = &self.halves {
            bindings.push((5, wgpu::BindingResource::TextureView(&halves.moments.levels[0])));
            bindings.push((6, wgpu::BindingResource::TextureView(&self.density.levels[0])));
        }
        let groups = self.settings.rsm_size.div_ceil(8);
        self.moments_pass.encode(
            &self.device,
            encoder,
            timer,
            &[Dispatch { bindings: &bindings, workgroups: [groups, groups, 1] }],
        );
    }

    fn write<T: bytemuck::NoUninit>(&self, buffer: &wgpu::Buffer, parameters: &T) {
        self.queue.write_buffer(buffer, 0, bytemuck::bytes_of(parameters));
    }

    /// The second stage: level 0 of the density from level 0 of the moments. Nothing with 16-bit moments, whose own pass
    /// writes the weight that the density is.
    pub fn encode_density(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: Option<&mut Timer<'_>>,
    ) {
        let Some(density_pass) = &self.density_pass else { return };
        let groups = self.settings.rsm_size.div_ceil(8);
        density_pass.encode(
            &self.device,
            encoder,
            timer,
            &[Dispatch {
                bindings: &[
                    (0, wgpu::BindingResource::TextureView(&self.moments.levels[0])),
                    (1, wgpu::BindingResource::TextureView(&self.density.levels[0])),
                ],
                workgroups: [groups, groups, 1],
            }],
        );
    }

    /// The third stage: the mip chains from their levels 0.
    pub fn encode_mips(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        mut timer: Option<&mut Timer<'_>>,
    ) {
        let mut encode = |pyramid: &Pyramid, pass| {
            pyramid.encode_mips(&self.device, encoder, pass, timer.as_deref_mut());
        };
        encode(&self.moments, &self.moments_mip_pass);
        if let Some(halves) = &self.halves {
            encode(&halves.moments, &halves.mip_pass);
        }
        encode(&self.density, &self.density_mip_pass);
    }

    /// The fourth stage: kernels and virtual lights.
    pub fn encode_sample(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        light: &LightView,
        timer: Option<&mut Timer<'_>>,
    ) {
        let (origin, minimum_variance) = (light.origin.into(), light.minimum_variance);
        let Settings { count, size_factor, .. } = self.settings;
        match self.settings.precision {
            Precision::F32 => {
                let rest = bytemuck::Zeroable::zeroed();
                let parameters = SglowSampleParametersF32 {
                    origin,
                    count,
                    size_factor,
                    minimum_variance,
                    ..rest
                };
                self.write(&self.sample_parameters, &parameters);
            }
            Precision::F16 => {
                let rest = bytemuck::Zeroable::zeroed();
                let parameters = SglowSampleParametersF16 {
                    origin,
                    count,
                    size_factor,
                    minimum_variance,
                    power_unit: light.power_unit,
                    ..rest
                };
                self.write(&self.sample_parameters, &parameters);
            }
        }
        let mut bindings = vec![
            (0, self.sample_parameters.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(&self.moments.all)),
            (2, wgpu::BindingResource::TextureView(&self.density.all)),
            (3, self.vsgls.as_entire_binding()),
            (4, self.kernels.as_entire_binding()),
        ];
        if let Some(sampler) = &self.sampler {
            bindings.push((5, wgpu::BindingResource::Sampler(sampler)));
        }
        if let Some(halves) = &self.halves {
            bindings.push((6, wgpu::BindingResource::TextureView(&halves.moments.all)));
            bindings.push((7, wgpu::BindingResource::TextureView(&self.density.all)));
        }
        let workgroups = [self.settings.count.div_ceil(64), 1, 1];
        self.sample_pass.encode(
            &self.device,
            encoder,
            timer,
            &[Dispatch { bindings: &bindings, workgroups }],
        );
    }

    /// The last stage: the virtual lights reflected towards the camera.
    pub fn encode_shade(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: SurfaceViews<'_>,
        eye: Vec3,
        timer: Option<&mut Timer<'_>>,
    ) {
        self.encode_shade_with(encoder, gbuffer, eye, Vec::new(), timer);
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
        self.encode_shade_with(encoder, gbuffer, eye, visibility.shade_bindings().into(), timer);
    }

    fn encode_shade_with(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: SurfaceViews<'_>,
        eye: Vec3,
        maps: Vec<(u32, wgpu::BindingResource<'_>)>,
        timer: Option<&mut Timer<'_>>,
    ) {
        let parameters = SglowShadeParameters { eye: eye.into(), count: self.settings.count };
        self.queue.write_buffer(&self.shade_parameters, 0, bytemuck::bytes_of(&parameters));
        let mut bindings = vec![
            (0, self.shade_parameters.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(gbuffer.position)),
            (2, wgpu::BindingResource::TextureView(gbuffer.normal)),
            (3, wgpu::BindingResource::TextureView(gbuffer.base_color)),
            (4, self.vsgls.as_entire_binding()),
        ];
        for (binding, output) in [(5, &self.diffuse), (6, &self.specular)] {
            if let Some((_, view)) = output {
                bindings.push((binding, wgpu::BindingResource::TextureView(view)));
            }
        }
        bindings.extend(maps);
        let [width, height] = self.settings.size;
        let workgroups = [width.div_ceil(8), height.div_ceil(8), 1];
        self.shade_pass.encode(
            &self.device,
            encoder,
            timer,
            &[Dispatch { bindings: &bindings, workgroups }],
        );
    }

    /// What it was made with.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Diffusely reflected radiance, rgba32float; nothing without diffuse reflection.
    pub fn diffuse(&self) -> Option<&wgpu::Texture> {
        self.diffuse.as_ref().map(|(texture, _)| texture)
    }

    /// Specularly reflected radiance, rgba32float; nothing without specular reflection.
    pub fn specular(&self) -> Option<&wgpu::Texture> {
        self.specular.as_ref().map(|(texture, _)| texture)
    }

    /// The moments with their mips, rgba32float, one layer for each: all of them, or those that 16 bits do not suffice
    /// for.
    pub fn moments(&self) -> &wgpu::Texture {
        &self.moments.texture
    }

    /// The moments that 16 bits suffice for with their mips, rgba16float, in [`LightView::power_unit`]; nothing with
    /// 32-bit precision.
    pub fn half_moments(&self) -> Option<&wgpu::Texture> {
        self.halves.as_ref().map(|halves| &halves.moments.texture)
    }

    /// The density with its mips, r32float.
    pub fn density(&self) -> &wgpu::Texture {
        &self.density.texture
    }

    /// The virtual lights: `SglowVsglBoth` or `SglowVsglDiffuse`, after the lobes; with 16-bit precision
    /// `SglowPackedVsglBoth` or `SglowPackedVsglDiffuse`.
    pub fn vsgls(&self) -> &wgpu::Buffer {
        &self.vsgls
    }

    /// The kernels that the lights were made of: `SglowKernel`.
    pub fn kernels(&self) -> &wgpu::Buffer {
        &self.kernels
    }

    /// The bytes of each texture, with its mips, and of each buffer that it keeps between its passes; those of the
    /// parameters are left out.
    pub fn bytes(&self) -> Vec<(&'static str, u64)> {
        let mut bytes = vec![("moments", texture_bytes(&self.moments.texture))];
        bytes.extend(self.half_moments().map(|texture| ("half moments", texture_bytes(texture))));
        bytes.push(("density", texture_bytes(&self.density.texture)));
        bytes.push(("vsgls", self.vsgls.size()));
        bytes.push(("kernels", self.kernels.size()));
        bytes.extend(self.diffuse().map(|texture| ("diffuse", texture_bytes(texture))));
        bytes.extend(self.specular().map(|texture| ("specular", texture_bytes(texture))));
        bytes
    }
}

/// What a texture's texels take, on all its levels and layers.
fn texture_bytes(texture: &wgpu::Texture) -> u64 {
    let texel = u64::from(texture.format().block_copy_size(None).unwrap_or(0));
    let texels = (0..texture.mip_level_count()).map(|level| {
        let side = |size: u32| u64::from((size >> level).max(1));
        side(texture.width()) * side(texture.height())
    });
    texels.sum::<u64>() * u64::from(texture.depth_or_array_layers()) * texel
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

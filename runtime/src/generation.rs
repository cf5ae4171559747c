//! Virtual lights from one map, of the light or of the camera: moments, density, mips, kernels.

use glam::Vec4;
use sglow_shaders::{
    Density, Draw, Emitter, Filter, Light, Lobes, Precision, SglowDensityParameters, SglowKernel,
    SglowMomentsParametersF16, SglowMomentsParametersF32, SglowSampleParametersF16,
    SglowSampleParametersF32, Solver, Space, SpecularPower, Texel, sample::Sample,
};

use crate::cluster::{ClusterInputs, ClusterSettings, Clusters};
use crate::indirect::{IndirectError, SurfaceViews};
use crate::labels::Labels;
use crate::light::LightView;
use crate::metropolis::{Metropolis, MetropolisSettings};
use crate::package::Package;
use crate::pipeline::{ComputePass, Dispatch, uniform};
use crate::pyramid::{Levels, MipPasses, Pyramid, pyramid_bytes, texture_bytes};
use crate::settings::density_variant;
use crate::timing::Timer;

/// What lights are made of.
#[derive(Clone)]
pub(crate) struct Recipe {
    pub(crate) labels: Labels,
    /// Width and height of the map.
    pub(crate) size: [u32; 2],
    pub(crate) count: u32,
    pub(crate) size_factor: f32,
    pub(crate) iterations: u32,
    pub(crate) light: Light,
    pub(crate) lobes: Lobes,
    pub(crate) specular_power: SpecularPower,
    pub(crate) precision: Precision,
    pub(crate) density: Density,
    pub(crate) sample: Sample,
    pub(crate) emitter: Emitter,
    /// Length of the mean direction of a texel's diffuse emission.
    pub(crate) diffuse_mean_length: f32,
    /// Clusters in some space instead of kernels.
    pub(crate) space: Space,
}

/// The camera's virtual lights, which the bidirectional density is made of.
#[derive(Clone, Copy)]
pub(crate) struct Importance<'a> {
    /// The light's position with w = 1, or the direction towards it with w = 0.
    pub(crate) light: Vec4,
    pub(crate) lights: &'a wgpu::Buffer,
    pub(crate) count: u32,
}

/// The moments that 16 bits suffice for, and the pass of their mips.
struct Halves {
    moments: Pyramid,
    mip_pass: MipPasses,
    /// The weights, where kernels are drawn by another density.
    weights: Option<Pyramid>,
}

/// Kernels with their lights, and the passes that make them.
struct Kernels {
    vsgls: wgpu::Buffer,
    kernels: wgpu::Buffer,
    parameters: wgpu::Buffer,
    moments_mip_pass: MipPasses,
    pass: ComputePass,
}

/// What the lights are made of.
#[expect(clippy::large_enum_variant, reason = "there is one for each map")]
enum Lights {
    Kernels(Kernels),
    Clusters(Clusters),
}

/// Passes from a map to virtual lights, with all they keep between them.
pub(crate) struct Generation {
    device: wgpu::Device,
    queue: wgpu::Queue,
    recipe: Recipe,
    moments: Option<Pyramid>,
    halves: Option<Halves>,
    density: Pyramid,
    lights: Lights,
    sampler: Option<wgpu::Sampler>,
    metropolis: Option<Metropolis>,
    moments_parameters: wgpu::Buffer,
    density_parameters: wgpu::Buffer,
    moments_pass: Option<ComputePass>,
    density_pass: Option<ComputePass>,
    density_mip_pass: MipPasses,
}

impl Recipe {
    /// Width and height of what is kept of the map. Mips of a power-of-two square hold exact means; what lies beyond the
    /// map stays zero.
    fn side(&self) -> u32 {
        self.size[0].max(self.size[1]).next_power_of_two()
    }

    fn clusters(&self) -> Option<ClusterSettings> {
        let Self { size, count, light, lobes, specular_power, space, .. } = *self;
        let diffuse_mean_length = self.diffuse_mean_length;
        let Sample { draw, variance, sharpness, .. } = self.sample;
        (space != Space::None).then_some(ClusterSettings {
            size,
            count,
            draw,
            space,
            light,
            variance,
            sharpness,
            lobes,
            specular_power,
            diffuse_mean_length,
        })
    }

    fn chains(&self) -> Option<MetropolisSettings> {
        (self.sample.draw == Draw::Metropolis).then(|| MetropolisSettings::of(self.count))
    }

    fn halves(&self) -> bool {
        self.precision == Precision::F16
    }

    /// Clusters sum what the map holds by themselves, and the reflectance is read from it, too.
    fn keeps_moments(&self) -> bool {
        self.space == Space::None || self.density != Density::Reflectance
    }

    /// With halves the moments pass writes the weight, which is the reflected power, by itself.
    fn has_density_pass(&self) -> bool {
        !(self.halves() && self.density == Density::Power)
    }

    fn keeps_weights(&self) -> bool {
        self.halves() && self.density != Density::Power
    }

    /// Layers of moments in 32 and in 16 bits.
    fn layers(&self) -> [u32; 2] {
        match (self.precision, self.lobes) {
            (Precision::F32, Lobes::Both) => [5, 0],
            (Precision::F32, Lobes::Diffuse) => [3, 0],
            (Precision::F16, Lobes::Both) => [2, 3],
            (Precision::F16, Lobes::Diffuse) => [1, 2],
        }
    }

    /// Levels of the moments: clusters need no mips.
    fn levels(&self) -> Levels {
        if self.space == Space::None { Levels::All } else { Levels::First }
    }

    fn moments_id(&self) -> String {
        let Self { light, lobes, specular_power, precision, .. } = *self;
        let sharpness = self.sample.sharpness;
        sglow_shaders::moments::Moments { light, lobes, specular_power, sharpness, precision }.id()
    }

    fn density_id(&self) -> String {
        density_variant(self.density, self.emitter, self.lobes, self.specular_power).id()
    }

    /// The variants that it runs.
    pub(crate) fn variants(&self) -> Vec<String> {
        let mut variants = MipPasses::variants(Texel::R32float);
        variants.extend(self.keeps_moments().then(|| self.moments_id()));
        variants.extend(self.has_density_pass().then(|| self.density_id()));
        if let Some(clusters) = self.clusters() {
            variants.extend(clusters.variants());
        } else {
            variants.extend(MipPasses::variants(Texel::Rgba32float));
            variants.push(self.sample.id());
        }
        if self.halves() {
            variants.extend(MipPasses::variants(Texel::Rgba16float));
        }
        variants.extend(self.chains().into_iter().flat_map(|chains| chains.variants()));
        variants
    }

    /// The bytes that it keeps, by name; textures first.
    pub(crate) fn bytes(&self) -> [Vec<(&'static str, u64)>; 2] {
        let [layers, half_layers] = self.layers();
        let texels = |layers: u32, texel, levels| pyramid_bytes(self.side(), layers, texel, levels);
        let mut textures = Vec::new();
        if self.keeps_moments() {
            textures.push(("moments", texels(layers, 16, self.levels())));
        }
        if self.halves() {
            textures.push(("half moments", texels(half_layers, 8, Levels::All)));
        }
        if self.keeps_weights() {
            textures.push(("weights", texels(1, 4, Levels::All)));
        }
        textures.push(("density", texels(1, 4, Levels::All)));
        let count = u64::from(self.count);
        let mut buffers = match self.clusters() {
            Some(clusters) => clusters.bytes(),
            None => vec![
                ("vsgls", count * vsgl_size(self.lobes, self.precision)),
                ("kernels", count * size_of::<SglowKernel>() as u64),
            ],
        };
        buffers.extend(self.chains().map(|chains| ("chains", chains.bytes())));
        [textures, buffers]
    }
}

impl Generation {
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        recipe: Recipe,
        package: &Package,
    ) -> Result<Self, IndirectError> {
        let Recipe { labels, lobes, precision, .. } = recipe;
        let mip = |texel, label| MipPasses::new(device, package, texel, label);
        let sample = recipe.sample;
        let metropolis = match recipe.chains() {
            Some(settings) => Some(Metropolis::new(device, package, &settings)?),
            None => None,
        };
        let pyramid = |label, layers, format, levels| {
            Pyramid::new(device, label, recipe.side(), layers, format, levels)
        };
        let [layers, half_layers] = recipe.layers();
        let halves = if recipe.halves() {
            let format = wgpu::TextureFormat::Rgba16Float;
            Some(Halves {
                moments: pyramid("sglow half moments", half_layers, format, Levels::All),
                mip_pass: mip(Texel::Rgba16float, labels.mip_half_moments)?,
                weights: recipe.keeps_weights().then(|| {
                    pyramid("sglow weights", 1, wgpu::TextureFormat::R32Float, Levels::All)
                }),
            })
        } else {
            None
        };
        let pass = |id: &str, label, constants: &[_]| {
            ComputePass::new(device, package, id, label, constants)
        };
        let lights = if let Some(settings) = recipe.clusters() {
            Lights::Clusters(Clusters::new(device, queue, package, &settings)?)
        } else {
            let iterations = [("sglow_iterations", f64::from(recipe.iterations))];
            let constants: &[_] =
                if sample.solver == Solver::Bisection { &iterations } else { &[] };
            let kernel = size_of::<SglowKernel>() as u64;
            Lights::Kernels(Kernels {
                vsgls: buffer(device, "sglow vsgls", recipe.count, vsgl_size(lobes, precision)),
                kernels: buffer(device, "sglow kernels", recipe.count, kernel),
                // Both precisions' parameters take the same room.
                parameters: uniform::<SglowSampleParametersF16>(device, "sglow sample parameters"),
                moments_mip_pass: mip(Texel::Rgba32float, labels.mip_moments)?,
                pass: pass(&sample.id(), labels.sample, constants)?,
            })
        };
        let moments_pass = if recipe.keeps_moments() {
            Some(pass(&recipe.moments_id(), labels.moments, &[])?)
        } else {
            None
        };
        let density_pass = if recipe.has_density_pass() {
            Some(pass(&recipe.density_id(), labels.density, &[])?)
        } else {
            None
        };
        Ok(Self {
            moments: recipe.keeps_moments().then(|| {
                let format = wgpu::TextureFormat::Rgba32Float;
                pyramid("sglow moments", layers, format, recipe.levels())
            }),
            halves,
            density: pyramid("sglow density", 1, wgpu::TextureFormat::R32Float, Levels::All),
            lights,
            sampler: (sample.filter == Filter::Hardware).then(|| {
                device.create_sampler(&wgpu::SamplerDescriptor {
                    label: Some("sglow trilinear"),
                    mag_filter: wgpu::FilterMode::Linear,
                    min_filter: wgpu::FilterMode::Linear,
                    mipmap_filter: wgpu::MipmapFilterMode::Linear,
                    ..Default::default()
                })
            }),
            metropolis,
            moments_parameters: uniform::<SglowMomentsParametersF16>(
                device,
                "sglow moments parameters",
            ),
            density_parameters: uniform::<SglowDensityParameters>(
                device,
                "sglow density parameters",
            ),
            moments_pass,
            density_pass,
            density_mip_pass: mip(Texel::R32float, labels.mip_density)?,
            device: device.clone(),
            queue: queue.clone(),
            recipe,
        })
    }

    /// Workgroups that cover the map.
    fn workgroups(&self) -> [u32; 3] {
        let [width, height] = self.recipe.size;
        [width.div_ceil(8), height.div_ceil(8), 1]
    }

    fn write<T: bytemuck::NoUninit>(&self, buffer: &wgpu::Buffer, parameters: &T) {
        self.queue.write_buffer(buffer, 0, bytemuck::bytes_of(parameters));
    }

    /// Level 0 of the moments, and of the weights where they are apart.
    pub(crate) fn encode_moments(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        map: SurfaceViews<'_>,
        view: &LightView,
        timer: Option<&mut Timer<'_>>,
    ) {
        let (Some(moments), Some(moments_pass)) = (&self.moments, &self.moments_pass) else {
            return;
        };
        let (light, origin) = (view.uniform, view.origin.into());
        let diffuse_mean_length = self.recipe.diffuse_mean_length;
        match self.recipe.precision {
            Precision::F32 => {
                let parameters = SglowMomentsParametersF32 { light, origin, diffuse_mean_length };
                self.write(&self.moments_parameters, &parameters);
            }
            Precision::F16 => {
                let power_scale = 1.0 / view.power_unit;
                let parameters = SglowMomentsParametersF16 {
                    light,
                    origin,
                    diffuse_mean_length,
                    power_scale,
                    ..bytemuck::Zeroable::zeroed()
                };
                self.write(&self.moments_parameters, &parameters);
            }
        }
        let mut bindings = vec![
            (0, self.moments_parameters.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(map.position)),
            (2, wgpu::BindingResource::TextureView(map.normal)),
            (3, wgpu::BindingResource::TextureView(map.base_color)),
            (4, wgpu::BindingResource::TextureView(&moments.levels[0])),
        ];
        if let Some(halves) = &self.halves {
            let weights = halves.weights.as_ref().unwrap_or(&self.density);
            bindings.push((5, wgpu::BindingResource::TextureView(&halves.moments.levels[0])));
            bindings.push((6, wgpu::BindingResource::TextureView(&weights.levels[0])));
        }
        let dispatch = Dispatch { bindings: &bindings, workgroups: self.workgroups() };
        moments_pass.encode(&self.device, encoder, timer, &[dispatch]);
    }

    /// Level 0 of the density. Nothing where the moments pass has written it.
    pub(crate) fn encode_density(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        map: SurfaceViews<'_>,
        importance: Option<Importance<'_>>,
        timer: Option<&mut Timer<'_>>,
    ) {
        let Some(density_pass) = &self.density_pass else { return };
        let view = wgpu::BindingResource::TextureView;
        let mut bindings = vec![(1, view(&self.density.levels[0]))];
        if self.recipe.density == Density::Power {
            let moments = self.moments.iter().map(|moments| (0, view(&moments.levels[0])));
            bindings.splice(0..0, moments);
        } else {
            bindings.push((2, view(map.position)));
        }
        if self.recipe.density == Density::Bidirectional {
            bindings.push((3, view(map.normal)));
        }
        if self.recipe.density != Density::Power {
            bindings.push((4, view(map.base_color)));
        }
        if let (Density::Bidirectional, Some(importance)) = (self.recipe.density, importance) {
            let apart = self.halves.as_ref().and_then(|halves| halves.weights.as_ref());
            let parameters = SglowDensityParameters {
                light: importance.light.into(),
                weight_channel: if apart.is_some() { Vec4::X } else { Vec4::W }.into(),
                weight_layer: u32::from(apart.is_none()),
                count: importance.count,
                ..bytemuck::Zeroable::zeroed()
            };
            self.write(&self.density_parameters, &parameters);
            bindings.push((5, self.density_parameters.as_entire_binding()));
            let weights = apart.or(self.moments.as_ref());
            bindings.extend(weights.map(|weights| (6, view(&weights.levels[0]))));
            bindings.push((7, importance.lights.as_entire_binding()));
        }
        let dispatch = Dispatch { bindings: &bindings, workgroups: self.workgroups() };
        density_pass.encode(&self.device, encoder, timer, &[dispatch]);
    }

    /// All mip chains from their levels 0.
    pub(crate) fn encode_mips(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        mut timer: Option<&mut Timer<'_>>,
    ) {
        let mut encode = |pyramid: &Pyramid, pass| {
            pyramid.encode_mips(
                &self.device,
                encoder,
                pass,
                self.recipe.size,
                timer.as_deref_mut(),
            );
        };
        if let (Some(moments), Lights::Kernels(kernels)) = (&self.moments, &self.lights) {
            encode(moments, &kernels.moments_mip_pass);
        }
        if let Some(halves) = &self.halves {
            encode(&halves.moments, &halves.mip_pass);
            if let Some(weights) = &halves.weights {
                encode(weights, &self.density_mip_pass);
            }
        }
        encode(&self.density, &self.density_mip_pass);
    }

    /// Kernels, or clusters, and virtual lights. Markov chains, if they draw the centres, move before.
    pub(crate) fn encode_sample(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        map: SurfaceViews<'_>,
        view: &LightView,
        mut timer: Option<&mut Timer<'_>>,
    ) {
        let Lights::Clusters(clusters) = &self.lights else {
            return self.encode_kernels(encoder, view, timer);
        };
        self.encode_chains(encoder, timer.as_deref_mut());
        let inputs = ClusterInputs {
            map,
            light: view,
            density: &self.density.all,
            chains: self.metropolis.as_ref().map(Metropolis::chains),
        };
        let encoded = clusters.encode(encoder, &inputs, timer);
        debug_assert!(encoded.is_ok(), "there are as many chains as clusters");
    }

    fn encode_chains(&self, encoder: &mut wgpu::CommandEncoder, timer: Option<&mut Timer<'_>>) {
        if let Some(metropolis) = &self.metropolis {
            metropolis.encode(&self.device, encoder, &self.density.all, timer);
        }
    }

    /// Kernels and virtual lights. Markov chains, if they draw the centres, move before.
    pub(crate) fn encode_kernels(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &LightView,
        mut timer: Option<&mut Timer<'_>>,
    ) {
        self.encode_chains(encoder, timer.as_deref_mut());
        let (Some(moments), Lights::Kernels(kernels)) = (&self.moments, &self.lights) else {
            return;
        };
        let (origin, minimum_variance) = (view.origin.into(), view.minimum_variance);
        let Recipe { count, size_factor, .. } = self.recipe;
        match self.recipe.precision {
            Precision::F32 => {
                let rest = bytemuck::Zeroable::zeroed();
                let parameters = SglowSampleParametersF32 {
                    origin,
                    count,
                    size_factor,
                    minimum_variance,
                    ..rest
                };
                self.write(&kernels.parameters, &parameters);
            }
            Precision::F16 => {
                let rest = bytemuck::Zeroable::zeroed();
                let parameters = SglowSampleParametersF16 {
                    origin,
                    count,
                    size_factor,
                    minimum_variance,
                    power_unit: view.power_unit,
                    ..rest
                };
                self.write(&kernels.parameters, &parameters);
            }
        }
        let mut bindings = vec![
            (0, kernels.parameters.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(&moments.all)),
            (2, wgpu::BindingResource::TextureView(&self.density.all)),
            (3, kernels.vsgls.as_entire_binding()),
            (4, kernels.kernels.as_entire_binding()),
        ];
        if let Some(sampler) = &self.sampler {
            bindings.push((5, wgpu::BindingResource::Sampler(sampler)));
        }
        if let Some(halves) = &self.halves {
            let weights = halves.weights.as_ref().unwrap_or(&self.density);
            bindings.push((6, wgpu::BindingResource::TextureView(&halves.moments.all)));
            bindings.push((7, wgpu::BindingResource::TextureView(&weights.all)));
        }
        if let Some(metropolis) = &self.metropolis {
            bindings.push((8, metropolis.chains().as_entire_binding()));
        }
        let workgroups = [self.recipe.count.div_ceil(64), 1, 1];
        let dispatch = Dispatch { bindings: &bindings, workgroups };
        kernels.pass.encode(&self.device, encoder, timer, &[dispatch]);
    }

    /// The moments with their mips; without mips, or none, where there are clusters.
    pub(crate) fn moments(&self) -> Option<&wgpu::Texture> {
        self.moments.as_ref().map(|moments| &moments.texture)
    }

    /// The moments in halves with their mips.
    pub(crate) fn half_moments(&self) -> Option<&wgpu::Texture> {
        self.halves.as_ref().map(|halves| &halves.moments.texture)
    }

    /// The weights with their mips, where they are neither in the moments nor the density.
    pub(crate) fn weights(&self) -> Option<&wgpu::Texture> {
        self.halves.as_ref()?.weights.as_ref().map(|weights| &weights.texture)
    }

    /// The density with its mips.
    pub(crate) fn density(&self) -> &wgpu::Texture {
        &self.density.texture
    }

    /// The chains that draw the centres of the kernels, if they are drawn so.
    pub(crate) fn metropolis(&self) -> Option<&Metropolis> {
        self.metropolis.as_ref()
    }

    /// The virtual lights.
    pub(crate) fn vsgls(&self) -> &wgpu::Buffer {
        match &self.lights {
            Lights::Kernels(kernels) => &kernels.vsgls,
            Lights::Clusters(clusters) => clusters.vsgls(),
        }
    }

    /// The clusters, if there are some instead of kernels.
    pub(crate) fn clusters(&self) -> Option<&Clusters> {
        match &self.lights {
            Lights::Kernels(_) => None,
            Lights::Clusters(clusters) => Some(clusters),
        }
    }

    /// The kernels that they were made of; none where there are clusters.
    pub(crate) fn kernels(&self) -> Option<&wgpu::Buffer> {
        match &self.lights {
            Lights::Kernels(kernels) => Some(&kernels.kernels),
            Lights::Clusters(_) => None,
        }
    }

    /// The bytes of each texture, with its mips, and of each buffer.
    pub(crate) fn bytes(&self) -> [Vec<(&'static str, u64)>; 2] {
        let textures = [
            ("moments", self.moments()),
            ("half moments", self.half_moments()),
            ("weights", self.weights()),
            ("density", Some(self.density())),
        ];
        let sized =
            |(name, texture): (_, Option<&wgpu::Texture>)| Some((name, texture_bytes(texture?)));
        let mut buffers = match &self.lights {
            Lights::Clusters(clusters) => clusters.bytes(),
            Lights::Kernels(Kernels { vsgls, kernels, .. }) => {
                vec![("vsgls", vsgls.size()), ("kernels", kernels.size())]
            }
        };
        buffers.extend(self.metropolis().map(|chains| ("chains", chains.chains().size())));
        [textures.into_iter().filter_map(sized).collect(), buffers]
    }
}

fn buffer(device: &wgpu::Device, label: &str, count: u32, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: u64::from(count) * size,
        usage: wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// The bytes of a virtual light.
pub(crate) fn vsgl_size(lobes: Lobes, precision: Precision) -> u64 {
    let size = match (precision, lobes) {
        (Precision::F32, Lobes::Both) => size_of::<sglow_shaders::SglowVsglBoth>(),
        (Precision::F32, Lobes::Diffuse) => size_of::<sglow_shaders::SglowVsglDiffuse>(),
        (Precision::F16, Lobes::Both) => size_of::<sglow_shaders::SglowPackedVsglBoth>(),
        (Precision::F16, Lobes::Diffuse) => size_of::<sglow_shaders::SglowPackedVsglDiffuse>(),
    };
    size as u64
}

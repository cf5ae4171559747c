//! Virtual lights from one map, of the light or of the camera: moments, density, mips, kernels.

use glam::Vec4;
use sglow_shaders::{
    Density, Draw, Filter, Light, Lobes, Precision, SglowDensityParameters, SglowKernel,
    SglowMomentsParametersF16, SglowMomentsParametersF32, SglowSampleParametersF16,
    SglowSampleParametersF32, Solver, Space, Texel, sample::Sample,
};

use crate::cluster::{ClusterInputs, ClusterSettings, Clusters};
use crate::indirect::{IndirectError, SurfaceViews};
use crate::light::LightView;
use crate::metropolis::{Metropolis, MetropolisSettings};
use crate::package::Package;
use crate::pipeline::{ComputePass, Dispatch, uniform};
use crate::pyramid::{MipPasses, Pyramid, texture_bytes};
use crate::timing::Timer;

/// What times are called.
#[derive(Clone, Copy)]
pub(crate) struct Labels {
    moments: &'static str,
    density: &'static str,
    mip_moments: &'static str,
    mip_half_moments: &'static str,
    mip_density: &'static str,
    sample: &'static str,
}

impl Labels {
    /// Of the light's map.
    pub(crate) const LIGHT: Self = Self {
        moments: "moments",
        density: "density",
        mip_moments: "mip moments",
        mip_half_moments: "mip half moments",
        mip_density: "mip density",
        sample: "sample",
    };
    /// Of the camera's.
    pub(crate) const CAMERA: Self = Self {
        moments: "camera moments",
        density: "camera density",
        mip_moments: "camera mip moments",
        mip_half_moments: "camera mip half moments",
        mip_density: "camera mip density",
        sample: "camera sample",
    };
}

/// What lights are made of.
#[derive(Clone)]
pub(crate) struct Plan {
    pub(crate) labels: Labels,
    /// Width and height of the map.
    pub(crate) size: [u32; 2],
    pub(crate) count: u32,
    pub(crate) size_factor: f32,
    pub(crate) iterations: u32,
    pub(crate) light: Light,
    pub(crate) lobes: Lobes,
    pub(crate) precision: Precision,
    pub(crate) density: Density,
    pub(crate) sample: Sample,
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

/// Passes from a map to virtual lights, with all they keep between them.
pub(crate) struct Generation {
    device: wgpu::Device,
    queue: wgpu::Queue,
    plan: Plan,
    moments: Pyramid,
    halves: Option<Halves>,
    density: Pyramid,
    vsgls: wgpu::Buffer,
    kernels: wgpu::Buffer,
    sampler: Option<wgpu::Sampler>,
    metropolis: Option<Metropolis>,
    clusters: Option<Clusters>,
    moments_parameters: wgpu::Buffer,
    density_parameters: wgpu::Buffer,
    sample_parameters: wgpu::Buffer,
    moments_pass: ComputePass,
    density_pass: Option<ComputePass>,
    moments_mip_pass: MipPasses,
    density_mip_pass: MipPasses,
    sample_pass: ComputePass,
}

impl Generation {
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        plan: Plan,
        package: &Package,
    ) -> Result<Self, IndirectError> {
        let Plan { labels, lobes, precision, density, .. } = plan;
        let half = precision == Precision::F16;
        let mip = |texel, label| MipPasses::new(device, package, texel, label);
        let moments_id =
            sglow_shaders::moments::Moments { light: plan.light, lobes, precision }.id();
        let density_id = sglow_shaders::density::Density { density, lobes }.id();
        let sample = plan.sample;
        let iterations = [("sglow_iterations", f64::from(plan.iterations))];
        let constants: &[_] = if sample.solver == Solver::Bisection { &iterations } else { &[] };
        let metropolis = match sample.draw {
            Draw::Warped => None,
            Draw::Metropolis => {
                Some(Metropolis::new(device, package, &MetropolisSettings::of(plan.count))?)
            }
        };
        let clusters = match plan.space {
            Space::None => None,
            space @ (Space::Image | Space::World) => {
                let settings = ClusterSettings {
                    size: plan.size,
                    count: plan.count,
                    draw: sample.draw,
                    space,
                    light: plan.light,
                    lobes,
                };
                Some(Clusters::new(device, queue, package, &settings)?)
            }
        };
        // Mips of a power-of-two square hold exact means; what lies beyond the map stays zero.
        let size = plan.size[0].max(plan.size[1]).next_power_of_two();
        let pyramid = |label, layers, format| Pyramid::new(device, label, size, layers, format);
        let (moment_layers, half_layers) = match (precision, lobes) {
            (Precision::F32, Lobes::Both) => (5, 0),
            (Precision::F32, Lobes::Diffuse) => (3, 0),
            (Precision::F16, Lobes::Both) => (2, 3),
            (Precision::F16, Lobes::Diffuse) => (1, 2),
        };
        let halves = if half {
            Some(Halves {
                moments: pyramid(
                    "sglow half moments",
                    half_layers,
                    wgpu::TextureFormat::Rgba16Float,
                ),
                mip_pass: mip(Texel::Rgba16float, labels.mip_half_moments)?,
                weights: (density != Density::Power)
                    .then(|| pyramid("sglow weights", 1, wgpu::TextureFormat::R32Float)),
            })
        } else {
            None
        };
        // With halves the moments pass writes the weight, which is the reflected power, by itself.
        let density_pass = if half && density == Density::Power {
            None
        } else {
            Some(ComputePass::new(device, package, &density_id, labels.density, &[])?)
        };
        Ok(Self {
            moments: pyramid("sglow moments", moment_layers, wgpu::TextureFormat::Rgba32Float),
            halves,
            density: pyramid("sglow density", 1, wgpu::TextureFormat::R32Float),
            vsgls: vsgl_buffer(device, plan.count, lobes, precision),
            kernels: buffer(device, "sglow kernels", plan.count, size_of::<SglowKernel>()),
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
            clusters,
            // Both precisions' parameters take the same room.
            moments_parameters: uniform::<SglowMomentsParametersF16>(
                device,
                "sglow moments parameters",
            ),
            density_parameters: uniform::<SglowDensityParameters>(
                device,
                "sglow density parameters",
            ),
            sample_parameters: uniform::<SglowSampleParametersF16>(
                device,
                "sglow sample parameters",
            ),
            moments_pass: ComputePass::new(device, package, &moments_id, labels.moments, &[])?,
            density_pass,
            moments_mip_pass: mip(Texel::Rgba32float, labels.mip_moments)?,
            density_mip_pass: mip(Texel::R32float, labels.mip_density)?,
            sample_pass: ComputePass::new(device, package, &sample.id(), labels.sample, constants)?,
            device: device.clone(),
            queue: queue.clone(),
            plan,
        })
    }

    /// Workgroups that cover the map.
    fn workgroups(&self) -> [u32; 3] {
        let [width, height] = self.plan.size;
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
        if self.clusters.is_some() && self.plan.density == Density::Reflectance {
            // Clusters sum what the map holds by themselves, and this density reads it too.
            return;
        }
        let (light, origin) = (view.uniform, view.origin.into());
        match self.plan.precision {
            Precision::F32 => {
                let rest = bytemuck::Zeroable::zeroed();
                let parameters = SglowMomentsParametersF32 { light, origin, ..rest };
                self.write(&self.moments_parameters, &parameters);
            }
            Precision::F16 => {
                let power_scale = 1.0 / view.power_unit;
                let parameters = SglowMomentsParametersF16 { light, origin, power_scale };
                self.write(&self.moments_parameters, &parameters);
            }
        }
        let mut bindings = vec![
            (0, self.moments_parameters.as_entire_binding()),
            (1, wgpu::BindingResource::TextureView(map.position)),
            (2, wgpu::BindingResource::TextureView(map.normal)),
            (3, wgpu::BindingResource::TextureView(map.base_color)),
            (4, wgpu::BindingResource::TextureView(&self.moments.levels[0])),
        ];
        if let Some(halves) = &self.halves {
            let weights = halves.weights.as_ref().unwrap_or(&self.density);
            bindings.push((5, wgpu::BindingResource::TextureView(&halves.moments.levels[0])));
            bindings.push((6, wgpu::BindingResource::TextureView(&weights.levels[0])));
        }
        let dispatch = Dispatch { bindings: &bindings, workgroups: self.workgroups() };
        self.moments_pass.encode(&self.device, encoder, timer, &[dispatch]);
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
        if self.plan.density == Density::Power {
            bindings.insert(0, (0, view(&self.moments.levels[0])));
        } else {
            bindings.push((2, view(map.position)));
        }
        if self.plan.density == Density::Bidirectional {
            bindings.push((3, view(map.normal)));
        }
        if self.plan.density != Density::Power {
            bindings.push((4, view(map.base_color)));
        }
        if let (Density::Bidirectional, Some(importance)) = (self.plan.density, importance) {
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
            bindings.push((6, view(&apart.unwrap_or(&self.moments).levels[0])));
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
            pyramid.encode_mips(&self.device, encoder, pass, self.plan.size, timer.as_deref_mut());
        };
        if self.clusters.is_some() {
            encode(&self.density, &self.density_mip_pass);
            return;
        }
        encode(&self.moments, &self.moments_mip_pass);
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
        let Some(clusters) = &self.clusters else {
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
        let (origin, minimum_variance) = (view.origin.into(), view.minimum_variance);
        let Plan { count, size_factor, .. } = self.plan;
        match self.plan.precision {
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
                    power_unit: view.power_unit,
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
            let weights = halves.weights.as_ref().unwrap_or(&self.density);
            bindings.push((6, wgpu::BindingResource::TextureView(&halves.moments.all)));
            bindings.push((7, wgpu::BindingResource::TextureView(&weights.all)));
        }
        if let Some(metropolis) = &self.metropolis {
            bindings.push((8, metropolis.chains().as_entire_binding()));
        }
        let workgroups = [self.plan.count.div_ceil(64), 1, 1];
        let dispatch = Dispatch { bindings: &bindings, workgroups };
        self.sample_pass.encode(&self.device, encoder, timer, &[dispatch]);
    }

    /// The moments with their mips.
    pub(crate) fn moments(&self) -> &wgpu::Texture {
        &self.moments.texture
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
        self.clusters.as_ref().map_or(&self.vsgls, Clusters::vsgls)
    }

    /// The clusters, if there are some instead of kernels.
    pub(crate) fn clusters(&self) -> Option<&Clusters> {
        self.clusters.as_ref()
    }

    /// The kernels that they were made of.
    pub(crate) fn kernels(&self) -> &wgpu::Buffer {
        &self.kernels
    }

    /// The bytes of each texture, with its mips, and of each buffer of lights.
    pub(crate) fn bytes(&self) -> Vec<(&'static str, u64)> {
        let mut bytes = vec![("moments", texture_bytes(self.moments()))];
        bytes.extend(self.half_moments().map(|texture| ("half moments", texture_bytes(texture))));
        bytes.extend(self.weights().map(|texture| ("weights", texture_bytes(texture))));
        bytes.push(("density", texture_bytes(self.density())));
        bytes.push(("vsgls", self.vsgls.size()));
        bytes.push(("kernels", self.kernels.size()));
        bytes
    }
}

fn buffer(device: &wgpu::Device, label: &str, count: u32, size: usize) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: u64::from(count) * size as u64,
        usage: wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// A buffer of virtual lights.
pub(crate) fn vsgl_buffer(
    device: &wgpu::Device,
    count: u32,
    lobes: Lobes,
    precision: Precision,
) -> wgpu::Buffer {
    let size = match (precision, lobes) {
        (Precision::F32, Lobes::Both) => size_of::<sglow_shaders::SglowVsglBoth>(),
        (Precision::F32, Lobes::Diffuse) => size_of::<sglow_shaders::SglowVsglDiffuse>(),
        (Precision::F16, Lobes::Both) => size_of::<sglow_shaders::SglowPackedVsglBoth>(),
        (Precision::F16, Lobes::Diffuse) => size_of::<sglow_shaders::SglowPackedVsglDiffuse>(),
    };
    buffer(device, "sglow vsgls", count, size)
}

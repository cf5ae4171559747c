//! Direct light with one shadow map, and the picture that all light adds up to.

use glam::Vec3;
use sglow_shaders::{
    Emission, Indirect as IndirectAxis, Light, Ndf, SglowDirectParametersPoint,
    SglowDirectParametersSpot,
};

use crate::indirect::{SurfaceViews, picture};
use crate::light::LightView;
use crate::package::Package;
use crate::pipeline::{ComputePass, Dispatch, PipelineError};
use crate::timing::Timer;

/// How far a position is moved and its depth reduced before it is compared with a shadow map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowBias {
    /// In units of depth, 0 to 1.
    pub depth: f32,
    /// Along the normal, in world units.
    pub normal: f32,
}

/// What one frame of direct light reads.
#[derive(Clone, Copy)]
pub struct DirectInputs<'a> {
    /// The camera's G-buffer, of the picture's size.
    pub gbuffer: SurfaceViews<'a>,
    /// The light.
    pub light: &'a LightView,
    /// The depth that [`crate::raster::Raster::encode_shadow`] drew for it.
    pub shadow_map: &'a wgpu::TextureView,
    /// Against shadows of a surface on itself.
    pub bias: ShadowBias,
    /// The camera's position.
    pub eye: Vec3,
}

/// The direct-light pass.
pub struct Direct {
    device: wgpu::Device,
    queue: wgpu::Queue,
    light: Light,
    size: [u32; 2],
    pass: ComputePass,
    parameters: wgpu::Buffer,
    output: wgpu::Texture,
    view: wgpu::TextureView,
}

impl Direct {
    /// Direct light of one kind of light on surfaces of one distribution (`none`: diffuse alone).
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        package: &Package,
        light: Light,
        ndf: Ndf,
        size: [u32; 2],
    ) -> Result<Self, PipelineError> {
        let id = sglow_shaders::direct::Direct { light, ndf }.id();
        let bytes = if light == Light::Point {
            size_of::<SglowDirectParametersPoint>()
        } else {
            size_of::<SglowDirectParametersSpot>()
        };
        let output = picture(device, "sglow direct", size, wgpu::TextureFormat::Rgba32Float);
        Ok(Self {
            pass: ComputePass::new(device, package, &id, "direct", &[])?,
            parameters: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("sglow direct parameters"),
                size: bytes as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            view: output.create_view(&Default::default()),
            output,
            device: device.clone(),
            queue: queue.clone(),
            light,
            size,
        })
    }

    /// Encodes direct light.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &DirectInputs<'_>,
        timer: Option<&mut Timer<'_>>,
    ) {
        let DirectInputs { gbuffer, light, shadow_map, bias, eye } = *inputs;
        let matrices: Vec<_> =
            light.faces.iter().map(|face| face.clip_from_light.to_cols_array_2d()).collect();
        if self.light == Light::Point {
            let mut parameters: SglowDirectParametersPoint = bytemuck::Zeroable::zeroed();
            parameters.light = light.uniform;
            parameters.eye = eye.into();
            parameters.depth_bias = bias.depth;
            parameters.normal_offset = bias.normal;
            for (target, matrix) in parameters.clip_from_light.iter_mut().zip(matrices) {
                *target = matrix;
            }
            self.queue.write_buffer(&self.parameters, 0, bytemuck::bytes_of(&parameters));
        } else {
            let mut parameters: SglowDirectParametersSpot = bytemuck::Zeroable::zeroed();
            parameters.light = light.uniform;
            parameters.eye = eye.into();
            parameters.depth_bias = bias.depth;
            parameters.normal_offset = bias.normal;
            parameters.clip_from_light = matrices[0];
            self.queue.write_buffer(&self.parameters, 0, bytemuck::bytes_of(&parameters));
        }
        self.pass.encode(
            &self.device,
            encoder,
            timer,
            &[Dispatch {
                bindings: &[
                    (0, self.parameters.as_entire_binding()),
                    (1, wgpu::BindingResource::TextureView(gbuffer.position)),
                    (2, wgpu::BindingResource::TextureView(gbuffer.normal)),
                    (3, wgpu::BindingResource::TextureView(gbuffer.base_color)),
                    (4, wgpu::BindingResource::TextureView(shadow_map)),
                    (5, wgpu::BindingResource::TextureView(&self.view)),
                ],
                workgroups: [self.size[0].div_ceil(8), self.size[1].div_ceil(8), 1],
            }],
        );
    }

    /// Reflected radiance, rgba32float.
    pub fn output(&self) -> &wgpu::Texture {
        &self.output
    }
}

/// The pass that adds everything up.
pub struct Compose {
    device: wgpu::Device,
    size: [u32; 2],
    pass: ComputePass,
    output: wgpu::Texture,
    view: wgpu::TextureView,
}

/// What is added up. A term that the variant leaves out is ignored.
#[derive(Clone, Copy)]
pub struct Terms<'a> {
    /// Direct light.
    pub direct: &'a wgpu::Texture,
    /// Diffuse indirect light.
    pub diffuse: Option<&'a wgpu::Texture>,
    /// Specular indirect light.
    pub specular: Option<&'a wgpu::Texture>,
    /// What surfaces emit.
    pub emission: Option<&'a wgpu::Texture>,
}

impl Compose {
    /// The sum of direct light and these terms.
    pub fn new(
        device: &wgpu::Device,
        package: &Package,
        indirect: IndirectAxis,
        emission: Emission,
        size: [u32; 2],
    ) -> Result<Self, PipelineError> {
        let id = sglow_shaders::compose::Compose { indirect, emission }.id();
        let output = picture(device, "sglow radiance", size, wgpu::TextureFormat::Rgba32Float);
        Ok(Self {
            pass: ComputePass::new(device, package, &id, "compose", &[])?,
            view: output.create_view(&Default::default()),
            output,
            device: device.clone(),
            size,
        })
    }

    /// Encodes the sum.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        terms: Terms<'_>,
        timer: Option<&mut Timer<'_>>,
    ) {
        let views: Vec<_> =
            [(0, Some(terms.direct)), (1, terms.diffuse), (2, terms.specular), (3, terms.emission)]
                .into_iter()
                .filter_map(|(binding, texture)| {
                    texture.map(|texture| (binding, texture.create_view(&Default::default())))
                })
                .collect();
        let mut bindings: Vec<_> = views
            .iter()
            .map(|(binding, view)| (*binding, wgpu::BindingResource::TextureView(view)))
            .collect();
        bindings.push((4, wgpu::BindingResource::TextureView(&self.view)));
        self.pass.encode(
            &self.device,
            encoder,
            timer,
            &[Dispatch {
                bindings: &bindings,
                workgroups: [self.size[0].div_ceil(8), self.size[1].div_ceil(8), 1],
            }],
        );
    }

    /// Radiance towards the camera, rgba32float.
    pub fn output(&self) -> &wgpu::Texture {
        &self.output
    }
}

//! Checks lights and surfaces against the contract of the shading pass: what a debug build runs before it.

use std::fmt;

use sglow_shaders::{Lobes, Precision, SglowCheckParameters};

use crate::device::{DeviceError, Gpu};
use crate::readback;
use sglow_runtime::indirect::SurfaceViews;
use sglow_runtime::package::Package;
use sglow_runtime::pipeline::{PipelineError, guarded, module};

/// How many lights and surfaces break the contract, and where first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Violations {
    /// With a number that is NaN or infinite.
    pub not_finite: u32,
    /// With a number outside of its range.
    pub out_of_range: u32,
    /// With a direction whose length is not 1.
    pub not_unit: u32,
    /// The first light among them.
    pub first_light: Option<u32>,
    /// The first pixel among them, row by row from the top.
    pub first_pixel: Option<u32>,
}

impl Violations {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.first_light.is_none() && self.first_pixel.is_none()
    }
}

impl fmt::Display for Violations {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return formatter.write_str("lights and surfaces keep the contract");
        }
        write!(
            formatter,
            "lights and surfaces break the contract: {} have a number that is not finite, {} one out of range, {} a \
             direction that is not unit",
            self.not_finite, self.out_of_range, self.not_unit
        )?;
        if let Some(light) = self.first_light {
            write!(formatter, "; light {light} is the first")?;
        }
        if let Some(pixel) = self.first_pixel {
            write!(formatter, "; pixel {pixel} is the first, row by row from the top")?;
        }
        Ok(())
    }
}

/// The check as a pass.
pub struct Check {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pass: wgpu::ComputePipeline,
    parameters: wgpu::Buffer,
    violations: wgpu::Buffer,
}

/// What `SglowViolations` holds: three counts, the first light, the first pixel.
const CLEARED: [u32; 5] = [0, 0, 0, u32::MAX, u32::MAX];

impl Check {
    /// A check of lights with these lobes in this precision.
    ///
    /// # Errors
    ///
    /// When the package lacks the variant or the device refuses it.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        package: &Package,
        lobes: Lobes,
        precision: Precision,
    ) -> Result<Self, PipelineError> {
        let id = sglow_shaders::check::Check { lobes, precision }.id();
        let module = module(device, package, &id)?;
        let pass = guarded(device, &id, || {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&id),
                layout: None,
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                cache: None,
            })
        })?;
        Ok(Self {
            device: device.clone(),
            queue: queue.clone(),
            pass,
            parameters: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("sglow check parameters"),
                size: size_of::<SglowCheckParameters>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            violations: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("sglow violations"),
                size: size_of_val(&CLEARED) as u64,
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_SRC
                    | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        })
    }

    /// Encodes the check of `count` lights and of the surfaces of a picture.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        surfaces: SurfaceViews<'_>,
        lights: &wgpu::Buffer,
        count: u32,
        [width, height]: [u32; 2],
    ) {
        let parameters = SglowCheckParameters { count };
        self.queue.write_buffer(&self.parameters, 0, bytemuck::bytes_of(&parameters));
        self.queue.write_buffer(&self.violations, 0, bytemuck::cast_slice(&CLEARED));
        let resources = [
            self.parameters.as_entire_binding(),
            wgpu::BindingResource::TextureView(surfaces.position),
            wgpu::BindingResource::TextureView(surfaces.normal),
            wgpu::BindingResource::TextureView(surfaces.base_color),
            lights.as_entire_binding(),
            self.violations.as_entire_binding(),
        ];
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("check"),
            layout: &self.pass.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.pass);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
    }

    /// What the last check found, once its commands were submitted.
    ///
    /// # Errors
    ///
    /// When the device fails.
    pub fn read(&self, gpu: &Gpu) -> Result<Violations, DeviceError> {
        let words: Vec<u32> = readback::buffer(gpu, &self.violations)?;
        let word = |index: usize| words.get(index).copied().unwrap_or(u32::MAX);
        let first = |index: usize| Some(word(index)).filter(|first| *first != u32::MAX);
        Ok(Violations {
            not_finite: word(0),
            out_of_range: word(1),
            not_unit: word(2),
            first_light: first(3),
            first_pixel: first(4),
        })
    }
}

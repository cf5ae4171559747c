//! Pipelines of variants, with the layouts that were generated beside them.

use thiserror::Error;

use crate::package::{Package, PackageError};
use crate::timing::Timer;

/// Why a variant does not become a pipeline.
#[derive(Debug, Error)]
pub enum PipelineError {
    /// The package does not give its text.
    #[error(transparent)]
    Package(#[from] PackageError),
    /// The bindings do not know it.
    #[error(
        "variant '{id}' has no bindings in this version of sglow-shaders; generate its Rust bindings again"
    )]
    NoBindings {
        /// The variant.
        id: String,
    },
    /// The device refuses it.
    #[error("variant '{id}' does not compile on this device: {message}")]
    Refused {
        /// The variant.
        id: String,
        /// What the device says.
        message: String,
    },
}

/// The shader module and the bind-group layouts of a variant.
pub(crate) struct Compiled {
    pub(crate) module: wgpu::ShaderModule,
    pub(crate) groups: Vec<wgpu::BindGroupLayout>,
    pub(crate) layout: wgpu::PipelineLayout,
}

/// Runs `build` and turns what the device refuses in it into an error that names the variant.
pub(crate) fn guarded<T>(
    device: &wgpu::Device,
    id: &str,
    build: impl FnOnce() -> T,
) -> Result<T, PipelineError> {
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let built = build();
    match pollster::block_on(scope.pop()) {
        None => Ok(built),
        Some(error) => {
            Err(PipelineError::Refused { id: id.to_owned(), message: error.to_string() })
        }
    }
}

pub(crate) fn module(
    device: &wgpu::Device,
    package: &Package,
    id: &str,
) -> Result<wgpu::ShaderModule, PipelineError> {
    let text = package.text(id)?;
    guarded(device, id, || {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(id),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        })
    })
}

pub(crate) fn compile(
    device: &wgpu::Device,
    package: &Package,
    id: &str,
) -> Result<Compiled, PipelineError> {
    let bindings = sglow_shaders::bind_groups(id)
        .ok_or_else(|| PipelineError::NoBindings { id: id.to_owned() })?;
    let module = module(device, package, id)?;
    guarded(device, id, || {
        let groups: Vec<_> = bindings
            .iter()
            .map(|entries| {
                device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: Some(id),
                    entries,
                })
            })
            .collect();
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(id),
            bind_group_layouts: &groups.iter().map(Some).collect::<Vec<_>>(),
            immediate_size: 0,
        });
        Compiled { module, groups, layout }
    })
}

/// A compute variant with one bind group.
pub(crate) struct ComputePass {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroupLayout,
    label: &'static str,
}

/// One dispatch: what it binds, in the order of binding numbers, and how many workgroups.
pub(crate) struct Dispatch<'a> {
    pub(crate) bindings: &'a [(u32, wgpu::BindingResource<'a>)],
    pub(crate) workgroups: [u32; 3],
}

/// One dispatch of a stage that several passes make up.
pub(crate) struct Step<'a> {
    pub(crate) pass: &'a ComputePass,
    pub(crate) bindings: Vec<(u32, wgpu::BindingResource<'a>)>,
    pub(crate) workgroups: [u32; 3],
}

/// Encodes the dispatches of a stage, which follow upon each other, timed as one under its label.
pub(crate) fn encode_stage(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    mut timer: Option<&mut Timer<'_>>,
    label: &'static str,
    steps: &[Step<'_>],
) {
    let groups: Vec<_> =
        steps.iter().map(|step| step.pass.bind_group(device, &step.bindings)).collect();
    timed(encoder, timer.as_deref_mut(), label, |encoder, stamps| {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(label),
            timestamp_writes: stamps.map(|stamps| stamps.compute()),
        });
        for (step, group) in steps.iter().zip(&groups) {
            let [x, y, z] = step.workgroups;
            pass.set_pipeline(&step.pass.pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(x, y, z);
        }
    });
    if let Some(timer) = timer {
        timer.dispatched(steps.len());
    }
}

impl ComputePass {
    pub(crate) fn new(
        device: &wgpu::Device,
        package: &Package,
        id: &str,
        label: &'static str,
        constants: &[(&str, f64)],
    ) -> Result<Self, PipelineError> {
        // What is not committed has no layouts in the bindings: the device then takes them from the module.
        let (module, committed) = if sglow_shaders::bind_groups(id).is_some() {
            let Compiled { module, groups, layout } = compile(device, package, id)?;
            (module, groups.into_iter().next().map(|group| (group, layout)))
        } else {
            (module(device, package, id)?, None)
        };
        guarded(device, id, || {
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(id),
                layout: committed.as_ref().map(|(_, layout)| layout),
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants,
                    ..Default::default()
                },
                cache: None,
            });
            let group =
                committed.map_or_else(|| pipeline.get_bind_group_layout(0), |(group, _)| group);
            Self { pipeline, group, label }
        })
    }

    fn bind_group(
        &self,
        device: &wgpu::Device,
        bindings: &[(u32, wgpu::BindingResource<'_>)],
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = bindings
            .iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: resource.clone(),
            })
            .collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.label),
            layout: &self.group,
            entries: &entries,
        })
    }

    /// Encodes dispatches that follow upon each other, timed as one pass.
    pub(crate) fn encode(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        timer: Option<&mut Timer<'_>>,
        dispatches: &[Dispatch<'_>],
    ) {
        let steps: Vec<_> = dispatches
            .iter()
            .map(|dispatch| Step {
                pass: self,
                bindings: dispatch.bindings.to_vec(),
                workgroups: dispatch.workgroups,
            })
            .collect();
        encode_stage(device, encoder, timer, self.label, &steps);
    }
}

/// Encodes one pass between the beginning and the end of its time.
pub(crate) fn timed(
    encoder: &mut wgpu::CommandEncoder,
    timer: Option<&mut Timer<'_>>,
    label: &str,
    encode: impl FnOnce(&mut wgpu::CommandEncoder, Option<&crate::timing::Stamps<'_>>),
) {
    match timer {
        None => encode(encoder, None),
        Some(timer) => {
            encode(encoder, timer.begin(label).as_ref());
            timer.end(encoder);
        }
    }
}

/// A uniform buffer that holds one struct.
pub(crate) fn uniform<T: bytemuck::NoUninit>(device: &wgpu::Device, label: &str) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size_of::<T>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

//! One function of the library over a buffer of arguments: what measures the functions that the passes are made of.

use std::time::Instant;

use crate::device::{DeviceError, Gpu};
use crate::readback;
use sglow_runtime::package::Package;
use sglow_runtime::pipeline::{PipelineError, guarded, module};
use thiserror::Error;

/// Why a function cannot be run.
#[derive(Debug, Error)]
pub enum FunctionError {
    /// Its variant does not become a pipeline.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// The device fails.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

/// Three vectors of four numbers; the function's `call` in `shaders/library.toml` says which means what.
pub type Arguments = [f32; 12];

/// A number of the arguments is NaN or infinite.
pub const NOT_FINITE: u32 = 1;
/// A number of the arguments is outside of its range.
pub const OUT_OF_RANGE: u32 = 2;
/// A direction among the arguments is not of length 1.
pub const NOT_UNIT: u32 = 4;

/// A function that is about to be timed.
pub struct Stopwatch<'a> {
    function: &'a Function<'a>,
    time: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    evaluations: f64,
}

impl Stopwatch<'_> {
    /// The time of one evaluation in nanoseconds, all cores of the device at work: that of one dispatch, by the wall's
    /// clock, over its evaluations.
    ///
    /// # Errors
    ///
    /// When the device fails.
    pub fn nanoseconds(&self) -> Result<f64, DeviceError> {
        let start = Instant::now();
        self.function.dispatch(&self.time, &self.group, TIMED_INVOCATIONS / WORKGROUP);
        self.function.gpu.finish()?;
        Ok(start.elapsed().as_secs_f64() * 1e9 / self.evaluations)
    }
}

/// Invocations of a workgroup of both entry points.
const WORKGROUP: u32 = 64;
/// Invocations of one timed dispatch.
const TIMED_INVOCATIONS: u32 = 4096;
/// The most elements that one dispatch evaluates: workgroups in one dimension are limited.
const CHUNK: usize = 1 << 20;

/// A function of the library as a pipeline.
pub struct Function<'a> {
    gpu: &'a Gpu,
    id: String,
    module: wgpu::ShaderModule,
    evaluate: wgpu::ComputePipeline,
}

impl<'a> Function<'a> {
    /// The variant `id` of the pass `function`.
    ///
    /// # Errors
    ///
    /// When the package lacks the variant or the device refuses it.
    pub fn new(gpu: &'a Gpu, package: &Package, id: &str) -> Result<Self, PipelineError> {
        let module = module(&gpu.device, package, id)?;
        let evaluate = pipeline(gpu, id, &module, "sglow_evaluate_function", &[])?;
        Ok(Self { gpu, id: id.to_owned(), module, evaluate })
    }

    /// The function at each of the arguments, which reach it through a buffer: nothing can be folded.
    ///
    /// # Errors
    ///
    /// When the device fails.
    pub fn evaluate(&self, arguments: &[Arguments]) -> Result<Vec<[f32; 4]>, DeviceError> {
        self.at_all(&self.evaluate, arguments)
    }

    /// How each of the arguments breaks the function's contract: the bits of [`NOT_FINITE`], [`OUT_OF_RANGE`] and
    /// [`NOT_UNIT`], 0 where all is right.
    ///
    /// # Errors
    ///
    /// When the device refuses the entry point, or fails.
    pub fn check(&self, arguments: &[Arguments]) -> Result<Vec<u32>, FunctionError> {
        let check = pipeline(self.gpu, &self.id, &self.module, "sglow_check_function", &[])?;
        let results = self.at_all(&check, arguments)?;
        Ok(results.into_iter().map(|[bits, ..]| bits as u32).collect())
    }

    fn at_all(
        &self,
        pipeline: &wgpu::ComputePipeline,
        arguments: &[Arguments],
    ) -> Result<Vec<[f32; 4]>, DeviceError> {
        let mut results = Vec::with_capacity(arguments.len());
        for chunk in arguments.chunks(CHUNK) {
            let (inputs, outputs) = self.buffers(chunk, chunk.len());
            let group = self.group(pipeline, &inputs, &outputs);
            self.dispatch(pipeline, &group, (chunk.len() as u32).div_ceil(WORKGROUP));
            results.extend(readback::buffer::<[f32; 4]>(self.gpu, &outputs)?);
        }
        Ok(results)
    }

    /// Gets ready to time the function on these arguments. The first dispatch, which compiles, is behind it then.
    ///
    /// # Errors
    ///
    /// When the device refuses the entry point, or fails.
    pub fn stopwatch(
        &self,
        arguments: &[Arguments],
        repetitions: u32,
    ) -> Result<Stopwatch<'_>, FunctionError> {
        let constants = [("sglow_repetitions", f64::from(repetitions))];
        let time = pipeline(self.gpu, &self.id, &self.module, "sglow_time_function", &constants)?;
        let (inputs, outputs) = self.buffers(arguments, TIMED_INVOCATIONS as usize);
        let group = self.group(&time, &inputs, &outputs);
        let evaluations = f64::from(TIMED_INVOCATIONS) * f64::from(repetitions);
        let stopwatch = Stopwatch { function: self, time, group, evaluations };
        stopwatch.nanoseconds()?;
        Ok(stopwatch)
    }

    fn buffers(&self, arguments: &[Arguments], results: usize) -> (wgpu::Buffer, wgpu::Buffer) {
        let device = &self.gpu.device;
        let bytes: &[u8] = bytemuck::cast_slice(arguments);
        let inputs = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("sglow function arguments"),
            size: bytes.len() as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.gpu.queue.write_buffer(&inputs, 0, bytes);
        let outputs = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("sglow function results"),
            size: (results * size_of::<[f32; 4]>()) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        (inputs, outputs)
    }

    fn group(
        &self,
        pipeline: &wgpu::ComputePipeline,
        inputs: &wgpu::Buffer,
        outputs: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("sglow function"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: inputs.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: outputs.as_entire_binding() },
            ],
        })
    }

    fn dispatch(&self, pipeline: &wgpu::ComputePipeline, group: &wgpu::BindGroup, groups: u32) {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(groups, 1, 1);
        }
        self.gpu.queue.submit([encoder.finish()]);
    }
}

fn pipeline(
    gpu: &Gpu,
    id: &str,
    module: &wgpu::ShaderModule,
    entry_point: &str,
    constants: &[(&str, f64)],
) -> Result<wgpu::ComputePipeline, PipelineError> {
    guarded(&gpu.device, id, || {
        gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(id),
            layout: None,
            module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants,
                ..Default::default()
            },
            cache: None,
        })
    })
}

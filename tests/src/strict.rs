//! Every legal variant on a device that takes nothing beyond WebGPU: its default limits, no optional feature. No driver
//! compiles them.

use sglow_runtime::pipeline::{guarded, module};

use crate::common::whole_space;

/// A device as a browser gives it to who asks for nothing, with all of wgpu's validation and no driver behind it.
fn device() -> wgpu::Device {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::NOOP;
    descriptor.backend_options.noop.enable = true;
    descriptor.flags |= wgpu::InstanceFlags::STRICT_WEBGPU_COMPLIANCE;
    let instance = wgpu::Instance::new(descriptor);
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    let device = adapter.unwrap().request_device(&wgpu::DeviceDescriptor::default());
    pollster::block_on(device).unwrap().0
}

#[test]
fn variants_are_taken_by_strict_webgpu() {
    let package = whole_space();
    let device = device();
    let mut refused = Vec::new();
    let mut pipelines = 0;
    for id in package.variants() {
        let module = match module(&device, package, id) {
            Ok(module) => module,
            Err(error) => {
                refused.push(error.to_string());
                continue;
            }
        };
        let read = naga::front::wgsl::parse_str(package.text(id).unwrap()).unwrap();
        let compute = |entry: &&naga::EntryPoint| entry.stage == naga::ShaderStage::Compute;
        for entry in read.entry_points.iter().filter(compute) {
            let made = guarded(&device, id, || {
                device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(id),
                    layout: None,
                    module: &module,
                    entry_point: Some(&entry.name),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    cache: None,
                })
            });
            match made {
                Ok(_) => pipelines += 1,
                Err(error) => refused.push(error.to_string()),
            }
        }
    }
    println!("{pipelines} compute pipelines");
    assert!(refused.is_empty(), "{}", refused.join("\n"));
    assert!(pipelines > 500);
}

#[test]
fn what_is_beyond_webgpu_is_refused() {
    // Negative control: 64-bit floats, and a workgroup above the default limit.
    let device = device();
    let texts = [
        ("floats", "@compute @workgroup_size(1) fn main() { var x: f64 = 1.0; x += 1.0; }"),
        ("invocations", "@compute @workgroup_size(257) fn main() {}"),
    ];
    for (name, text) in texts {
        let made = guarded(&device, name, || {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(text.into()),
            });
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: None,
                module: &module,
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        });
        assert!(made.is_err(), "{name}");
    }
}

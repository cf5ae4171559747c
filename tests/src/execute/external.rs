//! What a host supplies and does not fit: each thing is an error that names the resource, what it is and what would be right,
//! before anything is encoded, and none of them reaches the device's own error handler.

use sglow_graph::Configuration;
use sglow_runtime::execute::{Executor, Inputs, Lists};
use sglow_runtime::indirect::PARTS;
use sglow_shaders::Precision;
use wgpu::{TextureDimension, TextureFormat, TextureUsages, TextureViewDimension};

use super::foreign::Foreign;
use super::{Embedded, base, lights};
use crate::common::gpu;

const SAMPLED: TextureUsages = TextureUsages::TEXTURE_BINDING;

/// A texture of one layer, one level and one sample.
fn plain(size: [u32; 2], format: TextureFormat) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage: SAMPLED,
        view_formats: &[],
    }
}

fn layered(of: wgpu::TextureDescriptor<'static>, layers: u32) -> wgpu::TextureDescriptor<'static> {
    let size = wgpu::Extent3d { depth_or_array_layers: layers, ..of.size };
    wgpu::TextureDescriptor { size, ..of }
}

fn texture(of: &wgpu::TextureDescriptor<'_>) -> wgpu::Texture {
    gpu().device.create_texture(of)
}

fn view(of: &wgpu::TextureDescriptor<'_>, dimension: TextureViewDimension) -> wgpu::TextureView {
    let dimension = Some(dimension);
    texture(of).create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() })
}

fn buffer(size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
    gpu().device.create_buffer(&descriptor)
}

/// What encoding comes to, and that the device has nothing to say about it.
fn encode(executor: &mut Executor, inputs: &Inputs<'_>) -> Result<(), String> {
    let device = &gpu().device;
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let mut encoder = device.create_command_encoder(&Default::default());
    let encoded = executor.encode(&mut encoder, inputs, None).map_err(|faults| faults.to_string());
    gpu().queue.submit([encoder.finish()]);
    gpu().finish().unwrap();
    let reached = pollster::block_on(scope.pop());
    assert!(reached.is_none(), "{encoded:?} {reached:?}");
    encoded
}

/// That a single thing is wrong, called so.
fn assert_refused(executor: &mut Executor, inputs: &Inputs<'_>, start: &str, parts: &[&str]) {
    let text = encode(executor, inputs).expect_err(start);
    assert!(text.starts_with(start), "{text}\ninstead of {start}");
    assert!(parts.iter().all(|part| text.contains(part)), "{text}\nwithout {parts:?}");
    assert_eq!(text.lines().count(), 1, "{text}");
}

#[test]
fn what_is_sampled_fits_or_is_named() {
    let mut embedded = Embedded::new(base());
    embedded.run();
    let good = embedded.inputs();
    let executor = &mut embedded.executor;
    let right = plain([48, 48], TextureFormat::Rgba16Float);
    let of_format = |format| wgpu::TextureDescriptor { format, ..right.clone() };
    let drawn = TextureUsages::RENDER_ATTACHMENT;
    let solid = wgpu::TextureDescriptor { dimension: TextureDimension::D3, ..right.clone() };
    let samples =
        wgpu::TextureDescriptor { sample_count: 4, usage: SAMPLED | drawn, ..right.clone() };
    let unbound = wgpu::TextureDescriptor { usage: drawn, ..right.clone() };
    let flat = TextureViewDimension::D2;
    let wrong = [
        (view(&layered(right.clone(), 2), TextureViewDimension::D2Array), "", "D2Array"),
        (view(&layered(right.clone(), 6), TextureViewDimension::Cube), "", "Cube"),
        (view(&solid, TextureViewDimension::D3), "a texture of dimension D3; ", ""),
        (
            view(&of_format(TextureFormat::Depth32Float), flat),
            "a texture of format Depth32Float",
            "",
        ),
        (view(&of_format(TextureFormat::Rgba16Uint), flat), "a texture of format Rgba16Uint; ", ""),
        (view(&of_format(TextureFormat::Rgba16Sint), flat), "a texture of format Rgba16Sint; ", ""),
        (view(&samples, flat), "a texture of 4 samples; ", ""),
        (view(&unbound, flat), "a texture without usage ", "TEXTURE_BINDING"),
        (view(&plain([40, 24], right.format), flat), "a texture of 40 x 24 texels; ", ""),
    ];
    for (view, found, part) in &wrong {
        let mut inputs = good.clone();
        inputs.view("rsm_normal", view);
        let start = format!("resource `rsm_normal` is {found}");
        let expected = "it has to be a texture of 48 x 48 texels, rgba16float";
        assert_refused(executor, &inputs, &start, &[expected, part]);
    }
    // A view that allows less than its texture.
    let both = wgpu::TextureDescriptor { usage: SAMPLED | drawn, ..right.clone() };
    let descriptor = wgpu::TextureViewDescriptor { usage: Some(drawn), ..Default::default() };
    let mut inputs = good.clone();
    inputs.view("rsm_normal", &texture(&both).create_view(&descriptor));
    assert_refused(executor, &inputs, "resource `rsm_normal` is ", &["TEXTURE_BINDING"]);
    // A buffer of one's own in place of a texture.
    let storage = buffer(1 << 20, wgpu::BufferUsages::STORAGE);
    let mut inputs = good.clone();
    inputs.buffer("rsm_normal", &storage);
    assert_refused(executor, &inputs, "resource `rsm_normal` is a buffer; ", &["a texture"]);

    // All that is wrong is named at once, and each thing of one resource.
    let small = wgpu::TextureDescriptor {
        sample_count: 4,
        usage: drawn,
        ..plain([8, 16], TextureFormat::Rgba16Uint)
    };
    let mut inputs = good.clone();
    inputs
        .view("rsm_normal", &wrong[0].0)
        .view("rsm_position", &wrong[1].0)
        .texture("rsm_base_color", &texture(&small));
    let text = encode(executor, &inputs).unwrap_err();
    assert_eq!(text.lines().count(), 3, "{text}");
    let all = "resource `rsm_base_color` is a texture of 8 x 16 texels, of 4 samples, of format Rgba16Uint, without usage TextureUsages(TEXTURE_BINDING); ";
    for start in [all, "resource `rsm_normal` is ", "resource `rsm_position` is "] {
        assert!(text.lines().any(|line| line.starts_with(start)), "{text}\nwithout {start}");
    }

    // Negative control: other float formats, a layer of several and more levels than are read fit.
    let deep = wgpu::TextureDescriptor { mip_level_count: 3, ..layered(right.clone(), 2) };
    let layer = wgpu::TextureViewDescriptor {
        dimension: Some(flat),
        base_array_layer: 1,
        ..Default::default()
    };
    for fits in [
        texture(&deep).create_view(&layer),
        view(&of_format(TextureFormat::Rgba32Float), flat),
        view(&of_format(TextureFormat::Rgba8Snorm), flat),
    ] {
        let mut inputs = good.clone();
        inputs.view("rsm_normal", &fits);
        encode(executor, &inputs).unwrap();
    }
    embedded.run();
    assert!(embedded.lights() == lights(&embedded.renderer));
}

/// The moments of an engine's own: written at level 0, read as layers with all their levels.
#[test]
fn what_has_layers_and_levels_fits_or_is_named() {
    let mut embedded = Embedded::new(base());
    let configuration = Configuration {
        parts: Some(PARTS.map(str::to_owned).into()),
        supplied: ["moments".to_owned()].into(),
        ..embedded.settings.configuration()
    };
    let frame = embedded.package.description().unwrap().evaluate(&configuration).unwrap();
    let (device, queue) = (&gpu().device, &gpu().queue);
    let lists = Lists::new();
    let made = Executor::new(device, queue, &embedded.package, &frame, &lists);
    embedded.executor = made.unwrap();
    let good = embedded.inputs();
    let right = wgpu::TextureDescriptor {
        mip_level_count: 7,
        usage: SAMPLED | TextureUsages::STORAGE_BINDING,
        ..layered(plain([64, 64], TextureFormat::Rgba32Float), 5)
    };
    let usage = SAMPLED;
    let levels = |mip_level_count| wgpu::TextureDescriptor { mip_level_count, ..right.clone() };
    let wrong = [
        (layered(right.clone(), 3), "a texture of 3 layers; "),
        (levels(6), "a texture of 6 levels; "),
        (wgpu::TextureDescriptor { usage, ..right.clone() }, "a texture without usage "),
        (
            wgpu::TextureDescriptor { format: TextureFormat::Rgba16Float, ..right.clone() },
            "a texture of format Rgba16Float; ",
        ),
    ];
    let expected = "it has to be a texture of 64 x 64 texels, rgba32float, 5 layers, 7 levels";
    for (wrong, found) in wrong {
        let mut inputs = good.clone();
        inputs.texture("moments", &texture(&wrong));
        let start = format!("resource `moments` is {found}");
        assert_refused(&mut embedded.executor, &inputs, &start, &[expected]);
    }
    // What a view shows of them cannot be seen.
    for dimension in [TextureViewDimension::D2, TextureViewDimension::D2Array] {
        let mut inputs = good.clone();
        inputs.view("moments", &view(&layered(right.clone(), 5), dimension));
        let start = "resource `moments` is a view; ";
        assert_refused(&mut embedded.executor, &inputs, start, &[expected]);
    }
    let mut inputs = good.clone();
    inputs.texture("moments", &texture(&right));
    encode(&mut embedded.executor, &inputs).unwrap();
    assert!(embedded.lights() == lights(&embedded.renderer));
}

/// The lights of an engine's own, in a buffer.
#[test]
fn buffers_fit_or_are_named() {
    let embedded = Embedded::new(base());
    let parts = Some(["shading".to_owned()].into());
    let configuration = Configuration { parts, ..embedded.settings.configuration() };
    let frame = embedded.package.description().unwrap().evaluate(&configuration).unwrap();
    let (device, queue) = (&gpu().device, &gpu().queue);
    let mut executor =
        Executor::new(device, queue, &embedded.package, &frame, &Lists::new()).unwrap();
    let good = embedded.inputs();
    assert_eq!(embedded.settings.precision, Precision::F32);
    let size = 80 * u64::from(embedded.settings.lights);
    let storage = wgpu::BufferUsages::STORAGE;
    for (wrong, found) in [
        (buffer(size - 4, storage), format!("a buffer of {} bytes; ", size - 4)),
        (buffer(size, wgpu::BufferUsages::UNIFORM), "a buffer without usage ".to_owned()),
    ] {
        let mut inputs = good.clone();
        inputs.buffer("vsgls", &wrong);
        let start = format!("resource `vsgls` is {found}");
        assert_refused(&mut executor, &inputs, &start, &[&format!("a buffer of {size} bytes")]);
    }
    let mut inputs = good.clone();
    inputs.texture("vsgls", &texture(&plain([8, 8], TextureFormat::R32Float)));
    assert_refused(&mut executor, &inputs, "resource `vsgls` is a texture; ", &[]);
    let mut inputs = good.clone();
    inputs.buffer("vsgls", &buffer(size, storage));
    encode(&mut executor, &inputs).unwrap();
}

/// A picture of an engine's own that is drawn to.
#[test]
fn targets_fit_or_are_named() {
    let foreign = Foreign::new();
    let mut executor = foreign.executor_with(0, "inclusive", &["picture"]);
    let good = foreign.inputs(0);
    let usage = TextureUsages::RENDER_ATTACHMENT;
    let right = wgpu::TextureDescriptor { usage, ..plain([256, 64], TextureFormat::Rgba8Unorm) };
    let another = wgpu::TextureDescriptor { format: TextureFormat::R8Unorm, ..right.clone() };
    let samples = wgpu::TextureDescriptor { sample_count: 4, ..right.clone() };
    let unbound = wgpu::TextureDescriptor { usage: SAMPLED, ..right.clone() };
    let small = wgpu::TextureDescriptor { usage, ..plain([256, 32], right.format) };
    for (wrong, found) in [
        (another, "a texture of format R8Unorm; "),
        (samples, "a texture of 4 samples; "),
        (unbound, "a texture without usage "),
        (small, "a texture of 256 x 32 texels; "),
    ] {
        let mut inputs = good.clone();
        inputs.texture("picture", &texture(&wrong));
        let start = format!("resource `picture` is {found}");
        let expected = "it has to be a texture of 256 x 64 texels, rgba8unorm";
        assert_refused(&mut executor, &inputs, &start, &[expected]);
    }
    let mut inputs = good.clone();
    inputs.view("picture", &view(&layered(right.clone(), 3), TextureViewDimension::D2Array));
    assert_refused(&mut executor, &inputs, "resource `picture` is a view; ", &["a texture"]);
    let mut inputs = good.clone();
    inputs.texture("picture", &texture(&layered(right.clone(), 3)));
    encode(&mut executor, &inputs).unwrap();
}

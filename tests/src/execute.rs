//! Frames that are data, on a device: what a host gives, what it leaves out, and what is made when.
//!
//! That they show what frames showed before is held in `frames.rs`.

mod external;
mod foreign;

use glam::{DVec3, Vec3};
use sglow_graph::{Configuration, Frame};
use sglow_renderer::frame::Renderer;
use sglow_renderer::plan::Surfaces;
use sglow_renderer::readback;
use sglow_renderer::stages::Stages as _;
use sglow_runtime::execute::{DrawList, Executor, Input, Inputs, Lists, Stage};
use sglow_runtime::indirect::{Indirect, PARTS};
use sglow_runtime::light::{LightView, Surroundings};
use sglow_runtime::occluders::Occluders;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::{Light, Scene};
use sglow_shaders::{Draw, Emitter, Visibility};

use crate::common::{gpu, library, package_of, packaged, plan, whole_space};

/// The frame of settings, or parts of it, in a scene.
fn frame(package: &Package, settings: &Settings, scene: &Scene, parts: Option<&[&str]>) -> Frame {
    let mut configuration = settings.configuration();
    Surfaces::of(scene, settings.complete).describe(&mut configuration);
    let parts = parts.map(|parts| parts.iter().map(|part| (*part).to_owned()).collect());
    let description = package.description().unwrap();
    description
        .evaluate(&Configuration { parts, ..configuration })
        .unwrap_or_else(|errors| panic!("{errors}"))
}

fn base() -> Settings {
    Settings { size: [40, 24], map: 48, lights: 60, camera_lights: 70, ..Settings::default() }
}

/// A light that moves and changes from frame to frame.
fn moved(light: &Light, frame: usize) -> Light {
    let mut light = light.clone();
    light.position[0] += 0.05 * frame as f32;
    light.intensity = light.intensity.map(|part| part * (1.0 + frame as f32));
    light
}

pub(crate) fn buffer(buffer: &wgpu::Buffer) -> Vec<u8> {
    readback::buffer(gpu(), buffer).unwrap()
}

/// Submits what is encoded and waits for it.
pub(crate) fn submit(encode: impl FnOnce(&mut wgpu::CommandEncoder)) {
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    encode(&mut encoder);
    gpu().queue.submit([encoder.finish()]);
    gpu().finish().unwrap();
}

/// A small case with an executor that has its maps from a renderer: what an engine runs.
struct Embedded {
    scene: Scene,
    settings: Settings,
    package: Package,
    renderer: Renderer<'static>,
    executor: Executor,
}

/// The host's textures by the names of the frame's resources.
fn maps<'a>(renderer: &'a Renderer<'_>) -> [(&'static str, &'a wgpu::TextureView); 6] {
    let given = renderer.inputs();
    [
        ("rsm_position", given.rsm.position),
        ("rsm_normal", given.rsm.normal),
        ("rsm_base_color", given.rsm.base_color),
        ("gbuffer_position", given.gbuffer.position),
        ("gbuffer_normal", given.gbuffer.normal),
        ("gbuffer_base_color", given.gbuffer.base_color),
    ]
}

impl Embedded {
    fn new(settings: Settings) -> Self {
        let scene = Scene::builtin("cornell").unwrap();
        let light = sglow_renderer::light::kind(&scene.lights[0]);
        let settings = Settings { light, ..settings };
        let package = package_of(&plan(&settings, &scene).variants);
        let renderer = Renderer::new(gpu(), &package, &scene, &settings, 0).unwrap();
        renderer.render().unwrap();
        let executor = {
            let frame = frame(&package, &settings, &scene, Some(&PARTS));
            let gpu = gpu();
            Executor::new(&gpu.device, &gpu.queue, &package, &frame, &Lists::new()).unwrap()
        };
        Self { scene, settings, package, renderer, executor }
    }

    fn inputs(&self) -> Inputs<'static> {
        inputs(&self.renderer)
    }

    fn run(&mut self) {
        let inputs = self.inputs();
        submit(|encoder| self.executor.encode(encoder, &inputs, None).unwrap());
    }

    fn lights(&self) -> Vec<u8> {
        buffer(self.executor.buffer("vsgls").unwrap())
    }
}

/// Everything that a host gives for indirect light, as a renderer has it.
fn inputs(renderer: &Renderer<'_>) -> Inputs<'static> {
    renderer.indirect().given(&renderer.inputs())
}

fn lights(renderer: &Renderer<'_>) -> Vec<u8> {
    buffer(&renderer.indirect().vsgls().unwrap())
}

#[test]
fn a_manifest_loses_nothing_of_the_frame() {
    let library = library();
    let package = packaged("nothing", &library, &[]);
    assert_eq!(package.description(), library.frame().map(|frame| &frame.description));
    assert_eq!(Package::embedded().description(), package.description());
}

#[test]
fn an_engine_supplies_maps_and_may_change_them() {
    let mut embedded = Embedded::new(base());
    embedded.run();
    let expected = lights(&embedded.renderer);
    assert!(embedded.lights() == expected);
    let before = embedded.executor.made();
    embedded.run();
    assert_eq!(embedded.executor.made(), before);

    // Another renderer's maps, of another light: other views, so that what binds them is made anew, and no more.
    let Embedded { package, scene, settings, .. } = &embedded;
    let mut other = Renderer::new(gpu(), package, scene, settings, 0).unwrap();
    other.move_light(&moved(&scene.lights[0], 1)).unwrap();
    other.render().unwrap();
    let first = std::mem::replace(&mut embedded.renderer, other);
    embedded.run();
    let expected_other = lights(&embedded.renderer);
    assert!(embedded.lights() == expected_other && expected != expected_other);
    let after = embedded.executor.made();
    // moments and shade bind maps; density, mips and sample do not.
    assert_eq!((after.pipelines, after.groups), (before.pipelines, before.groups + 2));
    embedded.renderer = first;
    embedded.run();
    assert!(embedded.lights() == expected);
}

/// A texture of an engine's own that shading writes to.
fn output(format: wgpu::TextureFormat) -> wgpu::Texture {
    gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 40, height: 24, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

#[test]
fn an_engine_supplies_what_is_written_to() {
    let mut embedded = Embedded::new(base());
    embedded.run();
    let Embedded { settings, package, renderer, executor, .. } = &embedded;
    let expected = readback::texture(gpu(), executor.texture("diffuse").unwrap(), 0).unwrap();
    let configuration = Configuration {
        parts: Some(PARTS.map(str::to_owned).into()),
        supplied: ["diffuse".to_owned()].into(),
        ..settings.configuration()
    };
    let (source, nothing) = (gpu().source(package), Occluders::default());
    let indirect =
        Indirect::of_configuration(source, settings, configuration, &nothing, &Lists::new());
    let indirect = indirect.unwrap();
    let encode = |texture: &wgpu::Texture| {
        let mut given = indirect.given(&renderer.inputs());
        given.texture("diffuse", texture);
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        let encoded = indirect.executor().encode(&mut encoder, &given, None);
        gpu().queue.submit([encoder.finish()]);
        gpu().finish().unwrap();
        encoded.map_err(|error| error.to_string())
    };
    let own = output(wgpu::TextureFormat::Rgba32Float);
    encode(&own).unwrap();
    assert!(readback::texture(gpu(), &own, 0).unwrap() == expected);
    // What is written is of one format.
    let text = encode(&output(wgpu::TextureFormat::Rgba16Float)).unwrap_err();
    assert_eq!(
        text,
        "resource `diffuse` is a texture of format Rgba16Float; it has to be a texture of 40 x 24 texels, rgba32float; \
         rgba16float where output == 'rgba16float'"
    );
}

/// Indirect light that was resized and given other triangles is that of one that is made anew.
#[test]
fn what_is_resized_and_occluded_is_as_if_made_anew() {
    let visibility = Visibility::Imperfect;
    let small = Settings { visibility, shadow_points: 128, tile: 16, ..base() };
    let other = Settings { lights: 30, emitter: Emitter::Disc, bias_scale: 2.0, ..small.clone() };
    let Embedded { scene, renderer, .. } = Embedded::new(base());
    let (source, inputs) = (gpu().source(whole_space()), renderer.inputs());
    let occluders =
        |settings: &Settings| sglow_renderer::frame::occluders(gpu(), &scene, settings).unwrap();
    let made = |settings: &Settings, occluders: &Occluders| {
        Indirect::of_parts(source, settings, &PARTS, occluders).unwrap()
    };
    let run = |indirect: &Indirect| {
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        indirect.encode(&mut encoder, &inputs, None).map_err(|error| error.to_string())?;
        gpu().queue.submit([encoder.finish()]);
        gpu().finish().unwrap();
        Ok::<_, String>(readback::texture(gpu(), &indirect.diffuse().unwrap(), 0).unwrap())
    };
    let mut indirect = made(&small, &Occluders::default());
    // Without triangles no light is unshadowed in silence, and other numbers of points lie elsewhere.
    let text = run(&indirect).unwrap_err();
    let expected = "the geometry that occludes is left out; it has to be for visibility=imperfect,shadow_points=128";
    assert!(text.starts_with(expected), "{text}");
    let of_others = occluders(&Settings { shadow_points: 64, ..small.clone() });
    let text = indirect.occlude(of_others).unwrap_err().to_string();
    assert!(text.contains("shadow_points=64; it has to be for visibility=imperfect"), "{text}");
    indirect.occlude(occluders(&small)).unwrap();
    let first = run(&indirect).unwrap();
    indirect.resize(&other).unwrap();
    let second = run(&indirect).unwrap();
    indirect.occlude(occluders(&other)).unwrap();
    assert!(run(&indirect).unwrap() == second);
    assert!(first == run(&made(&small, &occluders(&small))).unwrap());
    assert!(second == run(&made(&other, &occluders(&other))).unwrap() && first != second);
    // A light of another kind.
    let directional = Settings { light: sglow_shaders::Light::Directional, ..base() };
    let text = run(&made(&directional, &Occluders::default())).unwrap_err();
    assert!(text.contains("a spot light") && text.contains("light=directional"), "{text}");
}

/// Positions are relative to an origin: far from that of the world nothing changes.
#[test]
fn lights_far_from_the_worlds_origin_are_those_near_it() {
    let view = |offset: DVec3| {
        let center = offset + DVec3::new(0.5, 1.0, -0.25);
        let around = Surroundings { origin: offset, center, radius: 3.0, map: 64 };
        let at = offset + DVec3::new(1.0, 4.0, 0.5);
        [
            LightView::spot(&around, at, Vec3::NEG_Y, [0.3, 0.6], [1.0, 2.0, 3.0]),
            LightView::directional(&around, Vec3::NEG_Y, [1.0; 3]),
            LightView::point(&around, at, [1.0; 3]),
        ]
    };
    let text = |offset| format!("{:?}", view(offset));
    let far = f64::from(1 << 20) * DVec3::new(1.0, -2.0, 4.0);
    assert_eq!(text(far), text(DVec3::ZERO));
    // Negative control: positions that are relative to another origin.
    let around = Surroundings { origin: DVec3::ONE, center: DVec3::ZERO, radius: 3.0, map: 64 };
    let near = LightView::point(&around, DVec3::ZERO, [1.0; 3]);
    assert_ne!(near.origin, view(DVec3::ZERO)[2].origin);
}

#[test]
fn chains_begin_again_and_sizes_change() {
    let draw = Draw::Metropolis;
    let mut embedded = Embedded::new(Settings { draw, ..base() });
    embedded.run();
    let first = embedded.lights();
    embedded.run();
    let second = embedded.lights();
    embedded.executor.restart();
    embedded.run();
    assert!(first == embedded.lights() && first != second);
    // Both frames are encoded before the first of them runs: each has its own number.
    embedded.executor.restart();
    let inputs = embedded.inputs();
    submit(|encoder| {
        embedded.executor.encode(encoder, &inputs, None).unwrap();
        embedded.executor.encode(encoder, &inputs, None).unwrap();
    });
    assert!(second == embedded.lights());

    let pipelines = embedded.executor.made().pipelines;
    let Embedded { package, scene, settings, executor, .. } = &mut embedded;
    let fewer = Settings { lights: 7, ..settings.clone() };
    let frame = frame(package, &fewer, scene, Some(&PARTS));
    executor.resize(package, &frame, &Lists::new()).unwrap();
    embedded.run();
    assert_eq!(embedded.executor.made().pipelines, pipelines);
    assert!(embedded.lights().len() < first.len());
    let same = Embedded::new(Settings { draw, lights: 7, ..base() });
    assert!(embedded.lights() == lights(&same.renderer));
}

#[test]
fn what_a_host_leaves_out_is_named_all_at_once() {
    let mut embedded = Embedded::new(base());
    let mut inputs = embedded.inputs();
    let Embedded { renderer, executor, .. } = &mut embedded;
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    let nothing = executor.encode(&mut encoder, &Inputs::new(), None).unwrap_err().to_string();
    for name in ["light.position", "origin", "eye", "minimum_variance", "diffuse_mean_length"] {
        assert!(
            nothing.contains(&format!("input `{name}` is left out; it has to be of type ")),
            "{nothing}"
        );
    }
    for (name, _) in maps(renderer) {
        assert!(
            nothing.contains(&format!("resource `{name}` is left out; it has to be a texture of "))
        );
    }
    let vsgls = renderer.indirect().vsgls().unwrap();
    let (position, normal) = (renderer.inputs().gbuffer.position, &vsgls);
    inputs.set("eye", 1.0).set("origin", Input::U32(vec![1, 2, 3]));
    inputs.view("rsm_position", position).buffer("rsm_normal", normal);
    let wrong = executor.encode(&mut encoder, &inputs, None).unwrap_err().to_string();
    assert_eq!(
        wrong,
        "resource `rsm_normal` is a buffer; it has to be a texture of 48 x 48 texels, rgba16float\n\
         resource `rsm_position` is a texture of 40 x 24 texels; it has to be a texture of 48 x 48 texels, rgba32float\n\
         input `origin` is 3 numbers of type u32; it has to be of type vec3<f32>\n\
         input `eye` is 1 numbers of type f32; it has to be of type vec3<f32>"
    );
    let texture = gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 48, height: 48, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    inputs.texture("rsm_normal", &texture);
    let wrong = executor.encode(&mut encoder, &inputs, None).unwrap_err().to_string();
    let without = "resource `rsm_normal` is a texture without usage ";
    assert!(wrong.starts_with(without) && wrong.contains("TEXTURE_BINDING"), "{wrong}");
    // With everything as it should be the same executor goes on.
    embedded.run();
    assert!(embedded.lights() == lights(&embedded.renderer));
}

#[test]
fn lists_of_draws_that_are_left_out_are_named() {
    let Embedded { scene, settings, package, renderer, .. } = Embedded::new(base());
    let frame = frame(&package, &settings, &scene, None);
    let (gpu, package) = (gpu(), &package);
    let made = Executor::new(&gpu.device, &gpu.queue, package, &frame, &Lists::new());
    assert_eq!(
        made.err().unwrap().to_string(),
        "list of draws `surfaces` is left out; it has to be among the lists of the host"
    );
    let (surfaces, emitters) = (renderer.raster().surfaces(), renderer.raster().emitters());
    let lists: [(_, &dyn DrawList); 2] = [("surfaces", &surfaces), ("emitters", &emitters)];
    let lists = Lists::from(lists);
    let mut executor = Executor::new(&gpu.device, &gpu.queue, package, &frame, &lists).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut inputs = inputs(&renderer);
    sglow_renderer::host::camera(&mut inputs, renderer.view());
    let bias = renderer.shadow_bias();
    sglow_renderer::host::shadow(&mut inputs, bias.depth, &bias.faces);
    let left_out = executor.encode(&mut encoder, &inputs, None).unwrap_err().to_string();
    assert_eq!(
        left_out,
        "list of draws `surfaces` is left out; it has to be among the lists of the host"
    );
}

#[test]
fn stages_run_by_themselves() {
    let mut embedded = Embedded::new(base());
    embedded.run();
    let expected = embedded.lights();
    let Embedded { renderer, executor, .. } = &mut embedded;
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    encoder.clear_buffer(executor.buffer("vsgls").unwrap(), 0, None);
    // Mips read nothing of the host's, and samples what follows from the light alone.
    let nothing = Inputs::new();
    let mips = |stage: Stage<'_>| stage.label.starts_with("mip ");
    executor.encode_where(mips, &mut encoder, &nothing, None).unwrap();
    let sample = |stage: Stage<'_>| stage.label == "sample";
    let missing = executor.encode_where(sample, &mut encoder, &nothing, None).unwrap_err();
    assert!(missing.to_string().contains("minimum_variance"), "{missing}");
    let mut inputs = Inputs::new();
    renderer.light().give(&mut inputs);
    executor.encode_where(sample, &mut encoder, &inputs, None).unwrap();
    gpu().queue.submit([encoder.finish()]);
    gpu().finish().unwrap();
    assert!(embedded.lights() == expected);
}

#[test]
fn a_missing_variant_names_the_command_that_makes_it() {
    let Embedded { scene, settings, package, .. } = &Embedded::new(base());
    let another = Settings { variance: sglow_shaders::Variance::Planar, ..settings.clone() };
    let frame = frame(package, &another, scene, Some(&PARTS));
    let gpu = gpu();
    let missing = Executor::new(&gpu.device, &gpu.queue, package, &frame, &Lists::new());
    let text = missing.err().unwrap().to_string();
    assert!(
        text.contains("has no variant 'sample-warped-modified-bracketed-exact-planar-"),
        "{text}"
    );
    let command =
        "make it by: cargo xtask gen-shaders --out DIR --set draw=warped,kernel=modified,";
    assert!(text.contains(command), "{text}");
}

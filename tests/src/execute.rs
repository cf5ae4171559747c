//! Frames that are data, on a device: what a host gives, what it leaves out, and what is made when.
//!
//! That they show what frames of today show is held in `frames/executed.rs`.

mod foreign;

use std::collections::{BTreeMap, BTreeSet};

use sglow_graph::description::Number;
use sglow_graph::{Configuration, Frame};
use sglow_runtime::execute::{DrawList, Executor, Inputs, Lists};
use sglow_runtime::frame::Renderer;
use sglow_runtime::host;
use sglow_runtime::package::Package;
use sglow_runtime::points::Geometry;
use sglow_runtime::readback;
use sglow_runtime::scene::{Light, Scene};
use sglow_runtime::settings::{AXES, PARAMETERS, Settings};
use sglow_runtime::visibility::SUBSETS;
use sglow_shaders::Draw;
use wgpu::util::DeviceExt;

use crate::common::{gpu, library, package_of, packaged};

/// What settings and a scene are in the words of the description.
fn configuration(settings: &Settings, renderer: &Renderer<'_>, scene: &Scene) -> Configuration {
    let axes = AXES.iter().map(|axis| ((*axis).to_owned(), settings.value(axis).unwrap()));
    let mut axes: BTreeMap<_, _> = axes.collect();
    let mut parameters: BTreeMap<String, Number> = PARAMETERS
        .iter()
        .map(|(name, _)| {
            let text = settings.parameter(name).unwrap();
            let whole = text.parse().map(Number::Whole);
            let number = whole.unwrap_or_else(|_| Number::Real(text.parse().unwrap()));
            ((*name).to_owned(), number)
        })
        .collect();
    let occluders = Occluders::of(scene);
    for (name, number) in [
        ("width", settings.size[0] as usize),
        ("height", settings.size[1] as usize),
        ("occluder_vertex_count", occluders.positions.len()),
        ("occluder_index_count", occluders.indices.len()),
    ] {
        parameters.insert(name.to_owned(), Number::Whole(number as u64));
    }
    let (surfaces, emitters) = (renderer.raster().surfaces(), renderer.raster().emitters());
    let seen = settings.complete || !emitters.axes().is_empty();
    let emission = if seen { "seen" } else { "none" };
    axes.insert("emission".to_owned(), emission.to_owned());
    let draws = [("surfaces", surfaces.axes()), ("emitters", emitters.axes())];
    let draws = draws.into_iter().map(|(name, axes)| (name.to_owned(), axes)).collect();
    Configuration { axes, parameters, draws, ..Configuration::default() }
}

/// The triangles that occlude virtual lights.
struct Occluders {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl Occluders {
    fn of(scene: &Scene) -> Self {
        let (mut positions, mut indices) = (Vec::new(), Vec::new());
        for mesh in &scene.meshes {
            let first = positions.len() as u32;
            positions.extend_from_slice(&mesh.positions);
            indices.extend(mesh.indices.iter().map(|index| first + index));
        }
        Self { positions, indices }
    }

    /// Resources by name.
    fn upload(&self, settings: &Settings) -> Vec<(&'static str, wgpu::Buffer)> {
        let Self { positions, indices } = self;
        let make = |bytes: &[u8], usage| {
            gpu().device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: None,
                contents: bytes,
                usage,
            })
        };
        let points = Geometry { positions, indices }.points(settings.shadow_points, SUBSETS);
        let (vertex, index) = (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX);
        vec![
            ("occluder_positions", make(bytemuck::cast_slice(positions), vertex)),
            ("occluder_indices", make(bytemuck::cast_slice(indices), index)),
            ("points", make(bytemuck::cast_slice(&points), wgpu::BufferUsages::STORAGE)),
        ]
    }
}

fn frame(package: &Package, configuration: &Configuration) -> Frame {
    let description = package.description().unwrap();
    description.evaluate(configuration).unwrap_or_else(|errors| panic!("{errors}"))
}

fn base() -> Settings {
    Settings { size: [40, 24], rsm_size: 48, count: 60, camera_count: 70, ..Settings::default() }
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

/// What today's renderer and the executor are made of.
pub(crate) struct Subject {
    pub(crate) scene: Scene,
    pub(crate) settings: Settings,
    package: Package,
    occluders: Vec<(&'static str, wgpu::Buffer)>,
}

impl Subject {
    /// A scene of one light, whose kind the settings have, with what it runs.
    pub(crate) fn new(scene: Scene, settings: Settings, package: Package) -> Self {
        let occluders = Occluders::of(&scene).upload(&settings);
        Self { package, scene, settings, occluders }
    }

    pub(crate) fn renderer(&self) -> Renderer<'static> {
        Renderer::new(gpu(), &self.package, &self.scene, &self.settings, 0).unwrap()
    }

    pub(crate) fn frame(&self, renderer: &Renderer<'_>) -> Frame {
        frame(&self.package, &configuration(&self.settings, renderer, &self.scene))
    }

    pub(crate) fn executor(&self, renderer: &Renderer<'_>, frame: &Frame) -> Executor {
        let (surfaces, emitters) = (renderer.raster().surfaces(), renderer.raster().emitters());
        let lists: [(_, &dyn DrawList); 2] = [("surfaces", &surfaces), ("emitters", &emitters)];
        let (gpu, lists) = (gpu(), Lists::from(lists));
        Executor::new(&gpu.device, &gpu.queue, &self.package, frame, &lists).unwrap()
    }

    /// What the host gives for a frame of the renderer's, but for draws.
    pub(crate) fn inputs(&self, renderer: &Renderer<'_>) -> Inputs<'_> {
        let (bias, mut inputs) = (renderer.shadow_bias(), Inputs::new());
        host::light(&mut inputs, renderer.light());
        host::camera(&mut inputs, renderer.view());
        host::shadow(&mut inputs, bias.depth, bias.normal);
        inputs.set("diffuse_mean_length", self.settings.diffuse_mean_length());
        let bias = host::bias(self.settings.bias_scale, self.settings.light_tile);
        let least_near = host::least_near(self.scene.bounds().radius());
        host::light_maps(&mut inputs, least_near, bias);
        for (name, buffer) in &self.occluders {
            inputs.buffer(name, buffer);
        }
        inputs
    }
}

/// Submits what is encoded and waits for it.
pub(crate) fn submit(encode: impl FnOnce(&mut wgpu::CommandEncoder)) {
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    encode(&mut encoder);
    gpu().queue.submit([encoder.finish()]);
    gpu().finish().unwrap();
}

/// A small case with an executor that has its maps from the renderer: what an engine runs.
struct Embedded {
    subject: Subject,
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
    fn frame(subject: &Subject, renderer: &Renderer<'_>, settings: &Settings) -> Frame {
        let parts = Some(BTreeSet::from(["indirect".to_owned()]));
        let configuration = configuration(settings, renderer, &subject.scene);
        frame(&subject.package, &Configuration { parts, ..configuration })
    }

    fn new(settings: Settings) -> Self {
        let scene = Scene::builtin("cornell").unwrap();
        let light = sglow_runtime::frame::kind(&scene.lights[0]);
        let settings = Settings { light, ..settings };
        let surfaces = sglow_runtime::plan::Surfaces::of(&scene, false);
        let wanted = sglow_runtime::plan::Plan::new(&settings, &surfaces).variants;
        let subject = Subject::new(scene, settings, package_of(&wanted));
        let renderer = subject.renderer();
        renderer.render().unwrap();
        let frame = Self::frame(&subject, &renderer, &subject.settings);
        let (gpu, package) = (gpu(), &subject.package);
        let executor =
            Executor::new(&gpu.device, &gpu.queue, package, &frame, &Lists::new()).unwrap();
        Self { subject, renderer, executor }
    }

    fn run(&mut self) {
        let Self { subject, renderer, executor } = self;
        let mut inputs = subject.inputs(renderer);
        for (name, view) in maps(renderer) {
            inputs.view(name, view);
        }
        submit(|encoder| executor.encode(encoder, &inputs, None).unwrap());
    }

    fn lights(&self) -> Vec<u8> {
        buffer(self.executor.buffer("vsgls").unwrap())
    }
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
    let expected = buffer(embedded.renderer.indirect().vsgls());
    assert!(embedded.lights() == expected);
    let before = embedded.executor.made();
    embedded.run();
    assert_eq!(embedded.executor.made(), before);

    // Another renderer's maps, of another light: other views, so that what binds them is made anew, and no more.
    let mut other = embedded.subject.renderer();
    other.move_light(&moved(&embedded.subject.scene.lights[0], 1)).unwrap();
    other.render().unwrap();
    let first = std::mem::replace(&mut embedded.renderer, other);
    embedded.run();
    let expected_other = buffer(embedded.renderer.indirect().vsgls());
    assert!(embedded.lights() == expected_other && expected != expected_other);
    let after = embedded.executor.made();
    // moments and shade bind maps; density, mips and sample do not.
    assert_eq!((after.pipelines, after.groups), (before.pipelines, before.groups + 2));
    embedded.renderer = first;
    embedded.run();
    assert!(embedded.lights() == expected);
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
    let Embedded { subject, renderer, executor } = &mut embedded;
    let mut inputs = subject.inputs(renderer);
    for (name, view) in maps(renderer) {
        inputs.view(name, view);
    }
    submit(|encoder| {
        executor.encode(encoder, &inputs, None).unwrap();
        executor.encode(encoder, &inputs, None).unwrap();
    });
    assert!(second == embedded.lights());

    let pipelines = embedded.executor.made().pipelines;
    let Embedded { subject, renderer, executor } = &mut embedded;
    let fewer = Settings { count: 7, ..subject.settings.clone() };
    let frame = Embedded::frame(subject, renderer, &fewer);
    executor.resize(&subject.package, &frame, &Lists::new()).unwrap();
    embedded.run();
    assert_eq!(embedded.executor.made().pipelines, pipelines);
    assert!(embedded.lights().len() < first.len());
    let same = Embedded::new(Settings { draw, count: 7, ..base() });
    assert!(embedded.lights() == buffer(same.renderer.indirect().vsgls()));
}

#[test]
fn what_a_host_leaves_out_is_named_all_at_once() {
    let mut embedded = Embedded::new(base());
    let Embedded { subject, renderer, executor } = &mut embedded;
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    let nothing = executor.encode(&mut encoder, &Inputs::new(), None).unwrap_err().to_string();
    for name in ["light", "origin", "eye", "minimum_variance", "diffuse_mean_length"] {
        assert!(
            nothing.contains(&format!("input `{name}` is left out; it is of type ")),
            "{nothing}"
        );
    }
    for (name, _) in maps(renderer) {
        assert!(nothing.contains(&format!("resource `{name}` is left out; it is a texture of ")));
    }
    let mut inputs = subject.inputs(renderer);
    for (name, view) in maps(renderer) {
        inputs.view(name, view);
    }
    let (position, normal) = (renderer.inputs().gbuffer.position, &subject.occluders[0].1);
    inputs.set("eye", 1.0).set("origin", [1_u32, 2, 3]);
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
    assert!(embedded.lights() == buffer(embedded.renderer.indirect().vsgls()));
}

#[test]
fn lists_of_draws_that_are_left_out_are_named() {
    let mut embedded = Embedded::new(base());
    let Embedded { subject, renderer, .. } = &mut embedded;
    let frame = subject.frame(renderer);
    let (gpu, package) = (gpu(), &subject.package);
    let made = Executor::new(&gpu.device, &gpu.queue, package, &frame, &Lists::new());
    assert_eq!(made.err().unwrap().to_string(), "the list of draws `surfaces` is left out");
    let mut executor = subject.executor(renderer, &frame);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let inputs = subject.inputs(renderer);
    let left_out = executor.encode(&mut encoder, &inputs, None).unwrap_err().to_string();
    assert_eq!(left_out, "the list of draws `surfaces` is left out");
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
    executor.encode_where(|label| label.starts_with("mip "), &mut encoder, &nothing, None).unwrap();
    let sample = |label: &str| label == "sample";
    let missing = executor.encode_where(sample, &mut encoder, &nothing, None).unwrap_err();
    assert!(missing.to_string().contains("minimum_variance"), "{missing}");
    let mut inputs = Inputs::new();
    host::light(&mut inputs, renderer.light());
    executor.encode_where(sample, &mut encoder, &inputs, None).unwrap();
    gpu().queue.submit([encoder.finish()]);
    gpu().finish().unwrap();
    assert!(embedded.lights() == expected);
}

#[test]
fn a_missing_variant_names_the_command_that_makes_it() {
    let embedded = Embedded::new(base());
    let Embedded { subject, renderer, .. } = &embedded;
    let another = Settings { variance: sglow_shaders::Variance::Planar, ..base() };
    let frame = Embedded::frame(subject, renderer, &another);
    let (gpu, package) = (gpu(), &subject.package);
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

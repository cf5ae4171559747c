//! The frame as data against today's runtime: the same bits in every output.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;
use std::time::Duration;

use sglow_graph::description::{Axis, Number};
use sglow_graph::formula::evaluated;
use sglow_graph::{Configuration, Description, Frame};
use sglow_runtime::execute::{DrawList, Executor, Inputs, Lists};
use sglow_runtime::frame::{Pixels, Renderer};
use sglow_runtime::host;
use sglow_runtime::interface::Interface;
use sglow_runtime::package::Package;
use sglow_runtime::points::Geometry;
use sglow_runtime::readback;
use sglow_runtime::scene::{Light, Scene};
use sglow_runtime::settings::{AXES, PARAMETERS, Settings};
use sglow_runtime::timing::{Clock, Timer};
use sglow_runtime::visibility::SUBSETS;
use sglow_shader_gen::manifest;
use sglow_shaders::{
    Density, Diffuse, Draw, Emitter, Filter, Lobes, Precision, Sharpness, Solver, Space, Visibility,
};
use wgpu::util::DeviceExt;

use crate::common::{gpu, library};

/// The frame with the axes, passes and facts of the library.
fn description() -> &'static Description {
    static DESCRIPTION: OnceLock<Description> = OnceLock::new();
    DESCRIPTION.get_or_init(|| {
        let library = library();
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders/frame.toml");
        let text = std::fs::read_to_string(path).unwrap();
        let mut description: Description = toml::from_str(&text).unwrap();
        for (name, axis) in &library.axis {
            let values = axis.value.iter().map(|value| value.name.clone()).collect();
            let axis = Axis { default: axis.default.clone(), values };
            description.axes.insert(name.clone(), axis);
        }
        let passes = library.pass.iter().map(|pass| (pass.name.clone(), pass.axes.clone()));
        description.passes.extend(passes);
        description.facts.extend(library.fact.iter().map(|fact| fact.name.clone()));
        description
    })
}

/// Variants with what is known of their bindings.
fn package(wanted: &BTreeSet<String>) -> Package {
    let library = library();
    let mut variants = library.variants();
    variants.retain(|variant| wanted.contains(&variant.id()));
    let made = sglow_shader_gen::generate::variants(&library, &variants).unwrap();
    let interfaces: Vec<_> = made
        .iter()
        .map(|one| {
            let reflection = manifest::reflect(&one.text, &one.module, &one.info).unwrap();
            let described = manifest::variant(&library, one, &reflection, Vec::new());
            let value = serde_json::to_value(described).unwrap();
            (one.variant.id(), serde_json::from_value::<Interface>(value).unwrap())
        })
        .collect();
    let texts = made.into_iter().map(|one| (one.variant.id(), one.text));
    Package::generated("the variants of the frames", texts).with_interfaces(interfaces)
}

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
        ("occluder_positions", occluders.positions.len()),
        ("occluder_indices", occluders.indices.len()),
    ] {
        parameters.insert(name.to_owned(), Number::Whole(number as u64));
    }
    let (surfaces, emitters) = (renderer.raster().surfaces(), renderer.raster().emitters());
    let emission = if emitters.axes().is_empty() { "none" } else { "seen" };
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

fn frame(configuration: &Configuration) -> Frame {
    description().evaluate(configuration).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Settings that are run, with the name of the scene and the number of frames.
struct Case {
    name: &'static str,
    scene: &'static str,
    settings: Settings,
    frames: usize,
}

fn base() -> Settings {
    Settings { size: [40, 24], rsm_size: 48, count: 60, camera_count: 70, ..Settings::default() }
}

fn cases() -> Vec<Case> {
    let case = |name, settings| Case { name, scene: "cornell", settings, frames: 1 };
    let on = |scene, case: Case| Case { scene, ..case };
    let frames = |frames, case: Case| Case { frames, ..case };
    let (draw, density, precision) = (Draw::Metropolis, Density::Bidirectional, Precision::F16);
    let (shadow_map, imperfect) = (Visibility::ShadowMap, Visibility::Imperfect);
    let (world, image, solver) = (Space::World, Space::Image, Solver::Bisection);
    let odd = Settings { size: [37, 19], rsm_size: 33, ..base() };
    let maps = Settings { visibility: shadow_map, light_tile: 16, ..base() };
    let points = Settings { visibility: imperfect, shadow_points: 500, ..maps.clone() };
    let disc = Settings { emitter: Emitter::Disc, ..base() };
    vec![
        case("base", base()),
        case("f16", Settings { precision, ..base() }),
        case("f16 bidirectional", Settings { precision, density, ..base() }),
        case("diffuse", Settings { lobes: Lobes::Diffuse, precision, ..base() }),
        case("bidirectional", Settings { density, emitter: Emitter::Lobe, ..base() }),
        case("reflectance", Settings { density: Density::Reflectance, ..base() }),
        case("bisection", Settings { solver, iterations: 5, filter: Filter::Hardware, ..base() }),
        case("world", Settings { space: world, count: 37, ..disc.clone() }),
        case("f16 disc", Settings { precision, density, ..disc }),
        case("one cluster", Settings { space: image, count: 1, ..base() }),
        case("one light", Settings { count: 1, sharpness: Sharpness::Toksvig, ..base() }),
        frames(3, case("metropolis", Settings { draw, density, ..base() })),
        frames(3, case("metropolis world", Settings { draw, space: world, ..base() })),
        case("shadow map", maps.clone()),
        case("shadow map f16", Settings { precision, count: 33, ..maps.clone() }),
        case("imperfect", points.clone()),
        on("columns", case("columns", Settings { precision, ..maps.clone() })),
        frames(2, on("foliage", case("foliage", points))),
        frames(2, on("atrium", case("atrium", maps))),
        on("cornell-glossy", case("odd sizes", odd)),
        case("no diffuse", Settings { diffuse: Diffuse::None, ..base() }),
    ]
}

/// A light that moves and changes from frame to frame.
fn moved(light: &Light, frame: usize) -> Light {
    let mut light = light.clone();
    light.position[0] += 0.05 * frame as f32;
    light.intensity = light.intensity.map(|part| part * (1.0 + frame as f32));
    light
}

/// What one frame came to: bytes by name.
type Outputs = BTreeMap<&'static str, Vec<u8>>;

fn texture(texture: &wgpu::Texture) -> Vec<u8> {
    bytemuck::cast_slice(&readback::texture(gpu(), texture, 0).unwrap()).to_vec()
}

fn buffer(buffer: &wgpu::Buffer) -> Vec<u8> {
    readback::buffer(gpu(), buffer).unwrap()
}

fn expected(renderer: &Renderer<'_>) -> Outputs {
    let indirect = renderer.indirect();
    let pixels = |pixels: &Pixels| bytemuck::cast_slice(pixels).to_vec();
    let frame = renderer.read().unwrap();
    let rsm = renderer.read_rsm().unwrap();
    let mut outputs = Outputs::from([
        ("vsgls", buffer(indirect.vsgls())),
        ("density", texture(indirect.density())),
        ("rsm_position", pixels(&rsm.position)),
        ("rsm_normal", pixels(&rsm.normal)),
        ("rsm_base_color", pixels(&rsm.base_color)),
        ("gbuffer_position", pixels(&frame.gbuffer.position)),
        ("gbuffer_normal", pixels(&frame.gbuffer.normal)),
        ("gbuffer_base_color", pixels(&frame.gbuffer.base_color)),
        ("shadow_map", pixels(&renderer.read_shadow_map().unwrap())),
        ("direct", pixels(&frame.direct)),
        ("radiance", pixels(&frame.radiance)),
    ]);
    outputs.extend(indirect.metropolis().map(|chains| ("chains", buffer(chains.chains()))));
    outputs.extend(indirect.kernels().map(|kernels| ("kernels", buffer(kernels))));
    outputs.extend(indirect.camera_vsgls().map(|lights| ("camera_vsgls", buffer(lights))));
    outputs.extend(renderer.visibility().map(|maps| ("light_maps", texture(maps.atlas()))));
    let pictures = [
        ("diffuse", &frame.indirect_diffuse),
        ("specular", &frame.indirect_specular),
        ("emission", &frame.emission),
    ];
    for (name, picture) in pictures {
        outputs.extend(picture.as_ref().map(|picture| (name, pixels(picture))));
    }
    outputs
}

fn found(executor: &Executor, names: &Outputs) -> Outputs {
    let read = |name: &&'static str| {
        let bytes = executor.buffer(name).map(buffer);
        (*name, bytes.or_else(|| executor.texture(name).map(texture)).unwrap_or_default())
    };
    names.keys().map(read).collect()
}

/// What today's renderer and the executor are made of.
struct Subject {
    scene: Scene,
    settings: Settings,
    package: Package,
    occluders: Vec<(&'static str, wgpu::Buffer)>,
}

impl Subject {
    fn new(case: &Case) -> Self {
        let mut scene = Scene::builtin(case.scene).unwrap();
        scene.lights.truncate(1);
        let light = sglow_runtime::frame::kind(&scene.lights[0]);
        let settings = Settings { light, ..case.settings.clone() };
        let surfaces = sglow_runtime::plan::Surfaces::of(&scene, false);
        let wanted = sglow_runtime::plan::Plan::new(&settings, &surfaces).variants;
        let occluders = Occluders::of(&scene).upload(&settings);
        Self { package: package(&wanted), scene, settings, occluders }
    }

    fn renderer(&self) -> Renderer<'static> {
        Renderer::new(gpu(), &self.package, &self.scene, &self.settings, 0).unwrap()
    }

    fn frame(&self, renderer: &Renderer<'_>) -> Frame {
        frame(&configuration(&self.settings, renderer, &self.scene))
    }

    /// What the host gives for a frame of the renderer's.
    fn inputs(&self, renderer: &Renderer<'_>) -> Inputs<'_> {
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
fn submit(encode: impl FnOnce(&mut wgpu::CommandEncoder)) {
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    encode(&mut encoder);
    gpu().queue.submit([encoder.finish()]);
    gpu().finish().unwrap();
}

#[test]
fn frames_from_data_are_those_of_today() {
    let mut compared = BTreeMap::new();
    for case in cases() {
        let subject = Subject::new(&case);
        let mut renderer = subject.renderer();
        let frame = subject.frame(&renderer);
        let variants: BTreeSet<_> = frame.variants().into_iter().map(ToString::to_string).collect();
        let gpu = gpu();
        let mut executor = {
            let (surfaces, emitters) = (renderer.raster().surfaces(), renderer.raster().emitters());
            let lists: [(_, &dyn DrawList); 2] = [("surfaces", &surfaces), ("emitters", &emitters)];
            let lists = Lists::from(lists);
            Executor::new(&gpu.device, &gpu.queue, &subject.package, &frame, &lists).unwrap()
        };
        let mut made = None;
        for number in 0..case.frames {
            renderer.move_light(&moved(&subject.scene.lights[0], number)).unwrap();
            let times = renderer.render().unwrap();
            let (surfaces, emitters) = (renderer.raster().surfaces(), renderer.raster().emitters());
            let mut inputs = subject.inputs(&renderer);
            inputs.draws("surfaces", &surfaces).draws("emitters", &emitters);
            let mut timer = Timer::with(gpu, Clock::Wall);
            let formulas = evaluated();
            submit(|encoder| executor.encode(encoder, &inputs, Some(&mut timer)).unwrap());
            // What depends on the host's resources is bound in the first frame; then nothing is made any more.
            let now = executor.made();
            assert!(made.is_none_or(|made| made == now), "{}: {made:?}, {now:?}", case.name);
            assert_eq!(evaluated(), formulas, "{}", case.name);
            made = Some(now);

            let labels = |passes: Vec<(String, _)>| -> Vec<String> {
                passes.into_iter().map(|pass: (String, Duration)| pass.0).collect()
            };
            assert_eq!(labels(timer.finish().unwrap()), labels(times.passes), "{}", case.name);
            let expected = expected(&renderer);
            let found = found(&executor, &expected);
            for (name, expected) in &expected {
                let dark = expected.iter().all(|byte| *byte == 0);
                assert!(!dark || *name == "emission", "{}: {name} is empty", case.name);
                let same = found[name] == *expected;
                assert!(same, "{}: {name} of frame {number} differs", case.name);
                *compared.entry(*name).or_insert(0) += 1;
            }
        }
        // The frame runs what the renderer does.
        let planned = subject.package.asked();
        let levels = |id: &String| id.starts_with("mip-");
        assert!(variants.is_subset(&planned), "{}", case.name);
        assert!(planned.difference(&variants).all(levels), "{}", case.name);
    }
    println!("{compared:#?}");
}

//! The frame as data against today's runtime: the same bits in every output.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

use sglow_graph::description::{Axis, Number};
use sglow_graph::{Configuration, Description, Frame};
use sglow_runtime::execute::{Executor, Faults, Inputs, Lists};
use sglow_runtime::frame::Renderer;
use sglow_runtime::host;
use sglow_runtime::interface::Interface;
use sglow_runtime::package::Package;
use sglow_runtime::readback;
use sglow_runtime::scene::{Light, Scene};
use sglow_runtime::settings::{AXES, PARAMETERS, Settings};
use sglow_shader_gen::manifest;
use sglow_shaders::{Density, Draw, Emitter, Lobes, Precision, Sharpness, Space};

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

/// What settings are in the words of the description.
fn configuration(settings: &Settings, parts: &[&str]) -> Configuration {
    let axes = AXES.iter().map(|axis| ((*axis).to_owned(), settings.value(axis).unwrap()));
    let mut parameters: BTreeMap<String, Number> = PARAMETERS
        .iter()
        .map(|(name, _)| {
            let text = settings.parameter(name).unwrap();
            let whole = text.parse().map(Number::Whole);
            let number = whole.unwrap_or_else(|_| Number::Real(text.parse().unwrap()));
            ((*name).to_owned(), number)
        })
        .collect();
    for (name, side) in [("width", settings.size[0]), ("height", settings.size[1])] {
        parameters.insert(name.to_owned(), Number::Whole(side.into()));
    }
    Configuration {
        axes: axes.collect(),
        parameters,
        parts: Some(parts.iter().map(|part| (*part).to_owned()).collect()),
        ..Configuration::default()
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

/// Configurations without visibility.
fn cases() -> Vec<Case> {
    let case = |name, settings| Case { name, scene: "cornell", settings, frames: 1 };
    let (draw, density, precision) = (Draw::Metropolis, Density::Bidirectional, Precision::F16);
    vec![
        case("base", base()),
        case("f16", Settings { precision, ..base() }),
        case("f16 bidirectional", Settings { precision, density, ..base() }),
        case("diffuse", Settings { lobes: Lobes::Diffuse, precision, ..base() }),
        case("bidirectional", Settings { density, emitter: Emitter::Lobe, ..base() }),
        case("reflectance", Settings { density: Density::Reflectance, ..base() }),
        case(
            "world",
            Settings { space: Space::World, emitter: Emitter::Disc, count: 37, ..base() },
        ),
        case("one cluster", Settings { space: Space::Image, count: 1, ..base() }),
        case("one light", Settings { count: 1, sharpness: Sharpness::Toksvig, ..base() }),
        Case { frames: 3, ..case("metropolis", Settings { draw, density, ..base() }) },
        Case {
            frames: 3,
            ..case("metropolis world", Settings { draw, space: Space::World, ..base() })
        },
        Case { scene: "atrium", ..case("atrium", base()) },
        Case {
            scene: "cornell-glossy",
            ..case("odd sizes", Settings { size: [37, 19], rsm_size: 33, ..base() })
        },
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
    let mut outputs = Outputs::from([("vsgls", buffer(indirect.vsgls()))]);
    outputs.insert("density", texture(indirect.density()));
    outputs.extend(indirect.kernels().map(|kernels| ("kernels", buffer(kernels))));
    outputs.extend(indirect.diffuse().map(|picture| ("diffuse", texture(picture))));
    outputs.extend(indirect.specular().map(|picture| ("specular", texture(picture))));
    outputs
}

fn found(executor: &Executor, names: &Outputs) -> Outputs {
    let read = |name: &&'static str| {
        let bytes = executor.buffer(name).map(buffer);
        (*name, bytes.or_else(|| executor.texture(name).map(texture)).unwrap_or_default())
    };
    names.keys().map(read).collect()
}

/// Runs a case both ways; the outputs of each frame.
fn run(case: &Case) -> Vec<[Outputs; 2]> {
    let mut scene = Scene::builtin(case.scene).unwrap();
    let light = scene.lights[0].clone();
    let mut settings = case.settings.clone();
    settings.light = sglow_runtime::frame::kind(&light);
    let evaluated = frame(&configuration(&settings, &["indirect"]));
    let surfaces = sglow_runtime::plan::Surfaces::of(&scene, false);
    let mut wanted = sglow_runtime::plan::Plan::new(&settings, &surfaces).variants;
    wanted.extend(evaluated.variants().into_iter().map(ToString::to_string));
    let package = package(&wanted);
    scene.lights.truncate(1);
    let mut renderer = Renderer::new(gpu(), &package, &scene, &settings, 0).unwrap();
    let gpu = gpu();
    let mut executor =
        Executor::new(&gpu.device, &gpu.queue, &package, &evaluated, &Lists::new()).unwrap();
    let mut outputs = Vec::new();
    let mut made = None;
    for number in 0..case.frames {
        renderer.move_light(&moved(&light, number)).unwrap();
        renderer.render().unwrap();
        let mut inputs = Inputs::new();
        let given = renderer.inputs();
        host::light(&mut inputs, given.light);
        host::eye_at(&mut inputs, given.eye);
        inputs.set("diffuse_mean_length", settings.diffuse_mean_length());
        for (name, view) in [
            ("rsm_position", given.rsm.position),
            ("rsm_normal", given.rsm.normal),
            ("rsm_base_color", given.rsm.base_color),
            ("gbuffer_position", given.gbuffer.position),
            ("gbuffer_normal", given.gbuffer.normal),
            ("gbuffer_base_color", given.gbuffer.base_color),
        ] {
            inputs.view(name, view);
        }
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        executor.encode(&mut encoder, &inputs, None).unwrap();
        gpu.queue.submit([encoder.finish()]);
        gpu.finish().unwrap();
        // What depends on the host's textures is bound in the first frame; after that nothing is made any more.
        let now = executor.made();
        assert!(made.is_none_or(|made| made == now), "{}: {made:?}, {now:?}", case.name);
        made = Some(now);
        let expected = expected(&renderer);
        outputs.push([found(&executor, &expected), expected]);
    }
    outputs
}

#[test]
fn frames_from_data_are_those_of_today() {
    for case in cases() {
        for (number, [found, expected]) in run(&case).iter().enumerate() {
            for (name, expected) in expected {
                let found = &found[name];
                assert!(expected.iter().any(|byte| *byte != 0), "{}: {name} is empty", case.name);
                assert!(found == expected, "{}: {name} of frame {number}", case.name);
            }
            println!("{}: {:?} of frame {number}", case.name, expected.keys());
        }
    }
}

fn fault(result: Result<(), Faults>) -> String {
    result.unwrap_err().to_string()
}

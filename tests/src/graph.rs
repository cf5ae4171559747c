//! The frame as data is the frame that the runtime plans: the same variants, and the same bytes by name.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use sglow_graph::description::Number;
use sglow_graph::frame::{Frame, Kind};
use sglow_graph::{Configuration, Description, Problem};
use sglow_runtime::plan::{Part, Plan, Surfaces};
use sglow_runtime::scene::Scene;
use sglow_runtime::settings::{AXES, PARAMETERS, Settings};
use sglow_shader_gen::library::Library;
use sglow_shader_gen::validate::Validated;
use sglow_shader_gen::{frame, manifest};

use sglow_oracle::fis::stress::Random;

use crate::common::library;

fn description(library: &Library) -> Description {
    library.frame().unwrap().description.clone()
}

/// The kinds of materials of a scene, and those of them that emit, as the axes of the host's draws.
type Kinds = BTreeMap<(bool, bool), bool>;

fn kinds(scene: &Scene, complete: bool) -> Kinds {
    let mut kinds = BTreeMap::new();
    let traits = scene.traits();
    for mesh in &scene.meshes {
        let one = &traits[mesh.material];
        let kind = (one.textured || complete, one.cutout || complete);
        *kinds.entry(kind).or_insert(complete) |= one.emits;
    }
    kinds
}

fn configuration(settings: &Settings, scene: &Scene) -> Configuration {
    let axes = AXES.map(|axis| (axis.to_owned(), settings.value(axis).unwrap()));
    let mut axes: BTreeMap<_, _> = axes.into();
    let number = |name: &str| {
        let text = settings.parameter(name).unwrap();
        text.parse().map_or_else(|_| Number::Real(text.parse().unwrap()), Number::Whole)
    };
    let mut parameters: BTreeMap<_, _> =
        PARAMETERS.iter().map(|(name, _)| ((*name).to_owned(), number(name))).collect();
    let [width, height] = settings.size.map(|side| Number::Whole(side.into()));
    let sum = |of: fn(&sglow_runtime::scene::Mesh) -> usize| {
        Number::Whole(scene.meshes.iter().map(of).sum::<usize>() as u64)
    };
    parameters.extend([
        ("width".to_owned(), width),
        ("height".to_owned(), height),
        ("occluder_vertex_count".to_owned(), sum(|mesh| mesh.positions.len())),
        ("occluder_index_count".to_owned(), sum(|mesh| mesh.indices.len())),
    ]);
    let kinds = kinds(scene, settings.complete);
    let emits = kinds.values().any(|&emits| emits);
    axes.insert("emission".to_owned(), if emits { "seen" } else { "none" }.to_owned());
    let draws = |only_emitters: bool| -> BTreeSet<BTreeMap<String, String>> {
        let drawn = kinds.iter().filter(|(_, emits)| **emits || !only_emitters);
        let values = drawn.map(|((textured, cutout), _)| {
            let material = if *textured { "textured" } else { "constant" };
            let opacity = if *cutout { "cutout" } else { "opaque" };
            [("material", material), ("opacity", opacity)]
                .map(|(axis, value)| (axis.to_owned(), value.to_owned()))
                .into()
        });
        values.collect()
    };
    Configuration {
        axes,
        parameters,
        draws: [("surfaces".to_owned(), draws(false)), ("emitters".to_owned(), draws(true))].into(),
        ..Configuration::default()
    }
}

/// What the plan calls a resource.
fn planned(name: &str, kind: &Kind) -> Option<&'static str> {
    let texture = match kind {
        Kind::Texture { .. } => true,
        Kind::Buffer { .. } => false,
        Kind::Sampler { .. } => return None,
    };
    let name = name.trim_end_matches(".0").trim_end_matches(".1");
    Some(match name {
        _ if name.starts_with("rsm_") => "reflective shadow map",
        _ if name.starts_with("gbuffer_") => "G-buffer",
        _ if name.starts_with("camera_") && texture => "camera textures",
        _ if name.starts_with("camera_") => "camera buffers",
        _ if name.starts_with("codes_") => "cluster tree",
        _ if name.starts_with("texels_") => "sorted texels",
        "shadow_map" => "shadow map",
        "moments" => "moments",
        "half_moments" => "half moments",
        "own_weights" => "weights",
        "density" => "density",
        "vsgls" => "vsgls",
        "kernels" => "kernels",
        "chains" => "chains",
        "centres" | "centres_box" => "centres",
        "children" | "parents" | "leaves" | "boxes" => "cluster tree",
        "starts" => "sorted texels",
        "diffuse" => "diffuse",
        "specular" => "specular",
        "light_maps" => "light maps",
        "occluder_positions" | "occluder_indices" => "light occluders",
        "points" => "shadow points",
        "splats" => "light splats",
        "direct" => "direct",
        "emission" => "emission",
        "radiance" => "radiance",
        _ => panic!("{name} is in no plan"),
    })
}

/// Bytes by part of the frame and name in the plan.
fn bytes(frame: &Frame) -> BTreeMap<(String, &'static str), u64> {
    let mut bytes = BTreeMap::new();
    for resource in &frame.resources {
        if let Some(name) = planned(&resource.name, &resource.kind) {
            *bytes.entry((resource.part.clone(), name)).or_insert(0) += resource.bytes;
        }
    }
    bytes
}

/// The variants of a frame. A plan has those of mip chains of any size: of each format that has a mip level, all.
fn variants(frame: &Frame) -> BTreeSet<String> {
    let mut variants: BTreeSet<_> = frame.variants().iter().map(ToString::to_string).collect();
    for variant in frame.variants() {
        if variant.pass == "mip" {
            let texel = &variant.axes[0].1;
            variants.extend(["one", "two", "three"].map(|levels| format!("mip-{texel}-{levels}")));
        }
    }
    variants
}

/// What differs between the frame as data and the plan.
fn difference(
    description: &Description,
    settings: &Settings,
    scene: &Scene,
    planned: &Settings,
) -> Option<String> {
    let frame = match description.evaluate(&configuration(settings, scene)) {
        Ok(frame) => frame,
        Err(errors) => return Some(errors.to_string()),
    };
    let plan = Plan::new(planned, &Surfaces::of(scene, planned.complete));
    let part = |part: Part| format!("{part:?}").to_lowercase();
    let known = plan.resources.iter().map(|of| ((part(of.part), of.name), of.bytes));
    let known: BTreeMap<_, _> = known.collect();
    let (found, kept) = (variants(&frame), bytes(&frame));
    if found != plan.variants {
        let [more, fewer] = [&found - &plan.variants, &plan.variants - &found];
        return Some(format!("in the frame alone: {more:?}; in the plan alone: {fewer:?}"));
    }
    (kept != known).then(|| format!("the frame keeps {kept:?}, the plan {known:?}"))
}

/// Legal settings with a random value on each axis that a renderer takes, and odd numbers.
fn random(library: &Library, random: &mut Random) -> Settings {
    let description = description(library);
    let mut pick = |count: usize| ((random.uniform() * count as f64) as usize).min(count - 1);
    loop {
        let mut settings = Settings { complete: pick(8) == 0, ..Settings::default() };
        for axis in AXES {
            let values = &library.axis[axis].value;
            settings.set(axis, &values[pick(values.len())].name).unwrap();
        }
        let numbers = [1, 2, 3, 7, 20, 33, 64, 100, 257, 1100, 4097];
        settings.size = [numbers[pick(9)] as u32 + 2, numbers[pick(9)] as u32 + 2];
        for name in ["lights", "camera_lights", "shadow_points"] {
            settings.set(name, &numbers[pick(numbers.len())].to_string()).unwrap();
        }
        settings.set("map", &(4 * numbers[pick(8)]).to_string()).unwrap();
        settings.set("tile", ["8", "16", "64"][pick(3)]).unwrap();
        let illegal = |errors: &sglow_graph::Errors| {
            errors.0.iter().any(|error| matches!(error.problem, Problem::Requirement(_)))
        };
        if !description.evaluate(&settings.configuration()).is_err_and(|errors| illegal(&errors)) {
            return settings;
        }
    }
}

#[test]
fn a_frame_is_what_is_planned() {
    let library = library();
    let description = description(&library);
    let scenes = ["cornell", "atrium:15k"].map(|name| Scene::builtin(name).unwrap());
    let mut numbers = Random::new(13);
    for index in 0..2000 {
        let (settings, scene) = (random(&library, &mut numbers), &scenes[index % 2]);
        let found = difference(&description, &settings, scene, &settings);
        assert_eq!(found, None, "{settings:?}");
    }
}

#[test]
fn another_frame_is_noticed() {
    let (description, settings) = (description(&library()), Settings::default());
    let scene = Scene::builtin("cornell").unwrap();
    for (name, value) in [("lobes", "diffuse"), ("map", "33"), ("visibility", "imperfect")] {
        let mut other = settings.clone();
        other.set(name, value).unwrap();
        assert!(difference(&description, &settings, &scene, &other).is_some(), "{name}");
    }
}

#[test]
fn the_frame_fits_what_its_variants_bind() {
    let library = library();
    let described = library.frame().unwrap();
    let configurations = described.configurations(3);
    assert!(configurations.len() > 100, "{}", configurations.len());
    let mut runs = BTreeSet::new();
    for configuration in &configurations {
        let frame = described.description.evaluate(configuration);
        runs.extend(frame.iter().flat_map(variants));
    }
    let legal: Vec<_> =
        library.variants().into_iter().filter(|variant| runs.contains(&variant.id())).collect();
    let validated = sglow_shader_gen::generate::variants(&library, &legal).unwrap();
    let reflected = |one: &Validated| {
        let reflection = manifest::reflect(&one.text, &one.module, &one.info).unwrap();
        manifest::variant(&library, one, &reflection, Vec::new())
    };
    let variants: Vec<_> = validated.iter().map(reflected).collect();
    if let Err(report) = frame::check(&library, &variants) {
        panic!("{}", report.render(false));
    }
}

/// What the evaluator of another language says of frames: whether it agrees, and its words. Nothing if the language is
/// not installed.
fn compared(graph: &serde_json::Value, cases: &[serde_json::Value]) -> Option<(bool, String)> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cases.json");
    let document = serde_json::json!({ "graph": graph, "cases": cases });
    std::fs::write(&file, document.to_string()).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/hosts/agree.py");
    let output = Command::new("python3").arg("-B").arg(script).arg(&file).output().ok()?;
    let text = [output.stdout, output.stderr].concat();
    Some((output.status.success(), String::from_utf8_lossy(&text).into_owned()))
}

#[test]
fn another_evaluator_says_the_same() {
    let library = library();
    let description = description(&library);
    let scene = Scene::builtin("cornell").unwrap();
    let mut numbers = Random::new(29);
    let cases: Vec<_> = (0..100)
        .map(|_| {
            let configuration = configuration(&random(&library, &mut numbers), &scene);
            let frame = description.evaluate(&configuration).unwrap();
            serde_json::json!({ "configuration": configuration, "frame": frame })
        })
        .collect();
    let graph = frame::json(&description);
    let Some((agrees, text)) = compared(&graph, &cases) else {
        return eprintln!("python3 is not installed: its evaluator is not compared");
    };
    assert!(agrees, "{text}");
    let mut other = graph;
    *other.pointer_mut("/template/chain/let/moment_layers/tree").unwrap() = 4.into();
    assert!(!compared(&other, &cases).unwrap().0, "another description is noticed");
}

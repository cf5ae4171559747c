//! The library's frame: it fits what its variants bind, and evaluators of other languages say the same of it.

use std::collections::BTreeSet;
use std::process::Command;

use sglow_graph::{Configuration, Description, Errors, Frame};
use sglow_renderer::plan::Surfaces;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::validate::Validated;
use sglow_shader_gen::{frame, manifest};

use sglow_oracle::fis::stress::Random;

use crate::common::library;

fn description(library: &Library) -> Description {
    library.frame().unwrap().description.clone()
}

fn configuration(settings: &Settings, scene: &Scene) -> Configuration {
    let mut configuration = settings.configuration();
    Surfaces::of(scene, settings.complete).describe(&mut configuration);
    configuration
}

/// Legal settings with a random value on each axis that a renderer takes, and odd numbers.
fn random(library: &Library, random: &mut Random) -> Settings {
    let description = description(library);
    let mut pick = |count: usize| ((random.uniform() * count as f64) as usize).min(count - 1);
    loop {
        let mut settings = Settings { complete: pick(8) == 0, ..Settings::default() };
        for axis in Settings::AXES.iter().copied() {
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
        let evaluated = description.evaluate(&settings.configuration());
        if !evaluated.as_ref().is_err_and(Errors::is_illegal) {
            return settings;
        }
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
        let ids = |frame: &Frame| -> Vec<_> {
            frame.variants().into_iter().map(|variant| variant.id.clone()).collect()
        };
        runs.extend(frame.iter().flat_map(ids));
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
    *other.pointer_mut("/let/chain_moment_layers").unwrap() = 4.into();
    assert!(!compared(&other, &cases).unwrap().0, "another description is noticed");
}

//! The library's own frame: what it comes to in some configurations.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use sglow_graph::description::{Axis, Number};
use sglow_graph::{Configuration, Description, Frame};

/// What of `library.toml` a description needs.
#[derive(Deserialize)]
struct Library {
    axis: BTreeMap<String, LibraryAxis>,
    pass: Vec<Pass>,
    fact: Vec<Named>,
}
#[derive(Deserialize)]
struct LibraryAxis {
    default: String,
    value: Vec<Named>,
}
#[derive(Deserialize)]
struct Named {
    name: String,
}
#[derive(Deserialize)]
struct Pass {
    name: String,
    #[serde(default)]
    axes: Vec<String>,
}

fn description() -> Description {
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let read = |name: &str| std::fs::read_to_string(shaders.join(name)).unwrap();
    let library: Library = toml::from_str(&read("library.toml")).unwrap();
    let mut description: Description = toml::from_str(&read("frame.toml")).unwrap();
    for (name, LibraryAxis { default, value }) in library.axis {
        let values = value.into_iter().map(|value| value.name).collect();
        description.axes.insert(name, Axis { default, values });
    }
    let passes = library.pass.into_iter().map(|pass| (pass.name, pass.axes));
    description.passes.extend(passes);
    description.facts.extend(library.fact.into_iter().map(|fact| fact.name));
    description
}

fn configuration(axes: &[(&str, &str)], parameters: &[(&str, u64)]) -> Configuration {
    let text = |text: &&str| (*text).to_owned();
    Configuration {
        axes: axes.iter().map(|(axis, value)| (text(axis), text(value))).collect(),
        parameters: parameters.iter().map(|(name, n)| (text(name), Number::Whole(*n))).collect(),
        ..Configuration::default()
    }
}

fn frame(axes: &[(&str, &str)], parameters: &[(&str, u64)]) -> Frame {
    match description().evaluate(&configuration(axes, parameters)) {
        Ok(frame) => frame,
        Err(errors) => panic!("{errors}"),
    }
}

#[test]
fn the_default_is_a_frame() {
    let frame = frame(&[], &[]);
    assert!(frame.steps.iter().any(|step| step.label == "shade"));
}

//! Prints the library's frame as the JSON that a package's manifest holds under `graph`.
//!
//! `cargo run -p sglow-graph --example dump > graph.json`

use std::collections::BTreeMap;
use std::error::Error;
use std::io::Write as _;
use std::path::Path;

use serde::Deserialize;
use sglow_graph::Description;
use sglow_graph::description::Axis;

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

fn main() -> Result<(), Box<dyn Error>> {
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let read = |name: &str| std::fs::read_to_string(shaders.join(name));
    let library: Library = toml::from_str(&read("library.toml")?)?;
    let mut description: Description = toml::from_str(&read("frame.toml")?)?;
    for (name, LibraryAxis { default, value }) in library.axis {
        let values = value.into_iter().map(|value| value.name).collect();
        description.axes.insert(name, Axis { default, values });
    }
    description.passes.extend(library.pass.into_iter().map(|pass| (pass.name, pass.axes)));
    description.facts.extend(library.fact.into_iter().map(|fact| fact.name));
    let text = serde_json::to_string(&description)?;
    writeln!(std::io::stdout().lock(), "{text}")?;
    Ok(())
}

//! The runtime stays thin: how long it is, what it depends on, and that no name of light is spelt in it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use sglow_runtime::settings::Settings;

use crate::common::library;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Files of Rust below a folder, with their texts.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|end| end == "rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            found.push((path, text));
        }
    }
    found
}

#[test]
fn the_runtime_and_the_graph_are_small() {
    let lines = |name: &str| {
        let texts = sources(&root().join(name).join("src"));
        texts.iter().map(|(_, text)| text.lines().count()).sum::<usize>()
    };
    let (runtime, graph) = (lines("runtime"), lines("graph"));
    println!("runtime: {runtime} lines, graph: {graph} lines");
    assert!(runtime > 1000 && runtime <= 4200, "{runtime}");
    assert!(graph > 1000 && graph <= 1500, "{graph}");
}

#[test]
fn hosts_in_other_languages_are_small() {
    let lines = |language: &str, ending: &str| {
        let of = |file: &str| {
            let path = root().join("tests/hosts").join(language).join(format!("{file}.{ending}"));
            std::fs::read_to_string(path).unwrap().lines().count()
        };
        of("graph") + of("host")
    };
    let (python, javascript) = (lines("python", "py"), lines("javascript", "mjs"));
    println!("hosts: {python} lines of Python, {javascript} of JavaScript");
    assert!(python > 200 && python <= 300, "{python}");
    assert!(javascript > 200 && javascript <= 300, "{javascript}");
}

#[test]
fn the_committed_manifest_is_small() {
    let bytes = sglow_shaders::MANIFEST.len();
    println!("manifest.json: {bytes} bytes");
    assert!(bytes > 100_000 && bytes <= 800_000, "{bytes}");
}

#[test]
fn an_engine_compiles_few_crates() {
    let crates = |package: &str| {
        let arguments =
            ["tree", "--package", package, "--edges", "normal", "--prefix", "none", "--offline"];
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let output = Command::new(cargo).args(arguments).current_dir(root()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        let names = text.lines().map(|line| line.trim_end_matches(" (*)").to_owned());
        names.collect::<BTreeSet<_>>()
    };
    let runtime = crates("sglow-runtime");
    assert!(runtime.len() > 10 && runtime.len() <= 80, "{}: {runtime:#?}", runtime.len());
    for heavy in ["gltf", "image", "toml", "tobj", "schemars", "naga_oil"] {
        let is_heavy = |line: &String| line.starts_with(&format!("{heavy} "));
        assert!(!runtime.iter().any(is_heavy), "{heavy}");
    }
    // Negative control: who renders scenes compiles more.
    assert!(crates("sglow-renderer").len() > runtime.len() + 10);
}

/// String literals of a text, comments left out.
fn literals(text: &str) -> BTreeSet<&str> {
    let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    code.flat_map(|line| line.split('"').skip(1).step_by(2)).collect()
}

#[test]
fn no_pass_axis_or_resource_is_named_in_the_runtime() {
    let library = library();
    let mut names: BTreeSet<String> = library.pass.iter().map(|pass| pass.name.clone()).collect();
    names.extend(library.axis.keys().cloned());
    let description = &library.frame().unwrap().description;
    let frame = description.evaluate(&Settings::default().configuration()).unwrap();
    names.extend(frame.resources.into_iter().map(|resource| resource.name));
    names.extend(description.resource.keys().cloned());
    let spelt = |folder: &str| -> BTreeSet<String> {
        let texts = sources(&root().join(folder));
        let found = texts.iter().flat_map(|(_, text)| literals(text));
        found.filter(|literal| names.contains(*literal)).map(str::to_owned).collect()
    };
    // A member of the light's uniform is called so, too.
    let allowed = BTreeSet::from(["position".to_owned()]);
    assert_eq!(&spelt("runtime/src") - &allowed, BTreeSet::new());
    // Negative control: what measures stages one by one spells many.
    assert!(spelt("renderer/src").len() > 10);
}

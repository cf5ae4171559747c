//! What sglow is built from: licences, the minimum version of Rust, where crates come from.

use std::path::Path;
use std::process::Command;

use cargo_metadata::{CargoOpt, Metadata, MetadataCommand};
use spdx::{Expression, ParseMode};

fn root() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every crate that is built on this machine, features included.
fn metadata() -> Metadata {
    let rustc = Command::new("rustc").arg("-vV").output().unwrap();
    let text = String::from_utf8(rustc.stdout).unwrap();
    let host = text.lines().find_map(|line| line.strip_prefix("host: ")).unwrap();
    let mut command = MetadataCommand::new();
    command.manifest_path(root().join("Cargo.toml")).features(CargoOpt::AllFeatures);
    let options = ["--offline", "--filter-platform", host].map(str::to_owned);
    command.other_options(options.to_vec()).exec().unwrap()
}

/// Whether a licence is one that `deny.toml` allows.
fn allowed(expression: &str, allow: &[&str]) -> bool {
    let expression = Expression::parse_mode(expression, ParseMode::LAX).unwrap();
    expression.evaluate(|wanted| wanted.license.id().is_some_and(|id| allow.contains(&id.name)))
}

#[test]
fn licences_are_those_that_are_allowed() {
    let text = std::fs::read_to_string(root().join("deny.toml")).unwrap();
    let deny = text.parse::<toml::Table>().unwrap();
    let allow = deny["licenses"]["allow"].as_array().unwrap();
    let allow = allow.iter().map(|one| one.as_str().unwrap()).collect::<Vec<_>>();

    let packages = metadata().packages;
    assert!(packages.len() > 100, "{}", packages.len());
    for package in &packages {
        let license = package.license.as_deref();
        let license = license.unwrap_or_else(|| panic!("{} names no licence", package.name));
        assert!(allowed(license, &allow), "{}: {license}", package.name);
    }
    // Negative controls.
    assert!(!allowed("GPL-3.0-only", &allow));
    assert!(!allowed("MIT AND GPL-3.0-only", &allow));
    assert!(allowed("MIT OR GPL-3.0-only", &allow));
}

#[test]
fn no_crate_needs_a_newer_rust_than_is_stated() {
    let metadata = metadata();
    let stated = metadata.workspace_packages()[0].rust_version.clone().unwrap();
    for package in &metadata.packages {
        if let Some(needs) = &package.rust_version {
            assert!(*needs <= stated, "{} needs Rust {needs}, {stated} is stated", package.name);
        }
        let ours = metadata.workspace_members.contains(&package.id);
        assert!(!ours || package.rust_version.as_ref() == Some(&stated), "{}", package.name);
    }
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let text = format!("Rust {}.{}", stated.major, stated.minor);
    assert!(readme.contains(&text), "README.md does not state {text}");
}

#[test]
fn crates_come_from_one_registry() {
    for package in metadata().packages {
        let source = package.source.map(|source| source.repr);
        let registry = "registry+https://github.com/rust-lang/crates.io-index";
        assert!(source.is_none_or(|source| source == registry), "{}", package.name);
    }
}

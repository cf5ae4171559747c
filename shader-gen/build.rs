//! A fingerprint of the generator, and the version of naga that it is built with.
//!
//! With both, "nothing has changed" is seen without generating anything.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

use sha2::{Digest, Sha256};

/// The crates whose version shows in the bytes of a package.
const PRINTERS: [&str; 8] =
    ["naga", "prettyplease", "proc-macro2", "quote", "rspirv", "schemars", "serde_json", "syn"];

fn main() -> io::Result<()> {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let source = root.join("src");
    let mut digest = Sha256::new();
    let mut files = Vec::new();
    collect(&source, &mut files)?;
    files.sort();
    for file in files {
        let path = file.strip_prefix(&source).unwrap_or(&file);
        digest.update(path.to_string_lossy().replace('\\', "/"));
        digest.update([0]);
        digest.update(fs::read(&file)?);
        digest.update([0]);
    }
    let lock = root.join("../Cargo.lock");
    let versions = versions(&fs::read_to_string(&lock).unwrap_or_default());
    for (name, version) in &versions {
        digest.update(format!("{name} {version}\n"));
    }
    let fingerprint = base16ct::lower::encode_string(&digest.finalize());
    let naga = versions.get("naga").map_or("unknown", String::as_str);
    println!("cargo::rustc-env=SGLOW_GENERATOR_FINGERPRINT={fingerprint}");
    println!("cargo::rustc-env=SGLOW_NAGA_VERSION={naga}");
    println!("cargo::rerun-if-changed={}", source.display());
    println!("cargo::rerun-if-changed={}", lock.display());
    println!("cargo::rerun-if-changed=build.rs");
    Ok(())
}

fn collect(folder: &Path, into: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, into)?;
        } else {
            into.push(path);
        }
    }
    Ok(())
}

/// The versions of [`PRINTERS`] in a lock file.
fn versions(lock: &str) -> BTreeMap<String, String> {
    let quoted = |line: &str, key: &str| {
        let value = line.strip_prefix(key)?.strip_prefix(" = \"")?.strip_suffix('"')?;
        Some(value.to_owned())
    };
    let mut versions = BTreeMap::new();
    let mut name = None;
    for line in lock.lines() {
        if let Some(found) = quoted(line, "name") {
            name = Some(found);
        } else if let Some(version) = quoted(line, "version")
            && let Some(name) = name.take()
            && PRINTERS.contains(&name.as_str())
        {
            versions.insert(name, version);
        }
    }
    versions
}

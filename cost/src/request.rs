//! What is to be compiled: the compute modules of a package.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::cost::Skipped;
use crate::error::Error;

/// What to compile, and for which GPUs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// The folder of the package, with its `manifest.json`.
    pub package: PathBuf,
    /// The family of GPUs, as `RADV_FORCE_FAMILY` takes it: `navi21`, `vega10`.
    pub family: String,
    /// Identifiers of the variants; empty for all.
    pub only: Vec<String>,
}

/// A compute entry point to compile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Subject {
    pub(crate) id: String,
    pub(crate) entry_point: String,
    pub(crate) path: PathBuf,
}

/// What a package has for a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Subjects {
    pub(crate) compute: Vec<Subject>,
    pub(crate) skipped: Vec<Skipped>,
}

#[derive(Deserialize)]
struct Manifest {
    shared: Shared,
    variants: Vec<Variant>,
}

#[derive(Deserialize)]
struct Shared {
    entry_points: BTreeMap<String, EntryPoint>,
}

#[derive(Deserialize)]
struct EntryPoint {
    name: String,
    stage: String,
}

#[derive(Deserialize)]
struct Variant {
    id: String,
    entry_points: Vec<String>,
    files: Vec<Output>,
}

#[derive(Deserialize)]
struct Output {
    target: String,
    path: String,
}

/// Reads the manifest; modules are read later, one at a time.
pub(crate) fn subjects(request: &Request) -> Result<Subjects, Error> {
    let path = request.package.join("manifest.json");
    let text = fs::read(&path).map_err(|source| Error::Read { path: path.clone(), source })?;
    let manifest: Manifest = serde_json::from_slice(&text)
        .map_err(|source| Error::Manifest { path: path.clone(), source })?;
    let known: BTreeSet<&str> = manifest.variants.iter().map(|variant| &*variant.id).collect();
    if let Some(id) = request.only.iter().find(|id| !known.contains(id.as_str())) {
        return Err(Error::Variant { id: id.clone(), path });
    }
    if !manifest.variants.iter().flat_map(|variant| &variant.files).any(|f| f.target == "spirv") {
        return Err(Error::NoSpirv { path });
    }
    let only: BTreeSet<&str> = request.only.iter().map(String::as_str).collect();
    let mut subjects = Subjects { compute: Vec::new(), skipped: Vec::new() };
    for variant in &manifest.variants {
        if only.is_empty() || only.contains(variant.id.as_str()) {
            add(&mut subjects, variant, &manifest.shared, &request.package)?;
        }
    }
    Ok(subjects)
}

fn add(to: &mut Subjects, variant: &Variant, shared: &Shared, folder: &Path) -> Result<(), Error> {
    let id = &variant.id;
    let mut skip = |why: String| to.skipped.push(Skipped { id: id.clone(), why });
    let Some(file) = variant.files.iter().find(|file| file.target == "spirv") else {
        skip("no file for `spirv`".to_owned());
        return Ok(());
    };
    if !Path::new(&file.path).components().all(|part| matches!(part, Component::Normal(_))) {
        return Err(Error::Outside { id: id.clone(), path: file.path.clone() });
    }
    for key in &variant.entry_points {
        let Some(point) = shared.entry_points.get(key) else {
            return Err(Error::EntryPoint { id: id.clone(), key: key.clone() });
        };
        if point.stage == "compute" {
            to.compute.push(Subject {
                id: id.clone(),
                entry_point: point.name.clone(),
                path: folder.join(&file.path),
            });
        } else {
            // A vertex or fragment stage alone has no cost: it needs formats that only a host knows.
            skip(format!("`{}` is a {} entry point; only compute is", point.name, point.stage));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shared() -> Shared {
        serde_json::from_str(
            r#"{"entry_points": {
                "a": {"name": "a", "stage": "compute"},
                "v": {"name": "v", "stage": "vertex"}
            }}"#,
        )
        .unwrap()
    }

    fn variant(entry: &str, path: &str) -> Variant {
        serde_json::from_str(&format!(
            r#"{{"id": "x", "entry_points": ["{entry}"],
                "files": [{{"target": "spirv", "path": "{path}"}}]}}"#
        ))
        .unwrap()
    }

    fn added(entry: &str, path: &str) -> Result<Subjects, Error> {
        let mut subjects = Subjects { compute: Vec::new(), skipped: Vec::new() };
        add(&mut subjects, &variant(entry, path), &shared(), Path::new("p")).map(|()| subjects)
    }

    #[test]
    fn compute_is_taken_and_the_rest_named() {
        let subjects = added("a", "spirv/a.spv").unwrap();
        assert_eq!(subjects.compute[0].path, Path::new("p/spirv/a.spv"));
        let subjects = added("v", "spirv/a.spv").unwrap();
        assert!(subjects.compute.is_empty());
        assert!(subjects.skipped[0].why.contains("vertex"), "{}", subjects.skipped[0].why);
    }

    #[test]
    fn paths_outside_and_unknown_entry_points_are_refused() {
        assert!(matches!(added("a", "../a.spv"), Err(Error::Outside { .. })));
        assert!(matches!(added("a", "/a.spv"), Err(Error::Outside { .. })));
        assert!(matches!(added("b", "a.spv"), Err(Error::EntryPoint { .. })));
    }
}

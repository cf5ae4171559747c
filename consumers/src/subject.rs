//! What consumers read: the variants of a package, and modules that are broken on purpose.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sglow_report::failure::{Context as _, Failure, Result};
use sglow_shader_gen::{emit, validate};

/// A module in the languages that consumers read.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Its identifier.
    pub name: String,
    /// Its WGSL.
    pub wgsl: PathBuf,
    /// Its SPIR-V; none if it has no entry point.
    pub spirv: Option<PathBuf>,
    /// WebGPU features that a device must have.
    pub features: Vec<String>,
    /// What can be run.
    pub entry_points: Vec<EntryPoint>,
    /// Of a broken module: whether every consumer sees that, not only a recent one.
    pub portable: bool,
}

/// An entry point.
#[derive(Clone, Debug, Serialize)]
pub struct EntryPoint {
    /// Its name.
    pub name: String,
    /// `compute`, `vertex` or `fragment`.
    pub stage: String,
}

/// The part of a manifest that is needed here; a package is read as a stranger would.
#[derive(Deserialize)]
struct Manifest {
    shared: Shared,
    variants: Vec<Variant>,
    #[serde(default)]
    libraries: Vec<FunctionLibrary>,
}

#[derive(Deserialize)]
struct FunctionLibrary {
    name: String,
    files: Vec<File>,
}

#[derive(Deserialize)]
struct Shared {
    requires: BTreeMap<String, Requires>,
}

#[derive(Deserialize)]
struct Variant {
    id: String,
    files: Vec<File>,
    requires: String,
}

#[derive(Deserialize)]
struct File {
    target: String,
    path: String,
}

#[derive(Deserialize)]
struct Requires {
    features: Vec<String>,
}

/// Reads all variants and function libraries of a package, sorted by name; their SPIR-V is written to `folder`.
///
/// # Errors
///
/// When the package is not one, or naga refuses a file.
pub fn read_package(package: &Path, folder: &Path) -> Result<Vec<Subject>> {
    let path = package.join("manifest.json");
    let manifest = manifest(package)?;
    let mut subjects = Vec::new();
    for variant in manifest.variants {
        let wgsl = variant.files.iter().find(|file| file.target == "wgsl");
        let wgsl = wgsl.ok_or_else(|| {
            Failure::new(format!("{}: variant {} has no WGSL", path.display(), variant.id))
                .help("generate the package with `--target wgsl`")
        })?;
        if !sglow_seal::is_inside(&wgsl.path) {
            let text = format!("{}: {} leads out of the package", path.display(), wgsl.path);
            return Err(Failure::new(text));
        }
        let wgsl = package.join(&wgsl.path);
        let requires = manifest.shared.requires.get(&variant.requires);
        let features = requires.map(|requires| requires.features.clone()).unwrap_or_default();
        subjects.push(read(variant.id, wgsl, features, folder)?);
    }
    // The functions as one text; their modules are WESL, which these consumers do not read.
    for library in manifest.libraries {
        let mut files = library.files.into_iter();
        if let Some(file) = files.find(|file| file.path.ends_with(".wgsl")) {
            subjects.push(read(library.name, package.join(file.path), Vec::new(), folder)?);
        }
    }
    subjects.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(subjects)
}

fn read(name: String, wgsl: PathBuf, features: Vec<String>, folder: &Path) -> Result<Subject> {
    let place = wgsl.display().to_string();
    let text = fs::read_to_string(&wgsl).context(format!("{place}: cannot be read"))?;
    let module = naga::front::wgsl::parse_str(&text)
        .map_err(|error| Failure::new(error.emit_to_string_with_path(&text, &place)))?;
    let entry_points: Vec<EntryPoint> = module
        .entry_points
        .iter()
        .map(|entry| EntryPoint {
            name: entry.name.clone(),
            stage: format!("{:?}", entry.stage).to_lowercase(),
        })
        .collect();
    let mut spirv = None;
    if !entry_points.is_empty() {
        let requires: BTreeSet<&str> = features.iter().map(String::as_str).collect();
        let info = validate::validator(&requires)
            .validate(&module)
            .map_err(|error| Failure::new(error.emit_to_string_with_path(&text, &place)))?;
        let words = emit::spirv::write(&module, &info).context(&place)?;
        let file = folder.join(format!("{name}.spv"));
        fs::write(&file, emit::spirv::bytes(&words)).context(file.display())?;
        spirv = Some(file);
    }
    Ok(Subject { name, wgsl, spirv, features, entry_points, portable: true })
}

/// A module that is right, for breaking.
const SOUND: &str = "\
@group(0) @binding(0) var<storage, read_write> values: array<f32, 4>;
var<workgroup> shared_values: array<f32, 4>;

@compute @workgroup_size(4)
fn control(@builtin(local_invocation_index) index: u32) {
    shared_values[index] = values[index];
    workgroupBarrier();
    values[index] = shared_values[3u - index];
}
";

/// Modules that are broken on purpose: a consumer that accepts one checks nothing.
///
/// # Errors
///
/// When they cannot be written.
pub fn controls(folder: &Path) -> Result<Vec<Subject>> {
    let entry_points = vec![EntryPoint { name: "control".to_owned(), stage: "compute".to_owned() }];
    let keep = |name: &str, bytes: &[u8]| -> Result<PathBuf> {
        let file = folder.join(name);
        fs::write(&file, bytes).context(file.display())?;
        Ok(file)
    };
    let sound =
        read("control".to_owned(), keep("control.wgsl", SOUND.as_bytes())?, Vec::new(), folder)?;
    let spirv = sound.spirv.as_deref().map(fs::read).transpose()?.unwrap_or_default();

    // An f32 where a u32 is required: well-formed, and wrong in its types alone.
    let mistyped = SOUND.replace("index: u32", "index: f32");
    let control = Subject {
        name: "control-broken".to_owned(),
        wgsl: keep("control-broken.wgsl", mistyped.as_bytes())?,
        spirv: Some(keep("control-broken.spv", &without_bound(spirv))?),
        features: Vec::new(),
        entry_points: entry_points.clone(),
        portable: true,
    };
    // naga's own words, before emit::spirv takes the layout from workgroup memory: only recent validators refuse them.
    let laid_out = Subject {
        name: "control-workgroup-layout".to_owned(),
        wgsl: control.wgsl.clone(),
        spirv: Some(keep("control-workgroup-layout.spv", &words_of_naga()?)?),
        features: Vec::new(),
        entry_points,
        portable: false,
    };
    Ok(vec![control, laid_out])
}

/// The module with its bound on identifiers set to 1, which every identifier exceeds.
fn without_bound(mut spirv: Vec<u8>) -> Vec<u8> {
    if let Some(bound) = spirv.get_mut(12..16) {
        bound.copy_from_slice(&1_u32.to_le_bytes());
    }
    spirv
}

fn words_of_naga() -> Result<Vec<u8>> {
    let module = naga::front::wgsl::parse_str(SOUND)?;
    let info = validate::validator(&BTreeSet::new()).validate(&module)?;
    let options = naga::back::spv::Options {
        lang_version: emit::spirv::VERSION,
        ..naga::back::spv::Options::default()
    };
    let words = naga::back::spv::write_vec(&module, &info, &options, None)?;
    Ok(emit::spirv::bytes(&words))
}

/// The identifiers of a package's variants, by its manifest.
///
/// # Errors
///
/// When the manifest cannot be read.
pub fn identifiers(package: &Path) -> Result<BTreeSet<String>> {
    Ok(manifest(package)?.variants.into_iter().map(|variant| variant.id).collect())
}

fn manifest(package: &Path) -> Result<Manifest> {
    let path = package.join("manifest.json");
    let text = fs::read_to_string(&path)
        .context(format!("{}: cannot be read", path.display()))
        .map_err(|failure| failure.help("`cargo xtask gen-shaders --out DIR` writes a package"))?;
    serde_json::from_str(&text).context(format!("{}: not a manifest", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_package_is_read_as_a_stranger_would() {
        let package = tempfile::tempdir().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let failure = read_package(package.path(), folder.path()).unwrap_err().to_string();
        assert!(failure.contains("manifest.json") && failure.contains("help: "), "{failure}");

        fs::create_dir_all(package.path().join("wgsl")).unwrap();
        fs::write(package.path().join("wgsl/one.wgsl"), "fn one() -> f32 { return 1.0; }").unwrap();
        fs::write(package.path().join("wgsl/swap.wgsl"), SOUND).unwrap();
        let manifest = r#"{"shared": {"requires": {"swap": {"features": []}}}, "variants": [{"id": "swap",
            "requires": "swap", "files": [{"target": "wgsl", "path": "wgsl/swap.wgsl"}]}],
            "libraries": [{"name": "one", "files": [{"target": "wgsl", "path": "wgsl/one.wgsl"}]}]}"#;
        fs::write(package.path().join("manifest.json"), manifest).unwrap();
        let subjects = read_package(package.path(), folder.path()).unwrap();
        let names: Vec<&str> = subjects.iter().map(|subject| subject.name.as_str()).collect();
        assert_eq!(names, ["one", "swap"]);
        assert!(subjects[0].spirv.is_none() && subjects[1].spirv.is_some());
        assert_eq!(subjects[1].entry_points[0].stage, "compute");
    }

    #[test]
    fn the_controls_are_broken() {
        let folder = tempfile::tempdir().unwrap();
        let controls = controls(folder.path()).unwrap();
        let text = fs::read_to_string(&controls[0].wgsl).unwrap();
        let sound = naga::front::wgsl::parse_str(SOUND).unwrap();
        assert!(validate::validator(&BTreeSet::new()).validate(&sound).is_ok());
        let broken = naga::front::wgsl::parse_str(&text);
        let accepted = broken
            .is_ok_and(|module| validate::validator(&BTreeSet::new()).validate(&module).is_ok());
        assert!(!accepted);
        let spirv = |control: &Subject| fs::read(control.spirv.as_ref().unwrap()).unwrap();
        assert_eq!(spirv(&controls[0])[12..16], [1, 0, 0, 0]);
        assert_ne!(spirv(&controls[1])[12..16], [1, 0, 0, 0]);
    }
}

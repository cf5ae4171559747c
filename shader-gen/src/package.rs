//! A package: the files of a set of variants, written beside their place and renamed.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use rayon::prelude::*;

use crate::bindings::{self, Described};
use crate::emit::{spirv, wgsl};
use crate::error::Report;
use crate::frame;
use crate::generate::{self, ValidatedLibrary};
use crate::hash;
use crate::library::Library;
use crate::manifest::reflect::Layout;
use crate::manifest::{self, File, Manifest, reflect};
use crate::matrix::Variant;
use crate::prune::Whole;
use crate::validate::Validated;

/// A language that packages are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Target {
    /// Commented WGSL; every package has it.
    Wgsl,
    /// SPIR-V 1.3 for Vulkan 1.1 and later.
    Spirv,
    /// Bindings for wgpu.
    Rust,
}

impl Target {
    /// Every target.
    pub const ALL: [Self; 3] = [Self::Wgsl, Self::Spirv, Self::Rust];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::Spirv => "spirv",
            Self::Rust => "rust",
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no [`Target`] has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown target `{0}`; known targets: wgsl, spirv, rust")]
pub struct UnknownTarget(pub String);

impl FromStr for Target {
    type Err = UnknownTarget;

    fn from_str(name: &str) -> Result<Self, UnknownTarget> {
        let known = Self::ALL.into_iter().find(|target| target.name() == name);
        known.ok_or_else(|| UnknownTarget(name.to_owned()))
    }
}

/// What variants were chosen for, and what was left out for that. Nothing here is looked at: it goes into the manifest.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Purpose {
    /// The input.
    pub made_for: manifest::MadeFor,
    /// What was left out.
    pub left_out: Vec<manifest::LeftOut>,
}

/// What is written, and where.
#[derive(Clone, Debug)]
pub struct Options {
    /// The folder of the package.
    pub out: PathBuf,
    /// Languages beside WGSL, which is always written.
    pub targets: BTreeSet<Target>,
    /// The variants; those that the library's `[package]` table selects if absent.
    pub variants: Option<Vec<Variant>>,
    /// What the variants were chosen for; any input if absent.
    pub purpose: Option<Purpose>,
    /// Compares the folder with what would be written, and writes nothing.
    pub check: bool,
    /// A folder to remember in that nothing has changed; nothing is remembered if absent.
    pub cache: Option<PathBuf>,
}

impl Options {
    /// The package that a library commits: WGSL and Rust bindings of the selected variants.
    pub fn new(out: impl Into<PathBuf>) -> Self {
        Self {
            out: out.into(),
            targets: BTreeSet::from([Target::Wgsl, Target::Rust]),
            variants: None,
            purpose: None,
            check: false,
            cache: None,
        }
    }
}

/// What has become of the files of a package, each relative to its folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Written, because they were missing or different.
    pub written: Vec<String>,
    /// Left alone, because they were the same.
    pub unchanged: Vec<String>,
    /// Removed, because nothing generates them any more.
    pub removed: Vec<String>,
}

/// How a file differs from what it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Change {
    /// It is not there.
    Missing,
    /// Its hash is not the one in `SHA256SUMS`: it was changed after it was generated.
    ByHand,
    /// The sources have changed since it was generated.
    Outdated,
    /// It was generated once, but nothing generates it any more.
    Stale,
    /// It was never generated.
    Extra,
}

/// A file that is not what it should be.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Difference {
    /// Relative to the folder of the package.
    pub path: String,
    /// How it differs.
    pub change: Change,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.change {
            Change::Missing => "is missing",
            Change::ByHand => "was changed by hand",
            Change::Outdated => "is out of date",
            Change::Stale => "is no longer generated",
            Change::Extra => "is not part of the package",
        };
        write!(f, "{}: {what}", self.path)
    }
}

/// A variant that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("{variant}: {cause}")]
pub struct VariantError {
    /// The variant.
    pub variant: String,
    /// Why.
    pub cause: Cause,
}

/// Why a variant cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum Cause {
    /// It cannot be described for its host.
    #[error(transparent)]
    Reflection(#[from] manifest::Error),
    /// It has no SPIR-V.
    #[error(transparent)]
    Spirv(#[from] spirv::Error),
}

/// Why a package was not written, or is not what it should be.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The library is wrong.
    #[error(transparent)]
    Library(#[from] Report),
    /// Variants cannot be written.
    #[error("{}", lines(.0))]
    Variants(Vec<VariantError>),
    /// There are no Rust bindings.
    #[error(transparent)]
    Bindings(#[from] bindings::Error),
    /// A licence whose text is not known.
    #[error(
        "the library's licence names `{0}`, whose text is not known; known are MIT, Apache-2.0"
    )]
    License(String),
    /// The manifest cannot be written as JSON.
    #[error("the manifest cannot be written: {0}")]
    Manifest(#[from] serde_json::Error),
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The folder is not what would be written.
    #[error("the package is not what its sources make; run `cargo xtask gen-shaders`:\n{}", lines(.0))]
    Differs(Vec<Difference>),
}

fn lines(items: &[impl fmt::Display]) -> String {
    items.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// What [`generate()`] is about to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Nothing has changed since the folder was written.
    Unchanged,
    /// So many variants are put together and validated.
    Variants(usize),
    /// So many variants are written in the target languages.
    Targets(usize),
    /// So many files are compared with those in the folder.
    Files(usize),
}

/// Reads the library in `library`, generates its variants, and writes the package or compares it.
///
/// With [`Options::cache`], and where neither sources nor generator nor package have changed, nothing is generated.
///
/// # Errors
///
/// Whatever is wrong with the library or its variants; when a file cannot be read or written; with [`Options::check`]
/// every difference.
pub fn generate(
    library: &Path,
    options: &Options,
    progress: &mut dyn FnMut(Progress),
) -> Result<Outcome, Error> {
    let folder = if library.is_dir() { library } else { library.parent().unwrap_or(library) };
    let changelog = read_if_there(&folder.join("CHANGELOG.md"))?;
    let library = Library::load(library)?;
    let variants = options.variants.clone().unwrap_or_else(|| library.selected());
    let source = source_hash(&library, &variants, changelog.as_deref(), &options.targets);
    let source = match &options.purpose {
        None => source,
        Some(purpose) => {
            let purpose = serde_json::to_string(purpose)?;
            hash::of_parts([("source", source.as_str()), ("purpose", purpose.as_str())])
        }
    };
    if let Some(unchanged) = remembered(options, &source) {
        progress(Progress::Unchanged);
        return Ok(unchanged);
    }
    progress(Progress::Variants(variants.len()));
    // A check takes the time to prove each variant against everything that its modules declare.
    let whole = if options.check { Whole::Modules } else { Whole::Imports };
    let validated = generate::variants_against(&library, &variants, whole)?;
    let libraries = generate::libraries(&library)?;
    progress(Progress::Targets(variants.len()));
    let parts = Parts {
        library: &library,
        variants: &validated,
        libraries: &libraries,
        changelog: changelog.as_deref(),
        source_hash: &source,
        purpose: options.purpose.as_ref(),
    };
    let files = build(&parts, &options.targets)?;
    progress(Progress::Files(files.len()));
    let outcome =
        if options.check { compare(&options.out, &files) } else { write(&options.out, &files) }?;
    remember(options, &source, &files)?;
    Ok(outcome)
}

// ---------------------------------------------------------------- in memory

/// What a package is made of.
#[derive(Clone, Copy, Debug)]
pub struct Parts<'a> {
    /// The library.
    pub library: &'a Library,
    /// Its variants.
    pub variants: &'a [Validated],
    /// Its files of functions.
    pub libraries: &'a [ValidatedLibrary],
    /// What changed in which version; the first version alone if absent.
    pub changelog: Option<&'a str>,
    /// Stands in the manifest for all of this.
    pub source_hash: &'a str,
    /// What the variants were chosen for; any input if absent.
    pub purpose: Option<&'a Purpose>,
}

/// SHA-256 of all that a package is made of.
#[must_use]
pub fn source_hash(
    library: &Library,
    variants: &[Variant],
    changelog: Option<&str>,
    targets: &BTreeSet<Target>,
) -> String {
    let ids: BTreeSet<String> = variants.iter().map(Variant::id).collect();
    let ids = ids.into_iter().collect::<Vec<_>>().join("\n");
    let targets = targets.iter().map(|target| target.name()).collect::<Vec<_>>().join("\n");
    let sources = library.sources().files().iter();
    let sources = sources.map(|file| (format!("source:{}", file.path), file.text.as_str()));
    let mut parts: Vec<_> = sources.collect();
    parts.push(("variants".to_owned(), &ids));
    parts.push(("targets".to_owned(), &targets));
    parts.push(("changelog".to_owned(), changelog.unwrap_or_default()));
    hash::of_parts(parts.iter().map(|(name, text)| (name.as_str(), *text)))
}

/// What each of `variants` takes by itself, by its identifier: operations, bindings and its WGSL's bytes; what memory it
/// works on is not known here.
///
/// # Errors
///
/// When a variant is wrong or cannot be described; all such variants at once.
pub fn weigh(
    library: &Library,
    variants: &[Variant],
) -> Result<BTreeMap<String, manifest::Weight>, Error> {
    let validated = generate::variants(library, variants)?;
    let mut weights = BTreeMap::new();
    let mut errors = Vec::new();
    for one in &validated {
        match reflect(&one.text, &one.module, &one.info) {
            Err(error) => {
                errors.push(VariantError { variant: one.variant.id(), cause: error.into() });
            }
            Ok(reflection) => {
                let operations = reflection.entry_points.iter().map(|of| of.cost);
                let weight = manifest::Weight {
                    static_operations: operations
                        .map(|cost| cost.arithmetic + cost.transcendental)
                        .sum(),
                    bindings: reflection.bindings.len() as u64,
                    shader_bytes: wgsl::variant(library, &one.variant, &one.text).len() as u64,
                    ..manifest::Weight::default()
                };
                weights.insert(one.variant.id(), weight);
            }
        }
    }
    if errors.is_empty() { Ok(weights) } else { Err(Error::Variants(errors)) }
}

struct Written {
    manifest: manifest::Variant,
    layouts: Vec<Arc<Layout>>,
    files: Vec<(String, Vec<u8>)>,
}

/// The files of a package by their path.
///
/// # Errors
///
/// When a variant cannot be described or written in a target language; all such variants at once.
pub fn build(
    parts: &Parts<'_>,
    targets: &BTreeSet<Target>,
) -> Result<BTreeMap<String, Vec<u8>>, Error> {
    let library = parts.library;
    let results: Vec<_> =
        parts.variants.par_iter().map(|validated| one(library, validated, targets)).collect();
    let (mut written, mut errors) = (Vec::new(), Vec::new());
    for (validated, result) in parts.variants.iter().zip(results) {
        match result {
            Ok(one) => written.push(one),
            Err(cause) => errors.push(VariantError { variant: validated.variant.id(), cause }),
        }
    }
    if !errors.is_empty() {
        return Err(Error::Variants(errors));
    }
    written.sort_by(|a, b| a.manifest.id.cmp(&b.manifest.id));

    let mut files = BTreeMap::new();
    for one in &mut written {
        files.extend(std::mem::take(&mut one.files));
    }
    let mut libraries = Vec::new();
    for functions in parts.libraries {
        let text = wgsl::functions(library, &functions.name, &functions.text).into_bytes();
        let (file, entry) = file(Target::Wgsl, format!("wgsl/lib/{}.wgsl", functions.name), text);
        libraries
            .push(manifest::FunctionLibrary { name: functions.name.clone(), files: vec![entry] });
        files.extend([file]);
    }
    if targets.contains(&Target::Rust) {
        let described: Vec<_> = written
            .iter()
            .map(|one| Described { variant: &one.manifest, layouts: &one.layouts })
            .collect();
        files.insert("rust/lib.rs".to_owned(), bindings::write(library, &described)?.into_bytes());
    }
    let variants: Vec<_> = written.into_iter().map(|one| one.manifest).collect();
    frame::check(library, &variants)?;
    let manifest = head(parts, targets, libraries, variants);
    files.insert("README.md".to_owned(), readme(&manifest).into_bytes());
    files.insert("CHANGELOG.md".to_owned(), changelog(parts).into_bytes());
    for (name, text) in licenses(library)? {
        files.insert(name.to_owned(), text.into_bytes());
    }
    files.insert("manifest.json".to_owned(), json(&manifest)?);
    files.insert("manifest.schema.json".to_owned(), json(&manifest::schema())?);
    let sums = hash::sums(&files);
    files.insert(SUMS.to_owned(), sums.into_bytes());
    Ok(files)
}

fn one(
    library: &Library,
    validated: &Validated,
    targets: &BTreeSet<Target>,
) -> Result<Written, Cause> {
    let id = validated.variant.id();
    let reflection = reflect(&validated.text, &validated.module, &validated.info)?;
    let text = wgsl::variant(library, &validated.variant, &validated.text).into_bytes();
    let mut written = vec![file(Target::Wgsl, format!("wgsl/{id}.wgsl"), text)];
    if targets.contains(&Target::Spirv) {
        let words = spirv::write(&validated.module, &validated.info)?;
        written.push(file(Target::Spirv, format!("spirv/{id}.spv"), spirv::bytes(&words)));
    }
    let (files, entries) = written.into_iter().unzip();
    Ok(Written {
        manifest: manifest::variant(library, validated, &reflection, entries),
        layouts: reflection.layouts,
        files,
    })
}

/// A file with its entry in the manifest.
fn file(target: Target, path: String, bytes: Vec<u8>) -> ((String, Vec<u8>), File) {
    let tool = match target {
        Target::Spirv => spirv::TOOL,
        Target::Wgsl | Target::Rust => wgsl::TOOL,
    };
    let entry = File {
        target: target.name().to_owned(),
        path: path.clone(),
        sha256: hash::sha256(&bytes),
        tool: tool.to_owned(),
    };
    ((path, bytes), entry)
}

fn head(
    parts: &Parts<'_>,
    targets: &BTreeSet<Target>,
    libraries: Vec<manifest::FunctionLibrary>,
    variants: Vec<manifest::Variant>,
) -> Manifest {
    let library = parts.library;
    let mut targets = targets.clone();
    targets.insert(Target::Wgsl);
    let mut names: Vec<_> = targets.iter().map(|target| target.name().to_owned()).collect();
    names.sort();
    let axis = |(name, axis): (&String, &crate::library::Axis)| manifest::Axis {
        name: name.clone(),
        description: axis.description.clone(),
        default: axis.default.clone(),
        values: axis
            .value
            .iter()
            .map(|value| manifest::AxisValue {
                name: value.name.clone(),
                description: value.description.clone(),
            })
            .collect(),
    };
    Manifest {
        schema_version: manifest::SCHEMA_VERSION,
        package: library.package.name.clone(),
        version: library.library.version.clone(),
        description: library.library.description.clone(),
        license: library.library.license.clone(),
        generator: manifest::Tool {
            name: env!("CARGO_PKG_NAME").to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        },
        naga: hash::NAGA.to_owned(),
        source_hash: parts.source_hash.to_owned(),
        citations: library
            .citation
            .iter()
            .map(|citation| manifest::Citation {
                key: citation.key.clone(),
                text: citation.text.clone(),
            })
            .collect(),
        prefix: library.library.prefix.clone(),
        made_for: parts.purpose.map(|purpose| purpose.made_for.clone()),
        left_out: parts.purpose.map(|purpose| purpose.left_out.clone()).unwrap_or_default(),
        targets: names,
        axes: library.axis.iter().map(axis).collect(),
        presets: library
            .preset
            .iter()
            .map(|preset| manifest::Preset {
                name: preset.name.clone(),
                description: preset.description.clone(),
                set: preset
                    .set
                    .iter()
                    .map(|(name, value)| (name.clone(), value.to_string()))
                    .collect(),
            })
            .collect(),
        passes: library
            .pass
            .iter()
            .map(|pass| manifest::Pass {
                name: pass.name.clone(),
                description: pass.description.clone(),
                axes: pass.axes.clone(),
            })
            .collect(),
        graph: library.frame().map(|of| frame::json(&of.description)),
        libraries,
        variants,
    }
}

fn json(value: &impl serde::Serialize) -> Result<Vec<u8>, Error> {
    let mut bytes = serde_json::to_vec_pretty(value)?;
    bytes.push(b'\n');
    Ok(bytes)
}

fn readme(manifest: &Manifest) -> String {
    let mut text = format!(
        "# {} {}\n\n{}.\n\n\
         Every file here is generated; `SHA256SUMS` has their hashes. `manifest.json` says of each variant what it binds, \
         needs and promises (its form: `manifest.schema.json`).\n\n\
         A shader in `wgsl/` is whole: hand its text to the device, make the bind groups of `bindings`, and set its \
         `overrides` as constants of the pipeline. Buffers have the layout of `structs`; the units and ranges of all \
         inputs stand in `contract` and at the top of each shader.",
        manifest.package, manifest.version, manifest.description
    );
    if !manifest.libraries.is_empty() {
        text.push_str(
            " `wgsl/lib/` has functions without bindings for hosts that bring their own passes.",
        );
    }
    if manifest.targets.iter().any(|target| target == "spirv") {
        text.push_str(
            " `spirv/` has the same variants as SPIR-V 1.3, overrides at their defaults; clip space is WebGPU's (y up).",
        );
    }
    if manifest.targets.iter().any(|target| target == "rust") {
        text.push_str(" `rust/lib.rs` has the choices as types, the structs, and the bind-group layouts for wgpu.");
    }
    text.push('\n');
    if let Some(made_for) = &manifest.made_for {
        text.push_str(&format!("\n## Made for {}\n\n", made_for.input));
        for assumed in &made_for.assumed {
            text.push_str(&format!(
                "- {}: {} ({}), by which the rule {} leaves things out\n",
                assumed.fact,
                if assumed.holds { "yes" } else { "no" },
                assumed.evidence,
                assumed.rule
            ));
        }
        text.push_str("\nOf an input of which this is not so the package does not show all; `left_out` in the manifest says what.\n");
    }
    for pass in &manifest.passes {
        let variants: Vec<_> =
            manifest.variants.iter().filter(|variant| variant.pass == pass.name).collect();
        if variants.is_empty() {
            continue;
        }
        text.push_str(&format!("\n## {}\n\n{}.\n\n", pass.name, capital(&pass.description)));
        text.push_str("| variant | entry points | binds | texture loads + samples | buffer reads | scalar operations |\n");
        text.push_str("|---|---|---|---|---|---|\n");
        for variant in variants {
            let costs = variant.entry_points.iter().map(|of| of.cost);
            let sum = |of: fn(manifest::Cost) -> u64| costs.clone().map(of).sum::<u64>();
            text.push_str(&format!(
                "| [`{id}`](wgsl/{id}.wgsl) | {} | {} | {} + {} | {} | {} |\n",
                variant
                    .entry_points
                    .iter()
                    .map(|of| format!("`{}`", of.name))
                    .collect::<Vec<_>>()
                    .join(", "),
                variant.bindings.len(),
                sum(|cost| cost.texture_loads),
                sum(|cost| cost.texture_samples),
                sum(|cost| cost.buffer_reads),
                sum(|cost| cost.arithmetic + cost.transcendental),
                id = variant.id,
            ));
        }
    }
    text.push_str(
        "\nThe numbers are static: a call counts what it calls, a loop counts once, a branch counts all its sides. They \
         compare texts, not run times.\n",
    );
    text
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map(|first| first.to_uppercase().to_string() + letters.as_str())
        .unwrap_or_default()
}

fn changelog(parts: &Parts<'_>) -> String {
    let version = &parts.library.library.version;
    parts
        .changelog
        .map_or_else(|| format!("# Changelog\n\n## {version}\n\n- First version.\n"), str::to_owned)
}

/// The licences of a library by the name of their file.
fn licenses(library: &Library) -> Result<Vec<(&'static str, String)>, Error> {
    let words = library.library.license.split(|c: char| c.is_whitespace() || "()".contains(c));
    let names = words.filter(|word| !["", "OR", "AND", "WITH"].contains(word));
    names
        .map(|name| match name {
            "MIT" => {
                let text = include_str!("package/LICENSE-MIT");
                Ok(("LICENSE-MIT", text.replace("{name}", &library.library.name)))
            }
            "Apache-2.0" => {
                Ok(("LICENSE-APACHE", include_str!("package/LICENSE-APACHE").to_owned()))
            }
            other => Err(Error::License(other.to_owned())),
        })
        .collect()
}

// ---------------------------------------------------------------- on disk

/// Where the hashes of all other files stand.
const SUMS: &str = "SHA256SUMS";

/// Writes `files` into `out` and removes what an earlier run has written there and nothing writes now.
///
/// What differs is first written beside `out` and then renamed into place, the hashes last; a run that is cut off
/// leaves whole files only.
///
/// # Errors
///
/// When a file cannot be read, written, renamed or removed.
pub fn write(out: &Path, files: &BTreeMap<String, Vec<u8>>) -> Result<Outcome, Error> {
    let before = recorded(out)?;
    let mut outcome = Outcome::default();
    for (path, bytes) in files {
        let same = read_if_there_bytes(&out.join(path))?.is_some_and(|found| found == *bytes);
        if same { &mut outcome.unchanged } else { &mut outcome.written }.push(path.clone());
    }
    outcome.removed = before
        .into_keys()
        .filter(|path| !files.contains_key(path) && out.join(path).is_file())
        .collect();
    if !outcome.written.is_empty() {
        replace(out, files, &outcome.written)?;
    }
    for path in &outcome.removed {
        let file = out.join(path);
        fs::remove_file(&file).map_err(at(&file))?;
        // A folder is removed with its last file; one that still has files stays.
        for folder in file.ancestors().skip(1).take_while(|folder| *folder != out) {
            if fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
    Ok(outcome)
}

fn replace(out: &Path, files: &BTreeMap<String, Vec<u8>>, paths: &[String]) -> Result<(), Error> {
    let parent = match out.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    fs::create_dir_all(parent).map_err(at(parent))?;
    let beside =
        tempfile::Builder::new().prefix(".package-").tempdir_in(parent).map_err(at(parent))?;
    let create = |file: &Path| {
        let folder = file.parent().unwrap_or(file);
        fs::create_dir_all(folder).map_err(at(folder))
    };
    for path in paths {
        let file = beside.path().join(path);
        create(&file)?;
        fs::write(&file, files.get(path).map(Vec::as_slice).unwrap_or_default())
            .map_err(at(&file))?;
    }
    let (sums, others): (Vec<_>, Vec<_>) = paths.iter().partition(|path| *path == SUMS);
    for path in others.into_iter().chain(sums) {
        let file = out.join(path);
        create(&file)?;
        fs::rename(beside.path().join(path), &file).map_err(at(&file))?;
    }
    Ok(())
}

/// Compares `out` with `files`.
///
/// # Errors
///
/// Every difference; or that a file cannot be read.
pub fn compare(out: &Path, files: &BTreeMap<String, Vec<u8>>) -> Result<Outcome, Error> {
    let before = recorded(out)?;
    let mut differences = Vec::new();
    let mut unchanged = Vec::new();
    for (path, bytes) in files {
        let change = match read_if_there_bytes(&out.join(path))? {
            None => Change::Missing,
            Some(found) if found == *bytes => {
                unchanged.push(path.clone());
                continue;
            }
            Some(found) => match before.get(path) {
                Some(hash) if *hash != hash::sha256(&found) => Change::ByHand,
                _ => Change::Outdated,
            },
        };
        differences.push(Difference { path: path.clone(), change });
    }
    for path in present(out)? {
        if !files.contains_key(&path) {
            let change = if before.contains_key(&path) { Change::Stale } else { Change::Extra };
            differences.push(Difference { path, change });
        }
    }
    if differences.is_empty() {
        Ok(Outcome { unchanged, ..Outcome::default() })
    } else {
        differences.sort();
        Err(Error::Differs(differences))
    }
}

/// Compares the files of a package with its own `SHA256SUMS`: what was changed by hand, is missing, or was added.
///
/// # Errors
///
/// When a file cannot be read; a package without `SHA256SUMS` misses that file.
pub fn verify_hashes(package: &Path) -> Result<Vec<Difference>, Error> {
    let recorded = recorded(package)?;
    let present = present(package)?;
    let mut differences = Vec::new();
    if !present.contains(SUMS) {
        differences.push(Difference { path: SUMS.to_owned(), change: Change::Missing });
    }
    for (path, hash) in &recorded {
        let change = match read_if_there_bytes(&package.join(path))? {
            None => Change::Missing,
            Some(found) if hash::sha256(&found) != *hash => Change::ByHand,
            Some(_) => continue,
        };
        differences.push(Difference { path: path.clone(), change });
    }
    let extra = present.into_iter().filter(|path| path != SUMS && !recorded.contains_key(path));
    differences.extend(extra.map(|path| Difference { path, change: Change::Extra }));
    differences.sort();
    Ok(differences)
}

/// The hashes in a package's `SHA256SUMS` by path; none if there is no such file.
fn recorded(package: &Path) -> Result<BTreeMap<String, String>, Error> {
    let text = read_if_there(&package.join(SUMS))?.unwrap_or_default();
    let inside = |path: &str| {
        Path::new(path).components().all(|part| matches!(part, std::path::Component::Normal(_)))
    };
    let mut recorded: BTreeMap<_, _> = hash::read_sums(&text)
        .into_iter()
        .filter(|(path, _)| inside(path))
        .map(|(path, hash)| (path.to_owned(), hash.to_owned()))
        .collect();
    recorded.remove(SUMS);
    Ok(recorded)
}

/// The files that lie in a package.
fn present(package: &Path) -> Result<BTreeSet<String>, Error> {
    let mut found = BTreeSet::new();
    let mut folders = vec![package.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries = match fs::read_dir(&folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            Err(error) => return Err(at(&folder)(error)),
        };
        for entry in entries {
            let path = entry.map_err(at(&folder))?.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.insert(crate::source::relative(package, &path));
            }
        }
    }
    Ok(found)
}

fn at(path: &Path) -> impl Fn(io::Error) -> Error {
    let path = path.to_owned();
    move |source| Error::File { path: path.clone(), source }
}

fn read_if_there_bytes(path: &Path) -> Result<Option<Vec<u8>>, Error> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(at(path)(error)),
    }
}

fn read_if_there(path: &Path) -> Result<Option<String>, Error> {
    match fs::read_to_string(path) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(at(path)(error)),
    }
}

// ---------------------------------------------------------------- what is remembered

/// Where it is remembered what a folder was made of.
fn stamp(options: &Options) -> Option<PathBuf> {
    let folder = std::path::absolute(&options.out).ok()?;
    let name = hash::sha256(folder.to_string_lossy().as_bytes());
    Some(options.cache.as_ref()?.join(name))
}

/// All that decides on the files of a folder, the folder's own hashes included.
fn state(source: &str, sums: &[u8]) -> String {
    hash::of_parts([
        ("source", source),
        ("generator", hash::GENERATOR),
        ("sums", &hash::sha256(sums)),
    ])
}

/// The outcome, if the folder is known to be what would be written.
fn remembered(options: &Options, source: &str) -> Option<Outcome> {
    let known = fs::read_to_string(stamp(options)?).ok()?;
    let sums = fs::read(options.out.join(SUMS)).ok()?;
    if known != state(source, &sums) || !verify_hashes(&options.out).ok()?.is_empty() {
        return None;
    }
    let mut unchanged: Vec<_> = recorded(&options.out).ok()?.into_keys().collect();
    unchanged.push(SUMS.to_owned());
    unchanged.sort();
    Some(Outcome { unchanged, ..Outcome::default() })
}

fn remember(
    options: &Options,
    source: &str,
    files: &BTreeMap<String, Vec<u8>>,
) -> Result<(), Error> {
    let (Some(stamp), Some(sums)) = (stamp(options), files.get(SUMS)) else {
        return Ok(());
    };
    let folder = stamp.parent().unwrap_or(&stamp);
    fs::create_dir_all(folder).map_err(at(folder))?;
    let file = tempfile::NamedTempFile::new_in(folder).map_err(at(folder))?;
    fs::write(file.path(), state(source, sums)).map_err(at(file.path()))?;
    file.persist(&stamp).map_err(|error| at(&stamp)(error.error))?;
    Ok(())
}

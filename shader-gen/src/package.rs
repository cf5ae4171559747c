//! A package: the files of a set of variants, written beside their place and renamed.

mod difference;
mod error;
mod exchange;
mod folder;
mod json;
mod memory;
mod options;
mod text;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;
pub use sglow_seal::Fault;
use sglow_seal::{MANIFEST, SUMS, at, read_if_there};

pub use self::difference::{Change, Difference, Outcome};
pub use self::error::{Cause, Error, VariantError};
pub use self::folder::{claim, compare, verify_hashes, write};
use self::folder::{mend, remember, remembered};
pub use self::json::json;
pub use self::memory::{InMemory, in_memory};
pub use self::options::{Options, Parts, Purpose, Target, UnknownTarget};
use crate::bindings;
use crate::deep::deep;
use crate::emit::{spirv, wgsl};
use crate::frame;
use crate::functions::functions;
use crate::generate;
use crate::hash;
use crate::library::Library;
use crate::manifest::{self, Described, File, Layout, Manifest, Omissions, Shared, reflect};
use crate::matrix::Variant;
use crate::name;
use crate::prune::Whole;
use crate::validate::Validated;

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
    let path = folder.join("CHANGELOG.md");
    let changelog = read_if_there(&path)?.map(String::from_utf8).transpose();
    let changelog = changelog.map_err(|wrong| at(&path)(io::Error::other(wrong)))?;
    let library = Library::load_with(library, &options.over)?;
    if !options.check {
        settle(folder, &library, options)?;
    }
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
    let whole = if options.check { Whole::Modules } else { options.whole };
    let validated = generate::variants_against(&library, &variants, whole)?;
    let functions = functions(&library)?;
    progress(Progress::Targets(variants.len()));
    let parts = Parts {
        library: &library,
        variants: &validated,
        functions: functions.as_ref(),
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

/// How many files were, or are, not what they should be.
#[must_use]
pub fn differing(outcome: &Result<Outcome, Error>) -> usize {
    match outcome {
        Ok(outcome) => outcome.written.len() + outcome.removed.len(),
        Err(Error::Differs(differences)) => differences.len(),
        Err(_) => 0,
    }
}

/// Makes sure, before the work, that the package may take the place of what is in its folder, and mends what a run that was
/// cut off left there. The folder of the package that a library commits is its own, whatever has become of the files in it,
/// and takes no other package.
fn settle(folder: &Path, library: &Library, options: &Options) -> Result<(), Error> {
    mend(&options.out)?;
    let real = |path: &Path| fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let committed = folder.join("packages").join(&library.package.name);
    if real(&committed) != real(&options.out) {
        return claim(&options.out);
    }
    let usual = Options::new(&options.out);
    let is_usual = options.variants.is_none()
        && options.purpose.is_none()
        && options.over.is_empty()
        && options.targets == usual.targets;
    if is_usual { Ok(()) } else { Err(Error::Committed { path: options.out.clone() }) }
}

// ---------------------------------------------------------------- in memory

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
                let operations = reflection.cost.values();
                let weight = manifest::Weight {
                    static_operations: operations.map(|cost| cost.text().scalars()).sum(),
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
    described: Described,
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
    let results: Vec<_> = deep(|| {
        parts.variants.par_iter().map(|validated| one(library, validated, targets)).collect()
    });
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
    written.sort_by(|a, b| a.described.id.cmp(&b.described.id));

    let mut files = BTreeMap::new();
    for one in &mut written {
        files.extend(std::mem::take(&mut one.files));
    }
    let mut libraries = Vec::new();
    for (name, path, text) in parts.functions.iter().flat_map(|of| wgsl::functions(library, of)) {
        let (file, entry) = file(Target::Wgsl, path, text.into_bytes());
        libraries.push(manifest::FunctionLibrary { name, files: vec![entry] });
        files.extend([file]);
    }
    if targets.contains(&Target::Rust) {
        let described: Vec<_> = written
            .iter()
            .map(|one| bindings::Described { variant: &one.described, layouts: &one.layouts })
            .collect();
        files.insert("rust/lib.rs".to_owned(), bindings::write(library, &described)?.into_bytes());
    }
    let variants: Vec<_> = written.into_iter().map(|one| one.described).collect();
    frame::check(library, &variants)?;
    let manifest = manifest(parts, targets, libraries, variants);
    files.insert("README.md".to_owned(), text::readme(library, &manifest).into_bytes());
    files.insert("CHANGELOG.md".to_owned(), text::changelog(parts).into_bytes());
    for (name, text) in text::licenses(library)? {
        files.insert(name.to_owned(), text.into_bytes());
    }
    files.insert(MANIFEST.to_owned(), json(&manifest)?);
    files.insert("omitted.json".to_owned(), json(&Omissions::of(parts.variants))?);
    files.insert("manifest.schema.json".to_owned(), json(&manifest::schema())?);
    if !library.examples.is_empty() {
        let version = manifest::SCHEMA_VERSION;
        let inputs = serde_json::json!({ "schema_version": version, "inputs": library.examples });
        files.insert("inputs.json".to_owned(), json(&inputs)?);
    }
    let sums = hash::sums(&files);
    files.insert(SUMS.to_owned(), sums.into_bytes());
    Ok(files)
}

fn one(
    library: &Library,
    validated: &Validated,
    targets: &BTreeSet<Target>,
) -> Result<Written, Cause> {
    let stem = name::stem(library, &validated.variant);
    let reflection = reflect(&validated.text, &validated.module, &validated.info)?;
    let text = wgsl::variant(library, &validated.variant, &validated.text).into_bytes();
    let mut written = vec![file(Target::Wgsl, format!("wgsl/{stem}.wgsl"), text)];
    if targets.contains(&Target::Spirv) {
        let words = spirv::write(&validated.module, &validated.info)?;
        written.push(file(Target::Spirv, format!("spirv/{stem}.spv"), spirv::bytes(&words)));
    }
    let (files, entries) = written.into_iter().unzip();
    Ok(Written {
        described: manifest::variant(library, validated, &reflection, entries),
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

fn manifest(
    parts: &Parts<'_>,
    targets: &BTreeSet<Target>,
    libraries: Vec<manifest::FunctionLibrary>,
    variants: Vec<Described>,
) -> Manifest {
    let library = parts.library;
    let mut shared = Shared::default();
    let variants = variants.into_iter().map(|one| shared.intern(one)).collect();
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
        shared,
        variants,
    }
}

//! Generated packages: the texts of variants, each checked against its hash before it is used.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use serde::Deserialize;
use sglow_graph::Description;
use sglow_seal::MANIFEST;
use thiserror::Error;

use crate::interface::{Interface, Keys, Shared};

/// Why a package or one of its variants cannot be used.
#[derive(Debug, Error)]
pub enum PackageError {
    /// A file of the package cannot be read, or is not what was written.
    #[error(transparent)]
    File(#[from] sglow_seal::Error),
    /// The manifest is not one.
    #[error("{}: {reason}; generate the package again with `cargo xtask gen-shaders`", path.display())]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The package lacks a variant.
    #[error(
        "the package {origin} has no variant '{id}'{}{}",
        if similar.is_empty() { String::new() } else { format!("; of this pass it has: {}", similar.join(", ")) },
        left_out.iter().map(|left_out| format!("; {left_out}")).collect::<String>()
    )]
    Missing {
        /// The variant.
        id: String,
        /// Where the package comes from.
        origin: String,
        /// The variants of the same pass.
        similar: Vec<String>,
        /// The rules by which it was left out, with what they left out and why.
        left_out: Vec<String>,
    },
}

/// An assumption about a scene, and the rule by which it let something be left out.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
pub struct Assumption {
    /// Name of the rule.
    pub rule: String,
    /// Name of the fact.
    pub fact: String,
    /// Whether it holds.
    pub holds: bool,
}

/// The shader texts of a package, by variant.
#[derive(Clone, Debug)]
pub struct Package {
    origin: String,
    /// Shared by copies, of which each [`crate::indirect::Indirect`] keeps one.
    texts: Arc<BTreeMap<String, String>>,
    manifest: Arc<Manifest>,
    requested: Requested,
}

/// The variants that were requested. Of a copy of a package none were.
#[derive(Debug, Default)]
struct Requested(Mutex<BTreeSet<String>>);

impl Clone for Requested {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Requested {
    /// What a thread that panicked has left is as good as any.
    fn set(&self) -> MutexGuard<'_, BTreeSet<String>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The format of manifests that is read.
const SCHEMA_VERSION: u32 = 7;

/// What is read of a manifest.
#[derive(Debug, Default)]
struct Manifest {
    made_for: MadeFor,
    left_out: Vec<LeftOut>,
    description: Option<Description>,
    variants: BTreeMap<String, (Vec<File>, Interface)>,
}

impl Manifest {
    /// A manifest of the format that is read, or what is wrong with it.
    fn read(text: &[u8]) -> Result<Self, String> {
        #[derive(Deserialize)]
        struct Version {
            schema_version: u32,
        }
        #[derive(Deserialize)]
        struct Whole {
            #[serde(default)]
            made_for: MadeFor,
            #[serde(default)]
            left_out: Vec<LeftOut>,
            graph: Option<Description>,
            shared: Shared,
            variants: Vec<Variant>,
        }
        let wrong = |error: serde_json::Error| error.to_string();
        // First of all, for another format need not have anything else of this one.
        let Version { schema_version } = serde_json::from_slice(text).map_err(wrong)?;
        if schema_version != SCHEMA_VERSION {
            return Err(format!(
                "is of format {schema_version}, and this version reads format {SCHEMA_VERSION}"
            ));
        }
        let Whole { made_for, left_out, graph, shared, variants } =
            serde_json::from_slice(text).map_err(wrong)?;
        let mut read = Self { made_for, left_out, description: graph, ..Self::default() };
        for Variant { id, files, keys } in variants {
            let interface = shared
                .interface(keys)
                .map_err(|key| format!("variant '{id}' refers to '{key}', which `shared` lacks"))?;
            if read.variants.insert(id.clone(), (files, interface)).is_some() {
                return Err(format!("has variant '{id}' twice"));
            }
        }
        let known = |fact: &str| read.description.as_ref().is_none_or(|of| of.facts.contains(fact));
        match read.made_for.assumed.iter().find(|one| !known(&one.fact)) {
            Some(one) => Err(format!("assumes '{}', which is no known fact", one.fact)),
            None => Ok(read),
        }
    }

    /// Why a variant is missing: the rules that left it out, or what was chosen in its place.
    fn reasons(&self, id: &str) -> Vec<String> {
        let mut words = id.split('-');
        let of = self.description.as_ref();
        let axes = of.zip(words.next()).and_then(|(of, pass)| of.passes.get(pass));
        let axes = axes.map(Vec::as_slice).unwrap_or_default();
        // What the identifier does not name is the default of the last one.
        let last = of.zip(axes.last()).and_then(|(of, axis)| of.axes.get(axis));
        let words = words.chain(last.map(|axis| axis.default.as_str()));
        let values: Vec<_> = axes.iter().map(String::as_str).zip(words).collect();
        let rules = self.left_out.iter().filter_map(|left| left.explains(id, &values));
        let rules: Vec<_> = rules.collect();
        if !rules.is_empty() {
            return rules;
        }
        let chosen = |(axis, value): &(&str, &str)| {
            let chosen = self.made_for.chosen.get(*axis).filter(|chosen| chosen != value)?;
            Some(format!("the package was made with {axis} {chosen}"))
        };
        values.iter().filter_map(chosen).collect()
    }
}

/// What a package was made for.
#[derive(Debug, Default, Deserialize)]
struct MadeFor {
    assumed: Vec<Assumption>,
    /// The value that was chosen on each axis; none where any was.
    chosen: BTreeMap<String, String>,
}

/// What a rule left out of a package.
#[derive(Debug, Deserialize)]
struct LeftOut {
    rule: String,
    reason: String,
    #[serde(default)]
    values: BTreeMap<String, Vec<String>>,
    #[serde(default)]
    variants: Vec<String>,
}

impl LeftOut {
    /// What to say of it where a variant is missing that it has left out.
    fn explains(&self, id: &str, values: &[(&str, &str)]) -> Option<String> {
        let left = |(axis, value): &(&str, &str)| {
            self.values.get(*axis).is_some_and(|left| left.iter().any(|left| left == value))
        };
        let found = values.iter().filter(|value| left(value));
        let found: Vec<_> = found.map(|(axis, value)| format!("{axis} {value}")).collect();
        let what = match &found[..] {
            [] => self.variants.iter().any(|variant| variant == id).then(|| "it".to_owned())?,
            found => found.join(", "),
        };
        Some(format!("the rule '{}' left {what} out: {}", self.rule, self.reason))
    }
}

#[derive(Deserialize)]
struct Variant {
    id: String,
    #[serde(default)]
    files: Vec<File>,
    #[serde(flatten)]
    keys: Keys,
}

#[derive(Debug, Deserialize)]
struct File {
    target: String,
    path: String,
}

impl Package {
    /// The package that was committed with this version. Its manifest is read once; a test holds that it can be read.
    pub fn embedded() -> Self {
        static MANIFEST: OnceLock<Arc<Manifest>> = OnceLock::new();
        let read = || Manifest::read(sglow_shaders::MANIFEST.as_bytes()).unwrap_or_default();
        let manifest = Arc::clone(MANIFEST.get_or_init(|| Arc::new(read())));
        let texts = sglow_shaders::EMBEDDED.iter();
        let texts = texts.map(|variant| (variant.id.to_owned(), variant.text.to_owned()));
        Self { manifest, ..Self::generated("embedded in sglow-shaders", texts) }
    }

    /// A package that was generated into a folder: as `SHA256SUMS` seals it, which guards against damage and not against an
    /// attacker.
    ///
    /// # Errors
    ///
    /// All files that are missing or changed; a manifest that cannot be read, or does not fit the texts.
    pub fn load(folder: &Path) -> Result<Self, Vec<PackageError>> {
        let files = sglow_seal::open(folder);
        let mut files =
            files.map_err(|all| all.into_iter().map(PackageError::from).collect::<Vec<_>>())?;
        let path = folder.join(MANIFEST);
        let no_manifest = |reason| PackageError::Manifest { path: path.clone(), reason };
        let manifest = Manifest::read(files.get(MANIFEST).map_or(&[], Vec::as_slice));
        let manifest = manifest.map_err(|reason| vec![no_manifest(reason)])?;
        let (mut texts, mut errors) = (BTreeMap::new(), Vec::new());
        for (id, (parts, interface)) in &manifest.variants {
            let part = parts.iter().find(|part| part.target == "wgsl");
            // Taken, so that no two variants have one file.
            let text = part.and_then(|part| String::from_utf8(files.remove(&part.path)?).ok());
            let missing = || text.as_ref().and_then(|text| interface.missing(text));
            let missing =
                text.is_none().then(|| "WGSL file of its own".to_owned()).or_else(missing);
            let no_part = |what| no_manifest(format!("variant '{id}' has no {what}"));
            errors.extend(missing.map(no_part));
            texts.extend(text.map(|text| (id.clone(), text)));
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        let manifest = Arc::new(manifest);
        Ok(Self { manifest, ..Self::generated(folder.display().to_string(), texts) })
    }

    /// Variants that were generated in memory: `origin` says by what, each text goes with its identifier.
    pub fn generated(
        origin: impl Into<String>,
        texts: impl IntoIterator<Item = (String, String)>,
    ) -> Self {
        Self {
            origin: origin.into(),
            texts: Arc::new(texts.into_iter().collect()),
            manifest: Arc::default(),
            requested: Requested::default(),
        }
    }

    /// Adds what a manifest, as JSON, says of how variants are run: their bindings, and the frame.
    ///
    /// # Errors
    ///
    /// When it is no manifest.
    pub fn with_manifest(self, text: &str) -> Result<Self, PackageError> {
        let no_manifest =
            |reason| PackageError::Manifest { path: PathBuf::from(&self.origin), reason };
        let manifest = Arc::new(Manifest::read(text.as_bytes()).map_err(no_manifest)?);
        Ok(Self { manifest, ..self })
    }

    /// The frame; nothing if the package describes none.
    pub fn description(&self) -> Option<&Description> {
        self.manifest.description.as_ref()
    }

    /// What is known of a variant beside its text.
    ///
    /// # Errors
    ///
    /// When the manifest says nothing of it.
    pub fn interface(&self, id: &str) -> Result<&Interface, PackageError> {
        let reason = || format!("does not say what variant '{id}' binds");
        let missing = || PackageError::Manifest { path: (&self.origin).into(), reason: reason() };
        self.manifest.variants.get(id).map(|(_, interface)| interface).ok_or_else(missing)
    }

    /// Replaces the text of one variant: how a test runs a shader that is broken on purpose.
    pub fn with_text(mut self, id: &str, text: String) -> Self {
        Arc::make_mut(&mut self.texts).insert(id.to_owned(), text);
        self
    }

    /// The WGSL of a variant.
    ///
    /// # Errors
    ///
    /// A missing one, never a similar variant in its place.
    pub fn text(&self, id: &str) -> Result<&str, PackageError> {
        self.requested.set().insert(id.to_owned());
        self.texts.get(id).map(String::as_str).ok_or_else(|| {
            let pass = id.split('-').next();
            let similar = self.texts.keys().filter(|known| known.split('-').next() == pass);
            PackageError::Missing {
                id: id.to_owned(),
                origin: self.origin.clone(),
                similar: similar.cloned().collect(),
                left_out: self.manifest.reasons(id),
            }
        })
    }

    /// What was taken to be so of the scene that it was made for; nothing if it was made for any.
    pub fn assumed(&self) -> &[Assumption] {
        &self.manifest.made_for.assumed
    }

    /// Where it comes from.
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// The variants whose texts were requested, had or not, since it was made or cloned.
    pub fn requested_variants(&self) -> BTreeSet<String> {
        self.requested.set().clone()
    }

    /// The variants it has, sorted.
    pub fn variants(&self) -> impl Iterator<Item = &str> {
        self.texts.keys().map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_embedded_variant_says_what_it_binds() {
        let package = Package::embedded();
        for id in package.variants() {
            let bindings = &package.interface(id).unwrap().bindings;
            let known = sglow_shaders::bind_groups(id).unwrap();
            let known: Vec<_> = known.iter().copied().flatten().collect();
            let found: Vec<_> = bindings.iter().map(|binding| &binding.entry).collect();
            assert_eq!(found, known, "{id}");
        }
        // The frame is that of the manifest, and comes to something.
        let description = package.description().unwrap();
        let frame = description.evaluate(&sglow_graph::Configuration::default()).unwrap();
        assert!(!frame.steps.is_empty());
    }
}

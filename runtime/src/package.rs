//! Generated packages: the texts of variants, each checked against its hash before it is used.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use sglow_graph::Description;
use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::interface::{Interface, Keys, Shared};

/// Why a package or one of its variants cannot be used.
#[derive(Debug, Error)]
pub enum PackageError {
    /// A file of the package cannot be read.
    #[error("{}: {source}; a package is a folder that `cargo xtask gen-shaders --out DIR` wrote", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The manifest is not one.
    #[error("{}: {reason}; generate the package again with `cargo xtask gen-shaders`", path.display())]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A shader is not what the manifest says.
    #[error(
        "{}: was changed after it was generated (its SHA-256 is {found}, the manifest says {expected}); edit the sources and run `cargo xtask gen-shaders`",
        path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// Its hash.
        found: String,
        /// The manifest's.
        expected: String,
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
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Deserialize)]
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
    texts: BTreeMap<String, String>,
    /// What is known of variants beside their texts, and the frame; parts of the manifest.
    interfaces: Arc<BTreeMap<String, Interface>>,
    description: Option<Arc<Description>>,
    asked: Asked,
    assumed: Vec<Assumption>,
    left_out: Vec<LeftOut>,
    /// The value that was chosen on each axis; none where any was.
    chosen: BTreeMap<String, String>,
    /// The axes of each pass, in the order of the values in an identifier.
    axes: BTreeMap<String, Vec<String>>,
}

/// The variants that were asked for. A copy of a package was asked for none.
#[derive(Debug, Default)]
struct Asked(Mutex<BTreeSet<String>>);

impl Clone for Asked {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Asked {
    /// What a thread that panicked has left is as good as any.
    fn set(&self) -> MutexGuard<'_, BTreeSet<String>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What is read of a manifest.
#[derive(serde::Deserialize)]
struct Manifest {
    #[serde(default)]
    made_for: Option<MadeFor>,
    #[serde(default)]
    left_out: Vec<LeftOut>,
    #[serde(default)]
    passes: Vec<Pass>,
    #[serde(default)]
    graph: Option<Description>,
    shared: Shared,
    variants: Vec<Variant>,
}

impl Manifest {
    /// A manifest of the format that is read, or what is wrong with it.
    fn read(text: &[u8]) -> Result<Self, String> {
        #[derive(serde::Deserialize)]
        struct Version {
            schema_version: u32,
        }
        let wrong = |error: serde_json::Error| error.to_string();
        // First of all, for another format need not have anything else of this one.
        match serde_json::from_slice(text).map_err(wrong)? {
            Version { schema_version: SCHEMA_VERSION } => {}
            Version { schema_version } => {
                return Err(format!(
                    "is of format {schema_version}, and this version reads format {SCHEMA_VERSION}"
                ));
            }
        }
        serde_json::from_slice(text).map_err(wrong)
    }

    /// What is known of how variants run.
    fn described(self) -> Result<Described, String> {
        let Self { graph, shared, variants, .. } = self;
        let interfaces = variants.into_iter().map(|variant| variant.interface(&shared));
        Ok((Arc::new(interfaces.collect::<Result<_, _>>()?), graph.map(Arc::new)))
    }
}

#[derive(serde::Deserialize)]
struct MadeFor {
    assumed: Vec<Assumption>,
    chosen: BTreeMap<String, String>,
}

#[derive(serde::Deserialize)]
struct Pass {
    name: String,
    axes: Vec<String>,
}

/// What a rule left out of a package.
#[derive(Clone, Debug, serde::Deserialize)]
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
        let Self { rule, reason, variants, .. } = self;
        if !found.is_empty() {
            Some(format!("the rule '{rule}' left {} out: {reason}", found.join(", ")))
        } else {
            let named = variants.iter().any(|variant| variant == id);
            named.then(|| format!("the rule '{rule}' left it out: {reason}"))
        }
    }
}

/// The format of manifests that is read.
const SCHEMA_VERSION: u32 = 5;

#[derive(serde::Deserialize)]
struct Variant {
    id: String,
    #[serde(default)]
    files: Vec<File>,
    #[serde(flatten)]
    keys: Keys,
}

impl Variant {
    /// Its identifier, and what is known of it beside its text.
    fn interface(self, shared: &Shared) -> Result<(String, Interface), String> {
        let Self { id, keys, .. } = self;
        match shared.interface(keys) {
            Ok(interface) => Ok((id, interface)),
            Err(key) => Err(format!("variant '{id}' refers to '{key}', which `shared` lacks")),
        }
    }
}

#[derive(serde::Deserialize)]
struct File {
    target: String,
    path: String,
    sha256: String,
}

type Described = (Arc<BTreeMap<String, Interface>>, Option<Arc<Description>>);

/// What the committed manifest says, read once; a test holds that it can be read.
fn embedded() -> &'static Described {
    static EMBEDDED: OnceLock<Described> = OnceLock::new();
    EMBEDDED.get_or_init(|| {
        let manifest = Manifest::read(sglow_shaders::MANIFEST.as_bytes());
        manifest.and_then(Manifest::described).unwrap_or_default()
    })
}

fn sha256(bytes: &[u8]) -> String {
    base16ct::lower::encode_string(&Sha256::digest(bytes))
}

impl Package {
    /// The package that was committed with this version.
    pub fn embedded() -> Self {
        let texts = sglow_shaders::EMBEDDED
            .iter()
            .map(|variant| (variant.id.to_owned(), variant.text.to_owned()));
        let (interfaces, description) = embedded().clone();
        Self { interfaces, description, ..Self::generated("embedded in sglow-shaders", texts) }
    }

    /// A package that was generated into a folder. Every text is compared with its hash in the manifest.
    pub fn load(folder: &Path) -> Result<Self, Vec<PackageError>> {
        let path = folder.join("manifest.json");
        let read = |path: &Path| {
            std::fs::read(path)
                .map_err(|source| PackageError::Unreadable { path: path.to_owned(), source })
        };
        let no_manifest = |reason| PackageError::Manifest { path: path.clone(), reason };
        let manifest = read(&path)
            .and_then(|text| Manifest::read(&text).map_err(no_manifest))
            .map_err(|error| vec![error])?;
        let made_for = manifest.made_for.map(|made_for| (made_for.assumed, made_for.chosen));
        let (assumed, chosen) = made_for.unwrap_or_default();
        let left_out = manifest.left_out;
        let axes = manifest.passes.into_iter().map(|pass| (pass.name, pass.axes)).collect();
        let (mut texts, mut interfaces) = (BTreeMap::new(), BTreeMap::new());
        let mut errors = Vec::new();
        for mut variant in manifest.variants {
            let file = variant.files.extract_if(.., |file| file.target == "wgsl").next();
            let Some(file) = file else {
                errors.push(no_manifest(format!("variant '{}' has no WGSL file", variant.id)));
                continue;
            };
            let (id, interface) = match variant.interface(&manifest.shared) {
                Ok(known) => known,
                Err(reason) => {
                    errors.push(no_manifest(reason));
                    continue;
                }
            };
            let shader = folder.join(&file.path);
            match read(&shader).map(String::from_utf8) {
                Err(error) => errors.push(error),
                Ok(Err(_)) => {
                    errors.push(PackageError::Manifest {
                        path: shader,
                        reason: "is not UTF-8".to_owned(),
                    });
                }
                Ok(Ok(text)) => {
                    let found = sha256(text.as_bytes());
                    if found == file.sha256 {
                        texts.insert(id.clone(), text);
                        interfaces.insert(id, interface);
                    } else {
                        errors.push(PackageError::Changed {
                            path: shader,
                            found,
                            expected: file.sha256,
                        });
                    }
                }
            }
        }
        if errors.is_empty() {
            Ok(Self {
                interfaces: Arc::new(interfaces),
                description: manifest.graph.map(Arc::new),
                assumed,
                left_out,
                chosen,
                axes,
                ..Self::generated(folder.display().to_string(), texts)
            })
        } else {
            Err(errors)
        }
    }

    /// Variants that were generated in memory: `origin` says by what, each text goes with its identifier.
    pub fn generated(
        origin: impl Into<String>,
        texts: impl IntoIterator<Item = (String, String)>,
    ) -> Self {
        Self {
            origin: origin.into(),
            texts: texts.into_iter().collect(),
            interfaces: Arc::default(),
            description: None,
            asked: Asked::default(),
            assumed: Vec::new(),
            left_out: Vec::new(),
            chosen: BTreeMap::new(),
            axes: BTreeMap::new(),
        }
    }

    /// Adds what a manifest, as JSON, says of how variants are run: their bindings, and the frame.
    ///
    /// # Errors
    ///
    /// When it is no manifest.
    pub fn with_manifest(self, text: &str) -> Result<Self, PackageError> {
        let described = Manifest::read(text.as_bytes()).and_then(Manifest::described);
        let no_manifest =
            |reason| PackageError::Manifest { path: PathBuf::from(&self.origin), reason };
        let (interfaces, description) = described.map_err(no_manifest)?;
        Ok(Self { interfaces, description, ..self })
    }

    /// The frame; nothing if the package describes none.
    pub fn description(&self) -> Option<&Description> {
        self.description.as_deref()
    }

    /// What is known of a variant beside its text.
    pub fn interface(&self, id: &str) -> Option<&Interface> {
        self.interfaces.get(id)
    }

    /// Leaves some variants alone in it.
    pub fn only(mut self, ids: &BTreeSet<String>) -> Self {
        self.texts.retain(|id, _| ids.contains(id));
        self
    }

    /// Replaces the text of one variant: how a test runs a shader that is broken on purpose.
    pub fn with_text(mut self, id: &str, text: String) -> Self {
        self.texts.insert(id.to_owned(), text);
        self
    }

    /// The WGSL of a variant. A missing one is an error, never a similar variant.
    pub fn text(&self, id: &str) -> Result<&str, PackageError> {
        self.asked.set().insert(id.to_owned());
        self.texts.get(id).map(String::as_str).ok_or_else(|| {
            let pass = id.split('-').next().unwrap_or(id);
            PackageError::Missing {
                id: id.to_owned(),
                origin: self.origin.clone(),
                similar: self
                    .texts
                    .keys()
                    .filter(|known| known.split('-').next() == Some(pass))
                    .cloned()
                    .collect(),
                left_out: self.reasons(id),
            }
        })
    }

    /// Why a variant is missing: the rules that left it out, or what was chosen in its place.
    fn reasons(&self, id: &str) -> Vec<String> {
        let mut words = id.split('-');
        let axes = words.next().and_then(|pass| self.axes.get(pass)).map(Vec::as_slice);
        let axes = axes.unwrap_or_default();
        // What the identifier does not name is the default of an axis that is implied.
        let last = axes.last().zip(self.description.as_ref());
        let last = last.and_then(|(axis, of)| of.axes.get(axis)).filter(|axis| axis.implied);
        let words = words.chain(last.map(|axis| axis.default.as_str()));
        let values: Vec<_> = axes.iter().map(String::as_str).zip(words).collect();
        let rules = self.left_out.iter().filter_map(|left| left.explains(id, &values));
        let rules: Vec<_> = rules.collect();
        if !rules.is_empty() {
            return rules;
        }
        let chosen = |(axis, value): &(&str, &str)| {
            let chosen = self.chosen.get(*axis).filter(|chosen| chosen != value)?;
            Some(format!("the package was made with {axis} {chosen}"))
        };
        values.iter().filter_map(chosen).collect()
    }

    /// What was taken to be so of the scene that it was made for; nothing if it was made for any.
    pub fn assumed(&self) -> &[Assumption] {
        &self.assumed
    }

    /// Where it comes from.
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// The variants whose texts were asked for, had or not, since it was made or cloned.
    pub fn asked(&self) -> BTreeSet<String> {
        self.asked.set().clone()
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
            let interface = package.interface(id).unwrap();
            let known = sglow_shaders::bind_groups(id).unwrap();
            let bindings: usize = known.iter().map(|group| group.len()).sum();
            assert_eq!(interface.bindings.len(), bindings, "{id}");
            assert!(!interface.entry_points.is_empty(), "{id}");
        }
        // The frame is that of the manifest, and comes to something.
        let description = package.description().unwrap();
        let frame = description.evaluate(&sglow_graph::Configuration::default()).unwrap();
        assert!(!frame.steps.is_empty());
    }
}

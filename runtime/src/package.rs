//! Generated packages: the texts of variants, each checked against its hash before it is used.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use sha2::{Digest, Sha256};
use thiserror::Error;

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
    #[error("the package {origin} has no variant '{id}'{}", if similar.is_empty() { String::new() } else { format!("; of this pass it has: {}", similar.join(", ")) })]
    Missing {
        /// The variant.
        id: String,
        /// Where the package comes from.
        origin: String,
        /// The variants of the same pass.
        similar: Vec<String>,
    },
}

/// The shader texts of a package, by variant.
#[derive(Clone, Debug)]
pub struct Package {
    origin: String,
    texts: BTreeMap<String, String>,
    asked: Asked,
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

#[derive(serde::Deserialize)]
struct Manifest {
    variants: Vec<Variant>,
}

#[derive(serde::Deserialize)]
struct Variant {
    id: String,
    files: Vec<File>,
}

#[derive(serde::Deserialize)]
struct File {
    target: String,
    path: String,
    sha256: String,
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Package {
    /// The package that was committed with this version.
    pub fn embedded() -> Self {
        let texts = sglow_shaders::EMBEDDED
            .iter()
            .map(|variant| (variant.id.to_owned(), variant.text.to_owned()));
        Self::generated("embedded in sglow-shaders", texts)
    }

    /// A package that was generated into a folder. Every text is compared with its hash in the manifest.
    pub fn load(folder: &Path) -> Result<Self, Vec<PackageError>> {
        let path = folder.join("manifest.json");
        let read = |path: &Path| {
            std::fs::read(path)
                .map_err(|source| PackageError::Unreadable { path: path.to_owned(), source })
        };
        let manifest: Manifest = serde_json::from_slice(&read(&path).map_err(|error| vec![error])?)
            .map_err(|error| {
                vec![PackageError::Manifest { path: path.clone(), reason: error.to_string() }]
            })?;
        let mut texts = BTreeMap::new();
        let mut errors = Vec::new();
        for variant in manifest.variants {
            let Some(file) = variant.files.into_iter().find(|file| file.target == "wgsl") else {
                let reason = format!("variant '{}' has no WGSL file", variant.id);
                errors.push(PackageError::Manifest { path: path.clone(), reason });
                continue;
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
                        texts.insert(variant.id, text);
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
            Ok(Self::generated(folder.display().to_string(), texts))
        } else {
            Err(errors)
        }
    }

    /// Variants that were generated in memory: `origin` says by what, each text goes with its identifier.
    pub fn generated(
        origin: impl Into<String>,
        texts: impl IntoIterator<Item = (String, String)>,
    ) -> Self {
        Self { origin: origin.into(), texts: texts.into_iter().collect(), asked: Asked::default() }
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
            }
        })
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

//! What keeps a package from being written.

use std::fmt;
use std::path::PathBuf;

use sglow_seal::Fault;

use super::difference::{Change, Difference};
use crate::bindings;
use crate::emit::spirv;
use crate::error::Report;
use crate::manifest;

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
    #[error(transparent)]
    File(#[from] Fault),
    /// The folder has somebody else's files.
    #[error("{}: a package would replace files of this folder: {why}; name a new or empty one", path.display())]
    NotOurs {
        /// The folder.
        path: PathBuf,
        /// What it is instead of a package.
        why: String,
    },
    /// Another package than the committed one would take its place.
    #[error("{}: this would replace the committed package by another one; name another folder", path.display())]
    Committed {
        /// The folder.
        path: PathBuf,
    },
    /// The folder is not what would be written.
    #[error("the package is not what its sources make; {}:\n{}", advice(.0), lines(.0))]
    Differs(Vec<Difference>),
}

/// What mends differences.
fn advice(differences: &[Difference]) -> &'static str {
    let extra = |one: &&Difference| one.change == Change::Extra;
    match differences.iter().filter(extra).count() {
        0 => "run `cargo xtask gen-shaders`",
        count if count == differences.len() => "remove what is not part of it",
        _ => "remove what is not part of it and run `cargo xtask gen-shaders`",
    }
}

fn lines(items: &[impl fmt::Display]) -> String {
    items.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

//! What keeps a package from being written.

use std::fmt;
use std::io;
use std::path::PathBuf;

use super::difference::Difference;
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

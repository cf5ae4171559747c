//! What a package is made of, and how it is written.

use std::collections::BTreeSet;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use crate::functions::Functions;
use crate::library::Library;
use crate::manifest;
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

/// What variants were chosen for, and what was left out for that. It goes into the manifest unchanged.
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
    /// Folders that are laid over the library, in their order.
    pub over: Vec<PathBuf>,
    /// Languages beside WGSL, which is always written.
    pub targets: BTreeSet<Target>,
    /// The variants; those that the library's `[package]` table selects if absent.
    pub variants: Option<Vec<Variant>>,
    /// What the variants were chosen for; any input if absent.
    pub purpose: Option<Purpose>,
    /// What each variant is proved against to have lost nothing. A check proves against whole modules in any case.
    pub whole: Whole,
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
            over: Vec::new(),
            targets: BTreeSet::from([Target::Wgsl, Target::Rust]),
            variants: None,
            purpose: None,
            whole: Whole::default(),
            check: false,
            cache: None,
        }
    }
}

/// What a package is made of.
#[derive(Clone, Copy, Debug)]
pub struct Parts<'a> {
    /// The library.
    pub library: &'a Library,
    /// Its variants.
    pub variants: &'a [Validated],
    /// Its functions for hosts that bring their own passes.
    pub functions: Option<&'a Functions>,
    /// What changed in which version; the first version alone if absent.
    pub changelog: Option<&'a str>,
    /// Stands in the manifest for all of this.
    pub source_hash: &'a str,
    /// What the variants were chosen for; any input if absent.
    pub purpose: Option<&'a Purpose>,
}

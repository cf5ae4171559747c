//! What is to be compiled.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// What to compile, and for which GPUs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// The family of GPUs, as `RADV_FORCE_FAMILY` takes it: `navi21`, `vega10`.
    pub family: String,
    /// The compute shaders.
    pub shaders: Vec<Shader>,
}

/// A compute shader: an entry point of a SPIR-V module.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shader {
    /// The identifier of the variant.
    pub id: String,
    /// The name of the entry point.
    pub entry_point: String,
    /// The file of the module.
    pub path: PathBuf,
}

//! What a GPU's compiler makes of a shader: known where no GPU is.

use schemars::JsonSchema;
use serde::Serialize;

/// A compute shader as a compiler leaves it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct StaticCost {
    /// The variant.
    pub variant: String,
    /// The family of GPUs that it was compiled for.
    pub family: String,
    /// The driver with its version.
    pub driver: String,
    /// Number of instructions.
    pub instructions: u64,
    /// Issue cycles of the longest loop, once through; none without a loop.
    pub loop_issue_cycles: Option<u64>,
    /// Vector registers.
    pub vgprs: u64,
    /// Subgroups that a SIMD unit holds at once.
    pub subgroups_per_simd: u64,
}

//! What a module without SPIR-V lacks.

use naga::back::pipeline_constants::PipelineConstantError;
use naga::back::spv;
use rspirv::spirv::Op;

/// Why a module has no SPIR-V.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An override has no default, or its default does not fit.
    #[error("the overrides cannot be baked with their defaults: {0}")]
    Overrides(#[from] Box<PipelineConstantError>),
    /// naga refuses the module that it has made of a valid one.
    #[error("naga refuses the module after baking its overrides: {0}")]
    Baked(#[from] Box<naga::WithSpan<naga::valid::ValidationError>>),
    /// The back end cannot express the module.
    #[error("naga's SPIR-V back end: {0}")]
    BackEnd(#[from] spv::Error),
    /// naga's words could not be read back.
    #[error("naga's SPIR-V cannot be read back: {0}")]
    ReadBack(String),
    /// An instruction that copies workgroup memory in a way that is not known here.
    #[error(
        "{0:?} copies workgroup memory whose type also lies in a buffer; only OpLoad and OpStore are known to"
    )]
    Copy(Op),
}

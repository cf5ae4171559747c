//! Target languages: one module per language that a validated variant is written in.

pub mod spirv;
pub mod wgsl;

//! The image that kernels are drawn by.

#[expect(clippy::module_inception, reason = "one concept, one stem, as in the shaders")]
pub mod density;

pub use density::{bidirectional, power, reflectance};

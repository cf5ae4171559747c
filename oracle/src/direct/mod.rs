//! Light that arrives without a detour.

#[expect(clippy::module_inception, reason = "the reflection itself, as in the shaders")]
pub mod direct;
pub mod shadow;

pub use direct::direct;
pub use shadow::{Shadow, ShadowMap};

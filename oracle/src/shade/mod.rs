//! The reflection of virtual spherical Gaussian lights at a shading point.

pub mod diffuse;
pub mod disc;
pub mod emitter;
pub mod incoming;
pub mod quadratic;
#[expect(clippy::module_inception, reason = "the sum itself, as in the shaders")]
pub mod shade;
pub mod specular;
pub mod specular_error;

pub use diffuse::Diffuse;
pub use emitter::Emitter;
pub use incoming::{Incoming, incoming};
pub use shade::{Model, Reflected, shade, shade_visible, towards};
pub use specular::Specular;

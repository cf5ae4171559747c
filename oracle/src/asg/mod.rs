//! Anisotropic spherical Gaussians `max(w . z, 0) exp(-bx (w . x)^2 - by (w . y)^2)`.

pub mod convolution;
pub mod evaluate;
pub mod reflection;

pub use convolution::convolution;
pub use evaluate::{Asg, evaluate};
pub use reflection::{reflection, reflection_flat};

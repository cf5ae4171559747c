//! Spherical Gaussians `G(w) = exp(sharpness (w . axis - 1))`.

pub mod evaluate;
pub mod integral;
pub mod product;

pub use evaluate::evaluate;
pub use integral::integral;
pub use product::{Product, product, product_integral};

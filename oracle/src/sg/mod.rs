//! Spherical Gaussians `G(w) = exp(sharpness (w . axis - 1))`.

pub mod cosine;
pub mod cosine_bounds;
pub mod evaluate;
pub mod hemisphere;
pub mod identities;
pub mod integral;
pub mod literal;
pub mod product;

pub use cosine::Cosine;
pub use cosine_bounds::{lower_cosine_integral, odd_part_scaled, upper_cosine_integral};
pub use evaluate::evaluate;
pub use hemisphere::{hemisphere_integral, hemisphere_share};
pub use integral::integral;
pub use product::{Product, product, product_integral};

//! The reflection that the approximations are compared with: `R_d/pi + D V F`.

pub mod albedo;
pub mod beckmann;
pub mod fresnel;
pub mod ggx;
pub mod incidence;
pub mod material;
pub mod ndf_filtered;
pub mod ndf_filtered_2024;
pub mod reflection;

pub use material::{Directions, Material, Ndf};
pub use reflection::Reflection;

//! The additional reflective shadow map: moments and their mips.

pub mod mip;
pub mod moments;
pub mod weights;

pub use mip::{Pyramid, PyramidError};
pub use moments::{Emission, Lobes, Moments, SpecularPower, Variance, moments};
pub use weights::Weights;

//! The additional reflective shadow map: moments, density and their mips.

pub mod density;
pub mod mip;
pub mod moments;

pub use mip::{Pyramid, PyramidError};
pub use moments::{Lobes, Moments, moments};

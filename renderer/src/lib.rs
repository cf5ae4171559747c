//! Renders scenes with the generated packages.
//!
//! [`frame::Renderer`] puts a whole frame of a scene together: the light's map and the camera's G-buffer, direct light,
//! indirect light by [`sglow_runtime`], the composition. What judges it stands beside it: times ([`timing`]), read-back
//! ([`readback`]), single stages ([`stages`]) and, with the feature `reference`, its data as the oracle takes them.

pub mod check;
pub mod density;
pub mod device;
pub mod frame;
pub mod function;
pub mod host;
pub mod light;
pub mod limits;
pub mod mips;
pub mod needs;
pub mod plan;
pub mod raster;
pub mod readback;
#[cfg(feature = "reference")]
pub mod reference;
pub mod request;
pub mod stages;
pub mod timing;
pub mod variants;

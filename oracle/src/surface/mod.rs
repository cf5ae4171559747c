//! Surfaces as a map shows them.

pub mod raycast;
pub mod texel;

pub use raycast::{Camera, Hit, Ray, Triangle};
pub use texel::SurfaceTexel;

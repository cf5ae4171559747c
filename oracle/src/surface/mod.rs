//! Surfaces as a map shows them, and what rays meet.

pub mod raycast;
pub mod scene;
pub mod texel;

pub use raycast::{Camera, Hit, Ray, Triangle};
pub use scene::{Crossing, Facet, Scene, SceneError};
pub use texel::SurfaceTexel;

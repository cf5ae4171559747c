//! Lights and the photons that they send through their maps.

pub mod lights;
pub mod photon;
pub mod ray;

pub use lights::{FaceTexel, Lights};
pub use photon::{Light, LightKind, TILES};
pub use ray::MapPoint;

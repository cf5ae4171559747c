//! Lights and the photons that they send through their maps.

pub mod photon;

pub use photon::{Light, LightKind};

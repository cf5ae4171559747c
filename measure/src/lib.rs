//! Holds every function and the whole pipeline against the oracle, over every regime, and says what each costs.
//!
//! Error is three numbers. *Rounding*: the device's f32 against the oracle's f64, in ULP and as a share of what GPU
//! languages allow. *Conditioning*: the shader's own text on the CPU in f32, under every [`arithmetic`] a driver may
//! use, against the same f64. *Model*: the oracle against the reference.

pub mod bound;
pub mod cache;
pub mod curve;
pub mod cuts;
pub mod densities;
pub mod extreme;
pub mod frontier;
pub mod function;
pub mod functions;
pub mod halves;
pub mod hold;
pub mod input;
pub mod kernels;
pub mod light_maps;
pub mod mirror;
pub mod partitions;
pub mod picture;
pub mod references;
pub mod reproduce;
pub mod rivals;
pub mod saved;
pub mod specular;
pub mod stability;
pub mod tile_lists;
#[cfg(test)]
mod tokens;

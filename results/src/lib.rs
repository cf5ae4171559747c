//! Typed results of measurements, with their units: what a report of scenes, a stability run and a reproduction consist of,
//! and what follows from the numbers alone: ranks, choices, bounds. No device and no picture file.

pub mod arithmetic;
pub mod check;
pub mod cuts;
pub mod densities;
pub mod display;
pub mod error;
pub mod frontier;
pub mod kernels;
pub mod light_maps;
pub mod picture;
pub mod picture_error;
pub mod progress;
pub mod references;
pub mod reproduction;
pub mod rivals;
pub mod saved;
pub mod specular;
pub mod stability;
pub mod static_cost;
pub mod tile_lists;
pub mod time;

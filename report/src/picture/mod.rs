//! Pictures: layers in linear units, written losslessly or as a person sees them.

pub mod compare;
pub mod density;
pub mod exr;
pub mod false_colour;
mod file;
pub mod kernels;
pub mod png;
pub mod read;
pub mod reproduction;
pub mod tone;

pub use sglow_results::picture::{Image, Layer, Picture, luminance};

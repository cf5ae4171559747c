//! The image that kernels are drawn by.

pub mod density;

pub use density::{bidirectional, power, reflectance};

//! Results as text for a terminal.

pub mod choose;
pub mod compare;
pub mod densities;
pub mod frontier;
pub mod kernels;
pub mod nearest;
pub mod render;
pub mod reproduce;
pub mod stability;
pub mod variants;

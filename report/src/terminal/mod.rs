//! Results as text for a terminal.

pub mod choose;
pub mod densities;
pub mod frontier;
pub mod reproduce;
pub mod stability;

//! The methods that make virtual lights, side by side.

pub mod flicker;
pub mod method;
pub mod overlap;
pub mod stages;
pub mod survey;

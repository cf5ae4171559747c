//! The rivals of one method on its own pipeline: how evenly they share a density out, what each stage costs, how much
//! their pictures flicker.

pub mod flicker;
pub mod overlap;

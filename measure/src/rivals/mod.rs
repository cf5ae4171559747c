//! The rivals of one method on its own pipeline: how evenly they share a density out, what each stage costs, how much
//! their pictures flicker. What `reproduce` shows of [Tokuyoshi 2016].

pub mod flicker;
pub mod method;
pub mod overlap;
pub mod stages;
pub mod survey;

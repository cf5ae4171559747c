//! The stability run: functions and the whole pipeline against their bounds.

pub mod checks;
pub mod halves;
pub mod held;
pub mod quantity;
pub mod regime;
pub mod report;

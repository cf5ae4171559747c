//! Holds every function and the whole pipeline against the oracle, over every regime, and says what each costs.

pub mod arithmetic;
pub mod mirror;

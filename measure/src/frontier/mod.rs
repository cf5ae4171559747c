//! Error against time: every way to a scene's indirect light, which of them no other beats, and where more of a number
//! stops paying.

mod bench;
pub mod choose;
pub mod document;
pub mod judge;
mod prune;
pub mod rank;
pub mod scene;
pub mod subject;
mod sweep;
pub mod truth;
pub mod way;

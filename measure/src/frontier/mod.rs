//! Error against time: every way to a scene's indirect light, which of them no other beats, and where more of a number
//! stops paying.

mod bench;
pub mod buy;
pub mod evaluate;
mod measure;
pub mod named;
mod prune;
pub mod scene;
pub mod screen;
mod shadings;
mod shared;
mod straddling;
pub mod subject;
mod sweep;
mod together;
pub mod truth;
pub mod way;

pub use bench::RUNS;

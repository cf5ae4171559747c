//! Error against time: every configuration of a scene's indirect light, which of them no other dominates, and where
//! more of a number stops paying.

mod bench;
pub mod buy;
pub mod case;
pub mod configuration;
pub mod depends;
pub mod evaluate;
pub mod found;
mod lists;
mod measure;
pub mod named;
pub mod offer;
mod prune;
pub mod references;
pub mod scene;
pub mod screen;
pub mod screening;
mod shadings;
mod shared;
pub mod space;
mod straddling;
pub mod subject;
mod sweep;
mod together;

pub use bench::RUNS;

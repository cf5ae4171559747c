//! Static cost of compute shaders, as a real AMD compiler reports it on a machine without a GPU.
//!
//! Mesa's RADV offers a device without hardware: with `RADV_FORCE_FAMILY` it compiles for that family and runs nothing.
//! [`compile`] compiles compute shaders that way, in child processes, because the environment has to be set before the
//! driver is loaded and a driver may crash. [`compare`] compares two results.
//!
//! What the figures leave out: caches, bandwidth, divergence, and how often a loop runs.

mod assembly;
mod capability;
mod child;
mod compare;
mod cost;
mod device;
mod error;
mod here;
mod issue;
mod objects;
mod pipeline;
mod request;
mod spirv;
mod statistics;

pub use child::{Program, RADEON_ICD, compile, serve};
pub use compare::{Change, Comparison, Difference, Fault, Relation, compare};
pub use cost::{Compiler, Cost, Costs, Skipped};
pub use error::Error;
pub use here::compile_here;
pub use request::{Request, Shader};

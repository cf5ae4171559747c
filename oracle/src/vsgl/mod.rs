//! Virtual spherical Gaussian lights: one for every kernel.

pub mod packed;
pub mod sample;
#[expect(clippy::module_inception, reason = "the light itself, as in the shaders")]
pub mod vsgl;

pub use packed::PackedLobe;
pub use sample::{Kernel, Sample, Settings, Solver, sample};
pub use vsgl::{LEAST_WEIGHT, Lobe, Vsgl};

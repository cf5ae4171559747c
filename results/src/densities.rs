//! Densities that stress the sampling pass: what each kind of kernel makes of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Width and height of the densities.
pub const SIZE: u32 = 256;

/// Kernels on each.
pub const COUNT: u32 = 1024;

/// What one method makes of one density.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct OnDensity {
    /// Its name.
    pub density: String,
    /// The kernel.
    pub kernel: String,
    /// How its size is found.
    pub solver: String,
    /// Summed power of the lights over that of the photons.
    pub power_ratio: f64,
    /// Power of the brightest light times their number, over that of the photons: 1 is ideal.
    pub brightest: f64,
    /// Of the sampling pass.
    pub milliseconds: f64,
}

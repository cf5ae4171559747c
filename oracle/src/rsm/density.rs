//! The density that kernels are drawn by.

use crate::Real;
use crate::rsm::Moments;

/// The density of a texel: the weight of its moments.
pub fn density<R: Real>(moments: &Moments<R>) -> R {
    moments.weight()
}

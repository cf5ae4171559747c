//! How evenly a density is shared out among kernels or clusters.

use serde::Serialize;

/// How evenly a density is shared out among clusters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Overlap {
    /// The coefficient of variation of the density's integral within each: 0 is ideal.
    pub variation: f64,
    /// The largest integral times their number, of the whole: 1 is ideal.
    pub largest: f64,
    /// The sum of all integrals, of the whole: 1 where overlaps and gaps are in balance.
    pub covered: f64,
    /// The share of the density that lies in none: 0 is ideal.
    pub gaps: f64,
}

impl Overlap {
    /// Of integrals of the density, and of the whole.
    #[must_use]
    pub fn of(masses: &[f64], total: f64) -> Self {
        let count = masses.len().max(1) as f64;
        let sum: f64 = masses.iter().sum();
        let mean = sum / count;
        let variance = masses.iter().map(|mass| (mass - mean).powi(2)).sum::<f64>() / count;
        let over = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        Self {
            variation: over(variance.sqrt(), mean),
            largest: over(masses.iter().copied().fold(0.0, f64::max) * count, total),
            covered: over(sum, total),
            gaps: 0.0,
        }
    }
}

/// How evenly a density is shared out by the weights with which the filter sums texels, which reach beyond the nominal
/// square of 4^level texels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Weighted {
    /// The share of the density that is not counted: the mean of what each texel lacks of one; 0 is ideal.
    pub gaps: f64,
    /// The share of the density that is counted beyond once; 0 is ideal.
    pub excess: f64,
    /// Root mean square of how often a texel is counted, less one; 0 is ideal.
    pub variation: f64,
    /// The number of kernels that share a texel, in the mean; 1 is a partition.
    pub sharing: f64,
    /// The variance of a kernel over that of its nominal square, in the mean; 1 of a square.
    pub widening: f64,
}

impl Weighted {
    /// Of clusters, each of whose texels is in one of them.
    pub const PARTITION: Self =
        Self { gaps: 0.0, excess: 0.0, variation: 0.0, sharing: 1.0, widening: 1.0 };
}

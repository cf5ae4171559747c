//! Overlaps of kernels and gaps between them: how evenly the density is shared out.

use rayon::prelude::*;
use serde::Serialize;
use sglow_oracle::fis::{Coverage, Footprints, Spread};
use sglow_shaders::SglowKernel;

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

    /// Of filtering kernels: the squares of 4^level texels around their centres.
    #[must_use]
    pub fn of_kernels(texels: &[f32], size: usize, kernels: &[SglowKernel]) -> Self {
        let density = Footprints::new([size; 2], texels);
        let masses: Vec<f64> = kernels
            .iter()
            .map(|kernel| {
                let centre = kernel.centre.map(|part| f64::from(part) * size as f64);
                density.mass(centre, f64::from(kernel.level).exp2())
            })
            .collect();
        let gaps = gaps(texels, size, kernels);
        Self { gaps, ..Self::of(&masses, density.total()) }
    }

    /// Of clusters: `assigned` gives the cluster of every texel.
    #[must_use]
    pub fn of_clusters(density: &[f32], assigned: &[u32], count: usize) -> Self {
        let mut masses = vec![0.0; count];
        for (&weight, &cluster) in density.iter().zip(assigned) {
            if let Some(mass) = masses.get_mut(cluster as usize) {
                *mass += f64::from(weight);
            }
        }
        Self::of(&masses, density.iter().copied().map(f64::from).sum())
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

    /// Of filtering kernels, with how often they count each texel.
    #[must_use]
    pub fn of_kernels(texels: &[f32], size: usize, kernels: &[SglowKernel]) -> (Self, Coverage) {
        let spreads: Vec<(Spread, f64)> = kernels
            .par_iter()
            .map(|kernel| {
                let centre = kernel.centre.map(f64::from);
                let spread = Spread::trilinear(size, centre, f64::from(kernel.level));
                (spread, f64::from(kernel.scale))
            })
            .collect();
        let coverage = Coverage::of(size, spreads.iter().map(|(spread, scale)| (spread, *scale)));
        let even = coverage.evenness(texels);
        let wider = |((spread, _), kernel): (&(Spread, f64), &SglowKernel)| {
            spread.variance() * 12.0 / (2.0 * f64::from(kernel.level)).exp2()
        };
        let sum: f64 = spreads.iter().zip(kernels).map(wider).sum();
        let weighted = Self {
            gaps: even.gaps,
            excess: even.excess,
            variation: even.variation,
            sharing: even.sharing,
            widening: sum / kernels.len().max(1) as f64,
        };
        (weighted, coverage)
    }
}

/// The share of a density in texels whose centre no kernel's square covers. A kernel covers the texel of its own centre,
/// however small it is.
fn gaps(texels: &[f32], size: usize, kernels: &[SglowKernel]) -> f64 {
    // Counts of squares by their corners, to be summed up along both axes.
    let mut changes = vec![0_i32; (size + 1) * (size + 1)];
    for kernel in kernels {
        let half = 0.5 * f64::from(kernel.level).exp2();
        let span = |part: f32| {
            let centre = f64::from(part) * size as f64;
            let own = (centre.max(0.0) as usize).min(size - 1);
            let first = (centre - half - 0.5).ceil().max(0.0) as usize;
            let end = ((centre + half - 0.5).floor() + 1.0).clamp(0.0, size as f64) as usize;
            (first.min(own), end.max(own + 1))
        };
        let ((left, right), (top, bottom)) = (span(kernel.centre[0]), span(kernel.centre[1]));
        for (x, y, change) in
            [(left, top, 1), (right, top, -1), (left, bottom, -1), (right, bottom, 1)]
        {
            changes[y * (size + 1) + x] += change;
        }
    }
    let (mut missed, mut total) = (0.0, 0.0);
    let mut above = vec![0; size + 1];
    for y in 0..size {
        let mut row = 0;
        for x in 0..size {
            row += changes[y * (size + 1) + x];
            above[x] += row;
            let mass = texels.get(y * size + x).copied().map_or(0.0, f64::from);
            total += mass;
            missed += if above[x] > 0 { 0.0 } else { mass };
        }
    }
    if total > 0.0 { missed / total } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_what_no_square_covers() {
        let kernel = |x: f32, y: f32, level: f32| SglowKernel { centre: [x, y], level, scale: 1.0 };
        let texels =
            [1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 5.0];
        assert_eq!(gaps(&texels, 4, &[]), 1.0);
        assert_eq!(gaps(&texels, 4, &[kernel(0.5, 0.5, 2.0)]), 0.0);
        // The upper left quarter.
        assert_eq!(gaps(&texels, 4, &[kernel(0.25, 0.25, 1.0)]), 17.0 / 20.0);
        // One texel, though the kernel is far smaller; and a kernel that hangs over the edge.
        assert_eq!(gaps(&texels, 4, &[kernel(0.9, 0.1, -9.0)]), 16.0 / 20.0);
        assert_eq!(gaps(&texels, 4, &[kernel(1.0, 1.0, 1.0)]), 15.0 / 20.0);
        assert_eq!(gaps(&[0.0; 16], 4, &[]), 0.0);
    }

    #[test]
    fn a_kernel_s_weights_reach_beyond_its_square() {
        // Four kernels of 4 texels at the centres of the texels of level 1: each is that texel and no more.
        let kernel = |x: f32, y: f32, level: f32| SglowKernel { centre: [x, y], level, scale: 4.0 };
        let aligned = [0.25, 0.75].map(|y| [0.25, 0.75].map(|x| kernel(x, y, 1.0))).concat();
        let texels = [1.0; 16];
        let (found, coverage) = Weighted::of_kernels(&texels, 4, &aligned);
        assert!((found.widening - 1.0).abs() < 1e-12, "{found:?}");
        assert_eq!(Weighted { widening: 1.0, ..found }, Weighted::PARTITION);
        assert_eq!(coverage.counted(), [1.0; 16]);
        // One in the middle of all four: a quarter of each, so that it is four times as wide as its square.
        let (found, coverage) = Weighted::of_kernels(&texels, 4, &[kernel(0.5, 0.5, 1.0)]);
        assert_eq!(coverage.counted(), [0.25; 16]);
        assert!((found.widening - 4.0).abs() < 1e-12 && found.gaps == 0.75, "{found:?}");
        assert_eq!(gaps(&texels, 4, &[kernel(0.5, 0.5, 1.0)]), 0.75, "the nominal square");
        assert_eq!(Weighted::of_kernels(&[], 4, &[]).0.sharing, 0.0);
    }

    #[test]
    fn even_shares_do_not_vary_and_uneven_ones_do() {
        let even = Overlap::of(&[0.25; 4], 1.0);
        assert_eq!((even.variation, even.largest, even.covered), (0.0, 1.0, 1.0));
        let uneven = Overlap::of(&[1.0, 0.0, 0.0, 0.0], 1.0);
        assert!((uneven.variation - 3f64.sqrt()).abs() < 1e-12 && uneven.largest == 4.0);
        assert_eq!(
            Overlap::of(&[], 0.0),
            Overlap { variation: 0.0, largest: 0.0, covered: 0.0, gaps: 0.0 }
        );
        let clusters = Overlap::of_clusters(&[1.0, 1.0, 2.0], &[0, 0, 1], 2);
        assert_eq!((clusters.variation, clusters.covered), (0.0, 1.0));
    }
}

//! Overlaps of kernels and gaps between them: how evenly the density is shared out.

use serde::Serialize;
use sglow_oracle::fis::Footprints;
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
        }
    }

    /// Of filtering kernels: the squares of 4^level texels around their centres.
    #[must_use]
    pub fn of_kernels(density: &Footprints, size: usize, kernels: &[SglowKernel]) -> Self {
        let masses: Vec<f64> = kernels
            .iter()
            .map(|kernel| {
                let centre = kernel.centre.map(|part| f64::from(part) * size as f64);
                density.mass(centre, f64::from(kernel.level).exp2())
            })
            .collect();
        Self::of(&masses, density.total())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_shares_do_not_vary_and_uneven_ones_do() {
        let even = Overlap::of(&[0.25; 4], 1.0);
        assert_eq!((even.variation, even.largest, even.covered), (0.0, 1.0, 1.0));
        let uneven = Overlap::of(&[1.0, 0.0, 0.0, 0.0], 1.0);
        assert!((uneven.variation - 3f64.sqrt()).abs() < 1e-12 && uneven.largest == 4.0);
        assert_eq!(Overlap::of(&[], 0.0), Overlap { variation: 0.0, largest: 0.0, covered: 0.0 });
        let clusters = Overlap::of_clusters(&[1.0, 1.0, 2.0], &[0, 0, 1], 2);
        assert_eq!((clusters.variation, clusters.covered), (0.0, 1.0));
    }
}

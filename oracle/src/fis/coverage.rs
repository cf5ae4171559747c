//! How often kernels count each texel: overlaps and gaps by the weights that a filter has.

use crate::fis::Spread;

/// What some kernels together make of each texel of a map. A kernel of scale c and weights w takes c w of a texel's power;
/// where these shares add up to one for every texel, the kernels are a partition of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// Sum of the shares, for each texel, row by row from the top: 1 where the texel's power counts once.
    counted: Vec<f64>,
    /// Sum of the squares of the shares.
    squares: Vec<f64>,
}

/// How evenly a density is counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evenness {
    /// The share of the density that is not counted: the mean of what each texel lacks of one. 0 is ideal.
    pub gaps: f64,
    /// The share of the density that is counted beyond once: the mean of what each texel has above one. 0 is ideal.
    pub excess: f64,
    /// Root mean square of how often a texel is counted, less one. 0 is ideal.
    pub variation: f64,
    /// The number of kernels that share a texel: one over the sum of the squares of the fractions of its counted power
    /// that they take, in the mean. 1 is a partition.
    pub sharing: f64,
}

impl Coverage {
    /// Of kernels, each with its scale: how many texels' power it holds.
    #[must_use]
    pub fn of<'a>(size: usize, kernels: impl IntoIterator<Item = (&'a Spread, f64)>) -> Self {
        let (mut counted, mut squares) = (vec![0.0; size * size], vec![0.0; size * size]);
        for (spread, scale) in kernels {
            let patch = spread.patch();
            let [left, top] = patch.corner;
            for (row, weights) in patch.weights.chunks(patch.size[0].max(1)).enumerate() {
                let first = (top + row) * size + left;
                for (at, weight) in weights.iter().enumerate() {
                    let share = scale * weight;
                    counted[first + at] += share;
                    squares[first + at] += share * share;
                }
            }
        }
        Self { counted, squares }
    }

    /// How often each texel is counted, row by row from the top.
    #[must_use]
    pub fn counted(&self) -> &[f64] {
        &self.counted
    }

    /// How evenly a density on the same texels is counted; nothing of a density without mass.
    #[must_use]
    pub fn evenness(&self, density: &[f32]) -> Evenness {
        let mass = || density.iter().map(|&mass| f64::from(mass)).zip(&self.counted);
        let total: f64 = mass().map(|(mass, _)| mass).sum();
        let mean = |value: &dyn Fn(f64) -> f64| {
            let sum: f64 = mass().map(|(mass, &counted)| mass * value(counted)).sum();
            if total > 0.0 { sum / total } else { 0.0 }
        };
        // Of texels that no kernel reaches nobody shares anything.
        let shared = mass().zip(&self.squares).filter(|(_, squares)| **squares > 0.0);
        let (shared, reached) =
            shared.fold((0.0, 0.0), |(sum, reached), ((mass, counted), squares)| {
                (sum + mass * counted * counted / squares, reached + mass)
            });
        Evenness {
            gaps: mean(&|counted| (1.0 - counted).max(0.0)),
            excess: mean(&|counted| (counted - 1.0).max(0.0)),
            variation: mean(&|counted| (counted - 1.0).powi(2)).sqrt(),
            sharing: if reached > 0.0 { shared / reached } else { 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::stress::Stress;
    use crate::fis::{Square, bracketed_level, lattice, modified_factor, trilinear, warp};

    #[test]
    fn a_partition_counts_each_texel_once_and_shares_none() {
        let square = |x: usize, y: usize| {
            Spread::of_squares(8, [Square { level: 1, at: [x, y], weight: 1.0 }])
        };
        let kernels: Vec<Spread> = (0..16).map(|at| square(at % 4, at / 4)).collect();
        let density: Vec<f32> = (0..64).map(|at| at as f32).collect();
        let even = Coverage::of(8, kernels.iter().map(|one| (one, 4.0))).evenness(&density);
        assert_eq!((even.gaps, even.excess, even.variation, even.sharing), (0.0, 0.0, 0.0, 1.0));
        // Negative control: one is missing, one is there twice.
        let twice = kernels[..15].iter().chain(&kernels[..1]).map(|one| (one, 4.0));
        let uneven = Coverage::of(8, twice).evenness(&density);
        let last = 4.0 * (54.0 + 55.0 + 62.0 + 63.0) / 4.0 / 2016.0;
        let first = (0.0 + 1.0 + 8.0 + 9.0) / 2016.0;
        assert!((uneven.gaps - last).abs() < 1e-12 && (uneven.excess - first).abs() < 1e-12);
        assert!((uneven.sharing - (first * 2.0 + 1.0 - first - last) / (1.0 - last)).abs() < 1e-12);
        assert_eq!(Coverage::of(8, []).evenness(&density).gaps, 1.0);
        assert_eq!(Coverage::of(8, []).evenness(&[0.0; 64]).gaps, 0.0);
    }

    /// Eq. (5) divides by the density within the kernel, so that the kernels hold the whole density at any K; larger
    /// ones share it more evenly and among more of them.
    #[test]
    fn modified_kernels_count_the_density_once_in_the_mean() {
        let density = Stress::Noise { sigma: 1.0 }.pyramid(64, 5).unwrap();
        let texels: Vec<f32> = density.level(0).iter().map(|&one| one as f32).collect();
        let evenness = |scale: f64| {
            let kernels: Vec<(Spread, f64)> = (0..256)
                .map(|index| {
                    let warped = warp(&density, lattice::point(index, 256));
                    let level = bracketed_level(&density, warped.centre, warped.texel, 256, scale);
                    let level = level.level.level;
                    let filtered = trilinear(&density, warped.centre, level);
                    let factor = modified_factor(filtered, density.top(), 64 * 64, 256);
                    (Spread::trilinear(64, warped.centre, level), factor)
                })
                .collect();
            Coverage::of(64, kernels.iter().map(|(spread, scale)| (spread, *scale)))
                .evenness(&texels)
        };
        let found = [0.25, 1.0, 4.0].map(evenness);
        for one in found {
            assert!((one.gaps - one.excess).abs() < 1e-6, "{one:?}");
        }
        for pair in found.windows(2) {
            assert!(pair[1].gaps < pair[0].gaps && pair[1].sharing > 1.5 * pair[0].sharing);
        }
    }
}

//! Overlaps of kernels and gaps between them: how evenly the density is shared out.

use serde::Serialize;
use sglow_shaders::SglowKernel;

/// Sums of a density over rectangles of any place and size.
#[derive(Clone, Debug)]
pub struct SummedArea {
    /// One more than the width.
    stride: usize,
    rows: usize,
    /// Sums of all texels above and to the left.
    sums: Vec<f64>,
}

impl SummedArea {
    /// Of an image, row by row from the top; what is missing of the last row counts as 0.
    #[must_use]
    pub fn new(texels: &[f32], width: usize) -> Self {
        let (stride, rows) = (width + 1, texels.len().div_ceil(width.max(1)));
        let mut sums = vec![0.0; stride * (rows + 1)];
        for y in 0..rows {
            let mut row = 0.0;
            for x in 0..width {
                row += texels.get(y * width + x).copied().map_or(0.0, f64::from);
                sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + row;
            }
        }
        Self { stride, rows, sums }
    }

    /// The sum over all texels.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// The sum above and to the left of a point in texels; bilinear within a texel, which is exact, for a texel's value
    /// is the same all over it.
    fn corner(&self, x: f64, y: f64) -> f64 {
        let place = |at: f64, last: usize| {
            let at = at.clamp(0.0, last as f64);
            let low = (at.floor() as usize).min(last.saturating_sub(1));
            (low, at - low as f64)
        };
        let ((x, right), (y, down)) = (place(x, self.stride - 1), place(y, self.rows));
        let row = |y: usize| {
            let at = y * self.stride + x;
            self.sums[at] * (1.0 - right) + self.sums[at + 1] * right
        };
        row(y) * (1.0 - down) + row(y + 1) * down
    }

    /// The sum over a square of a centre and a side in texels, as far as it lies within the image.
    #[must_use]
    pub fn square(&self, [x, y]: [f64; 2], side: f64) -> f64 {
        if self.rows == 0 || self.stride < 2 {
            return 0.0;
        }
        let (left, right, top, bottom) =
            (x - 0.5 * side, x + 0.5 * side, y - 0.5 * side, y + 0.5 * side);
        let sum = self.corner(right, bottom) - self.corner(left, bottom) - self.corner(right, top)
            + self.corner(left, top);
        sum.max(0.0)
    }
}

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
    pub fn of_kernels(density: &SummedArea, size: usize, kernels: &[SglowKernel]) -> Self {
        let masses: Vec<f64> = kernels
            .iter()
            .map(|kernel| {
                let centre = kernel.centre.map(|part| f64::from(part) * size as f64);
                density.square(centre, f64::from(kernel.level).exp2())
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
    fn squares_of_any_place_are_summed_exactly() {
        let texels: Vec<f32> = (0..35).map(|index| (index * index % 11) as f32).collect();
        let area = SummedArea::new(&texels, 7);
        let slow = |[x, y]: [f64; 2], side: f64| {
            let overlap = |low: f64, texel: usize| {
                ((low + side).min(texel as f64 + 1.0) - low.max(texel as f64)).max(0.0)
            };
            let mut sum = 0.0;
            for (index, &texel) in texels.iter().enumerate() {
                let share = overlap(x - 0.5 * side, index % 7) * overlap(y - 0.5 * side, index / 7);
                sum += f64::from(texel) * share;
            }
            sum
        };
        for centre in [[3.5, 2.5], [0.1, 4.9], [6.99, 0.0], [-3.0, 2.0], [20.0, 2.0]] {
            for side in [0.3, 1.0, 2.7, 40.0] {
                let difference = area.square(centre, side) - slow(centre, side);
                assert!(difference.abs() < 1e-9, "{centre:?}, {side}: {difference}");
            }
        }
        assert!((area.square([3.5, 2.5], 40.0) - area.total()).abs() < 1e-9);
        assert_eq!(SummedArea::new(&[], 7).square([1.0, 1.0], 1.0), 0.0);
    }

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

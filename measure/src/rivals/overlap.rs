//! Overlaps of kernels and gaps between them: how evenly the density is shared out.

use rayon::prelude::*;
use sglow_oracle::fis::{Coverage, Footprints, Spread};
use sglow_results::rivals::overlap::{Overlap, Weighted};
use sglow_shaders::SglowKernel;

/// Of filtering kernels: the squares of 4^level texels around their centres.
#[must_use]
pub fn of_kernels(texels: &[f32], size: usize, kernels: &[SglowKernel]) -> Overlap {
    let density = Footprints::new([size; 2], texels);
    let masses: Vec<f64> = kernels
        .iter()
        .map(|kernel| {
            let centre = kernel.centre.map(|part| f64::from(part) * size as f64);
            density.mass(centre, f64::from(kernel.level).exp2())
        })
        .collect();
    let gaps = gaps(texels, size, kernels);
    Overlap { gaps, ..Overlap::of(&masses, density.total()) }
}

/// Of clusters: `assigned` gives the cluster of every texel.
#[must_use]
pub fn of_clusters(density: &[f32], assigned: &[u32], count: usize) -> Overlap {
    let mut masses = vec![0.0; count];
    for (&weight, &cluster) in density.iter().zip(assigned) {
        if let Some(mass) = masses.get_mut(cluster as usize) {
            *mass += f64::from(weight);
        }
    }
    Overlap::of(&masses, density.iter().copied().map(f64::from).sum())
}

/// Of filtering kernels, with how often they count each texel.
#[must_use]
pub fn weighted(texels: &[f32], size: usize, kernels: &[SglowKernel]) -> (Weighted, Coverage) {
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
    let weighted = Weighted {
        gaps: even.gaps,
        excess: even.excess,
        variation: even.variation,
        sharing: even.sharing,
        widening: sum / kernels.len().max(1) as f64,
    };
    (weighted, coverage)
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
        let (found, coverage) = weighted(&texels, 4, &aligned);
        assert!((found.widening - 1.0).abs() < 1e-12, "{found:?}");
        assert_eq!(Weighted { widening: 1.0, ..found }, Weighted::PARTITION);
        assert_eq!(coverage.counted(), [1.0; 16]);
        // One in the middle of all four: a quarter of each, so that it is four times as wide as its square.
        let (found, coverage) = weighted(&texels, 4, &[kernel(0.5, 0.5, 1.0)]);
        assert_eq!(coverage.counted(), [0.25; 16]);
        assert!((found.widening - 4.0).abs() < 1e-12 && found.gaps == 0.75, "{found:?}");
        assert_eq!(gaps(&texels, 4, &[kernel(0.5, 0.5, 1.0)]), 0.75, "the nominal square");
        assert_eq!(weighted(&[], 4, &[]).0.sharing, 0.0);
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
        let clusters = of_clusters(&[1.0, 1.0, 2.0], &[0, 0, 1], 2);
        assert_eq!((clusters.variation, clusters.covered), (0.0, 1.0));
    }
}

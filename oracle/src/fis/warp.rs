//! Hierarchical sample warping: from the unit square to the density.

use crate::Real;
use crate::rsm::Pyramid;

/// Where a point of the unit square lands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warped<R = f64> {
    /// The kernel's centre in the image, 0 to 1; row 0 is at the small end of the second coordinate.
    pub centre: [R; 2],
    /// The texel of level 0 that holds the centre.
    pub texel: [usize; 2],
    /// The smallest distance of a coordinate to the fraction that it was split by: of all decisions on the way.
    pub margin: f64,
    /// Whether rounding cannot have changed a decision; always so with `f64`.
    pub certain: bool,
}

/// Warps a point of the unit square by a density at least 0.
///
/// From the top level down, the 2 x 2 children are split first between the columns by the first coordinate, then
/// between the rows of that column by the second; what remains of each coordinate is stretched to the unit interval.
/// Where there is no mass the interval is halved.
// [Clarberg 2005, Section 4.2]
pub fn warp<R: Real>(density: &Pyramid<R>, point: [R; 2]) -> Warped<R> {
    let mut texel = [0, 0];
    let mut rest = point;
    let mut margin = f64::INFINITY;
    let mut certain = true;
    let mut split = |coordinate: R, first: R, second: R| -> (usize, R) {
        // Where one side has all the mass there is nothing to decide, even for a coordinate that was rounded up to 1.
        match (first.value() > 0.0, second.value() > 0.0) {
            (true, false) => return (0, coordinate),
            (false, true) => return (1, coordinate),
            _ => {}
        }
        let total = first + second;
        let fraction = if total.value() > 0.0 { first / total } else { R::constant(0.5) };
        let distance = coordinate - fraction;
        margin = margin.min(distance.value().abs());
        certain &= distance.sign_is_certain() || distance.error() == 0.0;
        if distance.value() < 0.0 {
            (0, coordinate / fraction)
        } else {
            (1, distance / (R::one() - fraction))
        }
    };
    for level in (0..density.top_level()).rev() {
        let child = |x: usize, y: usize| density.at(level, 2 * texel[0] + x, 2 * texel[1] + y);
        let (column, x) = split(rest[0], child(0, 0) + child(0, 1), child(1, 0) + child(1, 1));
        let (row, y) = split(rest[1], child(column, 0), child(column, 1));
        texel = [2 * texel[0] + column, 2 * texel[1] + row];
        rest = [x, y];
    }
    let size = R::constant(density.size() as f64);
    let centre = [0, 1].map(|axis| (R::constant(texel[axis] as f64) + rest[axis]) / size);
    Warped { centre, texel, margin, certain }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;
    use crate::fis::lattice;
    use crate::fis::stress::Stress;

    fn counts(density: &Pyramid<f64>, count: u32, transpose: bool) -> Vec<f64> {
        let size = density.size();
        let mut counts = vec![0.0; size * size];
        for index in 0..count {
            let [x, y] = warp(density, lattice::point(index, count)).texel;
            counts[if transpose { x * size + y } else { y * size + x }] += 1.0;
        }
        counts
    }

    #[test]
    fn points_are_distributed_by_the_density() {
        let density = Stress::Noise { sigma: 1.0 }.pyramid(16, 3).unwrap();
        let total: f64 = density.level(0).iter().sum();
        let count = 1 << 16;
        let worst = |counts: &[f64]| {
            let pairs = counts.iter().zip(density.level(0));
            pairs
                .map(|(found, mass)| (found - mass / total * f64::from(count)).abs())
                .fold(0.0, f64::max)
        };
        // A texel is a rectangle of the unit square; the lattice's discrepancy is O(log N) points.
        let found = worst(&counts(&density, count, false));
        assert!(found < 8.0, "{found}");
        // Negative control: rows taken for columns.
        assert!(worst(&counts(&density, count, true)) > 100.0);
    }

    #[test]
    fn no_mass_means_no_texel() {
        let density =
            Pyramid::build(4, (0..16).map(|index| f64::from(u8::from(index == 9))).collect())
                .unwrap();
        for index in 0..64 {
            let warped = warp(&density, lattice::point::<f64>(index, 64));
            assert_eq!(warped.texel, [1, 2]);
            assert!(warped.centre[0] >= 0.25 && warped.centre[0] < 0.5);
        }
        // Without any mass the square is kept.
        let nothing = Pyramid::build(4, vec![0.0; 16]).unwrap();
        assert_eq!(warp(&nothing, [0.3, 0.9]).centre, [0.3, 0.9]);
    }

    #[test]
    fn doubtful_decisions_are_named() {
        let texels = vec![Bounded::exact(0.1); 4];
        let density = Pyramid::build(2, texels).unwrap();
        let warped = warp(&density, [Bounded::constant(0.3), Bounded::constant(0.7)]);
        assert!(warped.certain && (warped.margin - 0.2).abs() < 1e-6);
        let warped = warp(&density, [Bounded::constant(0.5 + 1e-8), Bounded::constant(0.7)]);
        assert!(!warped.certain);
    }
}

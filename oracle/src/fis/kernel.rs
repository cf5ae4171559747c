//! How large a filtering kernel is: its mip level.

use core::f64::consts::LN_2;

use crate::Real;
use crate::fis::trilinear;
use crate::rsm::Pyramid;

/// A kernel's mip level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level<R = f64> {
    /// The level, 0 to the top level.
    pub level: R,
    /// The smallest relative distance between the two sides of a comparison on the way; infinite where none was made.
    pub margin: f64,
    /// The interval that the level is in whatever rounding did; a point where every comparison was certain.
    pub certain: [f64; 2],
}

/// The level from the density at the kernel's centre: `4^l/M = min(K/(N p), 1)`.
///
/// `density` is that of the texel that the warp ended in, `top` that of the top level, so that `p = density/top`;
/// without density the kernel is the whole image.
// [Tokuyoshi 2016, Eq. (1)]
pub fn previous_level<R: Real>(
    density: R,
    top: R,
    texels: usize,
    count: u32,
    scale: f64,
) -> Level<R> {
    let highest = (texels as f64).log2() / 2.0;
    let level = if density.value() > 0.0 {
        let area = R::constant(scale) * top / (R::constant(f64::from(count)) * density);
        (area * R::constant(texels as f64)).log2() * R::constant(0.5)
    } else {
        R::constant(highest)
    };
    let level = level.clamp(0.0, highest);
    let certain = [level.value() - level.error(), level.value() + level.error()];
    Level { level, margin: f64::INFINITY, certain }
}

/// What the filtered value is multiplied with to give the kernel's total: `M/max(N p, 1)`.
// [Tokuyoshi 2016, Eq. (4)]; M because moments hold the power of a texel
pub fn previous_factor<R: Real>(density: R, top: R, texels: usize, count: u32) -> R {
    let expected =
        if top.value() > 0.0 { R::constant(f64::from(count)) * density / top } else { R::zero() };
    R::constant(texels as f64) / expected.max(R::one())
}

/// The level from the density's integral within the kernel, by bisection.
// [Tokuyoshi 2016, Eq. (3), Algorithm 1]
pub fn modified_level<R: Real>(
    density: &Pyramid<R>,
    centre: [R; 2],
    count: u32,
    scale: f64,
    iterations: u32,
) -> Level<R> {
    let (mut low, mut high) = (0.0, density.top_level() as f64);
    let mut certain = [low, high];
    let mut all_certain = true;
    let mut margin = f64::INFINITY;
    let target = R::constant(scale) / R::constant(f64::from(count));
    for _ in 0..iterations {
        // Exact in f32: a dyadic fraction.
        let level = 0.5 * (low + high);
        let difference = kernel_mass(density, centre, R::constant(level)) - target;
        margin = margin.min(difference.value().abs() / target.value());
        all_certain &= difference.sign_is_certain() || difference.error() == 0.0;
        if difference.value() < 0.0 {
            low = level;
        } else {
            high = level;
        }
        if all_certain {
            certain = [low, high];
        }
    }
    let level = 0.5 * (low + high);
    if all_certain {
        certain = [level; 2];
    }
    Level { level: R::constant(level), margin, certain }
}

/// The integral of p within the kernel of a level: `4^l/M p(l)`; the left side of Eq. (3).
// [Tokuyoshi 2016, Eq. (3)]
pub fn kernel_mass<R: Real>(density: &Pyramid<R>, centre: [R; 2], level: R) -> R {
    let top = density.top();
    if top.value() <= 0.0 {
        return R::zero();
    }
    let area = (R::constant(2.0) * level).exp2() / R::constant(density.texel_count() as f64);
    area * (trilinear(density, centre, level) / top)
}

/// What the filtered value is multiplied with to give the kernel's total: `M d_top/(N d(l))`; 0 without density.
// [Tokuyoshi 2016, Eq. (5)]; M because moments hold the power of a texel
pub fn modified_factor<R: Real>(filtered: R, top: R, texels: usize, count: u32) -> R {
    if filtered.value() > 0.0 {
        R::constant(texels as f64) * top / (R::constant(f64::from(count)) * filtered)
    } else {
        R::zero()
    }
}

/// The solutions of Eq. (3), ascending.
///
/// Between two levels the left side is `4^l (a + b l)`, which has at most one extremum; the pieces on both sides of it
/// are monotone and hold at most one solution each. So none is missed.
#[must_use]
pub fn all_roots(density: &Pyramid<f64>, centre: [f64; 2], count: u32, scale: f64) -> Vec<f64> {
    let target = scale / f64::from(count);
    let excess = |level: f64| kernel_mass(density, centre, level) - target;
    let mut roots = Vec::new();
    for (low, high) in monotone_pieces(density, centre) {
        let (at_low, at_high) = (excess(low), excess(high));
        if at_low == 0.0 {
            roots.push(low);
        } else if at_low * at_high < 0.0 {
            let (mut a, mut b) = (low, high);
            while b - a > 4.0 * f64::EPSILON * b.max(1.0) {
                let middle = 0.5 * (a + b);
                if excess(middle) * at_low > 0.0 { a = middle } else { b = middle }
            }
            roots.push(0.5 * (a + b));
        }
    }
    let top = density.top_level() as f64;
    if excess(top) == 0.0 {
        roots.push(top);
    }
    roots
}

/// Whether the left side of Eq. (3) nowhere decreases with the level.
#[must_use]
pub fn is_monotone(density: &Pyramid<f64>, centre: [f64; 2]) -> bool {
    let mass = |level: f64| kernel_mass(density, centre, level);
    monotone_pieces(density, centre)
        .iter()
        .all(|&(low, high)| mass(low) <= mass(high) * (1.0 + 1e-12))
}

/// The levels cut into intervals on which the left side of Eq. (3) is monotone.
fn monotone_pieces(density: &Pyramid<f64>, centre: [f64; 2]) -> Vec<(f64, f64)> {
    let mut pieces = Vec::new();
    for level in 0..density.top_level() {
        let low = level as f64;
        let at = trilinear(density, centre, low);
        let rise = trilinear(density, centre, low + 1.0) - at;
        // d/dt of 4^t (at + rise t) vanishes.
        let extremum = -at / rise - 1.0 / (2.0 * LN_2);
        if extremum > 0.0 && extremum < 1.0 {
            pieces.push((low, low + extremum));
            pieces.push((low + extremum, low + 1.0));
        } else {
            pieces.push((low, low + 1.0));
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;
    use crate::fis::stress::Stress;
    use crate::fis::{lattice, warp};

    #[test]
    fn the_previous_level_solves_its_equation() {
        // p = 2, N = 16, M = 4096: 4^l = 4096/32.
        let level = previous_level(2.0, 1.0, 4096, 16, 1.0).level;
        assert!((level - 3.5).abs() < 1e-14);
        assert!((previous_level(2.0, 1.0, 4096, 16, 4.0).level - 4.5).abs() < 1e-14);
        assert_eq!(previous_level(0.0, 0.0, 4096, 16, 1.0).level, 6.0);
        assert_eq!(previous_level(1e9, 1.0, 4096, 16, 1.0).level, 0.0);
        // The factor is the kernel's area in texels.
        assert!((previous_factor(2.0, 1.0, 4096, 16) - 4f64.powf(3.5)).abs() < 1e-10);
        assert_eq!(previous_factor(0.0, 0.0, 4096, 16), 4096.0);
    }

    #[test]
    fn the_modified_level_solves_its_equation_where_there_is_one_solution() {
        let density = Stress::Smooth.pyramid(64, 0).unwrap();
        for index in 0..64 {
            let centre = warp(&density, lattice::point(index, 64)).centre;
            let roots = all_roots(&density, centre, 64, 1.0);
            assert_eq!(roots.len(), 1);
            assert!((kernel_mass(&density, centre, roots[0]) * 64.0 - 1.0).abs() < 1e-12);
            let step = 6.0 / f64::from(1 << 12);
            let level = modified_level(&density, centre, 64, 1.0, 12).level;
            assert!((level - roots[0]).abs() <= step);
            // Negative control: one bisection is not enough.
            assert!((modified_level(&density, centre, 64, 1.0, 1).level - roots[0]).abs() > step);
        }
    }

    #[test]
    fn all_roots_are_found_where_there_are_several() {
        let density = Stress::Noise { sigma: 3.0 }.pyramid(64, 1).unwrap();
        let mut several = 0;
        for index in 0..64 {
            let centre = warp(&density, lattice::point(index, 64)).centre;
            let roots = all_roots(&density, centre, 64, 1.0);
            assert!(roots.is_sorted());
            // A scan sees the same number of changes of sign.
            let signs = (0..=60_000)
                .map(|step| kernel_mass(&density, centre, f64::from(step) * 1e-4) * 64.0 > 1.0);
            let signs: Vec<bool> = signs.collect();
            let changes = signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
            assert_eq!(changes, roots.len());
            several += usize::from(roots.len() > 1);
        }
        assert!(several > 5, "{several}");
    }

    #[test]
    fn doubtful_comparisons_leave_an_interval() {
        let density = Pyramid::build(4, vec![Bounded::exact(0.7); 16]).unwrap();
        let centre = [Bounded::exact(0.3), Bounded::exact(0.6)];
        // N = 4: the solution is exactly level 1, the first thing tried.
        let level = modified_level(&density, centre, 4, 1.0, 12);
        assert_eq!(level.certain, [0.0, 2.0]);
        assert!(level.margin < 1e-12);
        let level = modified_level(&density, centre, 5, 1.0, 4);
        assert_eq!(level.certain, [level.level.value; 2]);
    }
}

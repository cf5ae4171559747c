//! Holes in a map of points, filled from coarser levels.

use crate::Real;

/// The weighted mean of those numbers that are no holes; a hole of nothing but holes.
fn mean<R: Real>(numbers: impl IntoIterator<Item = (f64, R)>) -> R {
    let (mut sum, mut total) = (R::zero(), 0.0);
    for (weight, number) in numbers {
        if number.value() > 0.0 {
            sum = sum + number * R::constant(weight);
            total += weight;
        }
    }
    if total > 0.0 { sum / R::constant(total) } else { R::zero() }
}

/// A square tile whose holes, texels of 0, are filled from `levels` coarser levels: each is the mean of what is no hole
/// in the level below; then, from the coarsest down, holes get the bilinear mean of what is no hole above them.
// [Marroquim 2007, Section 4], without their test of depths; [Ritschel 2008, Section 3.3]
#[must_use]
pub fn fill<R: Real>(tile: &[R], size: usize, levels: usize) -> Vec<R> {
    if levels == 0 || size < 2 {
        return tile.to_vec();
    }
    let half = size / 2;
    let at = |texels: &[R], size: usize, x: usize, y: usize| texels[y * size + x];
    let coarse: Vec<R> = (0..half * half)
        .map(|index| {
            let (x, y) = (2 * (index % half), 2 * (index / half));
            let children = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
            mean(children.map(|(x, y)| (1.0, at(tile, size, x, y))))
        })
        .collect();
    let coarse = fill(&coarse, half, levels - 1);
    let side = |at: usize| {
        let own = at / 2;
        let other = if at % 2 == 1 { (own + 1).min(half - 1) } else { own.saturating_sub(1) };
        [(0.75, own), (0.25, other)]
    };
    let from_coarse = |x: usize, y: usize| {
        let pairs = side(y).into_iter().flat_map(|(down, y)| {
            side(x).into_iter().map(move |(across, x)| (16.0 * across * down, x, y))
        });
        mean(pairs.map(|(weight, x, y)| (weight, at(&coarse, half, x, y))))
    };
    tile.iter()
        .enumerate()
        .map(
            |(index, &texel)| {
                if texel.value() > 0.0 { texel } else { from_coarse(index % size, index / size) }
            },
        )
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;
    use crate::fis::stress::Random;

    fn plane(x: usize, y: usize) -> f64 {
        0.5 + 0.01 * x as f64 - 0.003 * y as f64
    }

    #[test]
    fn holes_in_a_plane_are_filled_by_the_plane() {
        let mut random = Random::new(2);
        let whole: Vec<f64> = (0..256).map(|index| plane(index % 16, index / 16)).collect();
        let holed: Vec<f64> =
            whole.iter().map(|&value| if random.uniform() < 0.5 { value } else { 0.0 }).collect();
        let filled = fill(&holed, 16, 3);
        for (index, (filled, whole)) in filled.iter().zip(&whole).enumerate() {
            assert!(*filled > 0.0);
            // A mean of texels at most two steps away on either axis.
            assert!((filled - whole).abs() < 2.0 * 0.013, "{index}: {filled} {whole}");
        }
        // With every second texel, where the means lie evenly, the plane is met but for the border.
        let checker: Vec<f64> = whole
            .iter()
            .enumerate()
            .map(|(index, &value)| if (index + index / 16).is_multiple_of(2) { value } else { 0.0 })
            .collect();
        let filled = fill(&checker, 16, 3);
        for y in 2..14 {
            for x in 2..14 {
                assert!((filled[y * 16 + x] - plane(x, y)).abs() < 1e-12, "{x} {y}");
            }
        }
        // Negative control: holes that count as far away.
        let careless = |numbers: [f64; 4]| numbers.iter().sum::<f64>() / 4.0;
        assert!(careless([0.5, 0.0, 0.0, 0.5]) < 0.3 && mean([(1.0, 0.5), (1.0, 0.0)]) == 0.5);
    }

    #[test]
    fn levels_bound_how_large_a_hole_is_filled() {
        let mut tile = vec![0.0; 64];
        tile[0] = 0.7;
        let filled = |levels| fill(&tile, 8, levels).iter().filter(|texel| **texel > 0.0).count();
        assert_eq!([0, 1, 2, 3].map(filled), [1, 9, 49, 64]);
        assert!(fill(&[0.0; 64], 8, 3).iter().all(|texel| *texel == 0.0));
        assert!(fill(&tile, 8, 3).iter().all(|texel| *texel == 0.0 || (texel - 0.7).abs() < 1e-12));
    }

    #[test]
    fn tolerances_are_useful() {
        let mut tile = vec![Bounded::zero(); 64];
        for index in [3, 17, 40] {
            tile[index] = Bounded::exact(0.3 + 0.01 * index as f32);
        }
        for texel in fill(&tile, 8, 3) {
            assert!(texel.value > 0.0 && texel.error < 1e-5 * texel.value, "{texel:?}");
        }
    }
}

//! Filtering between texels and between mip levels, by the weights that a pyramid is sampled by.

use crate::rsm::Pyramid;
use crate::{Linear, Real};

/// The two neighbours that a coordinate lies between, and how far towards the second, 0 to 1.
#[derive(Clone, Copy)]
struct Between<R> {
    low: usize,
    high: usize,
    fraction: R,
}

/// The neighbours of a coordinate on the integers 0 to `last`, first those of its value, then those that rounding may
/// choose in their stead. Neighbours beyond an end are the end.
fn between<R: Real>(coordinate: R, last: usize) -> impl Iterator<Item = Between<R>> + Clone {
    let own = coordinate.value().floor();
    let reach = coordinate.error();
    let lower = (coordinate.value() - reach < own).then_some(own - 1.0);
    let upper = (coordinate.value() + reach >= own + 1.0).then_some(own + 1.0);
    [Some(own), lower, upper].into_iter().flatten().map(move |floor| Between {
        low: floor.clamp(0.0, last as f64) as usize,
        high: (floor + 1.0).clamp(0.0, last as f64) as usize,
        fraction: (coordinate - R::constant(floor)).clamp(0.0, 1.0),
    })
}

fn blend<R: Real, T: Linear<R>>(low: T, high: T, fraction: R) -> T {
    low.scaled(R::one() - fraction).plus(high.scaled(fraction))
}

/// Joins the results of all choices that rounding leaves; the first one's value stands.
fn joined<R, T: Linear<R>>(choices: impl Iterator<Item = T>) -> T {
    choices.reduce(T::covering).unwrap_or_else(T::nothing)
}

/// The bilinear value of a level at a position 0 to 1, clamped to the edge, by the pyramid's weights.
pub fn bilinear<R: Real, T: Linear<R> + Send + Sync>(
    pyramid: &Pyramid<T>,
    position: [R; 2],
    level: usize,
) -> T {
    let size = pyramid.size_at(level);
    let coordinate = |axis: usize| position[axis] * R::constant(size as f64) - R::constant(0.5);
    let columns = between(coordinate(0), size - 1);
    let rows = between(coordinate(1), size - 1);
    let weight = |of: Between<R>| pyramid.weights().of_texels(of.fraction);
    joined(rows.flat_map(|row| {
        columns.clone().map(move |column| {
            let line = |y: usize| {
                blend(
                    pyramid.at(level, column.low, y),
                    pyramid.at(level, column.high, y),
                    weight(column),
                )
            };
            blend(line(row.low), line(row.high), weight(row))
        })
    }))
}

/// The value at a position 0 to 1 and a level, which is clamped to those that exist: bilinear in the two levels
/// around, linear between them, by the pyramid's weights.
pub fn trilinear<R: Real, T: Linear<R> + Send + Sync>(
    pyramid: &Pyramid<T>,
    position: [R; 2],
    level: R,
) -> T {
    let top = pyramid.top_level();
    let level = level.clamp(0.0, top as f64);
    joined(between(level, top).map(|levels| {
        let low = bilinear(pyramid, position, levels.low);
        if levels.low == levels.high {
            return low;
        }
        let weight = pyramid.weights().of_levels(levels.fraction);
        blend(low, bilinear(pyramid, position, levels.high), weight)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;
    use crate::fis::stress::Random;
    use crate::rsm::Weights;

    fn pyramid() -> Pyramid<f64> {
        Pyramid::build(8, (0..64).map(|index| f64::from(index * index % 29)).collect()).unwrap()
    }

    #[test]
    fn gives_texels_at_their_centres_and_means_between() {
        let pyramid = pyramid();
        for level in 0..4 {
            let size = pyramid.size_at(level);
            let centre = |index: usize| (index as f64 + 0.5) / size as f64;
            let (x, y) = (size - 1, size / 2);
            let found = trilinear(&pyramid, [centre(x), centre(y)], level as f64);
            assert!((found - pyramid.at(level, x, y)).abs() < 1e-12);
        }
        let middle = trilinear(&pyramid, [0.25, 0.0625], 0.0);
        assert!((middle - 0.5 * (pyramid.at(0, 1, 0) + pyramid.at(0, 2, 0))).abs() < 1e-12);
        let between_levels = trilinear(&pyramid, [0.3, 0.4], 1.25);
        let expected =
            0.75 * bilinear(&pyramid, [0.3, 0.4], 1) + 0.25 * bilinear(&pyramid, [0.3, 0.4], 2);
        assert!((between_levels - expected).abs() < 1e-12);
        // Negative control: one level off.
        assert!((trilinear(&pyramid, [0.3, 0.4], 2.25) - expected).abs() > 0.1);
    }

    #[test]
    fn clamps_to_the_edge_and_to_the_levels() {
        let pyramid = pyramid();
        assert_eq!(trilinear(&pyramid, [0.0, 0.0], -3.0), pyramid.at(0, 0, 0));
        assert_eq!(trilinear(&pyramid, [0.7, 0.1], 9.0), pyramid.top());
    }

    #[test]
    fn the_tolerance_spans_a_kink() {
        // At a texel's centre the slope changes; the tolerance has to know of the steeper side.
        let texels =
            [0.0_f32, 0.0, 1000.0, 0.0].into_iter().cycle().take(16).map(Bounded::exact).collect();
        let pyramid = Pyramid::build(4, texels).unwrap();
        let at = |x: f64| {
            trilinear(
                &pyramid,
                [Bounded::with_error(x, 1e-3), Bounded::exact(0.125)],
                Bounded::zero(),
            )
        };
        // x of texel 1's centre is 0.375: flat to the left, rising by 1000 per quarter to the right.
        let below = at(0.3745);
        assert!(below.value.abs() < 1e-9 && below.error >= 1.9, "{below:?}");
        assert!(at(0.3).error < 1e-6);
    }

    /// A weight of b bits is off by 2^-(b+1) at most, and each blend by that times the difference of what it blends.
    #[test]
    fn weights_of_few_bits_are_off_by_as_much_as_they_may() {
        let exact = pyramid();
        let fixed =
            |bits: u32| pyramid().sampled_by(Weights::Fixed { texel_bits: bits, mip_bits: bits });
        let worst = |bits: u32, promised: u32| {
            let (fixed, off) = (fixed(bits), 0.5 * f64::from(promised).exp2().recip());
            let mut random = Random::new(5);
            let mut share = 0.0_f64;
            for _ in 0..20_000 {
                let position = [random.uniform(), random.uniform()];
                let level = 2.0 * random.uniform();
                // Texels are 0 to 28: in each level two blends along x and one along y, then one between the levels.
                let spread = |level: usize| {
                    let texels = exact.level(level);
                    texels.iter().fold(0.0, |most: f64, &a| most.max(a))
                        - texels.iter().fold(f64::INFINITY, |least: f64, &a| least.min(a))
                };
                let low = level as usize;
                let within = 2.0 * spread(low).max(spread(low + 1));
                let between = spread(low).max(spread(low + 1));
                let error =
                    (trilinear(&fixed, position, level) - trilinear(&exact, position, level)).abs();
                share = share.max(error / (off * (within + between)));
            }
            share
        };
        let eight = worst(8, 8);
        println!("8 bits: {eight:.3} of what they may be off by");
        assert!(eight <= 1.0 && eight > 0.2, "{eight}");
        // Negative control: 6 bits are off by more than 8 bits may be.
        assert!(worst(6, 8) > 1.0);
        // With as many bits as an f32 has the weights are exact, and with 52 all the more.
        assert!(worst(23, 23) <= 1.0);
        let at = |bits: u32| trilinear(&fixed(bits), [0.303, 0.411], 1.27);
        let expected = trilinear(&exact, [0.303, 0.411], 1.27);
        assert!((at(23) - expected).abs() < 1e-5 && (at(52) - expected).abs() < 1e-13);
        assert!((at(8) - expected).abs() > 1e-4);
    }
}

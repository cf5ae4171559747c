//! Which texels a kernel sums, and with which weights: what a filter of mips comes to on level 0.
//!
//! A texel of level l is the mean of a square of 4^l texels, so that every filter of mips is a sum over squares that are
//! aligned to the texels of their levels. A kernel is wider than its size says: bilinear filtering spreads each of these
//! squares over its neighbours.

use crate::Linear;
use crate::rsm::Pyramid;

/// An aligned square of 4^level texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Square {
    /// Its level.
    pub level: usize,
    /// Its column and row on that level.
    pub at: [usize; 2],
    /// The weight of all its texels together.
    pub weight: f64,
}

/// The weights of a filter; they add up to one.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Width and height of level 0.
    size: usize,
    squares: Vec<Square>,
}

/// Weights of a rectangle of texels of level 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// The first column and row.
    pub corner: [usize; 2],
    /// Columns and rows.
    pub size: [usize; 2],
    /// Row by row.
    pub weights: Vec<f64>,
}

impl Spread {
    /// Of squares of a map of `size` texels, a power of two, in each direction; those without weight are left out.
    #[must_use]
    pub fn of_squares(size: usize, squares: impl IntoIterator<Item = Square>) -> Self {
        Self { size, squares: squares.into_iter().filter(|one| one.weight != 0.0).collect() }
    }

    /// Bilinear in the two levels around `level`, linear between them, at a position 0 to 1, clamped to the edge:
    /// [`trilinear`](crate::fis::trilinear) with exact weights.
    #[must_use]
    pub fn trilinear(size: usize, position: [f64; 2], level: f64) -> Self {
        let top = size.max(1).ilog2() as usize;
        let level = level.clamp(0.0, top as f64);
        let (low, fraction) = (level.floor() as usize, level.fract());
        let levels = [(low, 1.0 - fraction), ((low + 1).min(top), fraction)];
        let squares = levels.into_iter().flat_map(|(level, share)| {
            let side = size >> level;
            let [columns, rows] = position.map(|part| neighbours(part, side));
            rows.into_iter().flat_map(move |(y, down)| {
                columns.into_iter().map(move |(x, across)| Square {
                    level,
                    at: [x, y],
                    weight: share * across * down,
                })
            })
        });
        Self::of_squares(size, squares)
    }

    /// The squares.
    #[must_use]
    pub fn squares(&self) -> &[Square] {
        &self.squares
    }

    /// The filtered value of a pyramid of the same size.
    #[must_use]
    pub fn of<T: Linear<f64> + Send + Sync>(&self, pyramid: &Pyramid<T>) -> T {
        self.squares.iter().fold(T::nothing(), |sum, square| {
            let [x, y] = square.at;
            sum.plus(pyramid.at(square.level, x, y).scaled(square.weight))
        })
    }

    /// The weight of each texel of level 0, in the smallest rectangle that holds all of them.
    #[must_use]
    pub fn patch(&self) -> Patch {
        let spans = |axis: usize| self.squares.iter().map(move |one| span(one, axis));
        let bounds = |axis: usize| {
            let first = spans(axis).map(|span| span[0]).min().unwrap_or(0);
            let end = spans(axis).map(|span| span[1]).max().unwrap_or(0);
            [first, end]
        };
        let [[left, right], [top, bottom]] = [bounds(0), bounds(1)];
        let (width, height) = (right - left, bottom - top);
        let mut weights = vec![0.0; width * height];
        for square in &self.squares {
            let share = square.weight / 4f64.powi(square.level as i32);
            let ([x0, x1], [y0, y1]) = (span(square, 0), span(square, 1));
            for y in y0..y1 {
                let row = (y - top) * width;
                for weight in &mut weights[row + x0 - left..row + x1 - left] {
                    *weight += share;
                }
            }
        }
        Patch { corner: [left, top], size: [width, height], weights }
    }

    /// The variance of the weights about their own mean, in texels of level 0 squared, the mean of both axes. A texel
    /// counts as the square that it is: a square of side s has s^2/12.
    #[must_use]
    pub fn variance(&self) -> f64 {
        let moment = |power: i32, axis: usize| -> f64 {
            self.squares
                .iter()
                .map(|one| {
                    let [first, end] = span(one, axis).map(|at| at as f64);
                    let (centre, side) = (0.5 * (first + end), end - first);
                    let own = if power == 2 { side * side / 12.0 } else { 0.0 };
                    one.weight * (centre.powi(power) + own)
                })
                .sum()
        };
        let along = |axis: usize| moment(2, axis) - moment(1, axis).powi(2);
        0.5 * (along(0) + along(1))
    }

    /// Width and height of level 0.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }
}

/// The first texel of level 0 of a square along an axis, and the one after its last.
fn span(square: &Square, axis: usize) -> [usize; 2] {
    [square.at[axis] << square.level, (square.at[axis] + 1) << square.level]
}

/// The two texels of `side` that a position 0 to 1 lies between, with their weights.
fn neighbours(position: f64, side: usize) -> [(usize, f64); 2] {
    let coordinate = position * side as f64 - 0.5;
    let fraction = coordinate - coordinate.floor();
    let texel = |at: f64| at.clamp(0.0, (side - 1) as f64) as usize;
    [(texel(coordinate.floor()), 1.0 - fraction), (texel(coordinate.floor() + 1.0), fraction)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::stress::Random;
    use crate::fis::trilinear;

    /// The mean over positions of the variance over that of the square of 4^level texels.
    fn widening(level: f64, spread: impl Fn([f64; 2], f64) -> Spread) -> f64 {
        let mut random = Random::new(7);
        let count = 4000;
        let sum: f64 = (0..count)
            // Far from the edge, which cuts kernels off.
            .map(|_| [0.3 + 0.4 * random.uniform(), 0.3 + 0.4 * random.uniform()])
            .map(|position| spread(position, level).variance())
            .sum();
        sum / f64::from(count) / (4f64.powf(level) / 12.0)
    }

    /// A box of side s blurred by a tent of half width s has s^2/12 + s^2/6: 3 times the box. Half way between two
    /// levels half of each adds up to 5/8 s^2, and the square has s^2/6: 3.75.
    #[test]
    fn a_trilinear_kernel_is_three_times_as_wide_as_its_square() {
        let trilinear = |position, level| Spread::trilinear(1024, position, level);
        for level in [1.0, 2.0, 4.0] {
            let found = widening(level, trilinear);
            assert!((found - 3.0).abs() < 0.05, "{level}: {found}");
        }
        for level in [1.5, 3.5] {
            let found = widening(level, trilinear);
            assert!((found - 3.75).abs() < 0.06, "{level}: {found}");
        }
        // Negative control: the aligned square that holds the position has no more than its own.
        let aligned = |position: [f64; 2], level: f64| {
            let side = 1024 >> level as usize;
            let at = position.map(|part| (part * side as f64) as usize);
            Spread::of_squares(1024, [Square { level: level as usize, at, weight: 1.0 }])
        };
        assert!((widening(3.0, aligned) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn its_weights_are_the_filter_s() {
        let mut random = Random::new(3);
        let texels: Vec<f64> = (0..1024).map(|_| random.uniform()).collect();
        let pyramid = Pyramid::build(32, texels.clone()).unwrap();
        let mut noticed = 0;
        for _ in 0..500 {
            let position = [random.uniform(), random.uniform()];
            let level = 6.0 * random.uniform() - 0.5;
            let expected = trilinear(&pyramid, position, level);
            let spread = Spread::trilinear(32, position, level);
            assert!((spread.of(&pyramid) - expected).abs() < 1e-12);
            // The same by its weights on the texels alone.
            let patch = spread.patch();
            let by_texels = |shift: usize| -> f64 {
                let weights = patch.weights.iter().enumerate();
                weights
                    .map(|(at, weight)| {
                        let x = patch.corner[0] + (at + shift) % patch.size[0];
                        let y = patch.corner[1] + at / patch.size[0];
                        weight * texels[y * 32 + x]
                    })
                    .sum()
            };
            assert!((by_texels(0) - expected).abs() < 1e-12);
            assert!((patch.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            // Negative control: a column aside.
            noticed += usize::from((by_texels(1) - expected).abs() > 1e-4);
        }
        assert!(noticed > 300, "{noticed}");
    }
}

//! Mip levels: means of 2 x 2 texels.

use rayon::prelude::*;
use thiserror::Error;

use crate::rsm::Weights;
use crate::{Linear, Real};

/// An image and its mip levels, and what it is sampled by.
#[derive(Clone, Debug, PartialEq)]
pub struct Pyramid<T> {
    levels: Vec<Vec<T>>,
    size: usize,
    weights: Weights,
}

/// Why an image has no mip levels here.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum PyramidError {
    /// Only squares of a power of two divide evenly.
    #[error("the image's size is {0}; it has to be a power of two")]
    NotPowerOfTwo(usize),
    /// The texels are not those of a square.
    #[error("the image has {found} texels; a square of size {size} has {}", size * size)]
    WrongCount {
        /// The size requested.
        size: usize,
        /// The texels given.
        found: usize,
    },
}

impl<T: Copy + Send + Sync> Pyramid<T> {
    /// The levels of a square image, level 0 row by row from the top.
    ///
    /// # Errors
    /// If the size is not a power of two or not the image's.
    pub fn build<R: Real>(size: usize, texels: Vec<T>) -> Result<Self, PyramidError>
    where
        T: Linear<R>,
    {
        Self::build_stored(size, texels, |texel| texel)
    }

    /// The levels of an image where each texel is as `stored` leaves it, such as rounded to a format.
    ///
    /// # Errors
    /// If the size is not a power of two or not the image's.
    pub fn build_stored<R: Real>(
        size: usize,
        texels: Vec<T>,
        stored: impl Fn(T) -> T + Sync,
    ) -> Result<Self, PyramidError>
    where
        T: Linear<R>,
    {
        if !size.is_power_of_two() {
            return Err(PyramidError::NotPowerOfTwo(size));
        }
        if texels.len() != size * size {
            return Err(PyramidError::WrongCount { size, found: texels.len() });
        }
        let mut levels = vec![texels.into_iter().map(&stored).collect::<Vec<_>>()];
        let mut finer_size = size;
        while finer_size > 1 {
            let finer = &levels[levels.len() - 1];
            let coarser_size = finer_size / 2;
            let coarser = (0..coarser_size * coarser_size)
                .into_par_iter()
                .map(|index| {
                    stored(mean(finer, finer_size, index % coarser_size, index / coarser_size))
                })
                .collect();
            levels.push(coarser);
            finer_size = coarser_size;
        }
        Ok(Self { levels, size, weights: Weights::Exact })
    }

    /// From levels that were made elsewhere, such as read back from a GPU; finest first.
    ///
    /// # Errors
    /// If a level's size is not half that of the level before, or the first one's not a power of two.
    pub fn of_levels(size: usize, levels: Vec<Vec<T>>) -> Result<Self, PyramidError> {
        if !size.is_power_of_two() {
            return Err(PyramidError::NotPowerOfTwo(size));
        }
        for level in 0..=size.ilog2() as usize {
            let (side, found) = (size >> level, levels.get(level).map_or(0, Vec::len));
            if found != side * side {
                return Err(PyramidError::WrongCount { size: side, found });
            }
        }
        Ok(Self { levels, size, weights: Weights::Exact })
    }

    /// The same, sampled by other weights than exact ones: all that filters it then does so.
    #[must_use]
    pub fn sampled_by(self, weights: Weights) -> Self {
        Self { weights, ..self }
    }

    /// The weights that it is sampled by.
    #[must_use]
    pub fn weights(&self) -> Weights {
        self.weights
    }
    /// Width and height of level 0.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }
    /// Width and height of a level.
    #[must_use]
    pub fn size_at(&self, level: usize) -> usize {
        self.size >> level
    }
    /// The number of texels of level 0, M.
    #[must_use]
    pub fn texel_count(&self) -> usize {
        self.size * self.size
    }
    /// The number of the coarsest level, which has one texel.
    #[must_use]
    pub fn top_level(&self) -> usize {
        self.levels.len() - 1
    }
    /// The one texel of the coarsest level.
    #[must_use]
    pub fn top(&self) -> T {
        self.levels[self.top_level()][0]
    }
    /// A texel of a level.
    #[must_use]
    pub fn at(&self, level: usize, x: usize, y: usize) -> T {
        self.levels[level][y * self.size_at(level) + x]
    }
    /// The texels of a level, row by row from the top.
    #[must_use]
    pub fn level(&self, level: usize) -> &[T] {
        &self.levels[level]
    }
}

/// The mean of the 2 x 2 texels under a texel of the next level.
pub fn mean<R: Real, T: Linear<R>>(finer: &[T], finer_size: usize, x: usize, y: usize) -> T {
    let first = 2 * y * finer_size + 2 * x;
    let upper = finer[first].plus(finer[first + 1]);
    let lower = finer[first + finer_size].plus(finer[first + finer_size + 1]);
    upper.plus(lower).scaled(R::constant(0.25))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;

    #[test]
    fn every_level_keeps_the_mean() {
        let texels: Vec<f64> = (0..64).map(|index| f64::from(index * index % 37)).collect();
        let expected = texels.iter().sum::<f64>() / 64.0;
        let pyramid = Pyramid::build(8, texels).unwrap();
        assert_eq!(pyramid.top_level(), 3);
        for level in 0..4 {
            let texels = pyramid.level(level);
            assert!((texels.iter().sum::<f64>() / texels.len() as f64 - expected).abs() < 1e-13);
        }
        assert_eq!(pyramid.top(), expected);
        // The orientation: level 1's texel (1, 0) holds columns 2 and 3 of rows 0 and 1.
        let texel = |x: usize, y: usize| pyramid.at(0, x, y);
        assert_eq!(
            pyramid.at(1, 1, 0),
            (texel(2, 0) + texel(3, 0) + texel(2, 1) + texel(3, 1)) / 4.0
        );
        assert_ne!(pyramid.at(1, 1, 0), pyramid.at(1, 0, 1));
    }

    #[test]
    fn an_f32_mip_is_within_the_tolerance_and_a_shifted_one_is_not() {
        let texels: Vec<f32> = (0..16).map(|index| 1.0 / (1.0 + index as f32)).collect();
        let pyramid =
            Pyramid::build(4, texels.iter().copied().map(Bounded::exact).collect()).unwrap();
        let mean = |x: usize, y: usize| {
            0.25 * (texels[4 * y + x]
                + texels[4 * y + x + 1]
                + texels[4 * y + x + 4]
                + texels[4 * y + x + 5])
        };
        assert!(pyramid.at(1, 1, 0).admits(mean(2, 0)));
        assert!(!pyramid.at(1, 1, 0).admits(mean(1, 0)));
    }

    #[test]
    fn other_sizes_are_errors() {
        assert_eq!(Pyramid::<f64>::build(3, vec![0.0; 9]), Err(PyramidError::NotPowerOfTwo(3)));
        let wrong = Pyramid::<f64>::build(4, vec![0.0; 9]).unwrap_err();
        assert_eq!(wrong.to_string(), "the image has 9 texels; a square of size 4 has 16");
        assert!(Pyramid::of_levels(2, vec![vec![0.0; 4], vec![0.0; 2]]).is_err());
    }
}

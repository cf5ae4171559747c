//! Which reference is the better one of a frame: the one that is more certain of itself.

use sglow_oracle::estimate::{Estimate, Uncertainty};

/// A reference with visibility.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Paths of one bounce: see [`super::paths`].
    Paths,
    /// Every texel of the light's map, and what hides it: see [`super::points()`].
    Points,
}

/// The better reference and what it was chosen by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// The one whose own error over its mean is smaller; paths if they are equal.
    pub better: Kind,
    /// What paths say of themselves.
    pub paths: Uncertainty,
    /// What points say of themselves.
    pub points: Uncertainty,
    /// The root mean square difference of both, in the unit of the picture. Where it is far above both totals one of them
    /// does not know its error: a few pixels of paths that hardly ever find what is bright say too little. So all pixels
    /// are to be compared, not some.
    pub difference: f64,
}

impl Choice {
    /// The choice between what paths and points find of the same pixels.
    #[must_use]
    pub fn of(paths: &[Estimate], points: &[Estimate]) -> Self {
        let square = |(one, other): (&Estimate, &Estimate)| {
            (one.mean.total() - other.mean.total()).length_squared()
        };
        let squares: f64 = paths.iter().zip(points).map(square).sum();
        let count = 3 * paths.len().min(points.len());
        let (paths, points) = (Uncertainty::of(paths), Uncertainty::of(points));
        let better = if points.relative() < paths.relative() { Kind::Points } else { Kind::Paths };
        Self { better, paths, points, difference: (squares / count.max(1) as f64).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sglow_oracle::Vector3;
    use sglow_oracle::shade::Reflected;

    fn estimate(mean: f64, noise: f64, discretisation: f64) -> Estimate {
        let diffusely =
            |value| Reflected { diffuse: Vector3::splat(value), specular: Vector3::zero() };
        Estimate {
            mean: diffusely(mean),
            standard_errors: diffusely(noise),
            standard_error: Vector3::splat(noise),
            discretisation: diffusely(discretisation),
        }
    }

    #[test]
    fn the_more_certain_one_is_chosen() {
        let noisy = [estimate(1.0, 0.1, 0.0), estimate(2.0, 0.1, 0.0)];
        let coarse = |error| [estimate(1.1, 0.01, error), estimate(2.1, 0.01, error)];
        let choice = Choice::of(&noisy, &coarse(0.05));
        assert_eq!(choice.better, Kind::Points);
        assert!((choice.difference - 0.1).abs() < 1e-12, "{choice:?}");
        // The lattice's error counts.
        assert_eq!(Choice::of(&noisy, &coarse(0.5)).better, Kind::Paths);
        // Of nothing the choice is that of paths, and nothing is divided by 0.
        assert_eq!(Choice::of(&[], &[]).better, Kind::Paths);
        assert_eq!(Choice::of(&[], &[]).difference, 0.0);
        assert_eq!(Choice::of(&noisy, &[Estimate::none(); 2]).better, Kind::Points);
    }
}

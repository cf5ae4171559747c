//! What a reference says of a pixel, and its estimated error.

use crate::Vector3;
use crate::shade::Reflected;

/// Reflected radiance with its noise, which shrinks with more samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The reflected radiance.
    pub mean: Reflected,
    /// The standard error of each reflection, per channel; infinite of a single sample, 0 where nothing is drawn.
    pub standard_errors: Reflected,
    /// The standard error of the sum of both reflections, per channel; they are of the same draws, so that it is not
    /// the root of the sum of squares.
    pub standard_error: Vector3,
}

impl Default for Estimate {
    fn default() -> Self {
        Self::none()
    }
}

impl Estimate {
    /// No light, for certain.
    #[must_use]
    pub fn none() -> Self {
        Self {
            mean: Reflected::none(),
            standard_errors: Reflected::none(),
            standard_error: Vector3::zero(),
        }
    }

    /// The mean of two independent estimates of one pixel, and its noise.
    #[must_use]
    pub fn mean_of(halves: &[Self; 2]) -> Self {
        let [one, other] = halves;
        let mean = |a: Vector3, b: Vector3| (a + b) * 0.5;
        let noise = |a: Vector3, b: Vector3| (a.times(a) + b.times(b)).map(f64::sqrt) * 0.5;
        let both = |a: &Reflected, b: &Reflected, of: &dyn Fn(Vector3, Vector3) -> Vector3| {
            Reflected { diffuse: of(a.diffuse, b.diffuse), specular: of(a.specular, b.specular) }
        };
        Self {
            mean: both(&one.mean, &other.mean, &mean),
            standard_errors: both(&one.standard_errors, &other.standard_errors, &noise),
            standard_error: noise(one.standard_error, other.standard_error),
        }
    }
}

impl core::ops::Add for Estimate {
    type Output = Self;

    /// The sum of two independent estimates of one pixel, as of the light of two lights, and its noise.
    fn add(self, other: Self) -> Self {
        let noise = |a: Vector3, b: Vector3| (a.times(a) + b.times(b)).map(f64::sqrt);
        let [own, its] = [&self.standard_errors, &other.standard_errors];
        Self {
            mean: Reflected {
                diffuse: self.mean.diffuse + other.mean.diffuse,
                specular: self.mean.specular + other.mean.specular,
            },
            standard_errors: Reflected {
                diffuse: noise(own.diffuse, its.diffuse),
                specular: noise(own.specular, its.specular),
            },
            standard_error: noise(self.standard_error, other.standard_error),
        }
    }
}

/// Noise and mean of a picture, in its unit; every channel of every pixel counts alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty {
    /// Root mean square of the standard errors.
    pub noise: f64,
    /// The mean radiance, which the noise is to be compared with.
    pub mean: f64,
}

impl Uncertainty {
    /// The uncertainty of a picture; all 0 of a picture without pixels.
    #[must_use]
    pub fn of(estimates: &[Estimate]) -> Self {
        let count = (3 * estimates.len()).max(1) as f64;
        let square = |one: &Estimate| one.standard_error.length_squared();
        let sum = |one: &Estimate| one.mean.total().to_array().iter().sum::<f64>();
        Self {
            noise: (estimates.iter().map(square).sum::<f64>() / count).sqrt(),
            mean: estimates.iter().map(sum).sum::<f64>() / count,
        }
    }

    /// The noise over the mean; infinite of a picture that is not certain and black, or less by its noise; 0 of one that is
    /// certain.
    #[must_use]
    pub fn relative(&self) -> f64 {
        if self.noise == 0.0 { 0.0 } else { self.noise / self.mean.max(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_average_and_their_noise_by_the_root_of_two() {
        let of = |mean: f64, noise: f64| Estimate {
            mean: Reflected { diffuse: Vector3::splat(mean), specular: Vector3::splat(1.0) },
            standard_errors: Reflected {
                diffuse: Vector3::splat(noise),
                specular: Vector3::zero(),
            },
            standard_error: Vector3::splat(noise),
        };
        let mean = Estimate::mean_of(&[of(1.0, 3.0), of(2.0, 4.0)]);
        assert_eq!((mean.mean.diffuse.x, mean.mean.specular.y), (1.5, 1.0));
        assert_eq!((mean.standard_error.z, mean.standard_errors.diffuse.x), (2.5, 2.5));
        // One half of which nothing is known leaves the mean unknown.
        assert_eq!(
            Estimate::mean_of(&[of(1.0, f64::INFINITY), of(1.0, 1.0)]).standard_error.x,
            f64::INFINITY
        );
    }

    #[test]
    fn estimates_of_two_lights_add_up_and_their_noise_by_its_squares() {
        let of = |mean: f64, noise: f64| Estimate {
            mean: Reflected { diffuse: Vector3::splat(mean), specular: Vector3::splat(1.0) },
            standard_errors: Reflected { diffuse: Vector3::splat(noise), ..Reflected::none() },
            standard_error: Vector3::splat(noise),
        };
        let sum = of(1.0, 3.0) + of(2.0, 4.0);
        assert_eq!((sum.mean.diffuse.x, sum.mean.specular.y), (3.0, 2.0));
        assert_eq!((sum.standard_error.z, sum.standard_errors.diffuse.x), (5.0, 5.0));
    }

    #[test]
    fn noise_of_pixels_adds_by_its_squares() {
        let of = |noise: f64| Estimate {
            mean: Reflected { diffuse: Vector3::splat(2.0), specular: Vector3::splat(1.0) },
            standard_error: Vector3::splat(noise),
            ..Estimate::none()
        };
        let whole = Uncertainty::of(&[of(3.0), of(1.0)]);
        let found = [whole.noise, whole.mean];
        let expected = [5f64.sqrt(), 3.0];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{whole:?}");
        assert!((whole.relative() - 5f64.sqrt() / 3.0).abs() < 1e-12);
        // Negative control: without the second pixel it is another number.
        assert!((Uncertainty::of(&[of(3.0)]).noise - whole.noise).abs() > 0.5);
        assert_eq!(Uncertainty::of(&[]).relative(), 0.0);
        // Noise may take a mean below black: that is no certainty.
        let mut below = of(1.0);
        below.mean = Reflected { diffuse: Vector3::splat(-1.0), specular: Vector3::zero() };
        assert_eq!(Uncertainty::of(&[below]).relative(), f64::INFINITY);
        let dark = Estimate { mean: Reflected::none(), ..of(1.0) };
        assert_eq!(Uncertainty::of(&[dark]).relative(), f64::INFINITY);
    }
}

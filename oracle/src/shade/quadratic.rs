//! The mean of a clamped cosine as a parabola.

use core::f64::consts::PI;

use crate::Real;

/// The positive part of a number that is known but for an extent of at least 0: 0 up to `-extent`, the number itself
/// from `extent` on, and a parabola that meets both with their slopes between them.
///
/// It is not steeper than one in the value and a quarter in the extent, which bounds its tolerance even where the extent may
/// be 0: the quotient itself has no bound there.
pub fn positive_part<R: Real>(value: R, extent: R) -> R {
    let (m, e) = (value.value(), extent.value());
    let part = if m >= e {
        m
    } else {
        let sum = (m + e).max(0.0);
        0.25 * sum * (sum / e.max(1e-30))
    };
    if value.error() == 0.0 && extent.error() == 0.0 {
        return R::constant(part);
    }
    if m + value.error() <= -e - extent.error() {
        return R::zero();
    }
    // Four roundings of the parabola and one of the choice, and an underflow.
    if !(value.error() + extent.error()).is_finite() {
        return R::constant(part).cover(R::constant(f64::MAX));
    }
    let reach = value.error() + 0.25 * extent.error() + 8.0 * ROUNDING * part + 1e-37;
    R::constant(part).cover(R::constant(part + reach)).cover(R::constant(part - reach))
}

/// Half an ULP of f32 at one.
const ROUNDING: f64 = 1.0 / 16_777_216.0;
/// The smallest `1 - r^2` that counts, that of the greatest mean length of lights; f32 holds r to a fourteenth of it.
pub const LEAST_COMPLEMENT: f64 = 1.0 / 524_288.0;

/// The extent of directions of a mean length across their mean, `sqrt(1 - r^2)`.
pub fn extent_of<R: Real>(mean_length: R) -> R {
    let complement = (R::one() - mean_length) * (R::one() + mean_length);
    complement.max(R::constant(LEAST_COMPLEMENT)).sqrt()
}

/// The integral of a lobe times a clamped cosine, by the cosine of their axes, the lobe's sharpness and the mean length of
/// its directions.
pub fn cosine_quadratic<R: Real>(cosine: R, sharpness: R, mean_length: R) -> R {
    let extent = extent_of(mean_length);
    let integral = R::constant(4.0 * PI) / (R::one() + sharpness * (R::one() + mean_length));
    integral * positive_part(mean_length * cosine, extent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sg::{cosine, integral, upper_cosine_integral};
    use crate::vmf::mean_length;

    #[test]
    fn its_largest_error_is_the_stated_one() {
        let mut largest = (0.0, 0.0, 0.0);
        for step in 0..=120 {
            let l = 10f64.powf(-3.0 + 9.0 * f64::from(step) / 120.0);
            for angle in 0..=180 {
                let z = f64::from(angle).to_radians().cos();
                let found = cosine_quadratic(z, l, mean_length(l));
                let error = (found - cosine::quadrature(z, l)).abs() / upper_cosine_integral(l);
                if error > largest.0 {
                    largest = (error, l, z);
                }
            }
        }
        println!("{largest:?}");
        assert!(largest.0 < 0.024 && largest.0 > 0.022, "{largest:?}");
    }

    #[test]
    fn ends_are_exact() {
        // The same everywhere: A/4. One direction: A max(z, 0).
        let wide = cosine_quadratic(0.3, 0.0, 0.0);
        assert!((wide / (integral(0.0) / 4.0) - 1.0).abs() < 1e-14);
        let l = 1e12;
        for (cosine, expected) in [(0.5, 0.5), (-0.5, 0.0)] {
            let sharp = cosine_quadratic(cosine, l, mean_length(l)) / integral(l);
            assert!((sharp - expected).abs() < 1e-6, "{sharp}");
        }
        // The integral without an exponential is that of the lobe.
        for l in [1e-6, 0.1, 1.0, 3.0, 50.0, 1e5] {
            let quotient = 4.0 * PI / (1.0 + l * (1.0 + mean_length(l))) / integral(l);
            assert!((quotient - 1.0).abs() < 1e-9, "{l} {quotient}");
        }
    }
}

//! The integral of a spherical Gaussian over the hemisphere of a normal, without a cosine.

use crate::Real;
use crate::sg::cosine::{polar, slope_of};
use crate::sg::integral;

/// By quadrature over the polar angle; within 1e-9 of it.
#[must_use]
pub fn quadrature(cosine: f64, sharpness: f64) -> f64 {
    polar(cosine, sharpness, |_| 1.0)
}

/// The share of the integral over the sphere: the exact shares of a lobe along the normal and against it, blended by an
/// error function; 0 to 1.
// [Tokuyoshi 2022]; its constants are those of the author's sample code.
pub fn hemisphere_share<R: Real>(cosine: R, sharpness: R) -> R {
    let (one, half) = (R::one(), R::constant(0.5));
    let t = slope_of(sharpness, &[0.651_732_88, 0.5], &[7.221_668_8, 1.341_828, 1.0]);
    // At sharpness 0 both error functions vanish and their quotient is the cosine; to 3e-13 below 1e-6.
    let share = if t.value() > 1e-6 { (t * cosine).erf() / t.erf() } else { cosine };
    let decay = (-sharpness).exp();
    half * ((one + decay) + (one - decay) * share) / (one + decay)
}

/// The integral over the upper hemisphere of a normal.
// [Tokuyoshi 2022]
pub fn hemisphere_integral<R: Real>(cosine: R, sharpness: R) -> R {
    hemisphere_share(cosine, sharpness) * integral(sharpness)
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::quadrature::SphereRule;
    use crate::sg::evaluate;
    use crate::{Bounded, Vector3};

    #[test]
    fn the_truth_equals_the_quadrature_over_the_sphere() {
        let normal = Vector3::new(0.0, 0.0, 1.0);
        for (sharpness, angle) in [(1e-3, 1.0), (0.7, 0.2), (5.0, 1.5), (5.0, 2.6), (60.0, 1.7)] {
            let axis = Vector3::new(f64::sin(angle), 0.0, f64::cos(angle));
            let rule = SphereRule { polar_order: 48, ..SphereRule::around(normal, sharpness) }
                .with_azimuths(512);
            let upper = |at: Vector3| f64::from(u8::from(at.dot(normal) > 0.0));
            let expected = rule.integrate(|at| evaluate(at, axis, sharpness) * upper(at));
            let found = quadrature(angle.cos(), sharpness);
            assert!((found - expected).abs() < 1e-9 * integral(sharpness), "{sharpness} {angle}");
            // Both hemispheres are the sphere.
            let both = found + quadrature(-angle.cos(), sharpness);
            assert!((both / integral(sharpness) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn error_is_the_known_one() {
        let mut worst = 0.0_f64;
        for sharpness in [0.0, 1e-3, 0.5, 3.0, 7.9, 20.0, 300.0, 1e5] {
            let largest = 2.0 * PI * sharpness.one_minus_exp_over();
            for step in 0..=180 {
                let cosine = (PI * f64::from(step) / 180.0).cos();
                let found = hemisphere_integral(cosine, sharpness);
                worst = worst.max((found - quadrature(cosine, sharpness)).abs() / largest);
                // Exact: both hemispheres are the sphere, since the error function is odd.
                let both = found + hemisphere_integral(-cosine, sharpness);
                assert!((both / integral(sharpness) - 1.0).abs() < 1e-12);
            }
        }
        assert!(worst > 4.5e-3 && worst < 5e-3, "{worst}");
    }

    #[test]
    fn is_promised_for_every_sharpness() {
        for sharpness in [0.0, 1e-30, 0.7, 6.0, 80.0, 1e5, 1e12, 1e30] {
            for cosine in [-1.0, -1e-3, 0.0, 1.0] {
                let bounded =
                    hemisphere_integral(Bounded::exact(cosine), Bounded::exact(sharpness));
                let largest = integral(f64::from(sharpness));
                assert!(bounded.error < 1e-5 * largest, "{sharpness} {cosine} {bounded:?}");
            }
        }
    }
}

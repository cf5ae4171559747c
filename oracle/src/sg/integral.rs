//! The integral of a spherical Gaussian over the sphere.

use core::f64::consts::PI;

use crate::Real;

/// `A(l) = 2 pi (1 - exp(-2 l))/l` for a sharpness at least 0; 4 pi at 0.
// [Tokuyoshi 2016, Appendix A]
pub fn integral<R: Real>(sharpness: R) -> R {
    R::constant(4.0 * PI) * (R::constant(2.0) * sharpness).one_minus_exp_over()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::SphereRule;
    use crate::sg::evaluate;
    use crate::{Bounded, Vector3};

    #[test]
    fn equals_the_quadrature() {
        let axis = Vector3::new(0.48, -0.6, 0.64);
        for sharpness in [0.0, 1e-30, 2f64.powi(-24), 1.0, 1e2, 1e5, 1e9] {
            let quadrature = SphereRule::around(axis, sharpness)
                .integrate(|direction| evaluate(direction, axis, sharpness));
            assert!((integral(sharpness) / quadrature - 1.0).abs() < 1e-12, "{sharpness}");
        }
    }

    #[test]
    fn equals_the_literal_form_where_that_is_stable() {
        for sharpness in [0.1, 1.0, 30.0] {
            let literal = 2.0 * PI / sharpness * (1.0 - (-2.0 * sharpness).exp());
            assert!((integral(sharpness) / literal - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn is_finite_for_every_sharpness() {
        for sharpness in [0.0, 1e-38, 1e-30, 2f32.powi(-24), 1.0, 1e5, 2f32.powi(41), f32::MAX] {
            let bounded = integral(Bounded::exact(sharpness));
            assert!(bounded.value > 0.0 && bounded.value <= 4.0 * PI + 1e-12, "{sharpness}");
            if sharpness < 1e37 {
                assert!(bounded.error < 6e-6 * bounded.value + 1e-37, "{sharpness} {bounded:?}");
            }
        }
    }
}

//! The formulas as the papers print them. In exact arithmetic they equal the stable forms; with
//! [`Bounded`](crate::Bounded) they say how much of an f32 is left.

use core::f64::consts::PI;

use crate::sg::Product;
use crate::{Real, Vector3};

/// The value of a spherical Gaussian.
// [Tokuyoshi 2016, Appendix A]
pub fn evaluate<R: Real>(direction: Vector3<R>, axis: Vector3<R>, sharpness: R) -> R {
    (sharpness * (direction.dot(axis) - R::one())).exp()
}

/// The integral of a spherical Gaussian over the sphere.
// [Tokuyoshi 2016, Appendix A]
pub fn integral<R: Real>(sharpness: R) -> R {
    R::constant(2.0 * PI) / sharpness * (R::one() - (R::constant(-2.0) * sharpness).exp())
}

/// The product of two spherical Gaussians.
// [Tokuyoshi 2016, Eq. (12)]
pub fn product<R: Real>(
    axis_a: Vector3<R>,
    sharpness_a: R,
    axis_b: Vector3<R>,
    sharpness_b: R,
) -> Product<R> {
    let mean = axis_a * sharpness_a + axis_b * sharpness_b;
    let sharpness = mean.length();
    Product {
        axis: mean.map(|part| part / sharpness),
        sharpness,
        log_amplitude: sharpness - sharpness_a - sharpness_b,
    }
}

/// The integral of a lobe times the clamped cosine about its own axis.
// [Meder 2018, Eq. (9)]
pub fn upper_cosine_integral<R: Real>(sharpness: R) -> R {
    R::constant(2.0 * PI) / (sharpness * sharpness) * ((-sharpness).exp() - R::one() + sharpness)
}

/// The integral of a lobe times the clamped cosine about the opposite of its axis.
// [Meder 2018, Eq. (10)]
pub fn lower_cosine_integral<R: Real>(sharpness: R) -> R {
    R::constant(2.0 * PI) / (sharpness * sharpness)
        * (R::constant(-2.0) * sharpness).exp()
        * (sharpness.exp() - R::one() - sharpness)
}

/// The integral of a lobe times a clamped cosine.
// [Meder 2018, Eq. (9), Eq. (10), Eq. (15)-(18)]
pub fn cosine_logistic<R: Real>(cosine: R, sharpness: R) -> R {
    let (one, half) = (R::one(), R::constant(0.5));
    let t = R::constant(2.1007) * sharpness.sqrt() * sharpness / (sharpness + R::constant(4.4653));
    let u = one / (R::constant(0.2958) * t + R::constant(0.5033));
    let s = u / ((cosine.abs() * t).exp() + one);
    let c = s * (half * cosine + half) + (one - s) * cosine.max(R::zero());
    c * upper_cosine_integral(sharpness) + (one - c) * lower_cosine_integral(sharpness)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;
    use crate::sg::{self, Cosine};

    #[test]
    fn equal_the_stable_forms_where_they_are_stable() {
        let axis = Vector3::new(0.0, 0.6, 0.8);
        let other = Vector3::new(0.48, 0.6, 0.64);
        for sharpness in [0.5, 3.0, 20.0] {
            let pairs = [
                (evaluate(other, axis, sharpness), sg::evaluate(other, axis, sharpness)),
                (integral(sharpness), sg::integral(sharpness)),
                (upper_cosine_integral(sharpness), sg::upper_cosine_integral(sharpness)),
                (lower_cosine_integral(sharpness), sg::lower_cosine_integral(sharpness)),
                (cosine_logistic(0.3, sharpness), Cosine::Logistic.integral(0.3, sharpness)),
            ];
            for (literal, stable) in pairs {
                assert!((literal / stable - 1.0).abs() < 1e-12, "{literal} {stable}");
            }
            let literal = product(axis, sharpness, other, 2.0);
            let stable = sg::product(axis, sharpness, other, 2.0);
            assert!((literal.log_amplitude - stable.log_amplitude).abs() < 1e-13);
            assert!((literal.axis - stable.axis).length() < 1e-14);
        }
    }

    #[test]
    fn f32_leaves_nothing_of_them_at_the_ends() {
        // What the stable forms keep to 1e-5.
        let broad = Bounded::exact(1e-3);
        assert!(upper_cosine_integral(broad).error > 0.1 * PI);
        assert!(sg::upper_cosine_integral(broad).error < 1e-5 * PI);
        let sharp = Bounded::exact(100.0);
        assert!(!lower_cosine_integral(sharp).promises());
        assert!(sg::lower_cosine_integral(sharp).promises());
        assert!(!cosine_logistic(Bounded::exact(0.5), sharp).promises());
        let broad = Bounded::exact(1e-6);
        assert!(integral(broad).error > 0.1 * integral(broad).value);
        assert!(sg::integral(broad).error < 1e-5 * integral(broad).value);
    }
}

//! The integrals of a spherical Gaussian times the clamped cosine about its own axis and about the opposite one: the
//! largest and the smallest that there are.

use core::f64::consts::PI;

use crate::Real;

/// Where the closed forms stop cancelling much and the series stop.
const SERIES: f64 = 1.0;

/// `sum l^k/(k + 2)!`, with l or -l; for |l| below 1.
fn series<R: Real>(l: R) -> R {
    // 1/20! is below the rounding of f64.
    (0..18_u32).rev().fold(R::zero(), |sum, k| {
        let factorial: f64 = (1..=k + 2).map(f64::from).product();
        sum * l + R::constant(1.0 / factorial)
    })
}

/// `A_u = 2 pi (exp(-l) - 1 + l)/l^2`, the integral with the lobe's axis as the normal; for a sharpness at least 0.
// [Meder 2018, Eq. (9)]
pub fn upper_cosine_integral<R: Real>(sharpness: R) -> R {
    let scaled = if sharpness.value() < SERIES {
        series(-sharpness)
    } else {
        (R::one() - sharpness.one_minus_exp_over()) / sharpness
    };
    R::constant(2.0 * PI) * scaled
}

/// `A_b = 2 pi exp(-2 l) (exp(l) - 1 - l)/l^2`, the integral with the lobe's axis as the negative normal.
// [Meder 2018, Eq. (10)]
pub fn lower_cosine_integral<R: Real>(sharpness: R) -> R {
    let decay = (-sharpness).exp();
    let scaled = if sharpness.value() < SERIES {
        // (exp(l) - 1 - l)/l^2 without a difference.
        decay * decay * series(sharpness)
    } else {
        // Both factors of the numerator stay in range where exp(l) does not.
        let inverse = R::one() / sharpness;
        decay * inverse * (inverse - (R::one() + inverse) * decay)
    };
    R::constant(2.0 * PI) * scaled
}

/// `(A_u - A_b) (1 + l)/(2 pi)`, between 0 at sharpness 0 and 1: the odd part of the integral is exactly this times
/// the cosine, so that the forms are built on it.
pub fn odd_part_scaled<R: Real>(sharpness: R) -> R {
    let one = R::one();
    if sharpness.value() < SERIES {
        // 2 exp(-l) (cosh l - sinh(l)/l)/l, whose series has positive terms 2 k l^(2k - 1)/(2 k + 1)!.
        let square = sharpness * sharpness;
        let sum = (1..10_u32).rev().fold(R::zero(), |sum, k| {
            let factorial: f64 = (1..=2 * k + 1).map(f64::from).product();
            sum * square + R::constant(2.0 * f64::from(k) / factorial)
        });
        R::constant(2.0) * (-sharpness).exp() * sharpness * sum * (one + sharpness)
    } else {
        let inverse = one / sharpness;
        let decay = (R::constant(-2.0) * sharpness).exp();
        ((one - inverse) + (one + inverse) * decay) * (one + inverse)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::SphereRule;
    use crate::sg::evaluate;
    use crate::{Bounded, Vector3};

    #[test]
    fn equal_the_quadrature() {
        let axis = Vector3::new(0.0, 0.6, 0.8);
        for sharpness in [0.0, 1e-6, 0.3, 0.999, 1.0, 1.001, 8.0, 60.0, 1e4] {
            let rule = SphereRule::around(axis, sharpness);
            let cosine = |sign: f64| {
                rule.integrate(|at| evaluate(at, axis, sharpness) * (sign * at.dot(axis)).max(0.0))
            };
            let found = [upper_cosine_integral(sharpness), lower_cosine_integral(sharpness)];
            let quadrature = [cosine(1.0), cosine(-1.0)];
            assert!(
                (found[0] / quadrature[0] - 1.0).abs() < 1e-12,
                "{sharpness} {found:?} {quadrature:?}"
            );
            assert!(
                (found[1] - quadrature[1]).abs() <= 1e-9 * quadrature[1],
                "{sharpness} {found:?} {quadrature:?}"
            );
            let odd = odd_part_scaled(sharpness) * 2.0 * PI / (1.0 + sharpness);
            assert!((odd - (found[0] - found[1])).abs() < 1e-13 * found[0], "{sharpness}");
            // Negative control: the two are not the same number but at sharpness 0.
            assert!(sharpness < 1e-3 || found[0] > found[1] * 1.1);
        }
    }

    #[test]
    fn are_finite_and_promised_for_every_sharpness() {
        for sharpness in [0.0, 1e-30, 2f32.powi(-24), 0.5, 1.0, 1e2, 1e5, 2f32.powi(41), 1e37] {
            let sharpness = Bounded::exact(sharpness);
            let upper = upper_cosine_integral(sharpness);
            assert!(upper.promises() && upper.error < 1e-5 * upper.value + 2e-38, "{upper:?}");
            let odd = odd_part_scaled(sharpness);
            assert!(odd.promises() && odd.error < 1e-5 * odd.value + 1e-37, "{odd:?}");
            let lower = lower_cosine_integral(sharpness);
            assert!(lower.promises() && lower.error < 1e-5 * upper.value + 1e-37, "{lower:?}");
        }
    }
}

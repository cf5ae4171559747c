//! The Beckmann microfacet distribution with separable Smith visibility.

use core::f64::consts::PI;

use crate::{Real, Vector3};

/// The density of facets, per steradian, at the cosine between normal and half vector; 0 at or below the horizon.
// [Walter 2007, Eq. (25)]
pub fn d_beckmann<R: Real>(cosine: R, alpha: R) -> R {
    if cosine.value() <= 0.0 {
        return R::zero();
    }
    let width = alpha.squared();
    let square = cosine.squared();
    let exponent = (square - R::one()).min(R::zero()) / (square * width);
    exponent.exp() / (R::constant(PI) * width * square.squared())
}

/// The density of facets from unit vectors, which keeps the digits of a small sine; 0 at or below the horizon.
// [Walter 2007, Eq. (25)]
pub fn d_beckmann_about<R: Real>(normal: Vector3<R>, half: Vector3<R>, alpha: R) -> R {
    let cosine = normal.dot(half);
    // The tangent is above 1e4 below this, and nothing is left for any alpha up to 1.
    if cosine.value() <= 1e-4 {
        return R::zero();
    }
    let (width, square) = (alpha.squared(), cosine.squared());
    let exponent = -(normal.cross(half).length_squared() / (square * width));
    exponent.exp() / (R::constant(PI) * width * square.squared())
}

/// Masking of one direction, 0 to 1.
// [Walter 2007, Eq. (27)]
pub fn g1_smith_beckmann<R: Real>(cosine: R, alpha: R) -> R {
    (cosine * masking_over_cosine(cosine, alpha)).min(R::one())
}

/// Masking over the cosine: `G1(c)/c`, finite at the horizon.
///
/// The rational approximation exceeds 1 by 6e-5 where it ends; next to that place either value is admitted.
// [Walter 2007, Section 5.2, after Eq. (27)]
fn masking_over_cosine<R: Real>(cosine: R, alpha: R) -> R {
    let sine = (R::one() - cosine.squared()).max(R::zero()).sqrt();
    let slope = alpha * sine;
    // a = cos/(alpha sin) against 1.6, without the division.
    let beyond = cosine - R::constant(1.6) * slope;
    let lit = || R::one() / cosine;
    let rational = || {
        let a = cosine / slope;
        (R::constant(3.535) + R::constant(2.181) * a)
            / (slope * (R::one() + R::constant(2.276) * a + R::constant(2.577) * a.squared()))
    };
    match (beyond.value() >= 0.0, beyond.sign_is_certain()) {
        (true, true) => lit(),
        (false, true) => rational(),
        (true, false) => lit().cover(rational()),
        (false, false) => rational().cover(lit()),
    }
}

/// Masking and shadowing over `4 (n.l) (n.v)`.
// [Walter 2007, Eq. (23) with Section 5.2]
pub fn v_smith_beckmann<R: Real>(cosine_light: R, cosine_view: R, alpha: R) -> R {
    R::constant(0.25)
        * masking_over_cosine(cosine_light, alpha)
        * masking_over_cosine(cosine_view, alpha)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;

    /// An approximation of the error function to 1.2e-7, to compare the rational approximation with the exact masking.
    // [Numerical Recipes, erfcc]
    fn erf(x: f64) -> f64 {
        let t = 1.0 / (1.0 + 0.5 * x.abs());
        let series = [
            -1.265_512_23,
            1.000_023_68,
            0.374_091_96,
            0.096_784_18,
            -0.186_288_06,
            0.278_868_07,
            -1.135_203_98,
            1.488_515_87,
            -0.822_152_23,
            0.170_872_77,
        ];
        let polynomial = series.iter().rev().fold(0.0, |sum, term| sum * t + term);
        1.0 - t * (-x * x + polynomial).exp()
    }

    #[test]
    fn masking_is_close_to_the_exact_one() {
        let alpha = 0.4;
        for cosine in [0.05, 0.2, 0.5, 0.7, 0.9, 0.999] {
            let a = cosine / (alpha * f64::sqrt(1.0 - cosine * cosine));
            // [Walter 2007, Eq. (26), Beckmann's]
            let exact = 2.0 / (1.0 + erf(a) + (-a * a).exp() / (a * PI.sqrt()));
            let found = masking_over_cosine(cosine, alpha) * cosine;
            // Walter et al. promise a relative error below 0.35 %.
            assert!((found / exact - 1.0).abs() < 3.5e-3, "{cosine} {found} {exact}");
        }
        assert!(masking_over_cosine(0.0, alpha).is_finite());
        assert_eq!(masking_over_cosine(1.0, alpha), 1.0);
    }

    #[test]
    fn both_sides_of_the_end_of_the_approximation_are_admitted() {
        let alpha = 0.5_f64;
        // cos = 1.6 alpha sin
        let cosine = (0.64 / 1.64_f64).sqrt();
        let bounded = masking_over_cosine(Bounded::constant(cosine), Bounded::constant(alpha));
        assert!(bounded.error > 5e-5 && bounded.error < 5e-4, "{bounded:?}");
        let away = masking_over_cosine(Bounded::constant(cosine + 1e-3), Bounded::constant(alpha));
        assert!(away.error < 5e-6, "{away:?}");
    }
}

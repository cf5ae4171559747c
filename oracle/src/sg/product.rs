//! The product of two spherical Gaussians, which is one, and its integral.

use crate::sg::integral;
use crate::{Real, Vector3};

/// A product: `exp(log_amplitude) G(w, axis, sharpness)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Product<R = f64> {
    /// Unit axis; the first factor's where the product is constant.
    pub axis: Vector3<R>,
    /// Sharpness, at least 0.
    pub sharpness: R,
    /// Natural logarithm of the amplitude, at most 0.
    pub log_amplitude: R,
}

/// The product of two spherical Gaussians of unit axes and sharpness at least 0.
///
/// The logarithm `l - la - lb` of the amplitude is the small difference of large numbers; multiplied by
/// `(l + la + lb)/(l + la + lb)` it becomes `-la lb |xa - xb|^2/(l + la + lb)`, which has no difference but the axes'.
// [Tokuyoshi 2016, Eq. (12)]
pub fn product<R: Real>(
    axis_a: Vector3<R>,
    sharpness_a: R,
    axis_b: Vector3<R>,
    sharpness_b: R,
) -> Product<R> {
    let (larger, smaller) = (sharpness_a.max(sharpness_b), sharpness_a.min(sharpness_b));
    if larger.value() <= 0.0 {
        return Product { axis: axis_a, sharpness: larger, log_amplitude: R::zero() };
    }
    // In units of the larger sharpness, so that no sum and no square leaves the range of f32.
    let (share_a, share_b) = (sharpness_a / larger, sharpness_b / larger);
    let mean = axis_a * share_a + axis_b * share_b;
    let norm = mean.length();
    let chord = (axis_a - axis_b).length_squared();
    Product {
        axis: mean.normalized_or(axis_a),
        sharpness: larger * norm,
        log_amplitude: -(smaller * (chord / (norm + share_a + share_b))),
    }
}

/// The integral of the product of two spherical Gaussians over the sphere; exact.
// [Tokuyoshi 2015, Section 3.2, before Iwasaki's approximation]
pub fn product_integral<R: Real>(
    axis_a: Vector3<R>,
    sharpness_a: R,
    axis_b: Vector3<R>,
    sharpness_b: R,
) -> R {
    let product = product(axis_a, sharpness_a, axis_b, sharpness_b);
    product.log_amplitude.exp() * integral(product.sharpness)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;
    use crate::quadrature::SphereRule;
    use crate::sg::evaluate;

    fn direction(polar: f64, azimuth: f64) -> Vector3 {
        Vector3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())
    }

    #[test]
    fn is_the_product_everywhere() {
        for (la, lb, angle) in
            [(3.0, 5.0, 0.4), (1e-3, 20.0, 2.0), (0.0, 0.0, 1.0), (100.0, 1.0, 3.1)]
        {
            let (a, b) = (direction(0.3, 1.0), direction(0.3 + angle, 1.3));
            let lobe = product(a, la, b, lb);
            // [Tokuyoshi 2016, Eq. (12)], literally.
            assert!((lobe.log_amplitude - (lobe.sharpness - la - lb)).abs() < 1e-12);
            for (polar, azimuth) in [(0.1, 0.2), (1.0, 4.0), (2.9, 5.0)] {
                let at = direction(polar, azimuth);
                let expected = evaluate(at, a, la) * evaluate(at, b, lb);
                let found = lobe.log_amplitude.exp() * evaluate(at, lobe.axis, lobe.sharpness);
                assert!((found - expected).abs() <= 1e-13 * expected.max(1e-3));
            }
        }
    }

    #[test]
    fn integral_equals_the_quadrature() {
        for (la, lb, angle) in [
            (2.0, 50.0, 0.7),
            (10.0, 10.0, core::f64::consts::PI),
            (1e-12, 3.0, 1.0),
            (1e4, 2.0, 2.5),
        ] {
            let (a, b) = (direction(0.5, 0.0), direction(0.5 + angle, 0.0));
            let truth = SphereRule::around(if la > lb { a } else { b }, la.max(lb))
                .integrate(|at| evaluate(at, a, la) * evaluate(at, b, lb));
            let found = product_integral(a, la, b, lb);
            assert!((found / truth - 1.0).abs() < 1e-9, "{la} {lb} {angle}: {found} {truth}");
            // Negative control: another sharpness is another integral.
            assert!(
                (product_integral(a, la + 0.01 * (1.0 + la), b, lb) / truth - 1.0).abs() > 1e-4
            );
        }
    }

    #[test]
    fn the_literal_exponent_in_f32_leaves_the_tolerance() {
        let (la, lb) = (1.1e5_f32, 7.3e4_f32);
        let a = [0.0_f32, 0.0, 1.0, 0.0];
        let b = [3.0e-3_f32, 0.0, 0.999_995_5, 0.0];
        let lobe = product(
            Vector3::of_texel(a),
            Bounded::exact(la),
            Vector3::of_texel(b),
            Bounded::exact(lb),
        );
        let literal =
            ((la * a[0] + lb * b[0]).powi(2) + (la * a[2] + lb * b[2]).powi(2)).sqrt() - la - lb;
        let total = lobe.sharpness.value as f32 + la + lb;
        let stable = -la * ((a[0] - b[0]).powi(2) + (a[2] - b[2]).powi(2)) * (lb / total);
        assert!(lobe.log_amplitude.admits(stable), "{stable} {lobe:?}");
        assert!(!lobe.log_amplitude.admits(literal), "{literal} {lobe:?}");
    }
}

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
/// All lengths are in units of a power of two near the larger sharpness, whose square may be out of the range of f32.
// [Tokuyoshi 2016, Eq. (12)]
pub fn product<R: Real>(
    axis_a: Vector3<R>,
    sharpness_a: R,
    axis_b: Vector3<R>,
    sharpness_b: R,
) -> Product<R> {
    let larger = sharpness_a.value().max(sharpness_b.value());
    #[expect(clippy::cast_possible_truncation, reason = "the exponent of an f32")]
    let exponent = if larger > 0.0 { larger.log2().floor().max(-126.0) as i32 } else { 0 };
    let [share_a, share_b] =
        [sharpness_a, sharpness_b].map(|sharpness| sharpness.times_power_of_two(-exponent));
    let mean = axis_a * share_a + axis_b * share_b;
    let norm = mean.length();
    let total = norm + share_a + share_b;
    let log_amplitude = if total.value() > 0.0 {
        let chord = (axis_a - axis_b).length_squared();
        -(sharpness_a.min(sharpness_b) * (share_a.max(share_b) * (chord / total)))
    } else {
        R::zero()
    };
    Product {
        axis: mean.normalized_or(axis_a),
        sharpness: norm.times_power_of_two(exponent),
        log_amplitude,
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
            let quadrature = SphereRule::around(if la > lb { a } else { b }, la.max(lb))
                .integrate(|at| evaluate(at, a, la) * evaluate(at, b, lb));
            let found = product_integral(a, la, b, lb);
            assert!(
                (found / quadrature - 1.0).abs() < 1e-9,
                "{la} {lb} {angle}: {found} {quadrature}"
            );
            // Negative control: another sharpness is another integral.
            assert!(
                (product_integral(a, la + 0.01 * (1.0 + la), b, lb) / quadrature - 1.0).abs()
                    > 1e-4
            );
        }
    }

    #[test]
    fn swapping_the_factors_changes_nothing() {
        for (la, lb, angle) in [(3.0, 5.0, 0.4), (1e-3, 1e6, 2.0), (40.0, 40.0, 3.0)] {
            let (a, b) = (direction(0.3, 1.0), direction(0.3 + angle, 1.3));
            let (one, other) = (product(a, la, b, lb), product(b, lb, a, la));
            assert!((one.axis - other.axis).length() < 1e-12);
            assert!((one.sharpness / other.sharpness - 1.0).abs() < 1e-12);
            assert!((one.log_amplitude / other.log_amplitude - 1.0).abs() < 1e-13);
            // Negative control: swapping one thing only is another product.
            let mixed = product(a, lb, b, la);
            assert!(la == lb || (mixed.axis - one.axis).length() > 1e-3);
        }
    }

    #[test]
    fn is_promised_for_every_sharpness() {
        let (a, b) = (direction(0.3, 1.0), direction(0.5, 1.0));
        let vector = |v| Vector3::<Bounded>::constant(v);
        for la in [1e-37, 1e-30, 1.0, 1e20, 2e37] {
            for lb in [0.0, 1e-37, 1.0, 1e20, 2e37] {
                let lobe = product(vector(a), Bounded::exact(la), vector(b), Bounded::exact(lb));
                assert!(lobe.sharpness.promises(), "{la} {lb} {lobe:?}");
                assert!(lobe.sharpness.error < 1e-5 * lobe.sharpness.value + 1e-36);
                assert!(lobe.log_amplitude.promises(), "{la} {lb} {lobe:?}");
                assert!((lobe.axis.length_squared().value - 1.0).abs() < 1e-12);
            }
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

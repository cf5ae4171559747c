//! The integral of an anisotropic times a spherical Gaussian.

use core::f64::consts::PI;

use crate::asg::{Asg, evaluate};
use crate::quadrature::SphereRule;
use crate::{Real, Vector3, sg};

/// The greatest sharpness that counts.
pub const GREATEST_SHARPNESS: f64 = 1e18;
/// The least product of the sums of sharpness along both axes: two lobes that are the same everywhere have no convolution
/// of this form.
pub const LEAST_PRODUCT: f64 = 1e-30;

/// The integral over the sphere of the product of an anisotropic spherical Gaussian and a spherical one, the latter of
/// a unit axis and a sharpness at least 0. An approximation for sharp lobes.
// [Xu 2013, Eq. (13)]
pub fn convolution<R: Real>(asg: &Asg<R>, axis: Vector3<R>, sharpness: R) -> R {
    // A bandwidth is half of a sharpness.
    let sharpness = sharpness.min(R::constant(GREATEST_SHARPNESS));
    let [x, y, z] = asg.axes;
    let [along, across] = asg.bandwidths;
    let sums = asg.bandwidths.map(|own| own * R::constant(2.0) + sharpness);
    let product = (sums[0] * sums[1]).max(R::constant(LEAST_PRODUCT));
    // nu/(b_x + nu) is l s_y/(s_x s_y).
    let exponent = sharpness / product
        * (along * axis.dot(x).squared() * sums[1] + across * axis.dot(y).squared() * sums[0]);
    let smooth = axis.dot(z).max(R::zero());
    // The least of the three factors first: in that order flushing costs most, and a driver may take any.
    R::constant(2.0 * PI) * smooth * ((-exponent).exp() / product.sqrt())
}

/// The same by quadrature, for bandwidths up to 1e3 and a sharpness up to 1e3 about the same axis, 400 elsewhere; milliseconds.
#[must_use]
pub fn quadrature(asg: &Asg, axis: Vector3, sharpness: f64) -> f64 {
    let widest = asg.bandwidths[0].max(asg.bandwidths[1]);
    SphereRule::around(asg.axes[2], 4.0 * widest)
        .with_azimuths(1024)
        .integrate(|at| evaluate(at, asg) * sg::evaluate(at, axis, sharpness))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;

    fn lobe(bandwidths: [f64; 2]) -> Asg {
        let z = Vector3::new(0.48, -0.6, 0.64);
        let (x, y) = z.basis();
        Asg { axes: [x, y, z], bandwidths }
    }

    #[test]
    fn equals_the_quadrature_for_sharp_lobes() {
        for (bandwidths, sharpness, bound) in [
            ([400.0, 25.0], 50.0, 0.02),
            ([400.0, 25.0], 1e3, 0.02),
            ([1e3, 1e3], 200.0, 0.02),
            ([4.0, 3.0], 5.0, 0.05),
        ] {
            let asg = lobe(bandwidths);
            let [x, y, z] = asg.axes;
            for offset in [Vector3::zero(), x * 0.05 + y * 0.1, y * -0.2] {
                let axis = (z + offset).normalized();
                let (found, quadrature) =
                    (convolution(&asg, axis, sharpness), quadrature(&asg, axis, sharpness));
                let error = found / quadrature - 1.0;
                println!("{bandwidths:?} {sharpness} {offset:?}: {error:.4}");
                assert!(error.abs() < bound, "{bandwidths:?} {sharpness} {error}");
            }
            // Negative control: the bandwidths exchanged.
            let axis = (z + x * 0.2).normalized();
            let other = Asg { bandwidths: [bandwidths[1], bandwidths[0]], ..asg };
            let error =
                convolution(&other, axis, sharpness) / quadrature(&asg, axis, sharpness) - 1.0;
            assert!(error.abs() > bound || bandwidths[0] < 2.0 * bandwidths[1], "{error}");
        }
    }

    #[test]
    fn is_finite_and_falls_with_the_sharpness() {
        for bandwidths in [[0.0, 0.0], [1e-30, 1.0], [0.25, 0.25], [1e10, 25.0]] {
            let asg = lobe(bandwidths);
            let mut last = f64::INFINITY;
            for sharpness in [0.0, 1e-30, 2f64.powi(-24), 1.0, 1e5, 2f64.powi(41), 3.4e38] {
                let found: f64 = convolution(&asg, asg.axes[2], sharpness);
                assert!(found.is_finite() && found > 0.0 && found <= last, "{sharpness} {found}");
                last = found;
            }
        }
    }

    #[test]
    fn the_tolerance_is_a_few_ulp() {
        let asg = lobe([400.0, 25.0]);
        let asg = Asg {
            axes: asg.axes.map(Vector3::constant),
            bandwidths: asg.bandwidths.map(Bounded::constant),
        };
        let axis = Vector3::constant(Vector3::new(0.5, -0.6, 0.62).normalized());
        let found = convolution(&asg, axis, Bounded::constant(100.0));
        assert!(found.error < 1e-5 * found.value, "{found:?}");
    }
}

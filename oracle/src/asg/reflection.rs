//! The reflection lobe of a rough surface as an anisotropic spherical Gaussian.

use crate::asg::Asg;
use crate::brdf::incidence::across;
use crate::brdf::material::MINIMUM_WIDTH;
use crate::{Real, Vector3};

/// The least cosine of the view.
pub const MINIMUM_COSINE: f64 = 1e-2;

/// The lobe about the mirror direction of a unit view, for roughness alpha: z the mirror direction, x out of the plane
/// of reflection, y within it. Where the view is along the normal, any x across z.
///
/// The facets' lobe `exp(-(1/alpha^2) sin^2)` about the normal, warped to light directions: a half vector that leaves
/// the normal by a small angle turns the mirror direction by twice that angle within the plane of reflection, by twice
/// the cosine of it across.
// [Xu 2013, Section 4.1], [Tokuyoshi 2016, Appendix C.2, Specular reflection]
pub fn reflection<R: Real>(view: Vector3<R>, normal: Vector3<R>, alpha: R) -> Asg<R> {
    warped(view, normal, R::constant(0.25) / alpha.squared().max(R::constant(MINIMUM_WIDTH)))
}

/// The same lobe with the bandwidth `1/alpha^2 - 1` of the facets: constant at alpha 1, where the distribution of GGX is.
// after [Tokuyoshi 2024], as the author's sample has it
pub fn reflection_flat<R: Real>(view: Vector3<R>, normal: Vector3<R>, alpha: R) -> Asg<R> {
    let smoothness = (R::one() - alpha) * (R::one() + alpha);
    let width = alpha.squared().max(R::constant(MINIMUM_WIDTH));
    warped(view, normal, R::constant(0.25) * smoothness / width)
}

/// A lobe over half vectors of four times the bandwidth `quarter`, warped to light directions.
fn warped<R: Real>(view: Vector3<R>, normal: Vector3<R>, quarter: R) -> Asg<R> {
    let z = view.mirrored(normal);
    let x = across(z, normal);
    let cosine = normal.dot(view).max(R::constant(MINIMUM_COSINE));
    Asg { axes: [x, z.cross(x), z], bandwidths: [quarter / cosine.squared(), quarter] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::asg;
    use crate::sg;

    const NORMAL: Vector3 = Vector3::new(0.0, 0.0, 1.0);

    #[test]
    fn follows_the_facets() {
        // Close to the mirror direction the warped lobe has the value of the facets' Gaussian at the half vector.
        let (angle, alpha) = (0.9_f64, 0.05_f64);
        let view = Vector3::new(angle.sin(), 0.0, angle.cos());
        let lobe = reflection(view, NORMAL, alpha);
        let other = Asg { bandwidths: [lobe.bandwidths[1], lobe.bandwidths[0]], ..lobe };
        let [x, y, z] = lobe.axes;
        for offset in [x * 0.02, y * 0.02, x * 0.01 - y * 0.025] {
            let light = (z + offset).normalized();
            let facets = sg::evaluate((light + view).normalized(), NORMAL, 2.0 / (alpha * alpha));
            let found = asg::evaluate(light, &lobe);
            assert!((found / facets - 1.0).abs() < 0.02, "{found} {facets}");
            // Negative control: the bandwidths exchanged, where the offset tells them apart.
            assert!((asg::evaluate(light, &other) / facets - 1.0).abs() > 0.02);
        }
    }

    #[test]
    fn the_flat_lobe_is_constant_where_the_distribution_is() {
        let view = Vector3::new(0.6, 0.0, 0.8);
        let lobe = reflection_flat(view, NORMAL, 1.0);
        assert_eq!(lobe.bandwidths, [0.0, 0.0]);
        // Negative control: the printed lobe is not.
        assert!(reflection(view, NORMAL, 1.0).bandwidths[1] > 0.2);
        // Smooth surfaces: the same lobe.
        let [flat, printed] = [reflection_flat(view, NORMAL, 0.01), reflection(view, NORMAL, 0.01)]
            .map(|lobe| lobe.bandwidths);
        assert!((0..2).all(|axis| (flat[axis] / printed[axis] - 1.0).abs() < 1.1e-4));
    }

    #[test]
    fn the_axes_are_orthonormal_at_every_angle() {
        for angle in [0.0, 1e-9, 1e-4, 1.0, 1.57, 3.0] {
            let view = Vector3::new(f64::sin(angle), 0.0, f64::cos(angle));
            let lobe = reflection(view, NORMAL, 0.1);
            let [x, y, z] = lobe.axes;
            assert!((x.cross(y) - z).length() < 1e-14 && (x.length() - 1.0).abs() < 1e-14);
            assert!(lobe.bandwidths[0] <= 0.25 / 1e-6 && lobe.bandwidths[0] >= lobe.bandwidths[1]);
        }
    }
}

//! The reflection lobe of a rough surface as a spherical Gaussian.

use crate::brdf::material::{MINIMUM_COSINE, MINIMUM_WIDTH};
use crate::{Real, Vector3};

/// A reflection lobe of amplitude 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflection<R = f64> {
    /// Unit axis.
    pub axis: Vector3<R>,
    /// Sharpness, at least 0.
    pub sharpness: R,
}

/// The least cosine between the view and the dominant visible normal.
pub const MINIMUM_FACET_COSINE: f64 = 1e-6;

/// Sharpness of the lobe about the mirror direction, from roughness alpha and the cosine between that and the normal.
// [Tokuyoshi 2016, Appendix A.1]
pub fn mirror_sharpness<R: Real>(alpha: R, cosine: R) -> R {
    let facets = R::constant(2.0) / alpha.squared().max(R::constant(MINIMUM_WIDTH));
    facets / (R::constant(4.0) * cosine.abs().max(R::constant(MINIMUM_COSINE)))
}

/// The lobe about the mirror direction of a unit view.
// [Tokuyoshi 2016, Appendix A.1], [Wang 2009, Section 4]
pub fn mirror<R: Real>(view: Vector3<R>, normal: Vector3<R>, alpha: R) -> Reflection<R> {
    let axis = view.mirrored(normal);
    Reflection { axis, sharpness: mirror_sharpness(alpha, axis.dot(normal)) }
}

/// The dominant visible normal of GGX: the bisector of normal and view where the facets are a hemisphere.
///
/// Scaling heights by 1/alpha turns the ellipsoid of GGX into a hemisphere and directions `v` into
/// `(alpha v_t, v_n)`; normals scale back with another alpha. The mirror image of the view in it is within 0.29 radians
/// of the mean direction of the reflected lobe (the mirror direction within 1.57), and equal to it for alpha 1.
// [Tokuyoshi 2024]
pub fn dominant_visible_normal<R: Real>(
    view: Vector3<R>,
    normal: Vector3<R>,
    alpha: R,
) -> Vector3<R> {
    let width = alpha.squared().max(R::constant(MINIMUM_WIDTH));
    let height = view.dot(normal);
    let along = view - normal * height;
    let height = height.max(R::zero());
    let stretched = (width * along.length_squared() + height.squared()).sqrt();
    let lift = (height + stretched).max(R::constant(MINIMUM_FACET_COSINE));
    (along * width + normal * lift).normalized()
}

/// The lobe about the mirror image of the view in the dominant visible normal.
// [Tokuyoshi 2024]
pub fn dominant<R: Real>(view: Vector3<R>, normal: Vector3<R>, alpha: R) -> Reflection<R> {
    let facet = dominant_visible_normal(view, normal, alpha);
    let width = alpha.squared().max(R::constant(MINIMUM_WIDTH));
    let facets = R::constant(2.0) * (R::one() - alpha) * (R::one() + alpha) / width;
    let cosine = view.dot(facet).abs().max(R::constant(MINIMUM_FACET_COSINE));
    Reflection { axis: view.mirrored(facet), sharpness: facets / (R::constant(4.0) * cosine) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::ggx;
    use crate::quadrature::SphereRule;

    const NORMAL: Vector3 = Vector3::new(0.0, 0.0, 1.0);

    fn at(angle: f64) -> Vector3 {
        Vector3::new(angle.sin(), 0.0, angle.cos())
    }

    /// The mean direction of the reflected lobe: the mirror images of the view in the visible facets.
    fn mean_direction(view: Vector3, alpha: f64) -> Vector3 {
        let visible = SphereRule::around(NORMAL, 4.0 / (alpha * alpha))
            .with_azimuths(512)
            .integrate_color(|half| {
                if half.z <= 0.0 {
                    return Vector3::zero();
                }
                let weight = ggx::d_ggx(half.z, alpha) * view.dot(half).max(0.0);
                view.mirrored(half) * weight
            });
        visible.normalized()
    }

    /// The alternative: unlike the bisector, the exact mean of the visible normals of the hemisphere.
    fn mean_of_hemisphere(view: Vector3, alpha: f64) -> Vector3 {
        let scaled = Vector3::new(alpha * view.x, 0.0, view.z).normalized();
        let mean = SphereRule::around(NORMAL, 1.0).with_azimuths(512).integrate_color(|half| {
            if half.z > 0.0 { half * scaled.dot(half).max(0.0) } else { Vector3::zero() }
        });
        let facet = Vector3::new(alpha * mean.x, 0.0, mean.z).normalized();
        view.mirrored(facet)
    }

    #[test]
    fn the_dominant_lobe_is_closer_to_the_mean_direction_than_the_mirror_direction() {
        let angle_between = |a: Vector3, b: Vector3| a.cross(b).length().atan2(a.dot(b));
        let mut worst = [0.0_f64; 3];
        for alpha in [0.05, 0.1, 0.2, 0.5, 1.0] {
            for angle in [0.2, 0.8, 1.3, 1.5, 1.56] {
                let expected = mean_direction(at(angle), alpha);
                let errors = [
                    angle_between(dominant(at(angle), NORMAL, alpha).axis, expected),
                    angle_between(mirror(at(angle), NORMAL, alpha).axis, expected),
                    angle_between(mean_of_hemisphere(at(angle), alpha), expected),
                ];
                println!("alpha {alpha} angle {angle}: {errors:.3?}");
                assert!(errors[0] < errors[1].max(0.05), "{alpha} {angle} {errors:?}");
                for (worst, error) in worst.iter_mut().zip(errors) {
                    *worst = worst.max(error);
                }
            }
        }
        println!("worst, in radians: {worst:.3?}");
        // The hemisphere's mean normal does better on smooth surfaces and worse on rough ones.
        assert!(worst[0] < 0.29 && worst[1] > 1.5 && worst[2] > 0.46, "{worst:?}");
    }

    #[test]
    fn is_finite_at_every_view_and_roughness() {
        for alpha in [0.0, 1e-6, 1e-4, 0.01, 0.5, 1.0] {
            for angle in [0.0, 1e-9, 1.0, 1.56, 1.6, 3.0, core::f64::consts::PI] {
                for lobe in [mirror::<f64>, dominant].map(|lobe| lobe(at(angle), NORMAL, alpha)) {
                    assert!((lobe.axis.length() - 1.0).abs() < 1e-12, "{alpha} {angle} {lobe:?}");
                    assert!(lobe.sharpness >= 0.0 && lobe.sharpness < 1e19, "{alpha} {lobe:?}");
                }
            }
        }
        // Smooth facets: the mirror direction itself.
        assert!((dominant(at(1.0), NORMAL, 1e-4).axis - at(1.0).mirrored(NORMAL)).length() < 1e-7);
        assert_eq!(dominant(at(1.0), NORMAL, 1.0).sharpness, 0.0);
    }
}

//! Specular reflection of a spherical Gaussian by a filtered distribution, as published: what [`super::ndf_filtered`] is
//! compared with.
//!
//! Half vectors are projected along the normal, `u = h/n.h`. There GGX of roughness alpha is `(1 + u^T M u)^-2` with the
//! inverse of `M = alpha^2/(1 - alpha^2)` times the identity; a light of sharpness l has the covariance `1/l` in light
//! directions, and `J J^T/l` in half vectors, J the Jacobian of half vectors by light directions at the normal:
//! `diag(1/2, 1/(2 n.v))` along and across the plane of incidence. Filtered, `M + 2 J J^T/l` takes the place of M, and goes
//! back to squared roughnesses by `P/(1 + P)`.
//!
//! The text of the publication was not at hand: this follows a description of the method. Where the description leaves a
//! choice, the one was taken whose root mean square error against quadrature is that of a transcription of the published
//! sample, 0.182 (example `specular_model_error`, white metal): the projected area of facets all around (of those above the
//! surface: 0.317), a reflection lobe of sharpness `(2/alpha^2 - 2)/4` about the dominant direction in the share above the
//! horizon (over the cosine of the facet as well: 0.190), no shadowing. Where Fresnel's term is taken could not be checked:
//! here it is at the half vector of the lobe's axis.

use core::f64::consts::PI;

use crate::brdf::incidence::across;
use crate::brdf::material::{MINIMUM_COSINE, MINIMUM_WIDTH};
use crate::brdf::ndf_filtered::{GREATEST_SHARPNESS, LEAST_SHARPNESS, MINIMUM_SMOOTHNESS};
use crate::brdf::reflection;
use crate::sg::{hemisphere_share, integral, product};
use crate::{Real, Vector3};

/// The reflected radiance of a spherical Gaussian of amplitude 1 and of a unit axis, but for Fresnel's term.
// [Tokuyoshi 2024], without its text
pub fn reflection<R: Real>(
    view: Vector3<R>,
    normal: Vector3<R>,
    alpha: R,
    axis: Vector3<R>,
    sharpness: R,
) -> R {
    let one = R::one();
    let width = alpha.squared().max(R::constant(MINIMUM_WIDTH));
    let smoothness = ((one - alpha) * (one + alpha)).max(R::constant(MINIMUM_SMOOTHNESS));
    let narrowed = sharpness.clamp(LEAST_SHARPNESS, GREATEST_SHARPNESS);
    let height = view.dot(normal).clamp(MINIMUM_COSINE, 1.0);
    let height_squared = height.squared();

    // P + 1/s with s = 2 l and 2 l (n.v)^2, back as a roughness, all times s (1 - alpha^2): no part is ever subtracted.
    let filtered = |spread: R| (width * spread + smoothness) / (spread + smoothness);
    let twice = narrowed + narrowed;
    let (roughness_x, roughness_y) = (filtered(twice), filtered(twice * height_squared));

    // The density of facets at the half vector, [Walter 2007, Eq. (33)] with two roughnesses.
    let half = view + axis;
    let across = across(view, normal);
    let along = across.cross(normal);
    let stretched = half.dot(along).squared() / roughness_x
        + half.dot(across).squared() / roughness_y
        + half.dot(normal).squared();
    let quotient = half.length_squared() / stretched.max(R::constant(1e-12));
    let density =
        quotient.squared() / (R::constant(PI) * (roughness_x.sqrt() * roughness_y.sqrt()));

    // Four times the projected area of facets all around.
    let rest = (one - height_squared).max(R::zero());
    let area = R::constant(4.0) * (height_squared + rest * roughness_x).sqrt();

    let own = reflection::dominant(view, normal, alpha);
    let lobe = product(axis, narrowed, own.axis, R::constant(0.5) * (smoothness / width));
    let share = hemisphere_share(lobe.axis.dot(normal), lobe.sharpness);
    density / area * share * integral(sharpness)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;

    const NORMAL: Vector3 = Vector3::new(0.0, 0.0, 1.0);

    fn at(angle: f64) -> Vector3 {
        Vector3::new(angle.sin(), 0.0, angle.cos())
    }

    /// The same by matrices, in the plane of half vectors, for a view at any azimuth.
    fn by_matrices(view: Vector3, alpha: f64, axis: Vector3, sharpness: f64) -> f64 {
        let tangential = (view.x * view.x + view.y * view.y).sqrt();
        let (c, s) = (view.x / tangential, view.y / tangential);
        // J = rotation diag(1/2, 1/(2 n.v)); J J^T.
        let (a, b) = (0.25, 0.25 / (view.z * view.z));
        let jj =
            [[c * c * a + s * s * b, c * s * (a - b)], [c * s * (a - b), s * s * a + c * c * b]];
        let own = alpha * alpha / (1.0 - alpha * alpha);
        let mut p = jj.map(|row| row.map(|value| 2.0 * value / sharpness));
        (p[0][0], p[1][1]) = (p[0][0] + own, p[1][1] + own);
        // P (1 + P)^-1.
        let det = |m: [[f64; 2]; 2]| m[0][0] * m[1][1] - m[0][1] * m[1][0];
        let whole = [[1.0 + p[0][0], p[0][1]], [p[1][0], 1.0 + p[1][1]]];
        let r = [
            [(p[0][0] + det(p)) / det(whole), p[0][1] / det(whole)],
            [p[1][0] / det(whole), (p[1][1] + det(p)) / det(whole)],
        ];
        let h = (view + axis).normalized();
        let quadratic = (r[1][1] * h.x * h.x - 2.0 * r[0][1] * h.x * h.y + r[0][0] * h.y * h.y)
            / det(r)
            + h.z * h.z;
        let density = 1.0 / (PI * det(r).sqrt() * quadratic * quadratic);
        let area = r[0][0] * view.x * view.x
            + 2.0 * r[0][1] * view.x * view.y
            + r[1][1] * view.y * view.y
            + view.z * view.z;
        let own = reflection::dominant(view, NORMAL, alpha);
        let facets = 2.0 / (alpha * alpha) - 2.0;
        let lobe = product(axis, sharpness, own.axis, facets / 4.0);
        density / (4.0 * area.sqrt())
            * hemisphere_share(lobe.axis.z, lobe.sharpness)
            * integral(sharpness)
    }

    #[test]
    fn equals_the_matrices() {
        for (alpha, sharpness) in [(0.05, 300.0), (0.3, 5.0), (0.9, 40.0), (0.5, 0.1)] {
            for azimuth in [0.3_f64, 2.0] {
                let rotated = |angle: f64, azimuth: f64| {
                    let (sine, cosine) = angle.sin_cos();
                    Vector3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine)
                };
                let view = rotated(0.9, azimuth);
                let axis = rotated(0.7, azimuth + 3.0);
                let found = reflection(view, NORMAL, alpha, axis, sharpness);
                let expected = by_matrices(view, alpha, axis, sharpness);
                assert!((found / expected - 1.0).abs() < 1e-9, "{alpha} {sharpness} {found}");
                // Negative control: another light.
                let other = by_matrices(view, alpha, axis, 1.1 * sharpness);
                assert!((found / other - 1.0).abs() > 1e-3, "{alpha} {sharpness} {found}");
            }
        }
    }

    #[test]
    fn is_finite_and_positive_everywhere() {
        let mut count = 0;
        for alpha in [0.0, 1e-4, 0.01, 0.3, 1.0] {
            for angle in [0.0, 1e-7, 0.5, 1.57, 1.5709, 2.5, PI] {
                for light in [0.0, 1e-7, -0.5, 0.5, 1.57, -1.57, 3.0, angle + PI] {
                    for sharpness in [0.0, 1e-38, 2f64.powi(-24), 1.0, 1e5, 2f64.powi(41), 3.4e38] {
                        let found = reflection(at(angle), NORMAL, alpha, at(light), sharpness);
                        assert!(found.is_finite() && found >= 0.0, "{alpha} {angle} {found}");
                        count += 1;
                    }
                }
            }
        }
        assert!(count > 1000);
    }

    #[test]
    fn tolerances_are_useful() {
        for alpha in [0.01, 0.1, 0.5, 1.0] {
            for (angle, sharpness) in [(0.1, 5.0), (0.8, 300.0), (1.5, 1.0), (1.3, 1e4)] {
                let constant = |vector| Vector3::<Bounded>::constant(vector);
                let found = reflection(
                    constant(at(angle)),
                    constant(NORMAL),
                    Bounded::constant(alpha),
                    constant(at(0.1 - angle)),
                    Bounded::constant(sharpness),
                );
                assert!(found.error < 2e-3 * found.value, "{found:?}");
            }
        }
    }
}

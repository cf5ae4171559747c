//! What a rough surface reflects specularly of light from one direction, into all directions.

use core::f64::consts::PI;

use crate::brdf::fresnel::f90;
use crate::brdf::ggx;
use crate::{Real, Vector3};

// Both rational functions were fitted over cosines 0.001 to 1 and alpha 0.01 to 1 by the example fit_albedo: what facets lose
// to an absolute error of 0.0101, what Schlick's term adds to 0.049 of 0.04 + 0.96 times itself, a dielectric's albedo.

/// Largest error of [`directional`] for white metal: that of the fit, and what it is more between the points of its grid.
pub const WHITE_ERROR: f64 = 0.0105;
/// Largest error of [`directional`] for a dielectric of reflectance 0.04, over its albedo or 0.04, whichever is larger:
/// 0.96 x 0.049 by Schlick's term and 0.0101 by what facets lose, 0.057, where the term adds nothing; less elsewhere.
pub const DIELECTRIC_ERROR: f64 = 0.06;
/// The same for a reflectance of 0.01, of which half of Schlick's term is left: (0.49 x 0.049 x 0.04)/0.01 and 0.0101, 0.106;
/// 0.108 with what it is more between the points of the grid.
pub const FADING_ERROR: f64 = 0.11;

/// Coefficients of what facets lose: of 1, `a`, `c`, `a^2` above, times `ac`, with c the cosine and a the roughness alpha.
pub const LOST_NUMERATOR: [f64; 4] = [75.2404, -86.332, 27.0435, 1696.63];
/// Coefficients of the same: of `a`, `a^2`, `a^3`, `c`, `c^2`, `c^3`, `ac`, `a^2 c`, `a c^2` below.
pub const LOST_DENOMINATOR: [f64; 9] =
    [1.0, 480.834, -55.6694, 0.213211, 569.433, 302.306, -493.684, 3155.88, -1489.48];
/// Coefficients of what Schlick's term adds: of 1, `c`, `a`, `ac` above, times `(1 - c)^4`.
pub const SCHLICK_NUMERATOR: [f64; 4] = [0.935145, 0.599728, 0.85104, -3.30658];
/// Coefficients of the same: of 1, `c`, `a`, `c^2`, `ac`, `a^2` below.
pub const SCHLICK_DENOMINATOR: [f64; 6] = [1.0, -0.481459, 14.2642, 7.74423, -40.5106, 26.1089];

/// What white facets lose between them: 1 minus the directional albedo of GGX without Fresnel's term.
fn lost<R: Real>(cosine: R, alpha: R) -> R {
    let (c, a) = (cosine, alpha);
    let [n0, n1, n2, n3] = LOST_NUMERATOR.map(R::constant);
    let [d0, d1, d2, d3, d4, d5, d6, d7, d8] = LOST_DENOMINATOR.map(R::constant);
    let above = n0 + n1 * a + n2 * c + n3 * (a * a);
    // In powers of c, whose coefficients are polynomials of a.
    let below =
        (d0 + (d1 + d2 * a) * a) * a + (d3 + (d6 + d7 * a) * a + (d4 + d8 * a + d5 * c) * c) * c;
    c * a * above / below
}

/// The share that Schlick's term adds: the directional albedo of GGX with the weight `(1 - v.h)^5`.
fn schlick_share<R: Real>(cosine: R, alpha: R) -> R {
    let (c, a) = (cosine, alpha);
    let [n0, n1, n2, n3] = SCHLICK_NUMERATOR.map(R::constant);
    let [d0, d1, d2, d3, d4, d5] = SCHLICK_DENOMINATOR.map(R::constant);
    let above = n0 + n1 * c + (n2 + n3 * c) * a;
    let below = d0 + (d1 + d3 * c) * c + (d2 + d4 * c + d5 * a) * a;
    let fourth = (R::one() - c).squared().squared();
    (fourth * above / below).max(R::zero())
}

/// The directional albedo of GGX with Schlick's Fresnel term, from the specular reflectance at normal incidence (0 to 1), the
/// cosine of the light and the roughness alpha (0.01 to 1). The cosine is moved into 0 to 1; 0 for a reflectance of 0.
///
/// Within [`WHITE_ERROR`], [`DIELECTRIC_ERROR`] and [`FADING_ERROR`] of the [`quadrature`].
// [Schlick 1994, Eq. (15)] with [`f90`] for white, integrated over GGX; the fits are ours
pub fn directional<R: Real>(specular: Vector3<R>, cosine: R, alpha: R) -> Vector3<R> {
    let cosine = cosine.clamp(0.0, 1.0);
    let added = schlick_share(cosine, alpha);
    let white = R::one() - lost(cosine, alpha);
    let own = (white - added).max(R::zero());
    (specular * own + Vector3::splat(f90(specular) * added)).map(|part| part.min(R::one()))
}

/// The albedo of white facets and that of Schlick's weight alone, by quadrature over the facets that are visible from
/// the direction of the light; for cosines and alphas above 0. Off by less than 2e-4; a millisecond.
// [Dupuy 2023] for the visible facets, [Heitz 2014, Eq. (99)] for what is shadowed of them
#[must_use]
pub fn quadrature(cosine: f64, alpha: f64) -> [f64; 2] {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let view = Vector3::new(sine, 0.0, cosine);
    let stretched = Vector3::new(alpha * sine, 0.0, cosine).normalized();
    let (heights, azimuths) = (300, 120);
    let mut sum = [0.0; 2];
    for height in 0..heights {
        // Mirror directions of the stretched view in a hemisphere are uniform on a cap of the sphere.
        let share = (f64::from(height) + 0.5) / f64::from(heights);
        let z = (1.0 - share) * (1.0 + stretched.z) - stretched.z;
        let around = (1.0 - z * z).max(0.0).sqrt();
        for azimuth in 0..azimuths {
            let phi = PI * (f64::from(azimuth) + 0.5) / f64::from(azimuths);
            let cap = Vector3::new(around * phi.cos(), around * phi.sin(), z) + stretched;
            let half = Vector3::new(alpha * cap.x, alpha * cap.y, cap.z.max(0.0)).normalized();
            let light = view.mirrored(half);
            if light.z <= 0.0 {
                continue;
            }
            let facing = view.dot(half);
            let weight = shadowing(light.z, cosine, alpha);
            sum[0] += weight;
            sum[1] += weight * (1.0 - facing).max(0.0).powi(5);
        }
    }
    sum.map(|sum| sum / f64::from(heights * azimuths))
}

/// Masking and shadowing over masking of the view alone.
fn shadowing(cosine_light: f64, cosine_view: f64, alpha: f64) -> f64 {
    let root = (cosine_view.powi(2) * (1.0 - alpha * alpha) + alpha * alpha).sqrt();
    let masking = 2.0 * cosine_view / (cosine_view + root);
    4.0 * cosine_light * cosine_view * ggx::v_smith_ggx_correlated(cosine_light, cosine_view, alpha)
        / masking
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::{Directions, Material, Ndf};
    use crate::quadrature::SphereRule;

    const ALPHAS: [f64; 8] = [0.01, 0.04, 0.13, 0.27, 0.4, 0.6, 0.8, 1.0];
    const COSINES: [f64; 9] = [0.003, 0.02, 0.07, 0.15, 0.3, 0.45, 0.65, 0.85, 1.0];

    #[test]
    fn the_truth_is_that_of_the_sphere() {
        // Another rule, over light directions instead of visible facets.
        let normal = Vector3::new(0.0, 0.0, 1.0);
        for (angle, alpha) in [(0.3_f64, 0.5), (1.0, 0.3), (1.3, 0.8)] {
            let view = Vector3::new(angle.sin(), 0.0, angle.cos());
            let albedo = |specular: f64| {
                let specular = Vector3::splat(specular);
                let material = Material { diffuse: Vector3::zero(), specular, alpha };
                let mirror = view.mirrored(normal);
                SphereRule::around(mirror, 8.0).with_azimuths(512).integrate(|light| {
                    let directions = Directions { normal, view, light };
                    material.specular_brdf(Ndf::Ggx, &directions).x * light.z.max(0.0)
                })
            };
            let [white, added] = quadrature(view.z, alpha);
            assert!((albedo(1.0) - white).abs() < 3e-4, "{angle} {alpha} {white}");
            let dielectric = 0.04 * (white - added) + added;
            assert!((albedo(0.04) - dielectric).abs() < 3e-4, "{angle} {alpha} {dielectric}");
            // Negative control: without Fresnel's term, where that is more than the quadrature's error.
            assert!((albedo(0.04) - 0.04 * white).abs() > 1e-3 || angle < 0.5);
        }
    }

    #[test]
    fn the_fit_is_as_close_as_it_says() {
        let (mut worst, mut printed) = ([0.0_f64; 3], [0.0_f64; 3]);
        for alpha in ALPHAS {
            for cosine in COSINES {
                let [white, added] = quadrature(cosine, alpha);
                let specular = Vector3::new(1.0, 0.04, 0.01);
                let found = directional(specular, cosine, alpha).to_array();
                let apart = [1.0, 0.04, 0.01].map(|reflectance| {
                    let found = directional(Vector3::splat(reflectance), cosine, alpha).x;
                    let fading = (50.0 * reflectance).min(1.0);
                    (found, reflectance * (white - added) + fading * added, reflectance)
                });
                for (index, (found, expected, reflectance)) in apart.into_iter().enumerate() {
                    // Relative, with the reflectance at normal incidence as the least.
                    let scale = if index == 0 { 1.0 } else { expected.max(reflectance) };
                    worst[index] = worst[index].max((found - expected).abs() / scale);
                    printed[index] = printed[index].max((reflectance - expected).abs() / scale);
                }
                // Channels of one colour share what is reached at grazing angles.
                assert!(found[0] >= found[1] && found[1] >= found[2]);
            }
        }
        println!("{worst:.4?}; reflectance at normal incidence: {printed:.3?}");
        // On these points; the stated errors are of all.
        assert!(worst[0] < WHITE_ERROR && worst[1] < 0.055 && worst[2] < 0.1, "{worst:?}");
        // Negative control: the reflectance at normal incidence in the albedo's place.
        assert!(printed[0] > 0.6 && printed[1] > 0.9, "{printed:?}");
    }

    #[test]
    fn nothing_reflects_nothing_and_everything_stays_in_range() {
        for alpha in [0.01, 0.011, 0.1, 0.33, 0.5, 0.77, 1.0] {
            for step in -10..=1010 {
                let cosine = f64::from(step) * 1e-3;
                let found = directional(Vector3::new(1.0, 0.04, 0.0), cosine, alpha);
                assert!(found.x <= 1.0 && found.x > 0.3 && found.z >= 0.0, "{cosine} {found:?}");
                assert_eq!(directional(Vector3::zero(), cosine, alpha), Vector3::zero());
            }
        }
    }
}

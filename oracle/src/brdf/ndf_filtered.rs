//! Specular reflection of a spherical Gaussian: the distribution of facets, filtered by the light's lobe.
//!
//! The light's lobe is a Gaussian over half vectors. Convolved with it, the distribution of GGX is taken to be GGX
//! again, of another roughness along and across the plane of incidence: the reflection of the whole lobe is that of a
//! single direction by a rougher surface. [Tokuyoshi 2024]
//!
//! In the projected space of half vectors `h / n.h`, GGX is `(1 + |u|^2/P)^-2` with `P = alpha^2/(1 - alpha^2)`, and a
//! reflection lobe of roughness R in a direction has `R = P/(1 + P)`. A light direction that turns by an angle turns the
//! half vector by half of it in the plane of incidence and by 1/(2 v.h) of it across.
//!
//! Some things differ from the publication, each because it was measured to be closer to the reference:
//! - The width of the light's lobe is not 2/l but what gives the filtered reflection of a perfect mirror the peak of the
//!   lobe itself, exactly: `P = 1/(l (1 + L(l)))`, L being the mean length of a von Mises-Fisher lobe.
//! - Widths do not simply add: GGX has tails, which the convolution takes from the peak.
//! - The convolution has no more tails than the facets have: of a width that comes from the light, the shape is that of
//!   the light's lobe about the reflection lobe's axis.
//! - The result goes over from the projected area of the upper hemisphere's facets, exact for one direction, to that of
//!   facets all around, exact for light from everywhere.

use core::f64::consts::PI;

use crate::brdf::incidence::across;
use crate::brdf::material::{MINIMUM_COSINE, MINIMUM_WIDTH};
use crate::brdf::reflection;
use crate::sg::{hemisphere_share, integral, product};
use crate::vmf::{mean_length, mean_length_complement};
use crate::{Real, Vector3};

/// The greatest sharpness of a light's lobe that is distinguished.
pub const GREATEST_SHARPNESS: f64 = 1e15;
/// The least sharpness that is.
pub const LEAST_SHARPNESS: f64 = 1e-20;
/// What a convolved GGX is wider than the sum of its widths; fitted by the example `ndf_filter_fit` to the peak of the
/// convolution, over ratios of widths from 1e-6 to 1e6, to a relative 1.8 % (20 % without it).
pub const WIDENING: f64 = 0.485;
/// The least `1 - alpha^2`.
pub const MINIMUM_SMOOTHNESS: f64 = 1e-7;

/// What a surface reflects of a spherical Gaussian of amplitude 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilteredReflection<R = f64> {
    /// The reflected radiance, but for Fresnel's term.
    pub radiance: R,
    /// The cosine between half vector and view for Fresnel's term.
    pub cosine: R,
}

/// The filtered distribution along one axis of the projected space.
struct Filter<R> {
    /// What the light has added to the squared roughness.
    extra: R,
    /// The facets' share of the width, 0 to 1: that of the tails.
    tails: R,
    /// The light's width over the whole, 0 to 1.
    narrowing: R,
}

/// Of squared roughness, one minus that, and the inverse width of the light.
fn filter<R: Real>(width: R, smoothness: R, spread: R) -> Filter<R> {
    // P + 1/s + k P log2(1 + 1/(P s)), multiplied by s (1 - alpha^2): neither alpha 1 nor s = 0 divides by zero.
    let own = width * spread;
    let tails = R::constant(WIDENING) * own * (R::one() + smoothness / own).log2();
    let added = smoothness + tails;
    Filter {
        extra: smoothness * (added / (spread + added)),
        tails: own / (own + added),
        narrowing: smoothness / (own + added),
    }
}

/// The mean cosine of the part of a lobe above the horizon, roughly: from that of the whole lobe to 1/sqrt(l).
fn cosine_above<R: Real>(cosine: R, sharpness: R) -> R {
    let mean = mean_length(sharpness) * cosine;
    let spread = R::one() / (sharpness + R::one());
    let root = (mean.squared() + spread).sqrt();
    let half = R::constant(0.5);
    let above =
        if mean.value() < 0.0 { half * spread / (root - mean) } else { half * (mean + root) };
    above.clamp(1e-4, 1.0)
}

/// The reflection of a spherical Gaussian of a unit axis by GGX facets of roughness alpha.
// [Tokuyoshi 2024], with the differences that the module states
pub fn reflection<R: Real>(
    view: Vector3<R>,
    normal: Vector3<R>,
    alpha: R,
    axis: Vector3<R>,
    sharpness: R,
) -> FilteredReflection<R> {
    let (one, quarter) = (R::one(), R::constant(0.25));
    let width = alpha.squared().max(R::constant(MINIMUM_WIDTH));
    let smoothness = ((one - alpha) * (one + alpha)).max(R::constant(MINIMUM_SMOOTHNESS));
    let narrowed = sharpness.clamp(LEAST_SHARPNESS, GREATEST_SHARPNESS);

    // Along and across the plane of incidence.
    let half = view + axis;
    let squared_length = half.length_squared();
    let turned = (quarter * squared_length).max(R::constant(MINIMUM_COSINE * MINIMUM_COSINE));
    let spread = narrowed * (one + mean_length(narrowed));
    let height = view.dot(normal).clamp(MINIMUM_COSINE, 1.0);
    let height_squared = height.squared();
    let filter_x = filter(width, smoothness, spread);
    let filter_y = filter(width, smoothness, spread * turned);
    let filter_mirror = filter(width, smoothness, spread * height_squared);
    let roughness_x = width + filter_x.extra;
    let roughness_y = width + filter_y.extra;
    let roughness_mirror = width + filter_mirror.extra;

    // The density of facets at the half vector, [Walter 2007, Eq. (33)] with two roughnesses.
    let across = across(view, normal);
    let along = across.cross(normal);
    let stretched = half.dot(along).squared() / roughness_x
        + half.dot(across).squared() / roughness_y
        + half.dot(normal).squared();
    let quotient = squared_length / stretched.max(R::constant(1e-12));
    let facets = quotient.squared() / roughness_y.sqrt();

    // The light's lobe about the axis of the surface's.
    let own = reflection::dominant(view, normal, alpha);
    let chord = axis - own.axis;
    let chord_y = chord.dot(across);
    let chord_x = chord - across * chord_y;
    let exponent =
        filter_x.narrowing * chord_x.length_squared() + filter_mirror.narrowing * chord_y.squared();
    let gaussian = (exponent * narrowed * R::constant(-0.5)).exp() / roughness_mirror.sqrt();

    let tails = (filter_x.tails * filter_y.tails).sqrt().min(one);
    let density =
        (tails * facets + (one - tails) * gaussian) / (R::constant(PI) * roughness_x.sqrt());

    // Four times the facets' projected area towards the view: only the light's part of the filter reaches below.
    let rest = (one - height_squared).max(R::zero());
    let masked = |roughness: R| (height_squared + rest * roughness).sqrt();
    let area = R::constant(2.0) * (masked(filter_x.extra) + masked(roughness_x));

    // The share above the horizon is that of what the light and the surface agree on: their product.
    let lobe = product(axis, narrowed, own.axis, own.sharpness);
    let cosine = lobe.axis.dot(normal);
    let light = cosine_above(axis.dot(normal), narrowed);
    let shadowed = (light.squared() + width * (one - light.squared()).max(R::zero())).sqrt();
    // Height-correlated masking and shadowing over masking alone. [Heitz 2014, Eq. (99), Eq. (43)]
    let shadowing = light * (height + masked(width)) / (light * masked(width) + height * shadowed);

    let radiance =
        density / area * shadowing * hemisphere_share(cosine, lobe.sharpness) * integral(sharpness);
    // Half angles of the mean cosine of the lobe with the view, which is shorter than that of its axis.
    let facing = quarter * (view + lobe.axis).length_squared();
    let mean = R::constant(0.5) * mean_length_complement(lobe.sharpness)
        + mean_length(lobe.sharpness) * facing;
    FilteredReflection { radiance, cosine: mean.sqrt().min(one) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;
    use crate::brdf::{Directions, Material, Ndf};

    const NORMAL: Vector3 = Vector3::new(0.0, 0.0, 1.0);

    fn at(angle: f64) -> Vector3 {
        Vector3::new(angle.sin(), 0.0, angle.cos())
    }

    #[test]
    fn one_direction_is_reflected_exactly() {
        for alpha in [0.1, 0.5, 1.0] {
            for (angle, light) in [(0.3, -0.4), (1.2, -1.0), (1.5, 0.7)] {
                let (view, light) = (at(angle), at(light));
                let directions = Directions { normal: NORMAL, view, light };
                let material =
                    Material { diffuse: Vector3::zero(), specular: Vector3::splat(1.0), alpha };
                let brdf = material.specular_brdf(Ndf::Ggx, &directions).x * light.z;
                let ratio = |sharpness| {
                    let found = reflection(view, NORMAL, alpha, light, sharpness);
                    found.radiance / (brdf * integral(sharpness))
                };
                assert!((ratio(1e9) - 1.0).abs() < 1e-4, "{alpha} {angle} {}", ratio(1e9));
                // Negative control: a wider lobe is another thing.
                assert!((ratio(10.0) - 1.0).abs() > 1e-3);
            }
        }
    }

    #[test]
    fn a_mirror_shows_the_peak_of_the_lobe() {
        for sharpness in [1e-3, 1.0, 30.0, 1e4] {
            for angle in [0.0, 0.7, 1.2] {
                let view = at(angle);
                let found =
                    reflection(view, NORMAL, 1e-4, view.mirrored(NORMAL), sharpness).radiance;
                // 1, but for what the tails of the facets take away.
                assert!((found - 1.0).abs() < 2e-3, "{sharpness} {angle} {found}");
            }
        }
    }

    #[test]
    fn is_finite_and_positive_everywhere() {
        let sharpnesses = [0.0, 1e-38, 2f64.powi(-24), 1.0, 1e5, 2f64.powi(41), 3.4e38];
        let mut count = 0;
        for alpha in [0.0, 1e-4, 0.01, 0.3, 1.0] {
            for angle in [0.0, 1e-7, 0.5, 1.57, 1.5709, 2.5, PI] {
                for light in [0.0, 1e-7, -0.5, 0.5, 1.57, -1.57, 3.0, angle + PI] {
                    for sharpness in sharpnesses {
                        let found = reflection(at(angle), NORMAL, alpha, at(light), sharpness);
                        assert!(found.radiance.is_finite() && found.radiance >= 0.0, "{found:?}");
                        assert!((0.0..=1.0).contains(&found.cosine), "{found:?}");
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
                let share = found.radiance.error / found.radiance.value;
                println!("alpha {alpha} angle {angle} sharpness {sharpness}: {share:.1e}");
                assert!(share < 2e-3, "{found:?}");
            }
        }
    }
}

//! Specular reflection of an incoming spherical Gaussian.

use core::f64::consts::PI;

use crate::brdf::{Directions, Material, Ndf};
use crate::quadrature::SphereRule;
use crate::rsm::moments::specular_sharpness;
use crate::sg::product_integral;
use crate::shade::Incoming;
use crate::{Real, Vector3};

/// The least cosine of the view in the anisotropic lobe.
pub const MINIMUM_ANISOTROPIC_COSINE: f64 = 1e-2;

/// How the reflection lobe is approximated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Specular {
    /// By a spherical Gaussian.
    Sg,
    /// By an anisotropic spherical Gaussian.
    Asg,
}

/// The factor `C = D_peak F V cos` of the lobe at the axis of the incoming radiance; 0 from below the horizon.
// [Tokuyoshi 2016, Appendix A.1, Specular lobes]
fn amplitude<R: Real>(material: &Material<R>, ndf: Ndf, directions: &Directions<R>) -> Vector3<R> {
    let cosine = directions.normal.dot(directions.light).max(R::zero());
    let peak = R::one() / (R::constant(PI) * material.alpha.squared());
    material.visible_fresnel(ndf, directions) * (peak * cosine)
}

/// The unit axes `(x, y, z)` of the anisotropic lobe: z the mirror direction of the view, x out of the plane of
/// reflection, y within it. Where the view is along the normal, any x across z.
fn axes<R: Real>(view: Vector3<R>, normal: Vector3<R>) -> [Vector3<R>; 3] {
    let z = view.mirrored(normal);
    let (any, _) = z.value().basis();
    let x = normal.cross(z).normalized_or(Vector3::constant(any));
    [x, z.cross(x), z]
}

/// The integral of the product of a spherical and an anisotropic spherical Gaussian.
// [Xu 2013, Eq. (13)], [Tokuyoshi 2016, Appendix C.2, Specular reflection]
fn anisotropic_integral<R: Real>(
    arriving: &Incoming<R>,
    view: Vector3<R>,
    normal: Vector3<R>,
    alpha: R,
) -> R {
    let [x, y, z] = axes(view, normal);
    let bandwidth = R::one() / alpha.squared();
    let cosine = normal.dot(view).max(R::constant(MINIMUM_ANISOTROPIC_COSINE));
    // A half vector that leaves the normal by a small angle turns the mirror direction by twice that angle within the
    // plane of reflection, by twice the cosine of it across. [Xu 2013, Section 4.1]
    let quarter = bandwidth * R::constant(0.25);
    let bandwidths = [quarter / cosine.squared(), quarter];
    let half = arriving.sharpness * R::constant(0.5);
    let mut exponent = R::zero();
    let mut area = R::one();
    for (axis, own) in [x, y].into_iter().zip(bandwidths) {
        let sum = own + half;
        exponent = exponent + own * (half / sum) * arriving.axis.dot(axis).squared();
        area = area * sum;
    }
    let smooth = arriving.axis.dot(z).max(R::zero());
    R::constant(PI) * smooth * (-exponent).exp() / area.sqrt()
}

impl Specular {
    /// The reflected radiance of a material seen along `view`, at a surface of unit `normal`.
    pub fn reflect<R: Real>(
        self,
        arriving: &Incoming<R>,
        material: &Material<R>,
        ndf: Ndf,
        view: Vector3<R>,
        normal: Vector3<R>,
    ) -> Vector3<R> {
        let directions = Directions { normal, view, light: arriving.axis };
        let amplitude = amplitude(material, ndf, &directions);
        let integral = match self {
            Self::Sg => {
                let mirror = view.mirrored(normal);
                let sharpness = specular_sharpness(material.alpha, mirror.dot(normal));
                product_integral(arriving.axis, arriving.sharpness, mirror, sharpness)
            }
            Self::Asg => anisotropic_integral(arriving, view, normal, material.alpha),
        };
        arriving.coefficient.times(amplitude) * integral
    }
}

/// What the forms approximate: the reflection of the incoming lobe by the material's specular BRDF, by quadrature.
#[must_use]
pub fn truth(
    arriving: &Incoming,
    material: &Material,
    ndf: Ndf,
    view: Vector3,
    normal: Vector3,
) -> Vector3 {
    let mirror = view.mirrored(normal);
    let own = specular_sharpness(material.alpha, mirror.dot(normal));
    // Finest where the sharper of the two factors is; enough azimuths to see the other one.
    let rule = if arriving.sharpness > own {
        SphereRule::around(arriving.axis, arriving.sharpness)
    } else {
        SphereRule::around(mirror, 4.0 * own)
    };
    let azimuths = (40.0 * (own.min(arriving.sharpness) + 16.0).sqrt()).min(4000.0) as usize;
    rule.with_azimuths(azimuths).integrate_color(|light| {
        let cosine = normal.dot(light);
        if cosine <= 0.0 {
            return Vector3::zero();
        }
        let reflected = material.specular_brdf(ndf, &Directions { normal, view, light });
        arriving.radiance(light).times(reflected) * cosine
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sg::evaluate;

    const NORMAL: Vector3 = Vector3::new(0.0, 0.0, 1.0);

    fn at(angle: f64) -> Vector3 {
        Vector3::new(angle.sin(), 0.0, angle.cos())
    }

    fn material(alpha: f64) -> Material {
        Material { diffuse: Vector3::zero(), specular: Vector3::new(0.04, 0.5, 1.0), alpha }
    }

    fn arriving(axis: Vector3, sharpness: f64) -> Incoming {
        Incoming { axis, sharpness, coefficient: Vector3::splat(1.0) }
    }

    #[test]
    fn the_anisotropic_lobe_follows_the_facets() {
        // Close to the mirror direction the warped lobe has the value of the facets' Gaussian at the half vector.
        let (view, alpha) = (at(0.9), 0.05_f64);
        let [x, y, z] = axes(view, NORMAL);
        let cosine = NORMAL.dot(view);
        for offset in [x * 0.02, y * 0.02, x * 0.01 - y * 0.025] {
            let light = (z + offset).normalized();
            let half = (light + view).normalized();
            let facets = evaluate(half, NORMAL, 2.0 / (alpha * alpha));
            let eta = 0.25 / (alpha * alpha);
            let lobe = (-eta / (cosine * cosine) * light.dot(x).powi(2)
                - eta * light.dot(y).powi(2))
            .exp();
            assert!((lobe / facets - 1.0).abs() < 0.02, "{lobe} {facets}");
            // Negative control: the axes exchanged, where the offset tells them apart.
            let other = (-eta / (cosine * cosine) * light.dot(y).powi(2)
                - eta * light.dot(x).powi(2))
            .exp();
            assert!((other / facets - 1.0).abs() > 0.02);
        }
    }

    #[test]
    fn the_convolution_equals_its_quadrature_for_sharp_lobes() {
        let (view, alpha) = (at(0.7), 0.1_f64);
        let [x, y, z] = axes(view, NORMAL);
        let cosine = NORMAL.dot(view);
        for sharpness in [50.0, 1e3] {
            let arriving = arriving((z + x * 0.1 + y * 0.1).normalized(), sharpness);
            let eta = 0.25 / (alpha * alpha);
            let truth = SphereRule::around(z, 4.0 * eta).with_azimuths(512).integrate(|at| {
                let lobe =
                    (-eta / (cosine * cosine) * at.dot(x).powi(2) - eta * at.dot(y).powi(2)).exp();
                at.dot(z).max(0.0) * lobe * evaluate(at, arriving.axis, sharpness)
            });
            let found = anisotropic_integral(&arriving, view, NORMAL, alpha);
            assert!((found / truth - 1.0).abs() < 0.05, "{sharpness} {}", found / truth);
        }
    }

    #[test]
    fn approximates_the_reflection_of_a_lobe_about_the_mirror_direction() {
        // For smooth surfaces, away from grazing angles and for facets without tail; the model errors are stated.
        for (specular, alpha, angle, bound) in [
            (Specular::Sg, 0.1, 0.2, 0.05),
            (Specular::Asg, 0.1, 0.2, 0.05),
            (Specular::Asg, 0.1, 0.9, 0.10),
            (Specular::Asg, 0.05, 1.1, 0.10),
        ] {
            let (view, material) = (at(angle), material(alpha));
            for sharpness in [20.0, 300.0] {
                let arriving = arriving(view.mirrored(NORMAL), sharpness);
                let truth = truth(&arriving, &material, Ndf::Beckmann, view, NORMAL);
                let found = specular.reflect(&arriving, &material, Ndf::Beckmann, view, NORMAL);
                let ratio = found.z / truth.z;
                println!(
                    "{specular:?} alpha {alpha} angle {angle} sharpness {sharpness}: {ratio:.4}"
                );
                assert!(
                    (ratio - 1.0).abs() < bound,
                    "{specular:?} {alpha} {angle} {sharpness}: {ratio}"
                );
                // Negative control: another roughness.
                let other = specular.reflect(
                    &arriving,
                    &self::material(1.5 * alpha),
                    Ndf::Beckmann,
                    view,
                    NORMAL,
                );
                assert!(
                    (other.z / truth.z - 1.0).abs() > bound || sharpness < 100.0,
                    "{}",
                    other.z / truth.z
                );
            }
        }
    }

    #[test]
    fn light_from_below_is_not_reflected() {
        for specular in [Specular::Sg, Specular::Asg] {
            let arriving = arriving(Vector3::new(0.6, 0.0, -0.8), 1.0);
            for ndf in [Ndf::Ggx, Ndf::Beckmann] {
                assert_eq!(
                    specular.reflect(&arriving, &material(0.5), ndf, at(1.5), NORMAL),
                    Vector3::zero()
                );
            }
        }
    }
}

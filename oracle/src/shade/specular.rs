//! Specular reflection of an incoming spherical Gaussian.

use core::f64::consts::PI;

use crate::asg;
use crate::brdf::{
    Directions, Material, Ndf, fresnel, ndf_filtered, ndf_filtered_2024, reflection,
};
use crate::quadrature::SphereRule;
use crate::sg::{product, product_integral};
use crate::shade::Incoming;
use crate::{Real, Vector3};

/// How the reflection lobe is approximated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Specular {
    /// By a spherical Gaussian.
    Sg,
    /// By an anisotropic spherical Gaussian, as printed.
    Asg,
    /// The same of a bandwidth that falls to 0 at alpha 1.
    AsgFlat,
    /// The same again, with the other factors of the BRDF at the axis of the product of both lobes.
    AsgProduct,
    /// By a distribution of facets that is filtered by the light's lobe; GGX, whatever the requested distribution.
    NdfFiltered,
    /// The same as published in 2024: widths add up, without shadowing; GGX, whatever the requested distribution.
    NdfFiltered2024,
}

/// The factor `C = D_peak F V cos` of the lobe at the axis of the incoming radiance; 0 from below the horizon.
// [Tokuyoshi 2016, Appendix A.1, Specular lobes]
fn amplitude<R: Real>(material: &Material<R>, ndf: Ndf, directions: &Directions<R>) -> Vector3<R> {
    let cosine = directions.normal.dot(directions.light).max(R::zero());
    let peak = R::one() / (R::constant(PI) * material.alpha.squared());
    material.visible_fresnel(ndf, directions) * (peak * cosine)
}

/// The axis of the product of the incoming lobe and the reflection lobe, the latter as wide as [`Specular::AsgFlat`]'s.
// [Tokuyoshi 2015 supplement, Section 3.2], of xi_m
fn product_axis<R: Real>(
    arriving: &Incoming<R>,
    view: Vector3<R>,
    normal: Vector3<R>,
    alpha: R,
) -> Vector3<R> {
    let lobe = reflection::mirror(view, normal, alpha);
    let sharpness = lobe.sharpness * ((R::one() - alpha) * (R::one() + alpha));
    product(arriving.axis, arriving.sharpness, lobe.axis, sharpness).axis
}

impl Specular {
    /// All forms.
    pub const ALL: [Self; 6] = [
        Self::Sg,
        Self::Asg,
        Self::AsgFlat,
        Self::AsgProduct,
        Self::NdfFiltered,
        Self::NdfFiltered2024,
    ];

    /// Whether the form takes the requested distribution; the others are of GGX alone.
    #[must_use]
    pub fn takes_any_distribution(self) -> bool {
        !matches!(self, Self::NdfFiltered | Self::NdfFiltered2024)
    }

    /// The reflected radiance of a material seen along `view`, at a surface of unit `normal`.
    pub fn reflect<R: Real>(
        self,
        arriving: &Incoming<R>,
        material: &Material<R>,
        ndf: Ndf,
        view: Vector3<R>,
        normal: Vector3<R>,
    ) -> Vector3<R> {
        let mut towards = arriving.axis;
        let integral = match self {
            Self::Sg => {
                let lobe = reflection::mirror(view, normal, material.alpha);
                product_integral(arriving.axis, arriving.sharpness, lobe.axis, lobe.sharpness)
            }
            Self::Asg => {
                let lobe = asg::reflection(view, normal, material.alpha);
                asg::convolution(&lobe, arriving.axis, arriving.sharpness)
            }
            Self::AsgFlat | Self::AsgProduct => {
                if self == Self::AsgProduct {
                    towards = product_axis(arriving, view, normal, material.alpha);
                }
                let lobe = asg::reflection_flat(view, normal, material.alpha);
                asg::convolution(&lobe, arriving.axis, arriving.sharpness)
            }
            Self::NdfFiltered2024 => {
                let (axis, sharpness) = (arriving.axis, arriving.sharpness);
                let reflected =
                    ndf_filtered_2024::reflection(view, normal, material.alpha, axis, sharpness);
                let cosine = (view + axis).length() * R::constant(0.5);
                let fresnel = fresnel::f_schlick(material.specular, cosine);
                return arriving.coefficient.times(fresnel) * reflected;
            }
            Self::NdfFiltered => {
                let (axis, sharpness) = (arriving.axis, arriving.sharpness);
                let found = ndf_filtered::reflection(view, normal, material.alpha, axis, sharpness);
                let fresnel = fresnel::f_schlick(material.specular, found.cosine);
                return arriving.coefficient.times(fresnel) * found.radiance;
            }
        };
        let directions = Directions { normal, view, light: towards };
        let amplitude = amplitude(material, ndf, &directions);
        arriving.coefficient.times(amplitude) * integral
    }
}

/// What the forms approximate: the reflection of the incoming lobe by the material's specular BRDF, by quadrature.
#[must_use]
pub fn quadrature(
    arriving: &Incoming,
    material: &Material,
    ndf: Ndf,
    view: Vector3,
    normal: Vector3,
) -> Vector3 {
    let mirror = view.mirrored(normal);
    let own = reflection::mirror_sharpness(material.alpha, mirror.dot(normal));
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
                let quadrature = quadrature(&arriving, &material, Ndf::Beckmann, view, NORMAL);
                let found = specular.reflect(&arriving, &material, Ndf::Beckmann, view, NORMAL);
                let ratio = found.z / quadrature.z;
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
                    (other.z / quadrature.z - 1.0).abs() > bound || sharpness < 100.0,
                    "{}",
                    other.z / quadrature.z
                );
            }
        }
    }

    #[test]
    fn the_filtered_distribution_holds_for_rough_surfaces_and_grazing_views() {
        // The largest error over lobes at and beside the mirror direction, of the brightest of their reflections.
        let error = |specular: Specular, alpha: f64, angle: f64, sharpness: f64| {
            let (view, material) = (at(angle), material(alpha));
            let mirror = view.mirrored(NORMAL);
            let (x, y) = mirror.basis();
            let step = alpha + 1.0 / sharpness.sqrt();
            let pairs = [Vector3::zero(), x, y, -y, y * 2.0].map(|aside| {
                let arriving = arriving((mirror + aside * step).normalized(), sharpness);
                let quadrature = quadrature(&arriving, &material, Ndf::Ggx, view, NORMAL);
                let found = specular.reflect(&arriving, &material, Ndf::Ggx, view, NORMAL);
                [found.z, quadrature.z, found.x, quadrature.x]
            });
            [0, 2].map(|part| {
                let brightest = pairs.iter().map(|pair| pair[part + 1]).fold(0.0, f64::max);
                let errors = pairs.iter().map(|pair| (pair[part] - pair[part + 1]).abs());
                errors.fold(0.0, f64::max) / brightest
            })
        };
        for (alpha, angle, sharpness, bound) in [
            (0.05, 0.8, 5.0, 0.02),
            (0.05, 0.8, 1000.0, 0.03),
            (0.2, 0.8, 100.0, 0.04),
            (0.2, 1.3, 1000.0, 0.03),
            (0.5, 0.2, 100.0, 0.02),
            (0.5, 1.3, 100.0, 0.06),
            (1.0, 0.2, 5.0, 0.07),
            (1.0, 1.5, 1.0, 0.06),
        ] {
            let [white, dielectric] = error(Specular::NdfFiltered, alpha, angle, sharpness);
            let others =
                [Specular::Sg, Specular::Asg].map(|other| error(other, alpha, angle, sharpness)[0]);
            println!("{alpha} {angle} {sharpness}: {white:.4} {dielectric:.4}, {others:.4?}");
            assert!(white < bound, "{alpha} {angle} {sharpness} {white}");
            // Fresnel's term is taken once for the whole lobe.
            assert!(dielectric < 0.5, "{alpha} {angle} {sharpness} {dielectric}");
            // Negative control: the other models leave the bound.
            assert!(others[0].min(others[1]) > bound, "{alpha} {angle} {sharpness} {others:?}");
        }
    }

    #[test]
    fn light_from_below_is_not_reflected() {
        for specular in [Specular::Sg, Specular::Asg, Specular::AsgFlat] {
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

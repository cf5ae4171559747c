//! The reflection of a light that is seen directly.

use crate::brdf::{Directions, Ndf};
use crate::light::Light;
use crate::shade::Reflected;
use crate::surface::SurfaceTexel;
use crate::{Real, Vector3};

/// The radiance that a surface reflects towards the eye at world position `eye`, of a light of which the share
/// `visibility` (0 to 1) is seen; none where there is no surface.
///
/// The BRDF is the real one, `R_d/pi + D V F`; the irradiance falls off with the squared distance, but for directional
/// lights.
pub fn direct<R: Real>(
    surface: &SurfaceTexel<R>,
    eye: Vector3<R>,
    light: &Light,
    ndf: Ndf,
    visibility: R,
) -> Reflected<R> {
    if !surface.present {
        return Reflected::none();
    }
    let (towards, distance_squared) = light.towards(surface.position);
    let along = -towards.dot(Vector3::constant(light.forward));
    let cosine = surface.normal.dot(towards).max(R::zero());
    let scale = visibility * cosine / distance_squared;
    let irradiance = light.intensity_at(along) * scale;
    let view = (eye - surface.position).normalized();
    let directions = Directions { normal: surface.normal, view, light: towards };
    Reflected {
        diffuse: irradiance.times(surface.material.diffuse_brdf()),
        specular: irradiance.times(surface.material.specular_brdf(ndf, &directions)),
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::Bounded;
    use crate::light::LightKind;

    fn light(kind: LightKind) -> Light {
        Light {
            kind,
            position: Vector3::new(0.0, 2.0, 0.0),
            right: Vector3::new(1.0, 0.0, 0.0),
            up: Vector3::new(0.0, 0.0, -1.0),
            forward: Vector3::new(0.0, -1.0, 0.0),
            intensity: Vector3::splat(8.0),
        }
    }

    fn surface<R: Real>() -> SurfaceTexel<R> {
        SurfaceTexel::decode([0.0, 0.0, 0.0, 0.04], [0.0, 1.0, 0.0, 0.5], [0.5, 0.5, 0.5, 0.0])
    }

    #[test]
    fn the_irradiance_is_the_lights() {
        let eye = Vector3::new(1.0, 1.0, 0.0);
        let cone = LightKind::Spot { tan_half_angle: 1.0, cone_scale: 10.0, cone_offset: -9.0 };
        for kind in [LightKind::Point, cone] {
            let reflected = direct(&surface(), eye, &light(kind), Ndf::Ggx, 0.5);
            assert!((reflected.diffuse.x - 0.5 * 8.0 / 4.0 * 0.5 / PI).abs() < 1e-14);
        }
        let parallel = LightKind::Directional { half_extent: 1.0 };
        let reflected = direct(&surface(), eye, &light(parallel), Ndf::Ggx, 1.0);
        assert!((reflected.diffuse.x - 8.0 * 0.5 / PI).abs() < 1e-14);
        // Outside of the cone there is none.
        let beside = SurfaceTexel { position: Vector3::new(2.0, 0.0, 0.0), ..surface() };
        assert_eq!(direct(&beside, eye, &light(cone), Ndf::Ggx, 1.0).total(), Vector3::zero());
    }

    #[test]
    fn tolerances_are_useful() {
        let eye = Vector3::constant(Vector3::new(1.0, 1.0, 0.0));
        let reflected =
            direct(&surface::<Bounded>(), eye, &light(LightKind::Point), Ndf::Ggx, Bounded::one());
        for part in [reflected.diffuse.x, reflected.specular.x] {
            assert!(part.error < 1e-4 * part.value, "{part:?}");
        }
    }
}

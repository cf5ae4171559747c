//! Densities of a texel of a reflective shadow map or a G-buffer.

use crate::brdf::Ndf;
use crate::rsm::{Lobes, Moments, SpecularPower};
use crate::shade::{self, Diffuse, Emitter, Model, Specular};
use crate::surface::SurfaceTexel;
use crate::vsgl::Vsgl;
use crate::{Real, Vector3};

/// The power that a texel reflects: the weight of its moments.
// [Tokuyoshi 2016, Section 4.1]
pub fn power<R: Real>(moments: &Moments<R>) -> R {
    moments.weight()
}

/// The reflectance of a texel; 0 without a surface.
// [Tokuyoshi 2016, Section 5]
pub fn reflectance<R: Real>(surface: &SurfaceTexel<R>, lobes: Lobes) -> R {
    if !surface.present {
        return R::zero();
    }
    match lobes {
        Lobes::Diffuse => surface.material.diffuse.luminance(),
        Lobes::Both => (surface.material.diffuse + surface.material.specular).luminance(),
    }
}

/// The power that a texel reflects times the share of it that reaches what the camera sees.
///
/// `weight`: the weight of the texel's moments; `towards`: the unit direction to the light; `camera`: the virtual lights
/// of the camera's G-buffer, where every pixel sends the same importance; `emitter`: how they send it; `specular_power`:
/// the one that the weight has.
// [Ritschel 2011; Tokuyoshi 2016, Section 5, Appendix C]
pub fn bidirectional<R: Real>(
    weight: R,
    surface: &SurfaceTexel<R>,
    towards: Vector3<R>,
    camera: impl IntoIterator<Item = Vsgl<R>>,
    emitter: Emitter,
    lobes: Lobes,
    specular_power: SpecularPower,
) -> R {
    if weight.value() <= 0.0 {
        return R::zero();
    }
    let specular = (lobes == Lobes::Both).then_some(Specular::Sg);
    let model = Model { emitter, diffuse: Some(Diffuse::Constant), specular, ndf: Ndf::Ggx };
    let importance = shade::towards(surface, towards, camera, &model).total().luminance();
    weight * (importance / reflectance(&specular_power.reflecting(surface, towards), lobes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rsm::{Emission, moments};

    const F0: SpecularPower = SpecularPower::F0;

    fn patch(x: f64, facing: f64) -> SurfaceTexel {
        SurfaceTexel::decode(
            [x as f32, 0.0, 0.0, 0.0],
            [facing as f32, 0.0, 0.0, 1.0],
            [0.5, 0.5, 0.5, 0.0],
        )
    }

    fn camera_light(surface: &SurfaceTexel, lobes: Lobes) -> Vsgl {
        let eye = Vector3::new(0.0, 1.0, 0.0);
        let towards = (eye - surface.position).normalized();
        let moments = moments(
            surface,
            Vector3::splat(1.0),
            towards,
            Vector3::zero(),
            &Emission::printed(lobes),
        );
        Vsgl::of_moments(&moments, Vector3::zero(), 1e-4, &Emission::printed(lobes))
    }

    #[test]
    fn what_faces_away_from_all_that_is_seen_counts_for_less() {
        for lobes in [Lobes::Diffuse, Lobes::Both] {
            let seen = camera_light(&patch(1.0, -1.0), lobes);
            let towards = Vector3::new(0.6, 0.8, 0.0);
            let of = |weight, facing| {
                let patch = patch(0.0, facing);
                bidirectional(weight, &patch, towards, [seen], Emitter::Lobe, lobes, F0)
            };
            let at = |facing| of(2.0, facing);
            assert!(at(1.0) > 0.0);
            assert_eq!(at(-1.0), 0.0, "it faces away");
            let once = of(1.0, 1.0);
            assert!((at(1.0) / once - 2.0).abs() < 1e-12, "it goes with the power");
            let dark = of(0.0, 1.0);
            assert_eq!(dark, 0.0);
        }
    }

    #[test]
    fn far_away_importance_falls_with_the_square_of_the_distance() {
        let seen = camera_light(&patch(0.0, 1.0), Lobes::Diffuse);
        let towards = Vector3::new(-0.6, 0.8, 0.0);
        let at = |x| {
            let patch = patch(x, -1.0);
            bidirectional(1.0, &patch, towards, [seen], Emitter::Lobe, Lobes::Diffuse, F0)
        };
        assert!((at(10.0) / at(20.0) - 4.0).abs() < 0.01, "{}", at(10.0) / at(20.0));
    }

    #[test]
    fn the_specular_power_is_divided_out() {
        // Whatever the power's model, density per importance is the power of the photon.
        let (towards, surface) = (Vector3::new(0.05, 1.0, 0.0).normalized(), patch(0.0, 1.0));
        let surface = SurfaceTexel {
            material: crate::brdf::Material {
                specular: Vector3::splat(0.04),
                alpha: 0.2,
                ..surface.material
            },
            ..surface
        };
        let seen = camera_light(&patch(1.0, -1.0), Lobes::Both);
        let at = |model: SpecularPower, other| {
            let reflecting = model.reflecting(&surface, towards);
            let power = moments(
                &reflecting,
                Vector3::splat(1.0),
                towards,
                Vector3::zero(),
                &Emission::printed(Lobes::Both),
            );
            bidirectional(
                power.weight(),
                &surface,
                towards,
                [seen],
                Emitter::Lobe,
                Lobes::Both,
                other,
            )
        };
        let [f0, albedo] = [F0, SpecularPower::Albedo].map(|model| at(model, model));
        assert!(f0 > 0.0 && (albedo / f0 - 1.0).abs() < 1e-12);
        // Negative control: the power of one model over the reflectance of the other.
        assert!(at(SpecularPower::Albedo, F0) / f0 > 1.05);
    }

    #[test]
    fn no_surface_reflects_nothing() {
        let texel = SurfaceTexel::<f64>::decode([0.0, 0.0, 0.0, -1.0], [0.0; 4], [1.0; 4]);
        assert_eq!(reflectance(&texel, Lobes::Both), 0.0);
        assert!((reflectance(&patch(0.0, 1.0), Lobes::Both) - 0.5).abs() < 1e-12);
    }
}

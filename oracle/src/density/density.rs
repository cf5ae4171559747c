//! Densities of a texel of a reflective shadow map or a G-buffer.

use crate::brdf::Ndf;
use crate::rsm::{Lobes, Moments};
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
/// of the camera's G-buffer, where every pixel sends the same importance; `emitter`: how they send it.
// [Ritschel 2011; Tokuyoshi 2016, Section 5, Appendix C]
pub fn bidirectional<R: Real>(
    weight: R,
    surface: &SurfaceTexel<R>,
    towards: Vector3<R>,
    camera: impl IntoIterator<Item = Vsgl<R>>,
    emitter: Emitter,
    lobes: Lobes,
) -> R {
    if weight.value() <= 0.0 {
        return R::zero();
    }
    let specular = (lobes == Lobes::Both).then_some(Specular::Sg);
    let model = Model { emitter, diffuse: Some(Diffuse::Constant), specular, ndf: Ndf::Ggx };
    let importance = shade::towards(surface, towards, camera, &model).total().luminance();
    weight * (importance / reflectance(surface, lobes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rsm::{Emission, moments};

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
            let at = |facing| {
                bidirectional(2.0, &patch(0.0, facing), towards, [seen], Emitter::Lobe, lobes)
            };
            assert!(at(1.0) > 0.0);
            assert_eq!(at(-1.0), 0.0, "it faces away");
            let once = bidirectional(1.0, &patch(0.0, 1.0), towards, [seen], Emitter::Lobe, lobes);
            assert!((at(1.0) / once - 2.0).abs() < 1e-12, "it goes with the power");
            let dark = bidirectional(0.0, &patch(0.0, 1.0), towards, [seen], Emitter::Lobe, lobes);
            assert_eq!(dark, 0.0);
        }
    }

    #[test]
    fn far_away_importance_falls_with_the_square_of_the_distance() {
        let seen = camera_light(&patch(0.0, 1.0), Lobes::Diffuse);
        let towards = Vector3::new(-0.6, 0.8, 0.0);
        let at =
            |x| bidirectional(1.0, &patch(x, -1.0), towards, [seen], Emitter::Lobe, Lobes::Diffuse);
        assert!((at(10.0) / at(20.0) - 4.0).abs() < 0.01, "{}", at(10.0) / at(20.0));
    }

    #[test]
    fn no_surface_reflects_nothing() {
        let texel = SurfaceTexel::<f64>::decode([0.0, 0.0, 0.0, -1.0], [0.0; 4], [1.0; 4]);
        assert_eq!(reflectance(&texel, Lobes::Both), 0.0);
        assert!((reflectance(&patch(0.0, 1.0), Lobes::Both) - 0.5).abs() < 1e-12);
    }
}

//! The reflection of all lights at a shading point.

use crate::brdf::Ndf;
use crate::shade::{Diffuse, Emitter, Incoming, Specular, incoming};
use crate::surface::SurfaceTexel;
use crate::visibility::Seen;
use crate::vsgl::Vsgl;
use crate::{Linear, Real, Vector3};

/// Which reflections there are and how they are approximated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Model {
    /// How lights emit what they reflect diffusely.
    pub emitter: Emitter,
    /// Diffuse reflection, if any.
    pub diffuse: Option<Diffuse>,
    /// Specular reflection, if any.
    pub specular: Option<Specular>,
    /// The distribution of facets.
    pub ndf: Ndf,
}

/// Reflected radiance by its kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflected<R = f64> {
    /// Reflected diffusely.
    pub diffuse: Vector3<R>,
    /// Reflected specularly.
    pub specular: Vector3<R>,
}

impl<R: Real> Reflected<R> {
    /// No light.
    #[must_use]
    pub fn none() -> Self {
        Self { diffuse: Vector3::zero(), specular: Vector3::zero() }
    }
    /// The sum of both kinds.
    #[must_use]
    pub fn total(&self) -> Vector3<R> {
        self.diffuse + self.specular
    }
}

/// The radiance that a surface reflects towards the eye at world position `eye`; none where there is no surface.
// [Tokuyoshi 2016, Appendix C]
pub fn shade<R: Real>(
    surface: &SurfaceTexel<R>,
    eye: Vector3<R>,
    lights: impl IntoIterator<Item = Vsgl<R>>,
    model: &Model,
) -> Reflected<R> {
    towards(surface, (eye - surface.position).normalized(), lights, model)
}

/// The radiance that a surface reflects in the unit direction `view`; none where there is no surface.
// [Tokuyoshi 2016, Appendix C]
pub fn towards<R: Real>(
    surface: &SurfaceTexel<R>,
    view: Vector3<R>,
    lights: impl IntoIterator<Item = Vsgl<R>>,
    model: &Model,
) -> Reflected<R> {
    reflect(surface, view, lights.into_iter().map(|light| (light, Seen::Yes)), model)
}

/// The radiance that a surface reflects of lights that are seen or not. Of a light of which that is not certain, both
/// are within the tolerance.
// [Tokuyoshi 2016, Appendix C]
pub fn shade_visible<R: Real>(
    surface: &SurfaceTexel<R>,
    eye: Vector3<R>,
    lights: impl IntoIterator<Item = (Vsgl<R>, Seen)>,
    model: &Model,
) -> Reflected<R> {
    reflect(surface, (eye - surface.position).normalized(), lights, model)
}

fn reflect<R: Real>(
    surface: &SurfaceTexel<R>,
    view: Vector3<R>,
    lights: impl IntoIterator<Item = (Vsgl<R>, Seen)>,
    model: &Model,
) -> Reflected<R> {
    let mut sum = Reflected::none();
    if !surface.present {
        return sum;
    }
    for (light, seen) in lights {
        if seen == Seen::No {
            continue;
        }
        let before = sum;
        let (reflectance, normal) = (surface.material.diffuse, surface.normal);
        let specular = |arriving: &Incoming<R>| {
            let lobe = model.specular?;
            Some(lobe.reflect(arriving, &surface.material, model.ndf, view, normal))
        };
        let emitted = model.emitter.emitted(surface.position, &light, model.diffuse);
        if let Some(diffuse) = model.diffuse {
            let reflected = model.emitter.reflect(
                diffuse,
                &emitted,
                light.position - surface.position,
                &light,
                normal,
            );
            sum.diffuse = sum.diffuse + reflected.times(reflectance);
        }
        sum.specular = sum.specular + specular(&emitted).unwrap_or_else(Vector3::zero);
        if let Some(lobe) = light.specular {
            let arriving = incoming(surface.position, light.position, light.variance, &lobe);
            if let Some(diffuse) = model.diffuse {
                sum.diffuse = sum.diffuse + diffuse.reflect(&arriving, reflectance, normal);
            }
            sum.specular = sum.specular + specular(&arriving).unwrap_or_else(Vector3::zero);
        }
        if seen == Seen::Uncertain {
            sum.diffuse = sum.diffuse.covering(before.diffuse);
            sum.specular = sum.specular.covering(before.specular);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;
    use crate::rsm::{Emission, Lobes, Moments};

    fn scene<R: Real>() -> (SurfaceTexel<R>, Vector3<R>, Vsgl<R>) {
        let surface =
            SurfaceTexel::decode([0.0, 0.0, 0.0, 0.04], [0.0, 1.0, 0.0, 0.3], [0.8, 0.6, 0.4, 0.2]);
        let eye = Vector3::constant(Vector3::new(2.0, 1.5, 0.0));
        let texels = [
            [-10.0, 8.0, 1.0, 21.0],
            [5.0, 4.0, 3.0, 8.0],
            [2.0, -1.5, 0.1, 4.141],
            [0.5, 0.5, 0.5, 0.0],
            [0.3, -0.3, 0.0, 0.0],
        ];
        let light = Vsgl::of_moments(
            &Moments::of_texels(&texels),
            Vector3::zero(),
            1e-6,
            &Emission::printed(Lobes::Both),
        );
        (surface, eye, light)
    }

    const MODEL: Model = Model {
        emitter: Emitter::Lobe,
        diffuse: Some(Diffuse::Constant),
        specular: Some(Specular::Sg),
        ndf: Ndf::Ggx,
    };

    #[test]
    fn is_linear_in_the_lights() {
        let (surface, eye, light) = scene::<f64>();
        let one = shade(&surface, eye, [light], &MODEL);
        let three = shade(&surface, eye, [light; 3], &MODEL);
        assert!(one.diffuse.x > 0.0 && one.specular.x > 0.0);
        assert!((three.total() - one.total() * 3.0).length() < 1e-13 * three.total().length());
        let dark = Model { diffuse: None, ..MODEL };
        assert_eq!(shade(&surface, eye, [light], &dark).diffuse, Vector3::zero());
        let absent = SurfaceTexel { present: false, ..surface };
        assert_eq!(shade(&absent, eye, [light], &MODEL), Reflected::none());
    }

    #[test]
    fn tolerances_are_useful() {
        let (surface, eye, light) = scene::<Bounded>();
        for (emitter, diffuse) in Emitter::ALL
            .map(|emitter| (emitter, Diffuse::Fitted))
            .into_iter()
            .chain([Diffuse::Constant, Diffuse::Gaussian].map(|form| (Emitter::Lobe, form)))
        {
            for specular in [Specular::Sg, Specular::Asg, Specular::NdfFiltered] {
                for ndf in [Ndf::Ggx, Ndf::Beckmann] {
                    let model =
                        Model { emitter, diffuse: Some(diffuse), specular: Some(specular), ndf };
                    let bounded = shade(&surface, eye, [light; 8], &model);
                    for part in [bounded.diffuse.y, bounded.specular.y] {
                        println!("{model:?}: {:.2e}", part.error / part.value);
                        assert!(part.error < 2e-3 * part.value, "{model:?} {part:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn extremes_stay_finite() {
        let sharpnesses = [0.0, 1e-30, 2f64.powi(-24), 1.0, 1e2, 1e5, 2f64.powi(20) - 1.0];
        let axes = [
            Vector3::new(0.0, 1.0, 0.0),
            Vector3::new(0.0, -1.0, 0.0),
            Vector3::new(1.0, 0.0, 0.0),
            Vector3::new(0.0, 1.0, 1e-7),
        ];
        let mut checked = 0;
        for sharpness in sharpnesses {
            for axis in axes {
                for position in [Vector3::zero(), axes[0] * 1e-6, axes[0], axes[2] * 1e4, -axes[0]]
                {
                    for (variance, alpha) in [(1e-8, 0.01), (1.0, 1.0), (1e8, 0.01)] {
                        let lobe =
                            crate::vsgl::Lobe { axis, sharpness, coefficient: Vector3::splat(1.0) };
                        let light = Vsgl {
                            position,
                            variance,
                            diffuse: lobe,
                            diffuse_mean_length: crate::vmf::mean_length(sharpness),
                            specular: Some(lobe),
                        };
                        let (mut surface, _, _) = scene::<f64>();
                        surface.material.alpha = alpha;
                        for eye in [axes[0], axes[2], Vector3::new(1.0, 1e-4, 0.0)] {
                            checked += stays_finite(&surface, eye, light);
                        }
                    }
                }
            }
        }
        assert!(checked > 5000);
    }

    /// How many models were tried.
    fn stays_finite(surface: &SurfaceTexel, eye: Vector3, light: Vsgl) -> usize {
        let mut checked = 0;
        for emitter in Emitter::ALL {
            for diffuse in [Diffuse::Gaussian, Diffuse::Fitted] {
                for specular in [Specular::Sg, Specular::Asg, Specular::NdfFiltered] {
                    for ndf in [Ndf::Ggx, Ndf::Beckmann] {
                        let (diffuse, specular) = (Some(diffuse), Some(specular));
                        let model = Model { emitter, diffuse, specular, ndf };
                        let parts = shade(surface, eye, [light], &model).total().to_array();
                        let fine = parts.iter().all(|part| part.is_finite() && *part >= 0.0);
                        assert!(fine, "{model:?} {light:?} {parts:?}");
                        checked += 1;
                    }
                }
            }
        }
        checked
    }
}

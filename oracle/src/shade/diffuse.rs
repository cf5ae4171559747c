//! Diffuse reflection of an incoming spherical Gaussian.

use core::f64::consts::PI;

use crate::quadrature::SphereRule;
use crate::rsm::moments::DIFFUSE_SHARPNESS;
use crate::sg::{Cosine, cosine, integral, product_integral};
use crate::shade::Incoming;
use crate::{Real, Vector3};

/// How the cosine at the shading point is treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Diffuse {
    /// Constant over the lobe, taken at its axis.
    Constant,
    /// A normalised spherical Gaussian of sharpness 2 about the normal, with the exact product integral.
    Gaussian,
    /// The integral with the cosine by a logistic curve: [`Cosine::Logistic`].
    Logistic,
    /// The integral with the cosine by an error function: [`Cosine::Erf`].
    Erf,
    /// The integral with the cosine by a fourth power: [`Cosine::Quartic`].
    Quartic,
    /// The integral with the cosine from its exact odd part and a fit: [`Cosine::Fitted`].
    Fitted,
    /// The same with more constants: [`Cosine::FittedFine`].
    FittedFine,
}

impl Diffuse {
    /// All of them, the cheapest and least accurate first.
    pub const ALL: [Self; 7] = [
        Self::Constant,
        Self::Gaussian,
        Self::Logistic,
        Self::Erf,
        Self::Quartic,
        Self::Fitted,
        Self::FittedFine,
    ];

    /// The integral of a lobe times a clamped cosine, by the cosine of their axes.
    pub fn cosine_integral<R: Real>(self, cosine: R, sharpness: R) -> R {
        let form = match self {
            Self::Constant => Cosine::Constant,
            Self::Gaussian => Cosine::Gaussian,
            Self::Logistic => Cosine::Logistic,
            Self::Erf => Cosine::Erf,
            Self::Quartic => Cosine::Quartic,
            Self::Fitted => Cosine::Fitted,
            Self::FittedFine => Cosine::FittedFine,
        };
        form.integral(cosine.clamp(-1.0, 1.0), sharpness)
    }

    /// The same of a lobe whose mean length of directions is known.
    pub fn cosine_integral_mean<R: Real>(self, cosine: R, sharpness: R, mean_length: R) -> R {
        if self != Self::Quartic {
            return self.cosine_integral(cosine, sharpness);
        }
        let cosine = cosine.clamp(-1.0, 1.0);
        cosine::quartic_known(cosine, sharpness, mean_length, cosine::QUARTIC)
    }

    /// The reflected radiance of a surface of diffuse reflectance `reflectance` and unit normal.
    pub fn reflect<R: Real>(
        self,
        arriving: &Incoming<R>,
        reflectance: Vector3<R>,
        normal: Vector3<R>,
    ) -> Vector3<R> {
        let cosine = arriving.axis.dot(normal);
        let scale = match self {
            Self::Constant => return clamped(arriving, reflectance, normal),
            // [Tokuyoshi 2015, Eq. (1), Section 3.2]
            Self::Gaussian => {
                let sharpness = R::constant(DIFFUSE_SHARPNESS);
                let overlap =
                    product_integral(arriving.axis, arriving.sharpness, normal, sharpness);
                overlap / R::constant(integral(DIFFUSE_SHARPNESS))
            }
            Self::Logistic | Self::Erf | Self::Quartic | Self::Fitted | Self::FittedFine => {
                self.cosine_integral(cosine, arriving.sharpness) * R::constant(1.0 / PI)
            }
        };
        arriving.coefficient.times(reflectance) * scale
    }
}

/// The reflected radiance of a surface of diffuse reflectance `reflectance` and unit normal, by the cosine of the lobe's
/// axis.
// [Tokuyoshi 2016, Appendix C.2, Diffuse reflection]
pub fn clamped<R: Real>(
    arriving: &Incoming<R>,
    reflectance: Vector3<R>,
    normal: Vector3<R>,
) -> Vector3<R> {
    let cosine = arriving.axis.dot(normal).max(R::zero());
    let scale = integral(arriving.sharpness) * cosine * R::constant(1.0 / PI);
    arriving.coefficient.times(reflectance) * scale
}

/// What the forms approximate: the Lambert reflection of the incoming lobe, by quadrature.
#[must_use]
pub fn quadrature(arriving: &Incoming, reflectance: Vector3, normal: Vector3) -> Vector3 {
    let rule = SphereRule::around(arriving.axis, arriving.sharpness).with_azimuths(360);
    rule.integrate_color(|direction| {
        arriving.radiance(direction).times(reflectance) * (direction.dot(normal).max(0.0) / PI)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NORMAL: Vector3 = Vector3::new(0.0, 0.0, 1.0);

    fn arriving(sharpness: f64, angle: f64) -> Incoming {
        let axis = Vector3::new(angle.sin(), 0.0, angle.cos());
        Incoming { axis, sharpness, coefficient: Vector3::new(1.0, 0.5, 2.0) }
    }

    /// The largest error over angles, relative to the reflection of a facing lobe.
    fn model_error(diffuse: Diffuse, sharpness: f64) -> f64 {
        let white = Vector3::splat(1.0);
        let facing = quadrature(&arriving(sharpness, 0.0), white, NORMAL).x;
        (0..=36)
            .map(|step| {
                let arriving = arriving(sharpness, PI * f64::from(step) / 36.0);
                let found = diffuse.reflect(&arriving, white, NORMAL);
                (found - quadrature(&arriving, white, NORMAL)).x.abs() / facing
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn errors_of_the_models_are_the_known_ones() {
        // Table of the measured accuracy: constant cosine and the energy-conserving Gaussian of sharpness 2.
        for (sharpness, constant) in [(1.0, 1.4), (10.0, 0.13), (100.0, 0.04), (1e4, 0.004)] {
            let found = model_error(Diffuse::Constant, sharpness);
            assert!((found / constant - 1.0).abs() < 0.1, "{sharpness} {found}");
        }
        for sharpness in [0.1, 1.0, 10.0, 100.0, 1e4] {
            let found = model_error(Diffuse::Gaussian, sharpness);
            assert!(found > 0.01 && found < 0.145, "{sharpness} {found}");
        }
        // The others, at sharpness 1, 6 and 100; this reference, whose azimuths cut the horizon, is good to 3e-6.
        let table = [
            (Diffuse::Logistic, [2.8e-3, 5.8e-3, 1.4e-3]),
            (Diffuse::Erf, [8.4e-5, 1.54e-3, 3.1e-5]),
            (Diffuse::Quartic, [1.283e-3, 1.36e-3, 4.61e-4]),
            (Diffuse::Fitted, [1.9e-5, 3.8e-5, 9e-6]),
            (Diffuse::FittedFine, [1.35e-5, 1.3e-5, 3.3e-6]),
        ];
        for (diffuse, known) in table {
            for (sharpness, known) in [1.0, 6.0, 100.0].into_iter().zip(known) {
                let found = model_error(diffuse, sharpness);
                assert!(
                    (found - known).abs() < 0.1 * known + 3e-6,
                    "{diffuse:?} {sharpness} {found}"
                );
            }
        }
    }

    #[test]
    fn energy_is_conserved_over_all_normals() {
        // The mean over normals of the reflected radiance is a quarter of the reflected power, R A/(4 pi), for all
        // forms, up to their own error.
        let arriving = arriving(7.0, 0.4);
        let bounds = [1e-3, 1e-3, 1.3e-2, 2e-3, 2e-3, 2e-4, 5e-5];
        for (diffuse, bound) in Diffuse::ALL.into_iter().zip(bounds) {
            let total = SphereRule::around(arriving.axis, 7.0)
                .with_azimuths(360)
                .integrate(|normal| diffuse.reflect(&arriving, Vector3::splat(1.0), normal).x);
            assert!(
                (total / integral(7.0) - 1.0).abs() < bound,
                "{diffuse:?} {}",
                total / integral(7.0)
            );
        }
    }
}

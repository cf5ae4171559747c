//! The integral of a spherical Gaussian over the hemisphere of a normal, without a cosine.

use core::f64::consts::PI;

use crate::Real;
use crate::sg::cosine::{polar, slope_of};

/// By quadrature over the polar angle; within 1e-9 of it.
#[must_use]
pub fn truth(cosine: f64, sharpness: f64) -> f64 {
    polar(cosine, sharpness, |_| 1.0)
}

/// The exact integrals of a lobe along the normal and against it, blended by an error function.
// [Tokuyoshi 2022]; its constants are those of the author's sample code.
pub fn hemisphere_integral<R: Real>(cosine: R, sharpness: R) -> R {
    let (one, half) = (R::one(), R::constant(0.5));
    let t = slope_of(sharpness, &[0.651_732_88, 0.5], &[7.221_668_8, 1.341_828, 1.0]);
    // At sharpness 0 both error functions vanish and their quotient is the cosine; to 3e-13 below 1e-6.
    let share = if t.value() > 1e-6 { (t * cosine).erf() / t.erf() } else { cosine };
    let decay = (-sharpness).exp();
    let blend = half * ((one + decay) + (one - decay) * share);
    R::constant(2.0 * PI) * blend * sharpness.one_minus_exp_over()
}

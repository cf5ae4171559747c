//! Exact facts about the integral of a spherical Gaussian times a clamped cosine, as residuals of a function
//! `form(cosine, sharpness)` that claims to be that integral.
//!
//! Every residual is over the largest value `A_u` of the integral, so that it compares with an error. All vanish for
//! the integral itself. Only the odd part and both ends vanish for a form that is built on them.

use core::f64::consts::PI;

use crate::math::bessel_i_scaled;
use crate::quadrature::gauss_legendre;
use crate::sg::{integral, lower_cosine_integral, odd_part_scaled, upper_cosine_integral};

/// `A_u - A_b`, which is also `A (coth l - 1/l)`.
fn odd(sharpness: f64) -> f64 {
    2.0 * PI * odd_part_scaled(sharpness) / (1.0 + sharpness)
}

/// The cosine about a normal less that about the opposite one is the unclamped cosine:
/// `I(z) - I(-z) = (A_u - A_b) z`.
pub fn odd_part(form: impl Fn(f64, f64) -> f64, cosine: f64, sharpness: f64) -> f64 {
    let difference = form(cosine, sharpness) - form(-cosine, sharpness);
    (difference - odd(sharpness) * cosine) / upper_cosine_integral(sharpness)
}

/// A lobe along the horizon: `I(0) = 2 pi exp(-l) I_1(l)/l`, with the modified Bessel function.
pub fn horizon(form: impl Fn(f64, f64) -> f64, sharpness: f64) -> f64 {
    let value =
        if sharpness == 0.0 { PI } else { 2.0 * PI * bessel_i_scaled(1, sharpness) / sharpness };
    (form(0.0, sharpness) - value) / upper_cosine_integral(sharpness)
}

/// Half the step of the differences below: a part of the width of a lobe, of which the error goes with the square.
fn step(sharpness: f64) -> f64 {
    1e-4 / (1.0 + sharpness).sqrt()
}

/// The slope at the horizon, `I'(0) = (A_u - A_b)/2`, by a difference.
pub fn horizon_slope(form: impl Fn(f64, f64) -> f64, sharpness: f64) -> f64 {
    let step = step(sharpness);
    let slope = (form(step, sharpness) - form(-step, sharpness)) / (2.0 * step);
    (slope - 0.5 * odd(sharpness)) / upper_cosine_integral(sharpness)
}

/// The curvature at the horizon, `I''(0) = 2 pi exp(-l) I_2(l)`, by a difference; over the curvature's own size `A_u
/// (1 + l)^(1/2)`.
pub fn horizon_curvature(form: impl Fn(f64, f64) -> f64, sharpness: f64) -> f64 {
    // A second difference of f64 needs a longer step.
    let step = 10.0 * step(sharpness);
    let sum = form(step, sharpness) + form(-step, sharpness) - 2.0 * form(0.0, sharpness);
    let curvature = sum / (step * step) - 2.0 * PI * bessel_i_scaled(2, sharpness);
    curvature / (upper_cosine_integral(sharpness) * (1.0 + sharpness).sqrt())
}

/// The slope of a lobe that faces the normal, `I'(1) = A_u - pi exp(-l)`, by a difference from one side.
pub fn facing_slope(form: impl Fn(f64, f64) -> f64, sharpness: f64) -> f64 {
    let step = step(sharpness);
    let slope = (3.0 * form(1.0, sharpness) - 4.0 * form(1.0 - step, sharpness)
        + form(1.0 - 2.0 * step, sharpness))
        / (2.0 * step);
    let upper = upper_cosine_integral(sharpness);
    (slope - (upper - PI * (-sharpness).exp())) / upper
}

/// Both ends, `I(1) = A_u` and `I(-1) = A_b`.
pub fn ends(form: impl Fn(f64, f64) -> f64, sharpness: f64) -> [f64; 2] {
    let upper = upper_cosine_integral(sharpness);
    let lower = lower_cosine_integral(sharpness);
    [(form(1.0, sharpness) - upper) / upper, (form(-1.0, sharpness) - lower) / upper]
}

/// Energy: every direction sends a quarter of what it brings to a normal that is chosen at random,
/// `int_-1^1 I dz = A/2`.
pub fn energy(form: impl Fn(f64, f64) -> f64, sharpness: f64) -> f64 {
    // Panels that shrink towards the horizon, where the integral bends within 1/sqrt(l), and where forms have a kink.
    let rule = gauss_legendre(24);
    let mut total = 0.0;
    for side in [-1.0, 1.0] {
        let (mut low, mut high) = (0.0, (1.0 / (1.0 + sharpness).sqrt()).min(0.25));
        while low < 1.0 {
            for &(node, weight) in &rule {
                let cosine = 0.5 * (low + high) + 0.5 * (high - low) * node;
                total += 0.5 * (high - low) * weight * form(side * cosine, sharpness);
            }
            (low, high) = (high, (2.0 * high).min(1.0));
        }
    }
    (total - 0.5 * integral(sharpness)) / upper_cosine_integral(sharpness)
}

/// `(1 - z^2) I'' - 2 z I' + 2 I = 2 pi exp(-l) I_0(l sqrt(1 - z^2))`, by differences; for |z| below 0.99, and over
/// `A_u (1 + l)^(1/2)`.
pub fn differential_equation(form: impl Fn(f64, f64) -> f64, cosine: f64, sharpness: f64) -> f64 {
    let step = 10.0 * step(sharpness);
    let [below, here, above] = [-step, 0.0, step].map(|offset| form(cosine + offset, sharpness));
    let slope = (above - below) / (2.0 * step);
    let curvature = (above + below - 2.0 * here) / (step * step);
    let sine = (1.0 - cosine * cosine).sqrt();
    // exp(-l) I_0(l s), from the scaled function.
    let decay = (-sharpness * cosine * cosine / (1.0 + sine)).exp();
    let source = 2.0 * PI * decay * bessel_i_scaled(0, sharpness * sine);
    let residual = sine * sine * curvature - 2.0 * cosine * slope + 2.0 * here - source;
    residual / (upper_cosine_integral(sharpness) * (1.0 + sharpness).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sg::Cosine;
    use crate::sg::cosine::quadrature;

    const SHARPNESS: [f64; 8] = [1e-3, 0.3, 1.0, 3.0, 7.0, 30.0, 1e3, 1e5];

    fn worst(residual: impl Fn(f64) -> f64) -> f64 {
        SHARPNESS.iter().map(|&sharpness| residual(sharpness).abs()).fold(0.0, f64::max)
    }

    fn cosines(residual: impl Fn(f64, f64) -> f64) -> f64 {
        worst(|sharpness| {
            [-0.9, -0.5, -0.01, 0.0, 0.2, 0.7]
                .iter()
                .map(|&cosine| residual(cosine, sharpness).abs())
                .fold(0.0, f64::max)
        })
    }

    #[test]
    fn the_truth_has_them_all() {
        assert!(cosines(|cosine, sharpness| odd_part(quadrature, cosine, sharpness)) < 1e-12);
        assert!(worst(|sharpness| horizon(quadrature, sharpness)) < 1e-12);
        assert!(worst(|sharpness| horizon_slope(quadrature, sharpness)) < 1e-7);
        assert!(worst(|sharpness| horizon_curvature(quadrature, sharpness)) < 1e-5);
        assert!(worst(|sharpness| facing_slope(quadrature, sharpness)) < 1e-4);
        assert!(worst(|sharpness| energy(quadrature, sharpness)) < 1e-12);
        assert!(worst(|sharpness| ends(quadrature, sharpness)[0].abs()) < 1e-12);
        assert!(worst(|sharpness| ends(quadrature, sharpness)[1].abs()) < 1e-12);
        assert!(
            cosines(|cosine, sharpness| differential_equation(quadrature, cosine, sharpness))
                < 1e-5
        );
    }

    #[test]
    fn other_functions_lack_them() {
        // Negative control: the energy-conserving Gaussian cosine has none but the energy.
        let gaussian = |cosine: f64, sharpness: f64| Cosine::Gaussian.integral(cosine, sharpness);
        assert!(cosines(|cosine, sharpness| odd_part(gaussian, cosine, sharpness)) > 0.05);
        assert!(worst(|sharpness| horizon(gaussian, sharpness)) > 0.05);
        assert!(worst(|sharpness| horizon_slope(gaussian, sharpness)) > 0.05);
        assert!(worst(|sharpness| horizon_curvature(gaussian, sharpness)) > 0.05);
        assert!(worst(|sharpness| facing_slope(gaussian, sharpness)) > 0.05);
        assert!(worst(|sharpness| ends(gaussian, sharpness)[0].abs()) > 0.01);
        assert!(
            cosines(|cosine, sharpness| differential_equation(gaussian, cosine, sharpness)) > 0.05
        );
        assert!(worst(|sharpness| energy(gaussian, sharpness)) < 1e-9);
        // And a reference that is scaled by a thousandth more has not the energy either.
        let more = |cosine: f64, sharpness: f64| 1.001 * quadrature(cosine, sharpness);
        assert!(worst(|sharpness| energy(more, sharpness)) > 5e-4);
    }

    #[test]
    fn our_forms_have_those_that_they_are_built_on() {
        for form in [Cosine::Logistic, Cosine::Erf, Cosine::Fitted, Cosine::FittedFine] {
            let form = |cosine: f64, sharpness: f64| form.integral(cosine, sharpness);
            assert!(cosines(|cosine, sharpness| odd_part(form, cosine, sharpness)) < 1e-12);
        }
        for form in [Cosine::Fitted, Cosine::FittedFine] {
            let form = |cosine: f64, sharpness: f64| form.integral(cosine, sharpness);
            assert!(worst(|sharpness| horizon_slope(form, sharpness)) < 1e-7);
        }
        let errors = |form: Cosine| {
            let form = |cosine: f64, sharpness: f64| form.integral(cosine, sharpness);
            [
                worst(|sharpness| horizon(form, sharpness)),
                // An integral over an interval of length 2.
                0.5 * worst(|sharpness| energy(form, sharpness)),
                worst(|sharpness| ends(form, sharpness)[0].abs()),
            ]
        };
        for (form, bound) in [(Cosine::Fitted, 6e-5), (Cosine::FittedFine, 1.6e-5)] {
            let errors = errors(form);
            assert!(errors.iter().all(|&error| error < bound), "{form:?} {errors:?}");
            assert!(errors[0] > 1e-7, "{form:?} {errors:?}");
        }
    }
}

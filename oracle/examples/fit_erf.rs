//! Fits the rational functions and polynomials of `shaders/src/math/erf.wesl` and `expm1.wesl`, by least largest
//! relative error, and prints them as they stand there, with the error that is left after rounding them to f32.
//!
//! `cargo run --release -p sglow-oracle --example fit_erf`

mod minimax;

use minimax::{horner, largest, rational};
use sglow_oracle::math::{erf, erfc_integral_scaled, erfc_scaled, expm1_over_x};

/// Chebyshev points between two ends.
fn between(low: f64, high: f64, count: u32) -> Vec<f64> {
    (0..count)
        .map(|i| {
            let angle = core::f64::consts::PI * (f64::from(i) + 0.5) / f64::from(count);
            0.5 * (low + high) - 0.5 * (high - low) * angle.cos()
        })
        .collect()
}

/// 0 to infinity, which 1e4 stands for.
fn half_line() -> Vec<f64> {
    let far = (0..60).map(|i| 12.0 * 10f64.powf(f64::from(i) / 20.0));
    [0.0]
        .into_iter()
        .chain(between(0.0, 3.0, 200))
        .chain(between(3.0, 12.0, 150))
        .chain(far)
        .collect()
}

fn report(name: &str, points: &[f64], target: impl Fn(f64) -> f64, degrees: (usize, usize)) {
    let (top, bottom, error) = rational(points, &target, degrees.0, degrees.1);
    let round = |coefficients: &[f64]| -> Vec<f32> {
        coefficients.iter().map(|&coefficient| coefficient as f32).collect()
    };
    let (top, bottom) = (round(&top), round(&bottom));
    let exact = |rounded: &[f32]| rounded.iter().map(|&c| f64::from(c)).collect::<Vec<_>>();
    let errors: Vec<f64> = points
        .iter()
        .map(|&x| horner(&exact(&top), x) / horner(&exact(&bottom), x) / target(x) - 1.0)
        .collect();
    println!("{name} {degrees:?}: error {error:.2e}, rounded {:.2e}", largest(&errors));
    println!("  numerator   {top:?}");
    println!("  denominator {bottom:?}");
}

fn main() {
    for degrees in [(3, 4), (4, 5), (5, 6)] {
        report("erfc_scaled", &half_line(), erfc_scaled, degrees);
    }
    for degrees in [(3, 5), (4, 6)] {
        report("erfc_integral_scaled", &half_line(), erfc_integral_scaled, degrees);
    }
    for degree in [5, 6, 7] {
        let near = |square: f64| {
            let x = square.sqrt();
            if x == 0.0 { core::f64::consts::FRAC_2_SQRT_PI } else { erf(x) / x }
        };
        report("erf(x)/x of x^2, |x| < 1", &between(0.0, 1.0, 200), near, (degree, 0));
    }
    for degree in [6, 7] {
        report("expm1(x)/x, |x| < 1", &between(-1.0, 1.0, 200), expm1_over_x, (degree, 0));
    }
}

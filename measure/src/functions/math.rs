//! `shaders/src/math`.

use core::f64::consts::FRAC_2_SQRT_PI;
use std::sync::LazyLock;

use sglow_oracle::quadrature::gauss_legendre;
use sglow_oracle::{Real, math};

use super::entry::function;
use crate::function::{Function, Monotone, Numbers, Results, one};

/// A function of one number that falls with it, or grows.
const FALLS: Option<Monotone> = Some(Monotone { component: 3, grows: false });
const GROWS: Option<Monotone> = Some(Monotone { component: 3, grows: true });

/// The functions of this folder. Errors are relative: each number is its own peak.
pub(super) const FUNCTIONS: &[Function] = &[
    function!(erf(Number @ 3) -> ["value"],
        reference: Some(|x| one(erf_reference(x[3]))),
        peak: |x| [math::erf(x[3]).abs(); 4],
        never_negative: false,
        monotone: GROWS,
    ),
    function!(erfc(Number @ 3) -> ["value"],
        reference: Some(|x| one(erfc_reference(x[3]))),
        peak: |x| [math::erfc(x[3]); 4],
        monotone: FALLS,
    ),
    function!(erfc_scaled(Sharpness @ 3) -> ["value"],
        reference: Some(|x| one(erfc_scaled_reference(x[3]))),
        peak: |x| [math::erfc_scaled(x[3].min(1e6)); 4],
        monotone: FALLS,
    ),
    function!(erfc_integral_scaled(Sharpness @ 3) -> ["value"],
        reference: Some(|x| one(erfc_integral_scaled_reference(x[3]))),
        peak: |x| [math::erfc_integral_scaled(x[3].min(1e5)); 4],
        monotone: FALLS,
    ),
    function!(expm1(Exponent @ 3) -> ["value"],
        reference: Some(|x| one(expm1_reference(x[3]))),
        peak: |x| [x[3].exp_m1().abs(); 4],
        never_negative: false,
        monotone: GROWS,
    ),
    function!(expm1_over_x(Exponent @ 3) -> ["value"],
        reference: Some(|x| one(expm1_over_x_reference(x[3]))),
        peak: |x| [math::expm1_over_x(x[3].max(-8.5e37)); 4],
        monotone: GROWS,
    ),
];

/// `int_0^inf t^power exp(-2 x t - t^2) dt`, by quadrature: of what erfc and its integral are without their decay.
fn decaying(x: f64, power: i32) -> f64 {
    // Beyond this nothing is left of either factor.
    let reach = (40.0 / (2.0 * x).max(1e-300)).min(6.5);
    let sum: f64 = RULE
        .iter()
        .map(|(node, weight)| {
            let t = 0.5 * reach * (1.0 + node);
            weight * t.powi(power) * (-(2.0 * x + t) * t).exp()
        })
        .sum();
    0.5 * reach * sum
}

static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(64));

/// By quadrature of the Gaussian from 0.
fn erf_reference(x: f64) -> f64 {
    let reach = x.abs().min(6.5);
    let gaussian =
        |(node, weight): &(f64, f64)| weight * (-(0.5 * reach * (1.0 + node)).powi(2)).exp();
    FRAC_2_SQRT_PI * 0.5 * reach * RULE.iter().map(gaussian).sum::<f64>() * x.signum()
}

fn erfc_reference(x: f64) -> f64 {
    if x > 0.5 { (-x * x).exp() * erfc_scaled_reference(x) } else { 1.0 - erf_reference(x) }
}

/// As far as the function's contract goes.
fn erfc_scaled_reference(x: f64) -> f64 {
    FRAC_2_SQRT_PI * decaying(x.min(1e6), 0)
}

/// As far as the function's contract goes.
fn erfc_integral_scaled_reference(x: f64) -> f64 {
    FRAC_2_SQRT_PI * decaying(x.min(1e5), 1)
}

/// By the exponential's own series near 0, where the difference cancels.
fn expm1_over_x_reference(x: f64) -> f64 {
    // The contract: below -8.5e37 it counts as there.
    let x = x.max(-8.5e37);
    if x.abs() > 1.0 {
        return (x.exp() - 1.0) / x;
    }
    let mut term = 1.0;
    let mut sum = 1.0;
    for degree in 2..24 {
        term *= x / f64::from(degree);
        sum += term;
    }
    sum
}

fn expm1_reference(x: f64) -> f64 {
    if x.abs() > 1.0 { x.exp() - 1.0 } else { x * expm1_over_x_reference(x) }
}

fn erf<R: Real>(x: Numbers<R>) -> Results<R> {
    one(x[3].erf())
}

fn erfc<R: Real>(x: Numbers<R>) -> Results<R> {
    one(x[3].erfc())
}

fn erfc_scaled<R: Real>(x: Numbers<R>) -> Results<R> {
    // The contract: beyond 1e6 it counts as there.
    one(x[3].min(R::constant(1e6)).erfc_scaled())
}

fn erfc_integral_scaled<R: Real>(x: Numbers<R>) -> Results<R> {
    // The contract: beyond 1e5 it counts as there.
    one(x[3].min(R::constant(1e5)).erfc_integral_scaled())
}

fn expm1<R: Real>(x: Numbers<R>) -> Results<R> {
    one(x[3].expm1())
}

fn expm1_over_x<R: Real>(x: Numbers<R>) -> Results<R> {
    let x = x[3];
    // The contract: below -8.5e37 it counts as there.
    let x = x.max(R::constant(-8.5e37));
    one(if x.value() > 0.0 { x.expm1() / x } else { (-x).one_minus_exp_over() })
}

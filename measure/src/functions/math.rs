//! `shaders/src/math`.

use sglow_oracle::{Real, math};

use super::function;
use crate::function::{Function, Monotone, Numbers, Results, one};

/// A function of one number that falls with it, or grows.
const FALLS: Option<Monotone> = Some(Monotone { component: 3, grows: false });
const GROWS: Option<Monotone> = Some(Monotone { component: 3, grows: true });

/// The functions of this folder. Errors are relative: each number is its own peak.
pub(super) const FUNCTIONS: &[Function] = &[
    function!(erf(Number @ 3) -> ["value"],
        peak: |x| [math::erf(x[3]).abs(); 4],
        never_negative: false,
        monotone: GROWS,
    ),
    function!(erfc(Number @ 3) -> ["value"],
        peak: |x| [math::erfc(x[3]); 4],
        monotone: FALLS,
    ),
    function!(erfc_scaled(Sharpness @ 3) -> ["value"],
        peak: |x| [math::erfc_scaled(x[3].min(1e6)); 4],
        monotone: FALLS,
    ),
    function!(erfc_integral_scaled(Sharpness @ 3) -> ["value"],
        peak: |x| [math::erfc_integral_scaled(x[3].min(1e5)); 4],
        monotone: FALLS,
    ),
    function!(expm1(Exponent @ 3) -> ["value"],
        peak: |x| [x[3].exp_m1().abs(); 4],
        never_negative: false,
        monotone: GROWS,
    ),
    function!(expm1_over_x(Exponent @ 3) -> ["value"],
        peak: |x| [math::expm1_over_x(x[3].max(-8.5e37)); 4],
        monotone: GROWS,
    ),
];

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

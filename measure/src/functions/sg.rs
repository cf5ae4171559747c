//! `shaders/src/sg`.

use sglow_oracle::{Real, sg};

use super::function;
use crate::function::{Function, Monotone, Numbers, Results, one, vector};

/// The functions of this folder.
pub(super) const FUNCTIONS: &[Function] = &[
    function!(sg_evaluate(Axis @ 0, Sharpness @ 3, OtherAxis @ 4) -> ["value"],
        monotone: Some(Monotone { component: 3, grows: false }),
    ),
    function!(sg_integral(Sharpness @ 3) -> ["integral"],
        peak: |x| [sg::integral(x[3]); 4],
        monotone: Some(Monotone { component: 3, grows: false }),
    ),
    function!(sg_product(Axis @ 0, Sharpness @ 3, OtherAxis @ 4, OtherSharpness @ 7) -> ["sharpness", "log_amplitude"],
        peak: |x| [x[3] + x[7], 1.0, 1.0, 1.0],
        never_negative: false,
    ),
];

fn sg_evaluate<R: Real>(x: Numbers<R>) -> Results<R> {
    one(sg::evaluate(vector(&x, 0), vector(&x, 4), x[3]))
}

fn sg_integral<R: Real>(x: Numbers<R>) -> Results<R> {
    one(sg::integral(x[3]))
}

fn sg_product<R: Real>(x: Numbers<R>) -> Results<R> {
    let product = sg::product(vector(&x, 0), x[3], vector(&x, 4), x[7]);
    [product.sharpness, product.log_amplitude, R::zero(), R::zero()]
}

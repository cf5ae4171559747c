//! `shaders/src/asg`.

use core::f64::consts::PI;

use sglow_oracle::{Real, asg};

use super::entry::function;
use crate::function::{Function, Numbers, Results, one, vector};

/// The functions of this folder, all on the reflection lobe of a view (component 0), a normal (4) and an alpha (11).
pub(super) const FUNCTIONS: &[Function] = &[
    function!(asg_reflection(Axis @ 0, FacingAxis @ 4, Alpha @ 11) -> ["bandwidth x", "bandwidth y", "axis x", "axis y"],
        reflection,
        peak: |x| {
            let [along, across, ..] = reflection(x);
            [along, across, 1.0, 1.0]
        },
        never_negative: false,
    ),
    function!(asg_reflection_flat(Axis @ 0, FacingAxis @ 4, Alpha @ 11) ->
        ["bandwidth x", "bandwidth y", "axis x", "axis y"],
        reflection_flat,
        // At alpha 1 the lobe is constant, and no peak of its own.
        peak: |x| {
            let [along, across, ..] = reflection_flat(x);
            [along.max(1e-6), across.max(1e-6), 1.0, 1.0]
        },
        never_negative: false,
    ),
    function!(asg_evaluate(Axis @ 0, FacingAxis @ 4, OtherAxis @ 8, Alpha @ 11) -> ["value"], evaluate,
        peak: crate::function::unit,
    ),
    function!(asg_convolution(Axis @ 0, Sharpness @ 3, FacingAxis @ 4, OtherAxis @ 8, Alpha @ 11) -> ["integral"],
        convolution,
        reference: Some(convolution_reference),
        slow_reference: true,
        peak: |x| {
            let lobe = lobe(&x);
            [asg::convolution(&lobe, lobe.axes[2], x[3]).max(PI * 1e-18); 4]
        },
    ),
];

/// By quadrature, where that resolves both lobes.
fn convolution_reference(x: Numbers<f64>) -> Results<f64> {
    let lobe = lobe(&x);
    let resolved = lobe.bandwidths[0].max(lobe.bandwidths[1]) <= 1e3 && x[3] <= 400.0;
    let axis = vector(&x, 8);
    one(if resolved { asg::convolution::quadrature(&lobe, axis, x[3]) } else { f64::NAN })
}

fn lobe<R: Real>(x: &Numbers<R>) -> asg::Asg<R> {
    asg::reflection(vector(x, 0), vector(x, 4), x[11])
}

fn reflection<R: Real>(x: Numbers<R>) -> Results<R> {
    let lobe = lobe(&x);
    [lobe.bandwidths[0], lobe.bandwidths[1], lobe.axes[2].x, lobe.axes[2].y]
}

fn reflection_flat<R: Real>(x: Numbers<R>) -> Results<R> {
    let lobe = asg::reflection_flat(vector(&x, 0), vector(&x, 4), x[11]);
    [lobe.bandwidths[0], lobe.bandwidths[1], lobe.axes[2].x, lobe.axes[2].y]
}

fn evaluate<R: Real>(x: Numbers<R>) -> Results<R> {
    one(asg::evaluate(vector(&x, 8), &lobe(&x)))
}

fn convolution<R: Real>(x: Numbers<R>) -> Results<R> {
    one(asg::convolution(&lobe(&x), vector(&x, 8), x[3]))
}

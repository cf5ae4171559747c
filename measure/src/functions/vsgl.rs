//! `shaders/src/vsgl` and `shaders/src/shade`, as far as it reads no texture: what the pipeline does with one lobe.

use core::f64::consts::PI;

use sglow_oracle::shade;
use sglow_oracle::vsgl::Lobe;
use sglow_oracle::{Real, Vector3};

use super::function;
use crate::function::{Function, Numbers, Results, vector};

/// The functions of these folders.
pub(super) const FUNCTIONS: &[Function] = &[
    function!(emission(Axis @ 0, Magnitude @ 3, OtherAxis @ 4, UpperCosine @ 8) ->
        ["sharpness", "red", "green", "blue"],
        peak: |x| {
            let [sharpness, ..] = emission(x);
            let [red, green, blue] = [0, 1, 2].map(|at| x[at].abs() * x[3] * (sharpness + 1.0));
            [sharpness.max(1e-3), red, green, blue]
        },
    ),
    function!(incoming(Axis @ 0, Magnitude @ 3, OtherAxis @ 4, OtherSharpness @ 7, Variance @ 8) ->
        ["sharpness", "radiance"],
        peak: |x| [x[7] + x[3] * x[3] / x[8], 0.5 / (PI * x[8]), 1.0, 1.0],
    ),
];

fn emission<R: Real>(x: Numbers<R>) -> Results<R> {
    let power = vector(&x, 0).map(Real::abs) * x[3];
    let direction = vector(&x, 4) * (x[8] * x[3]);
    let lobe = Lobe::of_moments(power, direction);
    [lobe.sharpness, lobe.coefficient.x, lobe.coefficient.y, lobe.coefficient.z]
}

fn incoming<R: Real>(x: Numbers<R>) -> Results<R> {
    let lobe = Lobe {
        axis: vector(&x, 4),
        sharpness: x[7].min(R::constant(2e37)),
        coefficient: Vector3::splat(R::one()),
    };
    let offset = vector(&x, 0) * x[3];
    let arriving = shade::incoming(Vector3::zero(), offset, x[8], &lobe);
    [arriving.sharpness, arriving.coefficient.x, R::zero(), R::zero()]
}

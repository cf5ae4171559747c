//! `shaders/src/vsgl` and `shaders/src/shade`, as far as it reads no texture: what the pipeline does with one lobe.

use core::f64::consts::PI;

use sglow_oracle::sg::{self, cosine, upper_cosine_integral};
use sglow_oracle::shade::{self, Diffuse, Emitter, disc};
use sglow_oracle::vmf::{Sharpness, mean_length};
use sglow_oracle::vsgl::{Lobe, Vsgl};
use sglow_oracle::{Real, Vector3};

use super::entry::function;
use crate::bound::FILTERED_FLOOR;
use crate::function::{Function, Monotone, Numbers, Results, one, vector};

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
        peak: |x| [x[7] + x[3] * x[3] / variance(x), 0.5 / (PI * variance(x)), 1.0, 1.0],
    ),
    function!(cosine_quadratic(Sharpness @ 3, Cosine @ 0) -> ["integral"],
        reference: Some(|x| one(if x[3] <= 1e6 { cosine::quadrature(x[0], x[3]) } else { f64::NAN })),
        peak: |x| [upper_cosine_integral(x[3].min(2e37)); 4],
        monotone: Some(Monotone { component: 0, grows: true }),
    ),
    function!(emitted(Axis @ 0, Magnitude @ 3, OtherAxis @ 4, OtherSharpness @ 7, Variance @ 8) ->
        ["sharpness", "radiance"],
        peak: |x| {
            let integral = sg::integral(x[7].min(2e37));
            [x[3] * x[3] / variance(x), 0.5 * integral / (PI * PI * variance(x)), 1.0, 1.0]
        },
    ),
    function!(disc_irradiance(
        Axis @ 0, Magnitude @ 3, OtherAxis @ 4, OtherSharpness @ 7, Variance @ 8, OtherAxis @ 9
    ) -> ["irradiance"],
        peak: |x| [1.0 / (x[3] * x[3] + 2.0 * x[8]); 4],
        // The factors of a result near the smallest normal number may be flushed in another order: 4 times 2^-126, where
        // the peak is as low as 5e-31.
        floor: 2.0 * FILTERED_FLOOR,
    ),
];

/// The variance that counts at the light's distance.
fn variance(x: Numbers<f64>) -> f64 {
    shade::incoming::variance_at(x[3] * x[3], x[8])
}

fn cosine_quadratic<R: Real>(x: Numbers<R>) -> Results<R> {
    let sharpness = x[3].min(R::constant(2e37));
    one(shade::quadratic::cosine_quadratic(x[0], sharpness, mean_length(x[3])))
}

fn emitted<R: Real>(x: Numbers<R>) -> Results<R> {
    let light = Vsgl {
        position: vector(&x, 0) * x[3],
        variance: x[8],
        diffuse: Lobe {
            axis: vector(&x, 4),
            sharpness: x[7],
            coefficient: Vector3::splat(R::one()),
        },
        diffuse_mean_length: mean_length(x[7]),
        specular: None,
    };
    let arriving = Emitter::Cosine.emitted(Vector3::zero(), &light, Some(Diffuse::Fitted));
    [arriving.sharpness, arriving.coefficient.x, R::zero(), R::zero()]
}

fn disc_irradiance<R: Real>(x: Numbers<R>) -> Results<R> {
    let (offset, length) = (vector(&x, 0) * x[3], mean_length(x[7]));
    one(disc::irradiance(offset, x[8], vector(&x, 4), length, vector(&x, 9)))
}

fn emission<R: Real>(x: Numbers<R>) -> Results<R> {
    let power = vector(&x, 0).map(Real::abs) * x[3];
    let direction = vector(&x, 4) * (x[8] * x[3]);
    let lobe = Lobe::of_moments(power, direction, power.luminance(), Sharpness::Exact);
    [lobe.sharpness, lobe.coefficient.x, lobe.coefficient.y, lobe.coefficient.z]
}

fn incoming<R: Real>(x: Numbers<R>) -> Results<R> {
    let lobe = Lobe {
        axis: vector(&x, 4),
        // The contract: the squares are in range.
        sharpness: x[7].max(R::constant(1e-15)).min(R::constant(1e18)),
        coefficient: Vector3::splat(R::one()),
    };
    let offset = vector(&x, 0) * x[3];
    let arriving = shade::incoming(Vector3::zero(), offset, x[8], &lobe);
    [arriving.sharpness, arriving.coefficient.x, R::zero(), R::zero()]
}

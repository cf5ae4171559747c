//! `shaders/src/sg`.

use core::f64::consts::PI;

use sglow_oracle::sg::{self, Cosine};
use sglow_oracle::{Real, math};

use super::entry::function;
use crate::function::{Function, Monotone, Numbers, Results, one, vector};

const SHARPER_FALLS: Option<Monotone> = Some(Monotone { component: 3, grows: false });
const COSINE_GROWS: Option<Monotone> = Some(Monotone { component: 0, grows: true });

/// The largest integral of a lobe times a clamped cosine: that about its own axis.
fn upper(x: Numbers<f64>) -> Results<f64> {
    [sg::upper_cosine_integral(sharpness(x[3])); 4]
}

/// The sharpness of a product can be the sum of both. The error of its exponent is relative, where both lobes are of a
/// sharpness from 1e-3 to 1e6 and the amplitude is above e^-20; below, nothing is left of the light.
fn product_peak(x: Numbers<f64>) -> Results<f64> {
    let exponent = product_exact(x)[1].abs();
    let usual = [x[3], x[7]].iter().all(|sharpness| (1e-3..=1e6).contains(sharpness));
    // Below 1e-30 the amplitude is 1 to the last digit.
    let peak = if usual && exponent < 20.0 { exponent.max(1e-30) } else { f64::INFINITY };
    [x[3] + x[7], peak, 1.0, 1.0]
}

/// The functions of this folder.
pub(super) const FUNCTIONS: &[Function] = &[
    function!(sg_evaluate(Axis @ 0, Sharpness @ 3, OtherAxis @ 4) -> ["value"], evaluate,
        monotone: SHARPER_FALLS,
    ),
    function!(sg_integral(Sharpness @ 3) -> ["integral"], integral,
        reference: Some(|x| with_reference(x[3], integral_reference)),
        peak: |x| [sg::integral(sharpness(x[3])); 4],
        monotone: SHARPER_FALLS,
    ),
    function!(sg_product(Axis @ 0, Sharpness @ 3, OtherAxis @ 4, OtherSharpness @ 7) -> ["sharpness", "log_amplitude"], product,
        peak: product_peak,
        never_negative: false,
    ),
    function!(sg_product_moderate(Axis @ 0, Sharpness @ 3, OtherAxis @ 4, OtherSharpness @ 7) -> ["sharpness", "log_amplitude"], product_moderate,
        peak: product_peak,
        never_negative: false,
    ),
    function!(sg_upper_cosine_integral(Sharpness @ 3) -> ["integral"], upper_cosine_integral,
        reference: Some(|x| with_reference(x[3], |sharpness| sg::cosine::quadrature(1.0, sharpness))),
        peak: upper,
        monotone: SHARPER_FALLS,
    ),
    function!(sg_lower_cosine_integral(Sharpness @ 3) -> ["integral"], lower_cosine_integral,
        reference: Some(|x| with_reference(x[3], |sharpness| sg::cosine::quadrature(-1.0, sharpness))),
        peak: upper,
        monotone: SHARPER_FALLS,
    ),
    function!(sg_evaluate_literal(Axis @ 0, Sharpness @ 3, OtherAxis @ 4) -> ["value"], evaluate,
        monotone: SHARPER_FALLS,
        literal: true,
    ),
    function!(sg_integral_literal(Sharpness @ 3) -> ["integral"], integral,
        reference: Some(|x| with_reference(x[3], integral_reference)),
        peak: |x| [sg::integral(sharpness(x[3])); 4],
        monotone: SHARPER_FALLS,
        literal: true,
    ),
    function!(sg_product_literal(Axis @ 0, Sharpness @ 3, OtherAxis @ 4, OtherSharpness @ 7) -> ["sharpness", "log_amplitude"], product,
        peak: product_peak,
        never_negative: false,
        literal: true,
    ),
    function!(sg_upper_cosine_integral_literal(Sharpness @ 3) -> ["integral"], upper_cosine_integral,
        reference: Some(|x| with_reference(x[3], |sharpness| sg::cosine::quadrature(1.0, sharpness))),
        peak: upper,
        monotone: SHARPER_FALLS,
        literal: true,
    ),
    function!(sg_lower_cosine_integral_literal(Sharpness @ 3) -> ["integral"], lower_cosine_integral,
        reference: Some(|x| with_reference(x[3], |sharpness| sg::cosine::quadrature(-1.0, sharpness))),
        peak: upper,
        monotone: SHARPER_FALLS,
        literal: true,
    ),
    function!(sg_hemisphere_integral(Sharpness @ 3, Cosine @ 0) -> ["integral"], hemisphere_integral,
        reference: Some(|x| with_reference(x[3], |sharpness| sg::hemisphere::quadrature(x[0], sharpness))),
        peak: |x| [2.0 * PI * math::expm1_over_x(-sharpness(x[3])); 4],
        monotone: COSINE_GROWS,
    ),
    function!(sg_cosine_constant(Sharpness @ 3, Cosine @ 0) -> ["integral"], cosine_constant,
        reference: Some(cosine_reference),
        peak: upper,
        monotone: COSINE_GROWS,
    ),
    function!(sg_cosine_gaussian(Sharpness @ 3, Cosine @ 0) -> ["integral"], cosine_gaussian,
        reference: Some(cosine_reference),
        peak: upper,
        monotone: COSINE_GROWS,
    ),
    function!(sg_cosine_logistic(Sharpness @ 3, Cosine @ 0) -> ["integral"], cosine_logistic,
        reference: Some(cosine_reference),
        peak: upper,
        monotone: COSINE_GROWS,
    ),
    function!(sg_cosine_logistic_literal(Sharpness @ 3, Cosine @ 0) -> ["integral"], cosine_logistic,
        reference: Some(cosine_reference),
        peak: upper,
        monotone: COSINE_GROWS,
        literal: true,
    ),
    function!(sg_cosine_erf(Sharpness @ 3, Cosine @ 0) -> ["integral"], cosine_erf,
        reference: Some(cosine_reference),
        peak: upper,
        monotone: COSINE_GROWS,
    ),
    function!(sg_cosine_quartic(Sharpness @ 3, Cosine @ 0) -> ["integral"], cosine_quartic,
        reference: Some(cosine_reference),
        peak: upper,
        monotone: COSINE_GROWS,
    ),
    function!(cosine_quartic_mean(Sharpness @ 3, Cosine @ 0) -> ["integral"], cosine_quartic_mean,
        reference: Some(cosine_reference),
        peak: upper,
        monotone: COSINE_GROWS,
    ),
    function!(sg_cosine_fitted(Sharpness @ 3, Cosine @ 0) -> ["integral"], cosine_fitted,
        reference: Some(cosine_reference),
        peak: upper,
        monotone: COSINE_GROWS,
    ),
    function!(cosine_fitted_mean(Sharpness @ 3, Cosine @ 0) -> ["integral"], cosine_fitted,
        reference: Some(cosine_reference),
        peak: upper,
        monotone: COSINE_GROWS,
    ),
    function!(sg_cosine_fitted_fine(Sharpness @ 3, Cosine @ 0) -> ["integral"], cosine_fitted_fine,
        reference: Some(cosine_reference),
        peak: upper,
        monotone: COSINE_GROWS,
    ),
    function!(cosine_fitted_fine_mean(Sharpness @ 3, Cosine @ 0) -> ["integral"], cosine_fitted_fine,
        reference: Some(cosine_reference),
        peak: upper,
        monotone: COSINE_GROWS,
    ),
];

/// Independent of the closed form: the integral over the height above the axis, of `exp(-l h)` for h from 0 to 2.
fn integral_reference(sharpness: f64) -> f64 {
    // Beyond 40/l nothing is left.
    let reach = (40.0 / sharpness).min(2.0);
    let nodes = sglow_oracle::quadrature::gauss_legendre(48);
    let terms =
        nodes.iter().map(|(node, weight)| weight * (-sharpness * 0.5 * reach * (1.0 + node)).exp());
    2.0 * PI * 0.5 * reach * terms.sum::<f64>()
}

/// The quadrature is tested against the exact identities up to this sharpness; beyond it there is no reference.
const REFERENCE_UP_TO: f64 = 1e9;

fn with_reference(sharpness: f64, reference: impl Fn(f64) -> f64) -> Results<f64> {
    one(if sharpness <= REFERENCE_UP_TO { reference(sharpness) } else { f64::NAN })
}

fn cosine_reference(x: Numbers<f64>) -> Results<f64> {
    with_reference(x[3], |sharpness| sg::cosine::quadrature(x[0], sharpness))
}

/// The contract of these functions: sharpness beyond 4e37 counts as 4e37, since no language promises a quotient whose
/// divisor is beyond 2^126.
fn sharpness<R: Real>(sharpness: R) -> R {
    sharpness.min(R::constant(4e37))
}

fn evaluate<R: Real>(x: Numbers<R>) -> Results<R> {
    one(sg::evaluate(vector(&x, 0), vector(&x, 4), sharpness(x[3])))
}

fn integral<R: Real>(x: Numbers<R>) -> Results<R> {
    one(sg::integral(sharpness(x[3])))
}

fn product<R: Real>(x: Numbers<R>) -> Results<R> {
    // The contract: beyond 2e37 it counts as there, so that the sum of two is in range.
    let most = R::constant(2e37);
    let product = sg::product(vector(&x, 0), x[3].min(most), vector(&x, 4), x[7].min(most));
    [product.sharpness, product.log_amplitude, R::zero(), R::zero()]
}

fn product_moderate<R: Real>(x: Numbers<R>) -> Results<R> {
    // The contract: the squares are in range.
    let [a, b] = [x[3], x[7]].map(|one| one.max(R::constant(1e-15)).min(R::constant(1e18)));
    let product = sg::product(vector(&x, 0), a, vector(&x, 4), b);
    [product.sharpness, product.log_amplitude, R::zero(), R::zero()]
}

fn product_exact(x: Numbers<f64>) -> Results<f64> {
    product(x)
}

fn upper_cosine_integral<R: Real>(x: Numbers<R>) -> Results<R> {
    one(sg::upper_cosine_integral(sharpness(x[3])))
}

fn lower_cosine_integral<R: Real>(x: Numbers<R>) -> Results<R> {
    one(sg::lower_cosine_integral(sharpness(x[3])))
}

fn hemisphere_integral<R: Real>(x: Numbers<R>) -> Results<R> {
    one(sg::hemisphere_integral(x[0], sharpness(x[3])))
}

fn cosine_constant<R: Real>(x: Numbers<R>) -> Results<R> {
    one(Cosine::Constant.integral(x[0], sharpness(x[3])))
}

fn cosine_gaussian<R: Real>(x: Numbers<R>) -> Results<R> {
    one(Cosine::Gaussian.integral(x[0], sharpness(x[3])))
}

fn cosine_logistic<R: Real>(x: Numbers<R>) -> Results<R> {
    one(Cosine::Logistic.integral(x[0], sharpness(x[3])))
}

fn cosine_erf<R: Real>(x: Numbers<R>) -> Results<R> {
    one(Cosine::Erf.integral(x[0], sharpness(x[3])))
}

fn cosine_quartic<R: Real>(x: Numbers<R>) -> Results<R> {
    one(Cosine::Quartic.integral(x[0], sharpness(x[3])))
}

fn cosine_quartic_mean<R: Real>(x: Numbers<R>) -> Results<R> {
    let sharpness = sharpness(x[3]);
    let mean_length = sglow_oracle::vmf::mean_length(sharpness);
    one(sg::cosine::quartic_known(x[0], sharpness, mean_length, sg::cosine::QUARTIC))
}

fn cosine_fitted<R: Real>(x: Numbers<R>) -> Results<R> {
    one(Cosine::Fitted.integral(x[0], sharpness(x[3])))
}

fn cosine_fitted_fine<R: Real>(x: Numbers<R>) -> Results<R> {
    one(Cosine::FittedFine.integral(x[0], sharpness(x[3])))
}

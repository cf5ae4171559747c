//! `shaders/src/vmf`.

use sglow_oracle::{Real, quadrature, vmf};

use super::entry::function;
use crate::function::{Function, Monotone, Numbers, Results, one};

const SHARPER_GROWS: Option<Monotone> = Some(Monotone { component: 3, grows: true });
const SHARPER_FALLS: Option<Monotone> = Some(Monotone { component: 3, grows: false });

/// Relative errors: each sharpness is its own peak.
fn own(x: Numbers<f64>) -> Results<f64> {
    [inverse(x); 4]
}

/// The functions of this folder. A mean length and its complement are not followed to neighbours: they go together.
pub(super) const FUNCTIONS: &[Function] = &[
    function!(vmf_sharpness_toksvig(MeanLength @ 0) -> ["sharpness"], toksvig,
        reference: Some(sharpness_reference),
        peak: own,
    ),
    function!(vmf_sharpness_banerjee(MeanLength @ 0) -> ["sharpness"], banerjee,
        reference: Some(sharpness_reference),
        peak: own,
    ),
    function!(vmf_sharpness_kroeger(MeanLength @ 0) -> ["sharpness"], kroeger,
        reference: Some(sharpness_reference),
        peak: own,
    ),
    function!(vmf_sharpness_exact(MeanLength @ 0) -> ["sharpness"], exact,
        reference: Some(sharpness_reference),
        peak: own,
    ),
    function!(vmf_mean_length_toksvig(Sharpness @ 3) -> ["mean length"], mean_length_toksvig,
        reference: Some(|x| one(with_reference(x[3])[0])),
        monotone: SHARPER_GROWS,
    ),
    function!(vmf_mean_length_exact(Sharpness @ 3) -> ["mean length"], mean_length,
        reference: Some(|x| one(with_reference(x[3])[0])),
        monotone: SHARPER_GROWS,
    ),
    function!(vmf_mean_length_complement(Sharpness @ 3) -> ["complement"], mean_length_complement,
        reference: Some(|x| one(with_reference(x[3])[1])),
        peak: |x| [vmf::mean_length_complement(x[3]); 4],
        monotone: SHARPER_FALLS,
    ),
];

/// The sharpness whose mean length this is, by bisection of its logarithm; from the complement where that has more
/// digits.
fn inverse(x: Numbers<f64>) -> f64 {
    let [length, complement] = [x[0], x[1]];
    if length == 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (-110.0_f64, 41.0 * core::f64::consts::LN_2);
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        let below = if length < 0.5 {
            vmf::mean_length(middle.exp()) < length
        } else {
            vmf::mean_length_complement(middle.exp()) > complement
        };
        if below {
            low = middle;
        } else {
            high = middle;
        }
    }
    (0.5 * (low + high)).exp()
}

fn sharpness_reference(x: Numbers<f64>) -> Results<f64> {
    one(inverse(x))
}

/// Up to sharpness 1e9, the maximum at which the quadrature is tested; beyond it there is no reference.
fn with_reference(sharpness: f64) -> [f64; 2] {
    if sharpness <= 1e9 { moments(sharpness) } else { [f64::NAN; 2] }
}

/// Mean length and complement by quadrature over the height h = 1 - w.axis, of `exp(-l h)` on 0 to 2.
fn moments(sharpness: f64) -> [f64; 2] {
    let reach = (40.0 / sharpness).min(2.0);
    let mut sums = [0.0; 3];
    for (node, weight) in quadrature::gauss_legendre(48) {
        let height = 0.5 * reach * (1.0 + node);
        let mass = weight * (-sharpness * height).exp();
        sums[0] += mass * (1.0 - height);
        sums[1] += mass * height;
        sums[2] += mass;
    }
    // The mean length of a broad lobe is what is left of both sides.
    if sharpness < 1e-3 {
        return [sharpness / 3.0 * (1.0 - sharpness * sharpness / 15.0), sums[1] / sums[2]];
    }
    [sums[0] / sums[2], sums[1] / sums[2]]
}

fn toksvig<R: Real>(x: Numbers<R>) -> Results<R> {
    one(vmf::toksvig(x[0], x[1]))
}

fn banerjee<R: Real>(x: Numbers<R>) -> Results<R> {
    one(vmf::banerjee(x[0], x[1]))
}

fn kroeger<R: Real>(x: Numbers<R>) -> Results<R> {
    one(vmf::kroeger(x[0], x[1]))
}

fn exact<R: Real>(x: Numbers<R>) -> Results<R> {
    one(vmf::exact(x[0], x[1]))
}

fn mean_length_toksvig<R: Real>(x: Numbers<R>) -> Results<R> {
    one(vmf::mean_length_toksvig(x[3]))
}

fn mean_length<R: Real>(x: Numbers<R>) -> Results<R> {
    one(vmf::mean_length(x[3]))
}

fn mean_length_complement<R: Real>(x: Numbers<R>) -> Results<R> {
    one(vmf::mean_length_complement(x[3]))
}

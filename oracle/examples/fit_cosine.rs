//! Fits the constants of `sglow_sg_cosine_quartic`, `sglow_sg_cosine_fitted` and `sglow_sg_cosine_fitted_fine` by least
//! largest error over the largest value of the integral, prints them as `shaders/src/sg/cosine.wesl` and
//! `oracle/src/sg/cosine.rs` have them, and a table of the errors of all forms.
//!
//! `cargo run --release -p sglow-oracle --example fit_cosine`

mod minimax;

use core::f64::consts::PI;

use minimax::{fit, largest};
use rayon::prelude::*;
use sglow_oracle::sg::cosine::{DarkSide, Quartic, dark_side, quadrature, quartic, quartic_mean};
use sglow_oracle::sg::{Cosine, integral, upper_cosine_integral};
use sglow_oracle::vmf::{mean_length, mean_length_complement};

/// A sharpness, a cosine, the reference and its largest value.
type Sample = [f64; 4];

/// Numbers that grow by a constant factor.
fn geometric(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| low * (high / low).powf(f64::from(i) / f64::from(count - 1)))
}

/// What is fitted: lobes seen from behind, out to where nothing of them is left.
fn samples() -> Vec<Sample> {
    let sharpness: Vec<f64> = geometric(1e-2, 0.33, 14)
        .chain(geometric(0.35, 120.0, 60))
        .chain(geometric(150.0, 1e5, 9))
        .collect();
    sharpness
        .par_iter()
        .flat_map_iter(|&sharpness| {
            let reach = (4.2 / sharpness.sqrt()).min(1.0);
            (0..33).map(move |i| {
                let cosine = -0.5 * reach * (1.0 - (PI * f64::from(i) / 32.0).cos());
                let upper = upper_cosine_integral(sharpness);
                [sharpness, cosine, quadrature(cosine, sharpness), upper]
            })
        })
        .collect()
}

/// A polynomial in the sharpness l, lowest coefficient first, times `y^degree` with `y = 1/(1 + l)`: one in y.
fn in_y(coefficients: &[f64]) -> Vec<f64> {
    let degree = coefficients.len() - 1;
    let mut result = vec![0.0; degree + 1];
    for (power, coefficient) in coefficients.iter().enumerate() {
        // l^k y^n = (1 - y)^k y^(n - k)
        let mut binomial = 1.0;
        for i in 0..=power {
            result[degree - power + i] += coefficient * binomial;
            binomial *= -((power - i) as f64) / (i + 1) as f64;
        }
    }
    result
}

/// How many constants there are of each kind.
#[derive(Clone, Copy)]
struct Shape {
    /// Degree n of the numerator of the squared value at the horizon, whose denominator has degree n + 3: 2 n + 2
    /// constants, since both limits, 1 at sharpness 0 and 2/pi when sharp, are kept.
    degree: usize,
    /// Number of constants of the flattening; those of the weight are the rest.
    flattening: usize,
    /// Whether the weight is a constant, or a polynomial that is 1 for a sharp lobe.
    weight_is_constant: bool,
}

/// What a [`DarkSide`] borrows.
struct Constants {
    numerator: Vec<f64>,
    denominator: Vec<f64>,
    flattening: Vec<f64>,
    weight: Vec<f64>,
}

impl Constants {
    fn borrow(&self) -> DarkSide<'_> {
        DarkSide {
            numerator: &self.numerator,
            denominator: &self.denominator,
            flattening: &self.flattening,
            weight: &self.weight,
        }
    }
}

fn constants(shape: Shape, parameters: &[f64]) -> Constants {
    let (top, rest) = parameters.split_at(shape.degree);
    let (bottom, rest) = rest.split_at(shape.degree + 2);
    let (flattening, weight) = rest.split_at(shape.flattening);
    let numerator: Vec<f64> = top.iter().copied().chain([1.0]).collect();
    let denominator: Vec<f64> =
        [numerator[0]].into_iter().chain(bottom.iter().copied()).chain([0.5 * PI]).collect();
    let one = [1.0];
    Constants {
        numerator: in_y(&numerator),
        denominator: in_y(&denominator),
        flattening: one.iter().chain(flattening).copied().collect(),
        weight: if shape.weight_is_constant {
            weight.to_vec()
        } else {
            one.iter().chain(weight).copied().collect()
        },
    }
}

fn residuals(samples: &[Sample], constants: &Constants) -> Vec<f64> {
    samples
        .iter()
        .map(|&[sharpness, cosine, quadrature, upper]| {
            let error = (dark_side(cosine, sharpness, constants.borrow()) - quadrature) / upper;
            // Outside of what the square roots take, the fit is no good at all.
            if error.is_finite() { error } else { 1.0 }
        })
        .collect()
}

/// As f32 holds them.
fn rounded(constants: &Constants) -> Constants {
    let round = |list: &[f64]| list.iter().map(|&v| f64::from(v as f32)).collect();
    Constants {
        numerator: round(&constants.numerator),
        denominator: round(&constants.denominator),
        flattening: round(&constants.flattening),
        weight: round(&constants.weight),
    }
}

fn fit_form(name: &str, samples: &[Sample], shape: Shape, start: &[f64]) {
    let (parameters, error) =
        fit(|parameters| residuals(samples, &constants(shape, parameters)), start, 160);
    let found = constants(shape, &parameters);
    let after = largest(&residuals(samples, &rounded(&found)));
    println!("{name}: {} constants, error {error:.3e}, as f32 {after:.3e}", start.len());
    let list = |values: &[f64]| {
        values.iter().map(|&v| format!("{:?}", v as f32)).collect::<Vec<_>>().join(", ")
    };
    println!("  numerator   [{}]", list(&found.numerator));
    println!("  denominator [{}]", list(&found.denominator));
    println!("  flattening  [{}]", list(&found.flattening));
    println!("  weight      [{}]", list(&found.weight));
    println!("  parameters  {parameters:?}");
}

/// The six free numbers of the quartic: both limits of the horizon and that of the mean length for small sharpness are
/// kept.
fn quartic_of(parameters: &[f64]) -> Quartic {
    let &[h1, h2, bend, a, b, p] = parameters else { unreachable!("six numbers") };
    let sharp = 0.5 / PI;
    let horizon = [sharp, h1, h2, 0.0625 - sharp - h1 - h2];
    Quartic { horizon, bend, complement: [a, b, p, 3.0 * b] }
}

/// The errors with a mean length that is known, and with the fitted one.
fn quartic_residuals(samples: &[Sample], constants: Quartic) -> Vec<f64> {
    samples
        .iter()
        .flat_map(|&[sharpness, cosine, quadrature, upper]| {
            let (length, rest) = (mean_length(sharpness), mean_length_complement(sharpness));
            let known = integral(sharpness) * quartic_mean(cosine, length, rest, constants);
            let fitted = quartic(cosine, sharpness, constants);
            [known, fitted].map(|found| {
                let error = (found - quadrature) / upper;
                if error.is_finite() { error } else { 1.0 }
            })
        })
        .collect()
}

fn fit_quartic(samples: &[Sample], start: &[f64]) {
    // A mean length that is not exact is seen from the front as well.
    let fronts = samples.iter().map(|&[sharpness, cosine, _, upper]| {
        [sharpness, -cosine, quadrature(-cosine, sharpness), upper]
    });
    let all: Vec<Sample> = samples.iter().copied().chain(fronts).collect();
    let (parameters, error) =
        fit(|parameters| quartic_residuals(&all, quartic_of(parameters)), start, 160);
    let found = quartic_of(&parameters);
    let round = |v: f64| f64::from(v as f32);
    let rounded = Quartic {
        horizon: found.horizon.map(round),
        bend: round(found.bend),
        complement: found.complement.map(round),
    };
    let errors = quartic_residuals(&all, rounded);
    let [known, fitted] = [0, 1]
        .map(|first| largest(&errors.iter().skip(first).step_by(2).copied().collect::<Vec<_>>()));
    println!(
        "quartic: error {error:.3e}, as f32 {known:.3e} with the mean length, {fitted:.3e} without"
    );
    println!("  horizon     {:?}", found.horizon.map(|v| v as f32));
    println!("  bend        {:?}", found.bend as f32);
    println!("  complement  {:?}", found.complement.map(|v| v as f32));
    println!("  parameters  {parameters:?}");
}

/// Largest and root mean square error of each form over all sharpness and angles, and for sharpness of at least 1.
fn table() {
    let sharpness: Vec<f64> = geometric(1e-3, 1e6, 181).collect();
    let truths: Vec<(f64, Vec<(f64, f64)>)> = sharpness
        .par_iter()
        .map(|&sharpness| {
            let uniform = (0..181).map(|i| PI * f64::from(i) / 180.0);
            let reach = (8.0 / sharpness.sqrt()).min(0.5 * PI);
            let near = (0..81).map(|i| 0.5 * PI + reach * (f64::from(i) / 40.0 - 1.0));
            let angles = uniform.chain(near).map(f64::cos);
            (sharpness, angles.map(|cosine| (cosine, quadrature(cosine, sharpness))).collect())
        })
        .collect();
    println!(
        "{:<12} {:>10} {:>12} {:>10} {:>14}",
        "form", "largest", "sharpness>=1", "RMSE", "rel. I/Au>1e-3"
    );
    for form in Cosine::ALL {
        let (mut most, mut sharp, mut squares, mut relative) = (0.0_f64, 0.0_f64, 0.0, 0.0_f64);
        let mut at = (0.0, 0.0);
        for (sharpness, row) in &truths {
            let upper = upper_cosine_integral(*sharpness);
            for (index, &(cosine, quadrature)) in row.iter().enumerate() {
                let error = (form.integral(cosine, *sharpness) - quadrature).abs() / upper;
                if error > most {
                    (most, at) = (error, (*sharpness, cosine));
                }
                if *sharpness >= 1.0 {
                    sharp = sharp.max(error);
                }
                if index < 181 {
                    squares += error * error / (181.0 * 181.0);
                }
                if quadrature > 1e-3 * upper {
                    relative = relative.max(error * upper / quadrature);
                }
            }
        }
        println!(
            "{:<12} {most:>10.3e} {sharp:>12.3e} {:>10.2e} {relative:>14.2e}   at sharpness {:.3}, cosine {:.2}",
            format!("{form:?}"),
            squares.sqrt(),
            at.0,
            at.1
        );
    }
}

fn main() {
    let samples = samples();
    fit_quartic(&samples, &[-0.1428, 0.0577, 0.1232, 1.874, 3.666, 2.325]);
    // Starts: the value at the horizon fitted alone, the flattening from fits per sharpness.
    let two = [3.75, 0.31, 7.83, 7.96, 6.41, 1.74];
    let three = [10.8, 5.77, 0.91, 27.4, 31.5, 21.4, 11.7, 2.58];
    // The parameters are lowest coefficients first: top[0..n], then the denominator's from l to l^(n + 2).
    let start: Vec<f64> = vec![two[0], two[1], two[2], two[3], two[4], two[5], -1.9, 8.0, 0.94];
    fit_form(
        "fitted",
        &samples,
        Shape { degree: 2, flattening: 2, weight_is_constant: true },
        &start,
    );
    let start: Vec<f64> = three.iter().copied().chain([-2.0, 5.7, 8.0, -1.1, 3.6, -1.9]).collect();
    fit_form(
        "fitted_fine",
        &samples,
        Shape { degree: 3, flattening: 3, weight_is_constant: false },
        &start,
    );
    table();
}

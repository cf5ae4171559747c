//! The integral over the sphere of a spherical Gaussian times the clamped cosine about a normal,
//! `I(l, z) = int G(w) max(n . w, 0) dw`, as a function of the sharpness l and the cosine z of the angle between the
//! lobe's axis and the normal: its reference by quadrature, and seven closed forms.

use core::f64::consts::PI;
use std::sync::LazyLock;

use crate::Real;
use crate::math::bessel_i_scaled;
use crate::quadrature::gauss_legendre;
use crate::sg::{integral, lower_cosine_integral, odd_part_scaled};

static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(48));

/// An integral over the polar angle from the normal, of a lobe at the angle `acos(cosine)` from it, in one panel that
/// reaches as far as the lobe does.
pub(crate) fn polar(cosine: f64, sharpness: f64, weight: impl Fn(f64) -> f64) -> f64 {
    let tilt = cosine.clamp(-1.0, 1.0).acos();
    let horizon = 0.5 * PI;
    let (low, high) = if tilt <= horizon {
        let reach = 9.0 / (sharpness + 1.0).sqrt();
        ((tilt - reach).max(0.0), (tilt + reach).min(horizon))
    } else {
        let decay = sharpness * (tilt - horizon).sin() + sharpness.sqrt() + 1.0;
        ((horizon - 40.0 / decay).max(0.0), horizon)
    };
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
    let sum: f64 = RULE
        .iter()
        .map(|&(node, share)| {
            let angle = centre + half * node;
            let chord = (0.5 * (angle - tilt)).sin();
            let ring = bessel_i_scaled(0, sharpness * angle.sin() * tilt.sin());
            share * weight(angle) * angle.sin() * (-2.0 * sharpness * chord * chord).exp() * ring
        })
        .sum();
    2.0 * PI * half * sum
}

/// The integral itself: the azimuth in closed form, the polar angle by a Gauss-Legendre rule of 48 nodes. Within 1e-9
/// of it, and within 1e-13 of its largest value.
#[must_use]
pub fn quadrature(cosine: f64, sharpness: f64) -> f64 {
    polar(cosine, sharpness, f64::cos)
}

/// A closed form of the integral.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cosine {
    /// The cosine is constant over the lobe, taken at its axis.
    Constant,
    /// The cosine is a spherical Gaussian of sharpness 2 with the same integral, and the product is exact.
    Gaussian,
    /// A blend of two cosines by a logistic curve.
    Logistic,
    /// The integral of a Gaussian times a clamped line.
    Erf,
    /// [`quartic`] with [`QUARTIC`].
    Quartic,
    /// [`dark_side`] with [`FITTED`].
    Fitted,
    /// [`dark_side`] with [`FITTED_FINE`].
    FittedFine,
}

impl Cosine {
    /// All of them, the cheapest and least accurate first.
    pub const ALL: [Self; 7] = [
        Self::Constant,
        Self::Gaussian,
        Self::Logistic,
        Self::Erf,
        Self::Quartic,
        Self::Fitted,
        Self::FittedFine,
    ];

    /// The integral of a lobe of amplitude one and a sharpness at least 0; cosine: -1 to 1.
    pub fn integral<R: Real>(self, cosine: R, sharpness: R) -> R {
        match self {
            Self::Constant => constant(cosine, sharpness),
            Self::Gaussian => gaussian(cosine, sharpness),
            Self::Logistic => logistic(cosine, sharpness),
            Self::Erf => erf(cosine, sharpness),
            Self::Quartic => quartic(cosine, sharpness, QUARTIC),
            Self::Fitted => dark_side(cosine, sharpness, FITTED),
            Self::FittedFine => dark_side(cosine, sharpness, FITTED_FINE),
        }
    }
}

// [Tokuyoshi 2016, Appendix C.2]
fn constant<R: Real>(cosine: R, sharpness: R) -> R {
    integral(sharpness) * cosine.max(R::zero())
}

// [Tokuyoshi 2015, Eq. (1), Section 3.2]
fn gaussian<R: Real>(cosine: R, sharpness: R) -> R {
    let (one, two) = (R::one(), R::constant(2.0));
    // Lengths in units of the larger sharpness, whose square may be out of range.
    let (larger, ratio) =
        if sharpness.value() > 2.0 { (sharpness, two / sharpness) } else { (two, sharpness / two) };
    let length = ((one - ratio).squared() + two * ratio * (one + cosine)).sqrt();
    let share = ratio / (one + ratio + length);
    let exponent = -(larger * (two * share * (one - cosine)));
    R::constant(PI / integral(2.0)) * exponent.exp() * integral(larger * length)
}

/// `A_b + (A_u - A_b) c`.
fn between_bounds<R: Real>(sharpness: R, c: R) -> R {
    let odd = R::constant(2.0 * PI) * odd_part_scaled(sharpness) / (R::one() + sharpness);
    lower_cosine_integral(sharpness) + odd * c
}

// [Meder 2018, Eq. (15)-(18)]
fn logistic<R: Real>(cosine: R, sharpness: R) -> R {
    let (one, half) = (R::one(), R::constant(0.5));
    let t =
        R::constant(2.1007) * sharpness.sqrt() * (sharpness / (sharpness + R::constant(4.4653)));
    let u = one / (R::constant(0.2958) * t + R::constant(0.5033));
    // 1/(exp(x) + 1) without the large exponential.
    let decay = (-(cosine.abs() * t)).exp();
    let s = u * decay / (one + decay);
    let c = s * (half + half * cosine) + (one - s) * cosine.max(R::zero());
    between_bounds(sharpness, c)
}

/// `l sqrt(N(l)/D(l))`, N and D polynomials by their coefficients, lowest first, D of one degree more; written in
/// `1/(1 + l)` and `l/(1 + l)`, so that no power of a large sharpness occurs.
pub(crate) fn slope_of<R: Real>(sharpness: R, numerator: &[f64], denominator: &[f64]) -> R {
    let y = R::one() / (R::one() + sharpness);
    let u = sharpness * y;
    // Every term has the degree of the whole in both variables together.
    let homogeneous = |coefficients: &[f64]| {
        (0..).zip(coefficients).fold(R::zero(), |sum, (power, &coefficient)| {
            sum * y + (0..power).fold(R::constant(coefficient), |term, _| term * u)
        })
    };
    u * (homogeneous(numerator) / (y * homogeneous(denominator))).sqrt()
}

// [Tokuyoshi 2024]: c = 1/2 + (z erf(t z) - erf(t))/2 + (exp(-t^2 z^2) - exp(-t^2))/(2 t sqrt(pi)) + z/2
fn erf<R: Real>(cosine: R, sharpness: R) -> R {
    let t = slope_of(
        sharpness,
        &[0.5 * 17.021_297_8, 0.5 * 2.736_083_16, 0.5],
        &[76.087_896_3, 15.219_156_3, 4.010_082_67, 1.0],
    );
    let half = R::constant(0.5);
    let x = t * cosine;
    // The difference of the two exponentials, without cancellation: one times exp(-t^2 (1 - z^2)) - 1.
    let rest = (R::one() - cosine) * (R::one() + cosine);
    let difference = (-(x * x)).exp() * t * rest * (t * t * rest).one_minus_exp_over();
    let c = half * (cosine * (-x).erfc() + t.erfc()) + R::constant(0.5 / PI.sqrt()) * difference;
    between_bounds(sharpness, c.max(R::zero()))
}

/// The constants of [`quartic`] and [`quartic_mean`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quartic {
    /// Of the square of the mean cosine at the horizon over `s = 1 - r`: a polynomial in s, lowest coefficient first.
    pub horizon: [f64; 4],
    /// What the square of `r z` is taken of the fourth power's base with.
    pub bend: f64,
    /// `a, b, p, q` of `s = (l^2 + p l + q)/(l^3 + (a + 1) l^2 + (b + p) l + q)`.
    pub complement: [f64; 4],
}

/// Fitted by `examples/fit_cosine.rs` for the least largest error over `A_u` on sharpness 0.01 to 1e5 and both sides,
/// with the mean length known and without: 1.45e-3. Six numbers are free.
pub const QUARTIC: Quartic = Quartic {
    horizon: [0.159_154_94, -0.144_591_8, 0.062_458_012, -0.014_521_165],
    bend: 0.121_884_175,
    complement: [1.640_325_2, 3.172_988_7, 2.211_125_1, 9.518_967],
};

/// The mean of the clamped cosine over the directions of a lobe, from the mean length r of these and `s = 1 - r`.
///
/// The odd part is exactly `r z/2`, so that the mean is `r max(z, 0)` and what a lobe gives on the side that faces
/// away. That goes over the line as an integral of erfc, which a fourth power `h max(1 - x/e, 0)^4` follows to 0.003
/// times the width of the lobe. Here it is `h max(1 - |z| (r/(8 h) + c r^2 |z|), 0)^4`: its slope at the horizon is
/// exactly `-r/2`, and c bends it as the sphere does. The square of h, the mean at the horizon, is s times a polynomial
/// in s: 1/16 for a lobe that is the same everywhere, `s/(2 pi)` for a sharp one.
pub fn quartic_mean<R: Real>(cosine: R, mean_length: R, complement: R, constants: Quartic) -> R {
    let one = R::one();
    let horizon = (complement * polynomial(&constants.horizon, complement)).sqrt();
    let height = mean_length * cosine;
    let away = height.abs();
    let bent = R::constant(0.125) / horizon + R::constant(constants.bend) * away;
    let base = (one - away * bent).max(R::zero());
    height.max(R::zero()) + horizon * base.squared().squared()
}

/// The integral from the mean of the clamped cosine; r is a fit of `coth l - 1/l`.
pub fn quartic<R: Real>(cosine: R, sharpness: R, constants: Quartic) -> R {
    let [a, b, p, q] = constants.complement.map(R::constant);
    // Beyond 1e12 the lobe has one direction, and its third power would leave the range of f32.
    let l = sharpness.min(R::constant(1e12));
    let rest = q + l * (p + l);
    let complement = rest / (rest + l * (b + l * (a + l)));
    let mean_length = R::one() - complement;
    let mean = quartic_mean(cosine, mean_length, complement, constants);
    integral_of_mean_length(sharpness, mean_length) * mean
}

/// The same of a lobe whose mean length of directions is known, as far as f32 tells it from 1.
pub fn quartic_known<R: Real>(cosine: R, sharpness: R, mean_length: R, constants: Quartic) -> R {
    let complement = (R::one() - mean_length).max(R::constant(2_f64.powi(-24)));
    let mean = quartic_mean(cosine, mean_length, complement, constants);
    integral_of_mean_length(sharpness, mean_length) * mean
}

/// The integral of a lobe itself, since `(1 - exp(-2 l))/l` is `2/(1 + l (1 + r))` with `r = coth l - 1/l`.
fn integral_of_mean_length<R: Real>(sharpness: R, mean_length: R) -> R {
    R::constant(4.0 * PI) / (R::one() + sharpness * (R::one() + mean_length))
}

/// The constants of [`dark_side`]: functions of `y = 1/(1 + l)`, lowest coefficient first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DarkSide<'a> {
    /// Numerator of the square of the value at the horizon.
    pub numerator: &'a [f64],
    /// Its denominator; a factor y besides.
    pub denominator: &'a [f64],
    /// Denominator of the flattening p, whose numerator is `(1 - y)^2`.
    pub flattening: &'a [f64],
    /// The weight w of what the flattening changes.
    pub weight: &'a [f64],
}

/// Fitted by `examples/fit_cosine.rs` with a constant weight, for the least largest error over `A_u` on sharpness 0.01
/// to 1e5: 5.8e-5. Nine numbers are free; the horizon's limits for small and large sharpness are kept.
pub const FITTED: DarkSide<'static> = DarkSide {
    numerator: &[1.0, -1.664_101_7, 4.425_602_4],
    denominator: &[1.570_796_4, -6.071_711, 15.022_563, -16.302_683, 11.848_223, -2.305_686_5],
    flattening: &[1.0, -2.429_447_4, 8.802_209],
    weight: &[0.942_344_4],
};

/// As [`FITTED`], with one degree more and a cubic weight; fourteen numbers are free, the error is 1.6e-5.
pub const FITTED_FINE: DarkSide<'static> = DarkSide {
    numerator: &[1.0, -2.493_731_3, 7.714_763_6, 4.060_868_3],
    denominator: &[
        1.570_796_4,
        -7.488_554,
        25.234_873,
        -37.759_953,
        43.364_49,
        -20.095_003,
        5.455_252,
    ],
    flattening: &[1.0, -2.243_377, 5.719_42, 8.090_606],
    weight: &[1.0, -1.100_594_5, 3.576_575_3, -1.902_922_7],
};

fn polynomial<R: Real>(coefficients: &[f64], y: R) -> R {
    coefficients
        .iter()
        .rev()
        .fold(R::zero(), |sum, &coefficient| sum * y + R::constant(coefficient))
}

/// The form of this project: the exact odd part, and a fit to what a lobe gives on the side that faces away.
///
/// The odd part of the integral is exactly `(A_u - A_b) z/2`, so that `I(z) = (A_u - A_b) max(z, 0) + J(|z|)` with
/// `J(|z|) = I(-|z|)`. For a Gaussian over the line instead of the sphere J would be `exp(-x^2) h(x)/t` with `x = t z`
/// and h the scaled integral of erfc. On the sphere t grows with z, because the exponent goes with the chord and not
/// with the height: `t^2 = t_0^2 (1 + w (1 - r)/(1 + r))`, `r = sqrt(1 - p z^2)`, with p and w going to 1 for a sharp
/// lobe. J at the horizon is fitted, `2 pi exp(-l) I_1(l)/l`; t_0 follows, for the slope at the horizon is exactly
/// `-(A_u - A_b)/2`.
///
/// Every term is positive, and each of its factors falls with `|z|`.
pub fn dark_side<R: Real>(cosine: R, sharpness: R, constants: DarkSide<'_>) -> R {
    let one = R::one();
    let y = one / (one + sharpness);
    let u = sharpness * y;
    let odd = odd_part_scaled(sharpness);
    let top = polynomial(constants.numerator, y);
    let bottom = polynomial(constants.denominator, y);
    // J (1 + l)/pi at the horizon.
    let horizon = (y * top / bottom).sqrt();
    let t = odd / (R::constant(PI.sqrt()) * horizon);
    let flattening = u * u / polynomial(constants.flattening, y);
    let square = cosine * cosine;
    let root = (one - flattening * square).max(R::zero()).sqrt();
    // (1 - r)/(1 + r) without the difference.
    let bend = flattening * square / (one + root).squared();
    let stretch = (one + polynomial(constants.weight, y) * bend).sqrt();
    let x = t * stretch * cosine.abs();
    let dark = R::constant(0.5 * PI.sqrt()) * horizon * (-(x * x)).exp() * x.erfc_integral_scaled()
        / stretch;
    R::constant(2.0 * PI) * (y * (odd * cosine.max(R::zero()) + dark))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::SphereRule;
    use crate::sg::{evaluate, product_integral, upper_cosine_integral};
    use crate::{Bounded, Vector3};

    const SHARPNESS: [f64; 12] =
        [1e-3, 0.03, 0.224, 0.5, 1.0, 2.0, 3.5, 6.0, 20.0, 100.0, 1e4, 1e6];

    /// Cosines over the sphere and, closer, about the horizon.
    fn cosines(sharpness: f64) -> impl Iterator<Item = f64> {
        let reach = (8.0 / sharpness.sqrt()).min(0.5 * PI);
        let uniform = (0..=90).map(|i| PI * f64::from(i) / 90.0);
        let near = (0..=40).map(move |i| 0.5 * PI + reach * (f64::from(i) / 20.0 - 1.0));
        uniform.chain(near).map(f64::cos)
    }

    /// The largest error over all of [`SHARPNESS`] and cosines, over the largest value.
    fn model_error(form: Cosine) -> f64 {
        let errors = SHARPNESS.iter().flat_map(|&sharpness| {
            let upper = upper_cosine_integral(sharpness);
            cosines(sharpness).map(move |cosine| {
                (form.integral(cosine, sharpness) - quadrature(cosine, sharpness)).abs() / upper
            })
        });
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn the_truth_equals_the_quadrature_over_the_sphere() {
        let normal = Vector3::new(0.0, 0.0, 1.0);
        for (sharpness, angle) in
            [(1e-3, 1.0), (0.7, 0.2), (5.0, 1.5), (5.0, 2.6), (60.0, 1.7), (400.0, 1.5)]
        {
            let axis = Vector3::new(f64::sin(angle), 0.0, f64::cos(angle));
            let rule = SphereRule { polar_order: 48, ..SphereRule::around(normal, sharpness) }
                .with_azimuths(512);
            let expected =
                rule.integrate(|at| evaluate(at, axis, sharpness) * at.dot(normal).max(0.0));
            let found = quadrature(angle.cos(), sharpness);
            let upper = upper_cosine_integral(sharpness);
            assert!((found - expected).abs() < 1e-9 * upper, "{sharpness} {angle}");
            // Negative control: another angle is another integral.
            let other = quadrature((angle + 0.01).cos(), sharpness);
            assert!((other - expected).abs() > 1e-6 * sharpness.min(1.0) * upper);
        }
    }

    #[test]
    fn errors_of_the_forms_are_those_that_are_documented() {
        let bounds = [
            (Cosine::Constant, 2.9, 3.0),
            (Cosine::Gaussian, 0.13, 0.145),
            (Cosine::Logistic, 8.0e-3, 8.8e-3),
            (Cosine::Erf, 1.4e-3, 1.6e-3),
            (Cosine::Quartic, 1.3e-3, 1.5e-3),
            (Cosine::Fitted, 4e-5, 6.0e-5),
            (Cosine::FittedFine, 1e-5, 1.6e-5),
        ];
        for (form, low, high) in bounds {
            let error = model_error(form);
            assert!(error > low && error < high, "{form:?} {error}");
        }
        // Negative control: one digit of one constant less, and the promise is broken.
        let numerator = [1.0, -1.66, 4.425_602_4];
        let broken = DarkSide { numerator: &numerator, ..FITTED };
        let error = SHARPNESS.map(|sharpness| {
            (dark_side(0.0, sharpness, broken) - quadrature(0.0, sharpness)).abs()
                / upper_cosine_integral(sharpness)
        });
        assert!(error.into_iter().fold(0.0, f64::max) > 1.5e-4);
    }

    #[test]
    fn forms_that_promise_it_rise_with_the_cosine_and_are_positive() {
        for form in [Cosine::Erf, Cosine::Quartic, Cosine::Fitted, Cosine::FittedFine] {
            for step in 0..200 {
                let sharpness = 1e-3 * 10f64.powf(f64::from(step) * 9.0 / 199.0);
                let upper = upper_cosine_integral(sharpness);
                let mut last = -1e-300;
                for step in 0..=1000 {
                    let cosine = f64::from(step) / 500.0 - 1.0;
                    let value = form.integral(cosine, sharpness);
                    assert!(value >= last - 1e-15 * upper, "{form:?} {sharpness} {cosine}");
                    assert!(value >= 0.0);
                    last = value;
                }
            }
        }
    }

    #[test]
    fn the_gaussian_form_is_the_product_of_two_lobes() {
        let normal = Vector3::new(0.0, 0.0, 1.0);
        for (sharpness, angle) in [(0.1, 0.4), (2.0, 2.0), (2.0, PI), (70.0, 1.2), (1e6, 0.01)] {
            let axis = Vector3::new(f64::sin(angle), 0.0, f64::cos(angle));
            let expected = product_integral(axis, sharpness, normal, 2.0) * PI / integral(2.0);
            let found = Cosine::Gaussian.integral(angle.cos(), sharpness);
            assert!((found / expected - 1.0).abs() < 1e-8, "{sharpness} {angle}");
        }
    }

    #[test]
    fn tolerances_are_far_below_what_tells_the_forms_apart() {
        for sharpness in [0.0, 1e-30, 1e-3, 0.7, 1.5, 6.0, 80.0, 1e5, 1e12, 1e30] {
            for cosine in [-1.0, -0.4, -1e-3, 0.0, 0.3, 1.0] {
                for form in Cosine::ALL {
                    let bounded = form.integral(Bounded::exact(cosine), Bounded::exact(sharpness));
                    let upper = upper_cosine_integral(f64::from(sharpness));
                    assert!(bounded.promises(), "{form:?} {sharpness} {cosine}");
                    assert!(
                        bounded.error < 1.2e-5 * upper.max(integral(f64::from(sharpness))),
                        "{form:?} {sharpness} {cosine} {bounded:?}"
                    );
                }
            }
        }
    }
}

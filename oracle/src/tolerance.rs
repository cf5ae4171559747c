//! Tolerances: a running error analysis of f32 arithmetic under what GPU languages grant.
//!
//! A [`Bounded`] carries the f64 value of an expression and the largest distance that an f32 evaluation of the same
//! expression may keep from it. The grants are those of the Vulkan specification's table of precision, which WebGPU
//! shares. Sums may be taken in any order where the language says so, multiply-add may be fused, the rounding mode is
//! not specified (so that "correctly rounded" means within one ULP), and subnormal numbers may be flushed at any time.
//!
//! A bound holds for the order of operations written here. A shader that evaluates the same formula in another stable
//! order stays within it in practice, because a bound adds up worst cases; one that cancels does not, and shall not.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::real::Real;
use crate::{half, math};

/// The distance of neighbouring f32 numbers, relative to the lower end of their binade: 2^-23.
pub const ULP: f64 = f32::EPSILON as f64;
/// The smallest normal f32 number: what flushing a subnormal number can cost.
pub const SMALLEST_NORMAL: f64 = f32::MIN_POSITIVE as f64;
/// Grant of `+`, `-` and `*`, in ULP: correctly rounded, in a direction that is not specified.
pub const ROUNDING_ULPS: f64 = 1.0;
/// Grant of a division, in ULP, for a divisor of magnitude 2^-126 to 2^126.
pub const DIVISION_ULPS: f64 = 2.5;
/// Grant of `inverseSqrt`, in ULP.
pub const INVERSE_SQRT_ULPS: f64 = 2.0;
/// Grant of `sqrt`, in ULP: that of `1/inverseSqrt(x)`.
pub const SQRT_ULPS: f64 = INVERSE_SQRT_ULPS + DIVISION_ULPS;
/// Grant of `log` and `log2` outside of \[0.5, 2\], in ULP.
pub const LOG_ULPS: f64 = 3.0;
/// Grant of `log` and `log2` inside of \[0.5, 2\], absolute: 2^-21.
pub const LOG_NEAR_ONE: f64 = 1.0 / 2_097_152.0;

/// Grant of `exp` and `exp2` at `x`, in ULP.
#[must_use]
pub fn exp_ulps(x: f64) -> f64 {
    3.0 + 2.0 * x.abs()
}

/// The bound of `1 - exp(-x)`, in ULP of the result, for x at least 0.
///
/// Far from 0 the direct form's error, near 0 no more than 32 ULP, which asks for a series there: the direct form
/// loses everything as x goes to 0. Never less than 4 ULP, for the series.
#[must_use]
pub fn one_minus_exp_ulps(x: f64) -> f64 {
    let complement = -(-x).exp_m1();
    let direct = exp_ulps(x) * (-x).exp() / complement + ROUNDING_ULPS;
    direct.clamp(4.0, 32.0)
}

/// The bound of `exp(x) - 1`, in ULP of the result: a polynomial's error near 0, further out that of the
/// exponential.
#[must_use]
pub fn expm1_ulps(x: f64) -> f64 {
    if x.abs() < 1.0 { 8.0 } else { exp_ulps(x) * x.exp() / x.exp_m1().abs() + ROUNDING_ULPS }
}

/// The bound of the scaled complement of erf and of its integral, in ULP of the result: two polynomials of
/// positive coefficients and a division, which round 2 x 4 + 2 x 6 times, each time with less weight.
pub const ERFC_SCALED_ULPS: f64 = 16.0;

/// The bound of erfc, in ULP of the result.
///
/// The square in `exp(-x^2)` is rounded, which its exponential multiplies by `x^2`.
#[must_use]
pub fn erfc_ulps(x: f64) -> f64 {
    let square = x * x;
    let magnitude = exp_ulps(square) + square * ROUNDING_ULPS + ERFC_SCALED_ULPS + ROUNDING_ULPS;
    if x >= 0.0 { magnitude } else { magnitude * math::erfc(-x) / math::erfc(x) + ROUNDING_ULPS }
}

/// The bound of erf, in ULP of the result: a polynomial's error near 0, further out that of the complement.
#[must_use]
pub fn erf_ulps(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 { 10.0 } else { erfc_ulps(x) * math::erfc(x) / math::erf(x) + ROUNDING_ULPS }
}

/// A value and the largest error of its f32 evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    /// The value, from f64 arithmetic.
    pub value: f64,
    /// How far an f32 evaluation may be away, at least 0; infinite where nothing is promised.
    pub error: f64,
}

impl Bounded {
    /// An f32 number read from a buffer or texture: exact, but for a subnormal one, which may be flushed.
    #[must_use]
    pub fn exact(value: f32) -> Self {
        Self::constant(f64::from(value))
    }

    /// A value with an error that is known from elsewhere.
    #[must_use]
    pub fn with_error(value: f64, error: f64) -> Self {
        Self { value, error }
    }

    /// Whether an f32 result is within the tolerance. Anything is where nothing is promised; see [`Bounded::promises`].
    #[must_use]
    pub fn admits(self, measured: f32) -> bool {
        !self.promises() || (f64::from(measured) - self.value).abs() <= self.error
    }

    /// Whether the tolerance is finite. A comparison has to count the values of which nothing is promised.
    #[must_use]
    pub fn promises(self) -> bool {
        self.error.is_finite() && self.value.is_finite()
    }

    /// A result with the error its operands cause, a rounding of `ulps`, and a flush to zero where it may happen.
    fn rounded(value: f64, propagated: f64, ulps: f64) -> Self {
        let magnitude = value.abs() + propagated;
        if magnitude.is_nan() || magnitude > f64::from(f32::MAX) {
            return Self { value, error: f64::INFINITY };
        }
        let flush = if magnitude > 0.0 && value.abs() - propagated < SMALLEST_NORMAL {
            SMALLEST_NORMAL
        } else {
            0.0
        };
        Self { value, error: propagated + ulps * ULP * magnitude + flush }
    }

    /// A monotone function of this number: its values at both ends bound what the number's error causes.
    fn monotone(self, function: impl Fn(f64) -> f64, ulps: impl Fn(f64) -> f64) -> Self {
        let value = function(self.value);
        let ends = [self.value - self.error, self.value + self.error];
        let propagated = ends.map(|end| (function(end) - value).abs());
        let ulps = ends.map(ulps);
        let bounded = Self::rounded(value, propagated[0].max(propagated[1]), ulps[0].max(ulps[1]));
        // As for the exponential: a value below the range of f64 is no exact zero.
        let floor = if value == 0.0 && self.value != 0.0 { SMALLEST_NORMAL } else { 0.0 };
        Self { error: bounded.error.max(floor), ..bounded }
    }

    fn lowest_magnitude(self) -> f64 {
        self.value.abs() - self.error
    }

    fn highest_magnitude(self) -> f64 {
        self.value.abs() + self.error
    }
}

impl Add for Bounded {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::rounded(self.value + other.value, self.error + other.error, ROUNDING_ULPS)
    }
}

impl Sub for Bounded {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Bounded {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, error: self.error }
    }
}

/// The error that two factors' errors cause in their product; an exact 0 annihilates even an infinite error.
fn product_error(a: Bounded, b: Bounded) -> f64 {
    let scaled = |magnitude: f64, error: f64| {
        if magnitude == 0.0 || error == 0.0 { 0.0 } else { magnitude * error }
    };
    scaled(a.value.abs(), b.error) + scaled(b.value.abs(), a.error) + scaled(a.error, b.error)
}

impl Mul for Bounded {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::rounded(self.value * other.value, product_error(self, other), ROUNDING_ULPS)
    }
}

impl Div for Bounded {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        let low = other.lowest_magnitude();
        if !(low >= SMALLEST_NORMAL && other.highest_magnitude() <= 1.0 / SMALLEST_NORMAL) {
            return Self { value: quotient, error: f64::INFINITY };
        }
        let propagated = (self.error + quotient.abs() * other.error) / low;
        Self::rounded(quotient, propagated, DIVISION_ULPS)
    }
}

impl Real for Bounded {
    fn constant(value: f64) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "the rounding is what is measured")]
        let rounded = value as f32;
        let flushed = if rounded.is_subnormal() { f64::from(rounded.abs()) } else { 0.0 };
        Self { value, error: (f64::from(rounded) - value).abs() + flushed }
    }
    fn value(self) -> f64 {
        self.value
    }
    fn error(self) -> f64 {
        self.error
    }
    fn sqrt(self) -> Self {
        let root = self.value.max(0.0).sqrt();
        // |sqrt(a) - sqrt(b)| = |a - b| / (sqrt(a) + sqrt(b)), and never more than sqrt(|a - b|).
        let propagated = if self.error == 0.0 {
            0.0
        } else {
            let low = (self.value - self.error).max(0.0).sqrt();
            (self.error / (root + low)).min(self.error.sqrt())
        };
        Self::rounded(root, propagated, SQRT_ULPS)
    }
    fn exp(self) -> Self {
        exponential(self.value, self.error, self.value.exp(), 1.0)
    }
    fn exp2(self) -> Self {
        exponential(self.value, self.error, self.value.exp2(), core::f64::consts::LN_2)
    }
    fn log2(self) -> Self {
        let value = self.value.log2();
        let low = self.value - self.error;
        if low.is_nan() || low <= 0.0 {
            return Self { value, error: f64::INFINITY };
        }
        let propagated = value - low.log2();
        let near_one = low <= 2.0 && self.value + self.error >= 0.5;
        let absolute = if near_one { LOG_NEAR_ONE } else { 0.0 };
        Self::rounded(value, propagated + absolute, LOG_ULPS)
    }
    fn one_minus_exp_over(self) -> Self {
        let value = self.value.one_minus_exp_over();
        let low = (self.value - self.error).max(0.0);
        // The slope is steepest at the low end, where it is at most 1/2 and at most 1/x^2.
        let propagated = self.error * (0.5_f64).min(1.0 / low.powi(2));
        Self::rounded(value, propagated, one_minus_exp_ulps(low.max(1e-30)) + DIVISION_ULPS)
    }
    fn expm1(self) -> Self {
        self.monotone(f64::exp_m1, expm1_ulps)
    }
    fn erf(self) -> Self {
        self.monotone(math::erf, erf_ulps)
    }
    fn erfc(self) -> Self {
        self.monotone(math::erfc, erfc_ulps)
    }
    fn erfc_scaled(self) -> Self {
        self.monotone(|x| x.erfc_scaled(), |_| ERFC_SCALED_ULPS)
    }
    fn erfc_integral_scaled(self) -> Self {
        self.monotone(|x| x.erfc_integral_scaled(), |_| ERFC_SCALED_ULPS)
    }
    fn times_power_of_two(self, exponent: i32) -> Self {
        let scale = 2f64.powi(exponent);
        Self::rounded(self.value * scale, self.error * scale, 0.0)
    }
    fn abs(self) -> Self {
        Self { value: self.value.abs(), error: self.error }
    }
    fn min(self, other: Self) -> Self {
        -(-self).max(-other)
    }
    fn max(self, other: Self) -> Self {
        let (larger, smaller) =
            if self.value >= other.value { (self, other) } else { (other, self) };
        let certain = larger.value - larger.error >= smaller.value + smaller.error;
        let error = if certain {
            larger.error
        } else {
            larger.error.max(smaller.value + smaller.error - larger.value)
        };
        Self { value: larger.value, error }
    }
    fn dot(a: [Self; 3], b: [Self; 3]) -> Self {
        let value = f64::dot(a.map(|part| part.value), b.map(|part| part.value));
        let mut propagated = 0.0;
        let mut magnitude = 0.0;
        for (left, right) in a.into_iter().zip(b) {
            let error = product_error(left, right);
            propagated += error;
            magnitude += (left.value * right.value).abs() + error;
        }
        // Three products and two sums: whatever the order, each term is rounded at most three times.
        let rounding = 3.0 * ULP * magnitude * (1.0 + 3.0 * ULP);
        let flush = if magnitude > 0.0 { 3.0 * SMALLEST_NORMAL } else { 0.0 };
        Self::rounded(value, propagated + rounding + flush, 0.0)
    }
    fn to_half(self) -> Self {
        let magnitude = self.value.abs() + self.error;
        if magnitude.is_nan() || magnitude > half::LARGEST {
            return Self { value: self.value, error: f64::INFINITY };
        }
        let flushed = magnitude > 0.0 && self.value.abs() - self.error < half::SMALLEST_NORMAL;
        let flush = if flushed { half::SMALLEST_NORMAL } else { 0.0 };
        Self { value: self.value, error: self.error + 0.5 * half::ULP * magnitude + flush }
    }

    fn cover(self, other: Self) -> Self {
        let error = self.error.max((other.value - self.value).abs() + other.error);
        Self { value: self.value, error }
    }
}

/// The exponential of `x` with error `error`, whose value is `value`; `rate` is the logarithm of the base.
fn exponential(x: f64, error: f64, value: f64, rate: f64) -> Bounded {
    if rate * (x + error) < -100.0 {
        // Far below the range of f32: zero or subnormal, whatever the argument's error.
        return Bounded { value, error: SMALLEST_NORMAL };
    }
    let propagated = if error == 0.0 { 0.0 } else { value * (rate * error).exp_m1() };
    let bounded = Bounded::rounded(value, propagated, exp_ulps(x.abs() + error));
    // A result below the range of f64 has magnitude 0 here but is no exact zero there.
    Bounded {
        error: if value == 0.0 { bounded.error.max(SMALLEST_NORMAL) } else { bounded.error },
        ..bounded
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::stress::Random;

    /// Runs f32 arithmetic beside the bounds; returns the largest share of the tolerance that was used.
    fn largest_share(mut trial: impl FnMut(&mut Random) -> (f32, Bounded)) -> f64 {
        let mut random = Random::new(7);
        let mut largest = 0.0_f64;
        for _ in 0..20_000 {
            let (measured, bounded) = trial(&mut random);
            assert!(bounded.promises(), "{bounded:?}");
            largest = largest.max((f64::from(measured) - bounded.value).abs() / bounded.error);
        }
        largest
    }

    #[expect(clippy::cast_possible_truncation, reason = "inputs are f32")]
    fn uniform(random: &mut Random, low: f64, high: f64) -> f32 {
        (low + (high - low) * random.uniform()) as f32
    }

    #[test]
    fn f32_arithmetic_stays_within_the_bounds() {
        let polynomial = largest_share(|random| {
            let (x, y) = (uniform(random, -3.0, 3.0), uniform(random, 0.5, 9.0));
            let (a, b) = (Bounded::exact(x), Bounded::exact(y));
            ((x * y - x) / y + y.sqrt(), (a * b - a) / b + b.sqrt())
        });
        let exponential = largest_share(|random| {
            let (x, y) = (uniform(random, -4.0, 4.0), uniform(random, -4.0, 4.0));
            ((x * y).exp(), (Bounded::exact(x) * Bounded::exact(y)).exp())
        });
        let cancelling = largest_share(|random| {
            let x = uniform(random, 0.0, 1.0);
            let one = Bounded::one();
            (
                (1.0 + x * x * 1e-3) - 1.0,
                (one + Bounded::exact(x).squared() * Bounded::constant(1e-3)) - one,
            )
        });
        for share in [polynomial, exponential, cancelling] {
            assert!(share <= 1.0, "{share}");
            // The bound is a tolerance, not a blank cheque: the f32 evaluation uses a good part of it.
            assert!(share > 0.02, "{share}");
        }
    }

    #[test]
    fn a_naive_form_leaves_the_bound_of_a_stable_one() {
        // Negative control: the tolerance of (1 - e^-x)/x must not admit the form that cancels.
        let x = 3e-5_f32;
        let naive = (1.0 - (-x).exp()) / x;
        let bounded = Bounded::exact(x).one_minus_exp_over();
        assert!(!bounded.admits(naive), "{naive} {bounded:?}");
        #[expect(clippy::cast_possible_truncation, reason = "the stable result, rounded")]
        let stable = f64::from(x).one_minus_exp_over() as f32;
        assert!(bounded.admits(stable));
    }

    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "the rounding is what is measured")]
    fn the_naive_forms_of_our_functions_leave_their_bounds() {
        let x = 3e-4_f32;
        let exact = f64::from(x);
        let bounded = Bounded::exact(x);
        assert!(bounded.expm1().admits(exact.exp_m1() as f32));
        assert!(!bounded.expm1().admits(x.exp() - 1.0));
        assert!(bounded.erf().admits(math::erf(exact) as f32));
        assert!(!bounded.erf().admits(1.0 - math::erfc(exact) as f32));
        let (far, exact) = (4.0_f32, 4.0_f64);
        assert!(Bounded::exact(far).erfc().admits(math::erfc(exact) as f32));
        assert!(!Bounded::exact(far).erfc().admits(1.0 - math::erf(exact) as f32));
        let scaled = Bounded::exact(far).erfc_integral_scaled();
        assert!(scaled.admits(math::erfc_integral_scaled(exact) as f32));
        let naive = 0.564_189_6 - far * math::erfc_scaled(exact) as f32;
        assert!((f64::from(naive) - scaled.value).abs() > 0.5 * scaled.error, "{naive} {scaled:?}");
        // A number that is not known well has a function that is not known well.
        let blurred = Bounded::with_error(1.0, 0.1).erfc();
        assert!(blurred.error > math::erfc(0.9) - math::erfc(1.0));
    }

    #[test]
    fn nothing_is_promised_where_nothing_is_known() {
        let uncertain = Bounded::with_error(0.0, 1.0);
        assert!(!(Bounded::one() / uncertain).promises());
        assert!(!(Bounded::exact(3e38) * Bounded::exact(10.0)).promises());
        assert!(!uncertain.log2().promises());
        // An exact zero annihilates what is not known.
        let unknown = Bounded::one() / Bounded::with_error(1.0, 2.0);
        assert_eq!((unknown.error, (Bounded::zero() * unknown).error), (f64::INFINITY, 0.0));
    }

    #[test]
    fn extremes_and_covers() {
        let (a, b) = (Bounded::with_error(1.0, 0.1), Bounded::with_error(0.95, 0.2));
        let larger = Real::max(a, b);
        assert_eq!(larger.value, 1.0);
        assert!((larger.error - 0.15).abs() < 1e-12);
        assert_eq!(Real::max(a, Bounded::zero()), a);
        assert!((Real::min(a, b).value - 0.95).abs() < 1e-12);
        assert!((a.cover(b).error - 0.25).abs() < 1e-12);
        assert_eq!(Bounded::exact(1e-40).error, f64::from(1e-40_f32));
    }
}

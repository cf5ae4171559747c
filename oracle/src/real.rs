//! The numbers that a stage can be evaluated with.

use core::fmt::Debug;
use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::math;

/// A number: `f64` for the value alone, [`Bounded`](crate::Bounded) for the value and its tolerance.
///
/// The operations are those whose accuracy the GPU languages state. Branches are taken by [`Real::value`]; where a
/// rounding could take the other branch of a discontinuous function, both are evaluated and [`Real::cover`] joins them.
pub trait Real:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A number that the GPU holds rounded to f32.
    fn constant(value: f64) -> Self;
    /// The value in f64.
    fn value(self) -> f64;
    /// The tolerance: how far an f32 evaluation may be from [`Real::value`]; 0 for `f64`.
    fn error(self) -> f64;
    /// The square root; a negative argument counts as 0.
    fn sqrt(self) -> Self;
    /// e to the power of this number.
    fn exp(self) -> Self;
    /// 2 to the power of this number.
    fn exp2(self) -> Self;
    /// The logarithm to base 2 of a positive number.
    fn log2(self) -> Self;
    /// `(1 - exp(-x))/x` for x at least 0, and 1 at 0: the part of an SG's integral that has to be evaluated stably.
    fn one_minus_exp_over(self) -> Self;
    /// `exp(x) - 1`, evaluated stably near 0.
    fn expm1(self) -> Self;
    /// The error function.
    fn erf(self) -> Self;
    /// `1 - erf(x)`, evaluated stably.
    fn erfc(self) -> Self;
    /// `exp(x^2) erfc(x)`, for x at least 0; a smaller one counts as 0.
    fn erfc_scaled(self) -> Self;
    /// `exp(x^2)` times the integral of erfc from x on, for x at least 0; a smaller one counts as 0.
    fn erfc_integral_scaled(self) -> Self;
    /// `x 2^exponent`, which rounds nothing.
    fn times_power_of_two(self, exponent: i32) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// The smaller of two.
    fn min(self, other: Self) -> Self;
    /// The larger of two.
    fn max(self, other: Self) -> Self;
    /// A sum of three products, in any order.
    fn dot(a: [Self; 3], b: [Self; 3]) -> Self;
    /// The number rounded to the nearest half float; see [`crate::half`].
    fn to_half(self) -> Self;
    /// This value, with a tolerance that admits what `other` admits too.
    fn cover(self, other: Self) -> Self;

    /// 0.
    #[must_use]
    fn zero() -> Self {
        Self::constant(0.0)
    }
    /// 1.
    #[must_use]
    fn one() -> Self {
        Self::constant(1.0)
    }
    /// The number times itself.
    #[must_use]
    fn squared(self) -> Self {
        self * self
    }
    /// The number kept between two others.
    #[must_use]
    fn clamp(self, low: f64, high: f64) -> Self {
        self.max(Self::constant(low)).min(Self::constant(high))
    }
    /// Whether rounding cannot change the sign of this number.
    #[must_use]
    fn sign_is_certain(self) -> bool {
        self.value().abs() > self.error()
    }
}

impl Real for f64 {
    fn constant(value: f64) -> Self {
        value
    }
    fn value(self) -> f64 {
        self
    }
    fn error(self) -> f64 {
        0.0
    }
    fn sqrt(self) -> Self {
        Self::sqrt(self.max(0.0))
    }
    fn exp(self) -> Self {
        Self::exp(self)
    }
    fn exp2(self) -> Self {
        Self::exp2(self)
    }
    fn log2(self) -> Self {
        Self::log2(self)
    }
    fn one_minus_exp_over(self) -> Self {
        if self == 0.0 { 1.0 } else { -(-self).exp_m1() / self }
    }
    fn expm1(self) -> Self {
        self.exp_m1()
    }
    fn erf(self) -> Self {
        math::erf(self)
    }
    fn erfc(self) -> Self {
        math::erfc(self)
    }
    fn erfc_scaled(self) -> Self {
        math::erfc_scaled(self.max(0.0))
    }
    fn erfc_integral_scaled(self) -> Self {
        math::erfc_integral_scaled(self.max(0.0))
    }
    fn times_power_of_two(self, exponent: i32) -> Self {
        self * 2f64.powi(exponent)
    }
    fn abs(self) -> Self {
        Self::abs(self)
    }
    fn min(self, other: Self) -> Self {
        Self::min(self, other)
    }
    fn max(self, other: Self) -> Self {
        Self::max(self, other)
    }
    fn dot(a: [Self; 3], b: [Self; 3]) -> Self {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }
    fn to_half(self) -> Self {
        half::f16::from_f64(self).to_f64()
    }
    fn cover(self, _other: Self) -> Self {
        self
    }
}

/// What can be averaged: what a mip level holds.
pub trait Linear<R>: Copy {
    /// The sum's start.
    fn nothing() -> Self;
    /// The sum of two.
    #[must_use]
    fn plus(self, other: Self) -> Self;
    /// The product with a number.
    #[must_use]
    fn scaled(self, factor: R) -> Self;
    /// [`Real::cover`] of every part.
    #[must_use]
    fn covering(self, other: Self) -> Self;
}

impl<R: Real> Linear<R> for R {
    fn nothing() -> Self {
        R::zero()
    }
    fn plus(self, other: Self) -> Self {
        self + other
    }
    fn scaled(self, factor: R) -> Self {
        self * factor
    }
    fn covering(self, other: Self) -> Self {
        self.cover(other)
    }
}

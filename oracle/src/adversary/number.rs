//! An f32 that uses up what the GPU languages grant.
//!
//! Every operation is rounded up or down as by chance and missed by up to its grant, and subnormal results are flushed
//! now and then.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::Real;
use crate::fis::stress::Random;
use crate::tolerance::{
    DIVISION_ULPS, ERFC_SCALED_ULPS, LOG_NEAR_ONE, LOG_ULPS, ROUNDING_ULPS, SQRT_ULPS, erf_ulps,
    erfc_ulps, exp_ulps, expm1_ulps, one_minus_exp_ulps,
};

/// A number between -1 and 1, mostly one of both, that only depends on a value and on what it is used for.
fn malice(value: f64, question: u64) -> f64 {
    let mut random = Random::new(value.to_bits().rotate_left(29) ^ question);
    (4.0 * (random.uniform() - 0.5)).clamp(-1.0, 1.0)
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Adversary(pub(super) f64);

impl Adversary {
    /// The nearest f32 at or beyond a value that is missed by some ULP.
    #[expect(clippy::cast_possible_truncation, reason = "the rounding is what is wanted")]
    fn missed(value: f64, ulps: f64, absolute: f64) -> Self {
        // One ULP is kept for the rounding itself.
        let spread = (ulps - 1.0).max(0.0) * f64::from(f32::EPSILON) * 0.5 * value.abs() + absolute;
        let perturbed = value + malice(value, 1) * spread;
        let nearest = perturbed as f32;
        let rounded = if f64::from(nearest) == perturbed || malice(value, 2) > 0.0 {
            nearest
        } else if f64::from(nearest) < perturbed {
            nearest.next_up()
        } else {
            nearest.next_down()
        };
        if rounded.is_subnormal() && malice(value, 3) > 0.0 {
            Self(0.0)
        } else {
            Self(f64::from(rounded))
        }
    }
}

macro_rules! operator {
    ($trait:ident, $name:ident, $symbol:tt, $ulps:expr) => {
        impl $trait for Adversary {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                Self::missed(self.0 $symbol other.0, $ulps, 0.0)
            }
        }
    };
}
operator!(Add, add, +, ROUNDING_ULPS);
operator!(Sub, sub, -, ROUNDING_ULPS);
operator!(Mul, mul, *, ROUNDING_ULPS);
operator!(Div, div, /, DIVISION_ULPS);

impl Neg for Adversary {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Real for Adversary {
    fn constant(value: f64) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "constants are rounded to nearest")]
        Self(f64::from(value as f32))
    }
    fn value(self) -> f64 {
        self.0
    }
    fn error(self) -> f64 {
        0.0
    }
    fn sqrt(self) -> Self {
        Self::missed(self.0.max(0.0).sqrt(), SQRT_ULPS, 0.0)
    }
    fn exp(self) -> Self {
        Self::missed(self.0.exp(), exp_ulps(self.0), 0.0)
    }
    fn exp2(self) -> Self {
        Self::missed(self.0.exp2(), exp_ulps(self.0), 0.0)
    }
    fn log2(self) -> Self {
        let near_one = (0.5..=2.0).contains(&self.0);
        Self::missed(self.0.log2(), LOG_ULPS, if near_one { LOG_NEAR_ONE } else { 0.0 })
    }
    fn one_minus_exp_over(self) -> Self {
        Self::missed(self.0.one_minus_exp_over(), one_minus_exp_ulps(self.0.max(1e-30)), 0.0)
    }
    fn expm1(self) -> Self {
        Self::missed(self.0.exp_m1(), expm1_ulps(self.0), 0.0)
    }
    fn erf(self) -> Self {
        Self::missed(Real::erf(self.0), erf_ulps(self.0), 0.0)
    }
    fn erfc(self) -> Self {
        Self::missed(Real::erfc(self.0), erfc_ulps(self.0), 0.0)
    }
    fn erfc_scaled(self) -> Self {
        Self::missed(self.0.erfc_scaled(), ERFC_SCALED_ULPS, 0.0)
    }
    fn erfc_integral_scaled(self) -> Self {
        Self::missed(self.0.erfc_integral_scaled(), ERFC_SCALED_ULPS, 0.0)
    }
    fn times_power_of_two(self, exponent: i32) -> Self {
        Self::missed(self.0.times_power_of_two(exponent), 0.0, 0.0)
    }
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }
    fn dot(a: [Self; 3], b: [Self; 3]) -> Self {
        let [x, y, z] = [a[0] * b[0], a[1] * b[1], a[2] * b[2]];
        if malice(x.0, 4) > 0.0 { (x + y) + z } else { x + (z + y) }
    }
    fn to_half(self) -> Self {
        let stored = half::f16::from_f64(self.0);
        let flushed = !stored.is_normal() && malice(self.0, 6) > 0.0;
        if flushed { Self(0.0) } else { Self(stored.to_f64()) }
    }
    fn cover(self, _other: Self) -> Self {
        self
    }
}

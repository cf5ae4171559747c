//! Numbers of some lights side by side.

use core::ops::{Add, Div, Mul, Sub};

/// Lights that are summed side by side: the four texels of a square, so that each lane is a coarser map of its own.
pub(crate) const LANES: usize = 4;

/// A number of each of some lights.
///
/// Plain loops over arrays, which the compiler turns into vector instructions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lane(pub(crate) [f64; LANES]);

impl Lane {
    #[inline(always)]
    pub(crate) fn all(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    pub(crate) fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        let mut result = Self::default();
        for lane in 0..LANES {
            result.0[lane] = function(self.0[lane], other.0[lane]);
        }
        result
    }
    #[inline(always)]
    pub(crate) fn map(self, function: impl Fn(f64) -> f64) -> Self {
        self.zip(self, |value, _| function(value))
    }
    /// At least `low`; a plain comparison, since nothing is NaN here.
    #[inline(always)]
    pub(crate) fn at_least(self, low: f64) -> Self {
        self.map(|value| if value > low { value } else { low })
    }
    /// At most the other, plainly compared.
    #[inline(always)]
    pub(crate) fn at_most(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    pub(crate) fn dot(a: [Self; 3], b: [Self; 3]) -> Self {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }
}

impl Add for Lane {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Lane {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Lane {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Div for Lane {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

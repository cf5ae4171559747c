//! Functions of one number that the GPU languages lack, in f64.

pub mod bessel;
pub mod erf;

pub use bessel::bessel_i_scaled;
pub use erf::{erf, erfc, erfc_integral_scaled, erfc_scaled};

/// `(exp(x) - 1)/x`, and 1 at 0.
#[must_use]
pub fn expm1_over_x(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.exp_m1() / x }
}

//! The error function, its complement, and the two scaled by `exp(x^2)` that do not underflow.

use core::f64::consts::FRAC_2_SQRT_PI;

/// The error function.
#[must_use]
pub fn erf(x: f64) -> f64 {
    libm::erf(x)
}

/// The complement `1 - erf(x)`, without cancellation.
#[must_use]
pub fn erfc(x: f64) -> f64 {
    libm::erfc(x)
}

/// Where the continued fraction takes over: it converges fast from here on, and the direct forms lose digits.
const FAR: f64 = 2.0;

/// The ratios `i^0/i^-1` and `i^1/i^0` of repeated integrals of erfc, for x at least [`FAR`].
///
/// From `i^(n-1) = 2 x i^n + 2 (n + 1) i^(n+1)`, downwards: all terms are positive.
// [DLMF, Section 7.18(iv)]
fn ratios(x: f64) -> (f64, f64) {
    // The ratio after the last one matters by exp(-2 x sqrt(2 n)): below 1e-24 at x = 2.
    let mut ratio = 0.0;
    for n in (2..100_u32).rev() {
        ratio = 1.0 / (2.0 * x + 2.0 * f64::from(n) * ratio);
    }
    (1.0 / (2.0 * x + 2.0 * ratio), ratio)
}

/// `exp(x^2) erfc(x)` for x at least 0.
#[must_use]
pub fn erfc_scaled(x: f64) -> f64 {
    if x < FAR { (x * x).exp() * erfc(x) } else { FRAC_2_SQRT_PI * ratios(x).0 }
}

/// `exp(x^2)` times the integral of erfc from x to infinity, for x at least 0: `1/sqrt(pi) - x exp(x^2) erfc(x)`.
#[must_use]
pub fn erfc_integral_scaled(x: f64) -> f64 {
    if x < FAR {
        0.5 * FRAC_2_SQRT_PI - x * erfc_scaled(x)
    } else {
        let (first, second) = ratios(x);
        FRAC_2_SQRT_PI * first * second
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre;

    /// By quadrature of `erfc(x) = 2/sqrt(pi) exp(-x^2) int_0^inf exp(-s^2 - 2 x s) ds`, with s^n for its integrals.
    fn scaled(x: f64, power: i32) -> f64 {
        let rule = gauss_legendre(40);
        let reach = 40.0 / (x + (x * x + 40.0).sqrt());
        let panels = 8;
        let mut sum = 0.0;
        for panel in 0..panels {
            for &(node, weight) in &rule {
                let s = (f64::from(panel) + 0.5 + 0.5 * node) * reach / f64::from(panels);
                sum += weight * s.powi(power) * (-s * s - 2.0 * x * s).exp();
            }
        }
        // i^n erfc = 2/sqrt(pi) int (t - x)^n/n! exp(-t^2) dt.
        FRAC_2_SQRT_PI * sum * 0.5 * reach / f64::from(panels)
    }

    #[test]
    fn scaled_functions_equal_the_quadrature() {
        for x in [0.0, 1e-9, 0.1, 0.7, 1.5, 1.999, 2.0, 2.1, 3.0, 7.0, 26.0, 1e3, 1e8] {
            let (first, second) = (scaled(x, 0), scaled(x, 1));
            assert!((erfc_scaled(x) / first - 1.0).abs() < 5e-15, "{x}");
            assert!((erfc_integral_scaled(x) / second - 1.0).abs() < 3e-14, "{x}");
            // Negative control: they are different functions.
            assert!((second / first - 1.0).abs() > 0.1);
        }
    }

    #[test]
    fn erf_and_erfc_are_each_other_s_complement() {
        for x in [-6.0, -1.0, -1e-3, 0.0, 0.2, 0.84375, 3.0] {
            assert!((erf(x) + erfc(x) - 1.0).abs() < 4e-16, "{x}");
            assert!(x <= 0.0 || (erfc(x) / ((-x * x).exp() * erfc_scaled(x)) - 1.0).abs() < 4e-15);
        }
        // [DLMF, Table 7.23]: erf(1), and erfc(5) to 10 digits.
        assert!((erf(1.0) - 0.842_700_792_949_714_9).abs() < 1e-15);
        assert!((erfc(5.0) / 1.537_459_794_4e-12 - 1.0).abs() < 1e-10);
    }
}

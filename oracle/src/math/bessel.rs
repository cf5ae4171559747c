//! Modified Bessel functions of the first kind, scaled by `exp(-x)`.

use core::f64::consts::PI;

/// `exp(-x) I_n(x)` for x at least 0 and a small order n.
#[must_use]
pub fn bessel_i_scaled(order: u32, x: f64) -> f64 {
    if x < 25.0 { series(order, x) } else { asymptotic(order, x) }
}

/// All terms are positive. [DLMF, Eq. 10.25.2]
fn series(order: u32, x: f64) -> f64 {
    let half = 0.5 * x;
    let mut term = (1..=order).fold((-x).exp(), |term, k| term * half / f64::from(k));
    let mut sum = 0.0;
    let mut k = 0;
    while term > sum * 1e-18 {
        sum += term;
        k += 1;
        term *= half * half / (f64::from(k) * f64::from(k + order));
    }
    sum
}

/// The smallest term is about exp(-2 x). [DLMF, Eq. 10.40.1]
fn asymptotic(order: u32, x: f64) -> f64 {
    let mu = 4.0 * f64::from(order * order);
    let (mut term, mut sum) = (1.0, 0.0);
    let mut k = 0_u32;
    while f64::abs(term) > 1e-18 {
        sum += term;
        k += 1;
        let odd = f64::from(2 * k - 1);
        term *= -(mu - odd * odd) / (f64::from(k) * 8.0 * x);
    }
    sum / (2.0 * PI * x).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre;

    /// `1/pi int_0^pi exp(x (cos t - 1)) cos(n t) dt` [DLMF, Eq. 10.32.3]
    fn quadrature(order: u32, x: f64) -> f64 {
        let reach = PI.min(12.0 / x.max(1e-9).sqrt());
        let panels = 16;
        let rule = gauss_legendre(32);
        let mut sum = 0.0;
        for panel in 0..panels {
            for &(node, weight) in &rule {
                let angle = (f64::from(panel) + 0.5 + 0.5 * node) * reach / f64::from(panels);
                let sine = (0.5 * angle).sin();
                sum += weight * (-2.0 * x * sine * sine).exp() * (f64::from(order) * angle).cos();
            }
        }
        sum * 0.5 * reach / f64::from(panels) / PI
    }

    #[test]
    fn equals_the_quadrature() {
        for x in [0.0, 1e-3, 0.5, 3.0, 10.0, 24.9, 25.0, 26.0, 80.0, 1e3, 1e6] {
            for order in 0..3 {
                let (found, expected) = (bessel_i_scaled(order, x), quadrature(order, x));
                // At small x the quadrature of the higher orders cancels.
                assert!((found - expected).abs() < 4e-15 * expected.abs() + 1e-15, "{order} {x}");
            }
            // Negative control: the next order is another number.
            assert!((bessel_i_scaled(1, x) - bessel_i_scaled(0, x)).abs() > 1e-10);
        }
    }

    #[test]
    fn recurrence_holds() {
        // I_0 - I_2 = 2 I_1/x [DLMF, Eq. 10.29.1]; also where both forms meet.
        for x in [0.3, 2.0, 24.999, 25.0, 400.0] {
            let [zero, one, two] = [0, 1, 2].map(|order| bessel_i_scaled(order, x));
            assert!(((zero - two) / (2.0 * one / x) - 1.0).abs() < 1e-12, "{x}");
        }
        assert!((series(1, 25.0) / asymptotic(1, 25.0) - 1.0).abs() < 2e-15);
    }
}

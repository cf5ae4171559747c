//! Integrals over the sphere: the reference behind the closed forms.

use core::f64::consts::PI;

use crate::vector::Vector3;

/// Nodes and weights of the Gauss-Legendre rule on \[-1, 1\]; exact for polynomials of degree `2 order - 1`.
#[must_use]
pub fn gauss_legendre(order: usize) -> Vec<(f64, f64)> {
    (0..order)
        .map(|index| {
            // Newton's method from an asymptotic guess of the root of the Legendre polynomial.
            let mut x = (PI * (index as f64 + 0.75) / (order as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let (mut last, mut value) = (1.0, x);
                for degree in 2..=order {
                    let n = degree as f64;
                    (last, value) = (value, ((2.0 * n - 1.0) * x * value - (n - 1.0) * last) / n);
                }
                slope = order as f64 * (x * value - last) / (x * x - 1.0);
                let step = value / slope;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// A quadrature rule on the sphere, finer towards one axis.
///
/// The polar angle from the axis is cut into panels that double in width, each with a Gauss-Legendre rule; the azimuth
/// has a uniform rule, which is spectrally accurate for smooth periodic functions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereRule {
    /// Where the integrand is sharpest; a unit vector.
    pub axis: Vector3,
    /// Width of the integrand's feature at the axis, in radians.
    pub width: f64,
    /// Order of the Gauss-Legendre rule of each panel.
    pub polar_order: usize,
    /// Number of azimuths.
    pub azimuths: usize,
}

impl SphereRule {
    /// A rule for a lobe of a given sharpness around an axis.
    #[must_use]
    pub fn around(axis: Vector3, sharpness: f64) -> Self {
        Self { axis, width: 1.0 / (sharpness + 1.0).sqrt(), polar_order: 24, azimuths: 96 }
    }

    /// The same rule with another number of azimuths.
    #[must_use]
    pub fn with_azimuths(self, azimuths: usize) -> Self {
        Self { azimuths, ..self }
    }

    /// The integral of a function over the sphere.
    pub fn integrate(&self, function: impl Fn(Vector3) -> f64) -> f64 {
        self.integrate_color(|direction| Vector3::new(function(direction), 0.0, 0.0)).x
    }

    /// The integral of three functions over the sphere.
    pub fn integrate_color(&self, function: impl Fn(Vector3) -> Vector3) -> Vector3 {
        let (x, y) = self.axis.basis();
        let rule = gauss_legendre(self.polar_order);
        let azimuths: Vec<Vector3> = (0..self.azimuths)
            .map(|index| {
                let angle = 2.0 * PI * (index as f64 + 0.5) / self.azimuths as f64;
                x * angle.cos() + y * angle.sin()
            })
            .collect();
        let mut total = Vector3::zero();
        let mut low = 0.0;
        let mut high = self.width.min(PI);
        while low < PI {
            for &(node, weight) in &rule {
                let angle = 0.5 * (low + high) + 0.5 * (high - low) * node;
                let (sine, cosine) = angle.sin_cos();
                let ring = azimuths
                    .iter()
                    .map(|&azimuth| function(self.axis * cosine + azimuth * sine))
                    .fold(Vector3::zero(), |sum, value| sum + value);
                total = total + ring * (0.5 * (high - low) * weight * sine);
            }
            // Never wider than an eighth of pi: the rest of the integrand has features of its own. The equator bounds a
            // panel, since a function about a normal has a kink there.
            let next = high + (2.0 * (high - low)).min(PI / 8.0);
            let bound = if high < PI / 2.0 { PI / 2.0 } else { PI };
            (low, high) = (high, next.min(bound));
        }
        total * (2.0 * PI / self.azimuths as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_legendre_is_exact_to_its_degree() {
        let moment = |order: usize, degree: i32| -> f64 {
            gauss_legendre(order).iter().map(|(x, weight)| weight * x.powi(degree)).sum()
        };
        assert!((moment(5, 8) - 2.0 / 9.0).abs() < 1e-14);
        // Negative control: one degree beyond, the rule is wrong.
        assert!((moment(5, 10) - 2.0 / 11.0).abs() > 1e-4);
    }

    #[test]
    fn the_sphere_has_its_area_and_second_moment() {
        for width in [3.0, 0.1, 1e-3] {
            let rule = SphereRule { width, ..SphereRule::around(Vector3::new(0.6, 0.0, 0.8), 1.0) };
            assert!((rule.integrate(|_| 1.0) - 4.0 * PI).abs() < 1e-11);
            assert!(
                (rule.integrate(|direction| direction.y.powi(2)) - 4.0 * PI / 3.0).abs() < 1e-11
            );
        }
    }
}

//! The radiance that arrives from one lobe of a light.

use core::f64::consts::PI;

use crate::sg::{evaluate, product};
use crate::vsgl::Lobe;
use crate::{Real, Vector3};

/// Incoming radiance: `coefficient G(w, axis, sharpness)`, w pointing towards where the light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incoming<R = f64> {
    /// Unit axis.
    pub axis: Vector3<R>,
    /// Sharpness, at least 0.
    pub sharpness: R,
    /// Radiance along the axis.
    pub coefficient: Vector3<R>,
}

impl Incoming {
    /// The radiance from a unit direction.
    #[must_use]
    pub fn radiance(&self, direction: Vector3) -> Vector3 {
        self.coefficient * evaluate(direction, self.axis, self.sharpness)
    }
}

/// The squared distance below which a light is at the shading point.
pub const LEAST_SQUARED_DISTANCE: f64 = 1e-30;

/// The least variance of a light over its squared distance: it counts as at least a billionth of its distance wide.
pub const LEAST_SPREAD: f64 = 1e-18;

/// The variance of a light's positions as it counts at a squared distance.
pub fn variance_at<R: Real>(squared: R, variance: R) -> R {
    variance.max(squared * R::constant(LEAST_SPREAD))
}

/// The distribution of a light's positions seen from a point, for `path` from the point to their mean: the direction and
/// the sharpness of a spherical Gaussian. At the light itself there is no direction, and the vector is shorter than one.
// [Tokuyoshi 2016, Eq. (11)]
pub fn extent<R: Real>(path: Vector3<R>, variance: R) -> (Vector3<R>, R) {
    let squared = path.length_squared();
    // At the light itself every direction is as good: the spread is 0.
    let spread = squared / variance_at(squared, variance);
    let length = squared.max(R::constant(LEAST_SQUARED_DISTANCE)).sqrt();
    (path.map(|part| part / length), spread)
}

/// The radiance that arrives at a point from a lobe of a light at `position` of `variance` above 0, without visibility.
// [Tokuyoshi 2016, Eq. (11), Eq. (12)]
pub fn incoming<R: Real>(
    point: Vector3<R>,
    position: Vector3<R>,
    variance: R,
    lobe: &Lobe<R>,
) -> Incoming<R> {
    let path = position - point;
    let (towards, spread) = extent(path, variance);
    let lobe_product = product(towards, spread, -lobe.axis, lobe.sharpness);
    let variance = variance_at(path.length_squared(), variance);
    let scale = lobe_product.log_amplitude.exp() / (R::constant(2.0 * PI) * variance);
    Incoming {
        axis: lobe_product.axis,
        sharpness: lobe_product.sharpness,
        coefficient: lobe.coefficient * scale,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::SphereRule;

    fn lobe(sharpness: f64) -> Lobe {
        Lobe {
            axis: Vector3::new(0.0, -0.6, 0.8),
            sharpness,
            coefficient: Vector3::new(1.0, 2.0, 3.0),
        }
    }

    #[test]
    fn is_the_literal_product() {
        let (point, position, variance) =
            (Vector3::new(0.5, 0.0, 0.0), Vector3::new(0.0, 0.4, -0.7), 0.3);
        let lobe = lobe(4.0);
        let arriving = incoming(point, position, variance, &lobe);
        let path = position - point;
        for direction in
            [path.normalized(), Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.6, 0.0, -0.8)]
        {
            // [Tokuyoshi 2016, Eq. (12)], its first line: the light's intensity away from the direction, times the
            // Gaussian on the sphere around the point.
            let intensity = lobe.coefficient * evaluate(-direction, lobe.axis, lobe.sharpness);
            let on_sphere = direction * path.length() - path;
            let gaussian =
                (-on_sphere.length_squared() / (2.0 * variance)).exp() / (2.0 * PI * variance);
            assert!((arriving.radiance(direction) - intensity * gaussian).length() < 1e-14);
        }
    }

    #[test]
    fn far_away_it_is_a_point_light() {
        // The irradiance on a facing surface tends to I/d^2.
        let (lobe, position) = (lobe(3.0), Vector3::new(0.0, 0.0, 0.0));
        let towards = Vector3::new(0.6, 0.0, 0.8);
        let error = |distance: f64| {
            let arriving = incoming(towards * distance, position, 0.01, &lobe);
            let irradiance =
                SphereRule::around(arriving.axis, arriving.sharpness).integrate(|direction| {
                    arriving.radiance(direction).x * direction.dot(-towards).max(0.0)
                });
            let expected = evaluate(towards, lobe.axis, lobe.sharpness) / (distance * distance);
            (irradiance / expected - 1.0).abs()
        };
        assert!(
            error(10.0) < 1e-3 && error(40.0) < error(10.0) / 10.0,
            "{} {}",
            error(10.0),
            error(40.0)
        );
        assert!(error(0.1) > 0.1);
    }

    #[test]
    fn is_finite_at_the_light() {
        let arriving = incoming(Vector3::zero(), Vector3::zero(), 0.5, &lobe(0.0));
        assert_eq!(arriving.sharpness, 0.0);
        assert!((arriving.coefficient.x - 1.0 / PI).abs() < 1e-15);
    }
}

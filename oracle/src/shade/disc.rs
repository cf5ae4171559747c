//! Irradiance of a uniform disc.

use crate::shade::quadratic::{extent_of, positive_part};
use crate::{Real, Vector3};

/// Irradiance of a light that is a uniform disc of radius `sqrt(2 variance)` about its mean position, per radiant
/// intensity towards the receiver.
///
/// `path`: from the receiver to the mean position; `axis`: the unit mean normal; `mean_length`: of the normals;
/// `normal`: the receiver's. The vector irradiance of the whole disc is the closed form; what lies below the receiver's
/// horizon is cut off as [`positive_part`] does, with the extent of the disc along the receiver's normal. Exact for a
/// disc of one normal that lies wholly above the horizon.
pub fn irradiance<R: Real>(
    path: Vector3<R>,
    variance: R,
    axis: Vector3<R>,
    mean_length: R,
    normal: Vector3<R>,
) -> R {
    let (one, zero) = (R::one(), R::zero());
    let square = variance * R::constant(2.0);
    let unit = one / (path.length_squared() + square).sqrt();
    let scaled = path * unit;
    let a = square * unit * unit;
    let height = -scaled.dot(axis);
    let place = scaled + axis * height;
    let spread = extent_of(mean_length);
    let h = height * height + R::constant(0.25) * a * (spread * spread);
    let t = place.length_squared();
    let (x, y) = (t + h + a, t + h - a);
    let q = (y * y + R::constant(4.0) * a * h).sqrt();
    let along =
        if y.value() < 0.0 { (q - y) / (R::constant(4.0) * a * h) } else { one / (q + y.abs()) };
    let inverse = one / (x + q);
    let vector = place * inverse - axis * (height.max(zero) * along);
    let distance = scaled.length();
    let flow = vector * (R::constant(2.0) * distance / q);
    let tilt = mean_length * axis.dot(normal);
    let wide = a * ((one - tilt) * (one + tilt)).max(zero);
    let extent = flow.length() * share(wide, distance * distance).sqrt();
    unit * unit * positive_part(flow.dot(normal), extent)
}

/// `part/(rest + part)` of two numbers of at least 0. Where rounding is larger than the part, the tolerance is that of both
/// ends of its interval: an interval about it would reach below 0, where the quotient has no end.
fn share<R: Real>(part: R, rest: R) -> R {
    let of = |part: R| part / (rest + part).max(R::constant(1e-30));
    if part.error() < 0.5 * part.value() || part.error() == 0.0 {
        return of(part);
    }
    let [low, high] = [part.value() - part.error(), part.value() + part.error()];
    let at = |value: f64| of(R::constant(value.max(0.0)));
    let share = at(part.value()).cover(at(low)).cover(at(high));
    if share.error().is_finite() {
        return share;
    }
    // Whatever it is, it is a share.
    R::constant(share.value().clamp(0.0, 1.0)).cover(R::zero()).cover(R::one())
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;

    /// Irradiance of a disc of one normal by quadrature over its points, per radiant intensity towards the receiver.
    fn by_quadrature(path: Vector3, variance: f64, axis: Vector3, normal: Vector3) -> f64 {
        let radius = (2.0 * variance).sqrt();
        let side = if axis.x.abs() < 0.9 {
            Vector3::new(1.0, 0.0, 0.0)
        } else {
            Vector3::new(0.0, 1.0, 0.0)
        };
        let u = axis.cross(side).normalized();
        let v = axis.cross(u);
        let (rings, sectors) = (400, 400);
        let mut sum = 0.0;
        for ring in 0..rings {
            let r = radius * ((f64::from(ring) + 0.5) / f64::from(rings)).sqrt();
            for sector in 0..sectors {
                let angle = 2.0 * PI * (f64::from(sector) + 0.5) / f64::from(sectors);
                let to = path + (u * angle.cos() + v * angle.sin()) * r;
                let squared = to.length_squared();
                let cosines = (-to.dot(axis)).max(0.0) * to.dot(normal).max(0.0);
                sum += cosines / (squared * squared);
            }
        }
        // Of an emitter of power pi, whose intensity is the cosine at its middle.
        let mean = sum / f64::from(rings * sectors);
        mean / (-path.normalized().dot(axis))
    }

    #[test]
    fn is_that_of_the_disc_above_the_horizon() {
        let axis = Vector3::new(0.3, -0.2, 1.0).normalized();
        let normals = [-axis, Vector3::new(-0.5, 0.4, -1.0).normalized()];
        // Heights over the plane and places beside the middle, in radii.
        for (height, beside) in [(0.2, 0.0), (0.5, 0.3), (1.0, 0.9), (1.0, 2.0), (4.0, 1.0)] {
            let variance = 0.5;
            let side = axis.cross(Vector3::new(0.0, 1.0, 0.0)).normalized();
            let path = -(axis * height + side * beside);
            for normal in normals {
                let expected = by_quadrature(path, variance, axis, normal);
                let found = irradiance(path, variance, axis, 1.0, normal);
                // Above the horizon it is exact; that normal which is tilted cuts the disc at the least height.
                let bound = if normal == -axis { 2e-3 } else { 0.05 };
                assert!(
                    (found / expected - 1.0).abs() < bound,
                    "{height} {beside}: {found} {expected}"
                );
            }
        }
        // Negative control: a light at the middle of the disc.
        let path = axis * -0.5;
        let point = 1.0 / path.length_squared();
        assert!((point / by_quadrature(path, 0.5, axis, -axis) - 1.0).abs() > 1.0);
    }

    #[test]
    fn far_away_it_is_the_inverse_square() {
        let axis = Vector3::new(0.0, 0.0, 1.0);
        let normal = Vector3::new(0.6, 0.0, -0.8);
        for mean_length in [0.0, 0.5, 1.0] {
            let path = Vector3::new(300.0, 100.0, -900.0);
            let found = irradiance(path, 0.5, axis, mean_length, normal);
            let expected = path.normalized().dot(normal) / path.length_squared();
            assert!((found / expected - 1.0).abs() < 1e-5, "{mean_length} {found} {expected}");
        }
    }

    #[test]
    fn extremes_stay_finite() {
        let axes = [Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.6, 0.0, 0.8)];
        for distance in [0.0, 1e-18, 1e-6, 1.0, 1e9, 1e18] {
            for variance in [1e-12, 1.0, 1e30] {
                for axis in axes {
                    for direction in [axes[0], -axes[0], axes[1], Vector3::new(1.0, 0.0, 0.0)] {
                        for mean_length in [0.0, 1.0 - 1e-6] {
                            let found = irradiance(
                                direction * distance,
                                variance,
                                axis,
                                mean_length,
                                axes[0],
                            );
                            assert!(found.is_finite() && found >= 0.0);
                        }
                    }
                }
            }
        }
    }
}

//! The plane of incidence.

use crate::{Real, Vector3};

/// The squared sine of the angle below which a direction and a normal are parallel.
pub const PARALLEL: f64 = 1e-10;

/// The unit vector out of the plane of a unit direction and a unit normal. Where they are parallel any would do; it is
/// the one across the x axis, or across the y axis where the direction is within 60 degrees of x.
pub fn across<R: Real>(direction: Vector3<R>, normal: Vector3<R>) -> Vector3<R> {
    let across = normal.cross(direction);
    if across.length_squared().value() < PARALLEL {
        let (zero, one) = (R::zero(), R::one());
        let helper =
            if direction.x.value().abs() > 0.5 { [zero, one, zero] } else { [one, zero, zero] };
        let [x, y, z] = helper;
        return Vector3::new(x, y, z).cross(direction).normalized();
    }
    across.normalized()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_a_unit_vector_across_both() {
        let normal = Vector3::new(0.0, 0.6, 0.8);
        let (x, _) = normal.basis();
        for direction in [normal, -normal, x, (normal + x * 1e-9).normalized()] {
            let across = across(direction, normal);
            assert!((across.length() - 1.0).abs() < 1e-14);
            assert!(across.dot(direction).abs() < 1e-8 && across.dot(normal).abs() < 1e-8);
        }
        // Negative control: of the two orders one is right-handed.
        assert!((across(x, normal) - normal.cross(x)).length() < 1e-14);
        assert!((across(normal, x) - normal.cross(x)).length() > 1.0);
    }
}

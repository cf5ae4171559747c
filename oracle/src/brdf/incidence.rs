//! The plane of incidence.

use crate::{Real, Vector3};

/// The unit vector out of the plane of a unit direction and a unit normal; where they are parallel, any across them.
pub fn across<R: Real>(direction: Vector3<R>, normal: Vector3<R>) -> Vector3<R> {
    let (any, _) = direction.value().basis();
    normal.cross(direction).normalized_or(Vector3::constant(any))
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

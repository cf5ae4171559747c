//! The plane of incidence.

use crate::{Real, Vector3};

/// The squared sine of the angle below which a direction and a normal are parallel.
pub const PARALLEL: f64 = 1e-10;

/// The unit vector out of the plane of a unit direction and a unit normal. Where they are parallel any would do; it is
/// the one across the x axis, or across the y axis where the direction is within 60 degrees of x. Where rounding may
/// decide whether they are parallel, both are admitted.
pub fn across<R: Real>(direction: Vector3<R>, normal: Vector3<R>) -> Vector3<R> {
    let across = normal.cross(direction);
    let excess = across.length_squared() - R::constant(PARALLEL);
    let helper = if direction.x.value().abs() > 0.5 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
    let [x, y, z] = helper.map(R::constant);
    let any = || Vector3::new(x, y, z).cross(direction).normalized();
    match (excess.value() < 0.0, excess.sign_is_certain()) {
        (true, true) => any(),
        (false, true) => across.normalized(),
        (parallel, false) => {
            let both =
                if parallel { [any(), across.normalized()] } else { [across.normalized(), any()] };
            let [found, other] = both.map(Vector3::to_array);
            let [x, y, z] = [0, 1, 2].map(|part| found[part].cover(other[part]));
            Vector3::new(x, y, z)
        }
    }
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

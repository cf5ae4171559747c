//! The basis that a light's map is laid out in.

use crate::{Real, Vector3};

/// Three unit vectors at right angles, right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis<R = f64> {
    /// The first.
    pub x: Vector3<R>,
    /// The second.
    pub y: Vector3<R>,
    /// The third, which the others were made for.
    pub z: Vector3<R>,
    /// Whether rounding cannot have chosen another basis about the same axis.
    pub certain: bool,
}

/// Where the sign in the basis changes: away from 0, where the axes of upright walls lie.
pub const CHANGE: f64 = -0.5;

impl<R: Real> Basis<R> {
    /// The basis about a unit vector.
    // [Duff 2017, Section 4], with another place for the change of sign
    #[must_use]
    pub fn about(z: Vector3<R>) -> Self {
        let above = z.z - R::constant(CHANGE);
        let sign = if above.value() > 0.0 { R::one() } else { -R::one() };
        let scale = -(R::one() / (sign + z.z));
        let mixed = z.x * z.y * scale;
        Self {
            x: Vector3::new(R::one() + sign * z.x * z.x * scale, sign * mixed, -(sign * z.x)),
            y: Vector3::new(mixed, sign + z.y * z.y * scale, -z.y),
            z,
            certain: above.sign_is_certain(),
        }
    }

    /// The coordinates of a vector.
    #[must_use]
    pub fn coordinates(&self, vector: Vector3<R>) -> Vector3<R> {
        Vector3::new(self.x.dot(vector), self.y.dot(vector), self.z.dot(vector))
    }
}

impl Basis {
    /// The vector of coordinates.
    #[must_use]
    pub fn vector(&self, coordinates: Vector3) -> Vector3 {
        self.x * coordinates.x + self.y * coordinates.y + self.z * coordinates.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;
    use crate::fis::stress::Random;

    #[test]
    fn bases_are_orthonormal_and_right_handed() {
        let mut random = Random::new(5);
        let mut axes: Vec<Vector3> = (0..1000)
            .map(|_| Vector3::new(random.normal(), random.normal(), random.normal()).normalized())
            .collect();
        axes.extend([-1.0, 1.0].map(|z| Vector3::new(0.0, 0.0, z)));
        axes.extend([-0.5, -0.5 + 1e-14].map(|z| Vector3::new(0.75_f64.sqrt(), 0.0, z)));
        for axis in axes {
            let Basis { x, y, z, .. } = Basis::about(axis);
            assert!((x.cross(y) - z).length() < 1e-12, "{axis:?}");
            assert!((x.length() - 1.0).abs() < 1e-12 && x.dot(y).abs() < 1e-12, "{axis:?}");
            let some = Vector3::new(0.3, -2.0, 0.7);
            let basis = Basis::about(axis);
            assert!((basis.vector(basis.coordinates(some)) - some).length() < 1e-11);
        }
    }

    #[test]
    fn rounding_does_not_decide_for_upright_walls() {
        let about = |z: f64| {
            Basis::about(Vector3::new(
                Bounded::with_error((1.0 - z * z).sqrt(), 1e-7),
                Bounded::zero(),
                Bounded::with_error(z, 1e-7),
            ))
        };
        assert!(about(0.0).certain && about(1e-8).certain && about(-1.0).certain);
        assert!(!about(CHANGE).certain);
        // Negative control: with the change at 0 an error of 1e-7 would decide.
        assert!(!Bounded::with_error(1e-8, 1e-7).sign_is_certain());
        assert!(about(-0.99).x.x.error < 1e-5, "{:?}", about(-0.99).x.x);
    }
}

//! The value of a spherical Gaussian.

use crate::{Real, Vector3};

/// A spherical Gaussian of a sharpness at least 0 at a unit direction; 0 to 1.
///
/// From the squared distance: `w . axis - 1` cancels near the axis.
// [Tokuyoshi 2016, Appendix A]
pub fn evaluate<R: Real>(direction: Vector3<R>, axis: Vector3<R>, sharpness: R) -> R {
    ((direction - axis).length_squared() * sharpness * R::constant(-0.5)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bounded;

    #[test]
    fn equals_the_literal_form() {
        let axis = Vector3::new(0.0, 0.0, 1.0);
        for (angle, sharpness) in [(0.0, 5.0), (0.3, 40.0), (2.0, 0.5), (3.1, 7.0)] {
            let direction = Vector3::new(f64::sin(angle), 0.0, f64::cos(angle));
            let literal = (sharpness * (direction.dot(axis) - 1.0)).exp();
            assert!((evaluate(direction, axis, sharpness) - literal).abs() < 1e-14);
            assert!(
                (evaluate(direction, -axis, sharpness) - literal).abs() > 1e-9 || sharpness == 0.0
            );
        }
    }

    #[test]
    fn the_literal_form_in_f32_leaves_the_tolerance() {
        // A sharp lobe close to its axis; the exponent is about -1.
        let sharpness = 1e6_f32;
        let direction = Vector3::new(1.4e-3, 0.0, (1.0 - 1.4e-3_f64 * 1.4e-3).sqrt());
        #[expect(clippy::cast_possible_truncation, reason = "inputs are f32")]
        let texel = [direction.x as f32, 0.0, direction.z as f32, 0.0];
        let axis = Vector3::constant(Vector3::new(0.0, 0.0, 1.0));
        let bounded = evaluate(Vector3::of_texel(texel), axis, Bounded::exact(sharpness));
        let stable = (-0.5 * sharpness * (texel[0].powi(2) + (texel[2] - 1.0).powi(2))).exp();
        let literal = (sharpness * (texel[2] - 1.0)).exp();
        assert!(bounded.admits(stable), "{stable} {bounded:?}");
        assert!(!bounded.admits(literal), "{literal} {bounded:?}");
    }
}

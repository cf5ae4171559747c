//! The GGX distribution of facets with height-correlated Smith visibility.

use core::f64::consts::PI;

use crate::{Real, Vector3};

/// The density of facets, per steradian, at the cosine between normal and half vector.
///
/// In the form `(n.h)^2 (alpha^2 - 1) + 1`, which cancels for smooth surfaces: its tolerance includes all forms in use.
// [Walter 2007, Eq. (33)]
pub fn d_ggx<R: Real>(cosine: R, alpha: R) -> R {
    let width = alpha.squared();
    let denominator = cosine.squared() * (width - R::one()) + R::one();
    width / (R::constant(PI) * denominator.squared())
}

/// The density of facets from unit vectors, which keeps the digits of a small sine: `|n x h|^2 + alpha^2 (n.h)^2` for
/// the denominator. 0 below the horizon.
// [Walter 2007, Eq. (33)]
pub fn d_ggx_about<R: Real>(normal: Vector3<R>, half: Vector3<R>, alpha: R) -> R {
    let cosine = normal.dot(half);
    let width = alpha.squared();
    let denominator = normal.cross(half).length_squared() + cosine.squared() * width;
    let above = width / (R::constant(PI) * denominator.squared());
    let (found, other) = if cosine.value() > 0.0 { (above, R::zero()) } else { (R::zero(), above) };
    if cosine.sign_is_certain() { found } else { found.cover(other) }
}

/// Masking and shadowing over `4 (n.l) (n.v)`.
// [Heitz 2014, Eq. (99)], with the Lambda of Eq. (72)
pub fn v_smith_ggx_correlated<R: Real>(cosine_light: R, cosine_view: R, alpha: R) -> R {
    let width = alpha.squared();
    let root = |cosine: R| (cosine.squared() * (R::one() - width) + width).sqrt();
    R::constant(0.5) / (cosine_light * root(cosine_view) + cosine_view * root(cosine_light))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Masking of one direction.
    // [Heitz 2014, Eq. (72)]
    fn lambda(cosine: f64, alpha: f64) -> f64 {
        let tangent_squared = (1.0 - cosine * cosine) / (cosine * cosine);
        0.5 * ((1.0 + alpha * alpha * tangent_squared).sqrt() - 1.0)
    }

    #[test]
    fn visibility_equals_the_definition() {
        for (l, v, alpha) in [(0.9, 0.2, 0.5), (0.1, 0.1, 0.01), (1.0, 0.5, 1.0)] {
            let expected = 1.0 / ((1.0 + lambda(l, alpha) + lambda(v, alpha)) * 4.0 * l * v);
            assert!((v_smith_ggx_correlated(l, v, alpha) / expected - 1.0).abs() < 1e-12);
            // Negative control: the separable form is another one.
            let separable =
                1.0 / ((1.0 + lambda(l, alpha)) * (1.0 + lambda(v, alpha)) * 4.0 * l * v);
            assert!(
                (v_smith_ggx_correlated(l, v, alpha) / separable - 1.0).abs() > 1e-9 || l == 1.0
            );
        }
    }
}

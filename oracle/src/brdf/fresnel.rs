//! The share of light that a facet reflects.

use crate::{Real, Vector3};

/// Schlick's weight `(1 - cos)^5` of white, for a cosine that is clamped to 0 to 1.
// [Schlick 1994, Eq. (15)]
pub fn schlick_weight<R: Real>(cosine: R) -> R {
    let rest = R::one() - cosine.clamp(0.0, 1.0);
    rest.squared().squared() * rest
}

/// The reflectance that is reached at grazing angles: white, but for what reflects less than 2 % at normal incidence,
/// which fades in proportion. A surface without specular reflectance then has none at any angle, and may be left out.
pub fn f90<R: Real>(reflectance: Vector3<R>) -> R {
    let largest = reflectance.x.max(reflectance.y).max(reflectance.z);
    (R::constant(50.0) * largest).min(R::one())
}

/// Schlick's approximation of the Fresnel term, from the reflectance at normal incidence (0 to 1).
// [Schlick 1994, Eq. (15)], with [`f90`] for white
pub fn f_schlick<R: Real>(reflectance: Vector3<R>, cosine: R) -> Vector3<R> {
    let weight = schlick_weight(cosine);
    reflectance + (Vector3::splat(f90(reflectance)) - reflectance) * weight
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goes_from_the_reflectance_to_white() {
        let reflectance = Vector3::new(0.04, 0.5, 1.0);
        assert!((f_schlick(reflectance, 1.0) - reflectance).length() < 1e-15);
        assert!((f_schlick(reflectance, 0.0) - Vector3::splat(1.0)).length() < 1e-15);
        assert_eq!(f_schlick(Vector3::<f64>::zero(), 0.0), Vector3::zero());
        assert!((f_schlick(Vector3::splat(0.01), 0.0).x - 0.5).abs() < 1e-15);
        assert!((f_schlick(reflectance, 0.5).x - (0.04 + 0.96 / 32.0)).abs() < 1e-15);
    }
}

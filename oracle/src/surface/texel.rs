//! One texel of the surface textures: of a reflective shadow map or of the camera's G-buffer.

use crate::brdf::Material;
use crate::{Real, Vector3};

/// The surface behind a texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceTexel<R = f64> {
    /// World position.
    pub position: Vector3<R>,
    /// Unit shading normal, facing the viewer of the map.
    pub normal: Vector3<R>,
    /// What the surface reflects.
    pub material: Material<R>,
    /// Whether there is a surface.
    pub present: bool,
}

impl<R: Real> SurfaceTexel<R> {
    /// From the texels `position`, `normal` and `base_color` as the conventions of the surface textures lay them out.
    ///
    /// The normal is made a unit vector again, since a half-precision texture keeps its length to 2^-11 only.
    #[must_use]
    pub fn decode(position: [f32; 4], normal: [f32; 4], base_color: [f32; 4]) -> Self {
        let number = |value: f32| R::constant(f64::from(value));
        Self {
            position: Vector3::of_texel(position),
            normal: Vector3::of_texel(normal).normalized(),
            material: Material::of_base_color(
                Vector3::of_texel(base_color),
                number(base_color[3]),
                number(position[3]),
                number(normal[3]),
            ),
            present: position[3] >= 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decodes_the_conventions() {
        let texel = SurfaceTexel::<f64>::decode(
            [1.0, 2.0, 3.0, 0.25],
            [0.0, 0.0, 1.0, 0.0],
            [0.5, 1.0, 0.0, 0.5],
        );
        assert!(texel.present);
        assert_eq!(texel.material.diffuse, Vector3::new(0.25, 0.5, 0.0));
        assert_eq!(texel.material.specular, Vector3::new(0.375, 0.625, 0.125));
        assert_eq!(texel.material.alpha, 0.01);
        assert!(!SurfaceTexel::<f64>::decode([0.0, 0.0, 0.0, -1.0], [0.0; 4], [0.0; 4]).present);
    }
}

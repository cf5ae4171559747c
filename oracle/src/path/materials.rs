//! What a scene's surfaces are made of.

use crate::Vector3;
use crate::brdf::Material;
use crate::surface::Crossing;

/// What a scene's surfaces are made of; the caller knows of textures.
pub trait Materials: Sync {
    /// The material where a ray meets a facet.
    fn material(&self, crossing: &Crossing) -> Material;

    /// The unit shading normal, on the side that the hit's is.
    fn normal(&self, crossing: &Crossing) -> Vector3 {
        crossing.hit.normal
    }

    /// Whether there is a surface: not in the holes of a cutout.
    fn counts(&self, _crossing: &Crossing) -> bool {
        true
    }
}

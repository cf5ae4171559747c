//! Small scenes for tests.

use crate::Vector3;
use crate::brdf::Material;
use crate::light::{Light, LightKind};
use crate::path::Materials;
use crate::surface::{Crossing, Facet, SurfaceTexel, Triangle};

/// Materials by their number.
pub(crate) struct Table(pub(crate) Vec<Material>);

impl Materials for Table {
    fn material(&self, crossing: &Crossing) -> Material {
        self.0[crossing.hit.material as usize]
    }
    fn counts(&self, crossing: &Crossing) -> bool {
        // The last material is a hole.
        (crossing.hit.material as usize) < self.0.len()
    }
}

pub(crate) fn diffuse(reflectance: f64) -> Material {
    Material { diffuse: Vector3::splat(reflectance), specular: Vector3::zero(), alpha: 1.0 }
}

pub(crate) fn glossy(specular: f64, alpha: f64) -> Material {
    Material { diffuse: Vector3::splat(0.3), specular: Vector3::splat(specular), alpha }
}

pub(crate) fn facet(
    positions: [Vector3; 3],
    normals: Option<[Vector3; 3]>,
    material: u32,
) -> Facet {
    let [a, b, c] = positions;
    let normals = normals.unwrap_or([(b - a).cross(c - a).normalized(); 3]);
    let triangle = Triangle { positions, normals, material };
    Facet { triangle, uvs: [[0.0; 2]; 3], double_sided: true }
}

/// A square in a plane of constant z, from `low` to `high` in x and y.
pub(crate) fn square(low: [f64; 2], high: [f64; 2], z: f64, material: u32) -> [Facet; 2] {
    let corner = |x: f64, y: f64| Vector3::new(x, y, z);
    let [a, b] = [corner(low[0], low[1]), corner(high[0], low[1])];
    let [c, d] = [corner(high[0], high[1]), corner(low[0], high[1])];
    [facet([a, b, c], None, material), facet([a, c, d], None, material)]
}

pub(crate) fn texel(position: Vector3, normal: Vector3, material: Material) -> SurfaceTexel {
    SurfaceTexel { position, normal, material, present: true }
}

pub(crate) fn light(kind: LightKind, position: Vector3) -> Light {
    Light {
        kind,
        position,
        right: Vector3::new(1.0, 0.0, 0.0),
        up: Vector3::new(0.0, 1.0, 0.0),
        forward: Vector3::new(0.0, 0.0, -1.0),
        intensity: Vector3::new(1.0, 2.0, 3.0),
    }
}

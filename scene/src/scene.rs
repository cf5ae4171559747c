//! A scene as plain data.

use crate::bounds::Bounds;
use crate::camera::Camera;
use crate::images::Image;
use crate::light::Light;
use crate::material::Material;
use crate::mesh::Mesh;
use crate::note::Note;

/// A scene that is ready to be drawn: it has at least one triangle, one light and a camera, every
/// position is finite, every light has power.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The built-in name as given, or the file's stem.
    pub name: String,
    /// What all positions are relative to, in the file's space: what [`super::Options::origin`] says, else 0 where the
    /// middle of the scene lies within 16 of its radii of it, else a point near the middle. It is subtracted in 64 bits.
    pub origin: [f64; 3],
    /// Triangles in world space, like everything relative to the origin.
    pub meshes: Vec<Mesh>,
    /// What [`Mesh::material`] counts in.
    pub materials: Vec<Material>,
    /// What [`TextureUse::image`](crate::TextureUse::image) counts in.
    pub images: Vec<Image>,
    /// At least one.
    pub lights: Vec<Light>,
    /// The camera of the sidecar, else of the file, else derived from the bounding box.
    pub camera: Camera,
    /// Everything ignored, assumed or derived.
    pub notes: Vec<Note>,
}

/// One triangle of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// World positions, counter-clockwise seen from the front.
    pub positions: [[f32; 3]; 3],
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Index into [`Scene::materials`].
    pub material: usize,
}

impl Scene {
    /// All triangles, mesh by mesh.
    pub fn triangles(&self) -> impl Iterator<Item = Triangle> + '_ {
        self.meshes.iter().enumerate().flat_map(|(index, mesh)| {
            mesh.triangles().map(move |positions| Triangle {
                positions,
                mesh: index,
                material: mesh.material,
            })
        })
    }

    /// The number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.meshes.iter().map(Mesh::triangle_count).sum()
    }

    /// The box around all triangles; vertices that no triangle has do not count.
    pub fn bounds(&self) -> Bounds {
        Bounds::around(self.meshes.iter().flat_map(|mesh| mesh.triangles().flatten()))
    }
}

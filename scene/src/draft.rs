//! What a loader makes, and what is checked and derived before it is a scene.

use std::path::Path;

use crate::bounds::Bounds;
use crate::camera::Camera;
use crate::error::SceneError;
use crate::light::Light;
use crate::material::{Image, Material};
use crate::mesh::RawMesh;
use crate::note::{NoteKind, Notes};
use crate::scene::Scene;

/// What a loader makes: a scene that is not checked yet and may lack a camera and lights.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    pub(crate) meshes: Vec<RawMesh>,
    pub(crate) materials: Vec<Material>,
    pub(crate) images: Vec<Image>,
    pub(crate) lights: Vec<Light>,
    pub(crate) camera: Option<Camera>,
    pub(crate) notes: Notes,
}

impl Draft {
    /// Checks everything that a scene promises, and derives what is missing.
    pub(crate) fn finish(mut self, file: &Path, name: String) -> Result<Scene, SceneError> {
        let mut faults = Vec::new();
        for material in &mut self.materials {
            if material.clamp() {
                self.notes.add(NoteKind::Assumed, "factors clamped to their range", &material.name);
            }
        }
        let mut meshes = Vec::new();
        for raw in self.meshes {
            match raw.clean(file, &mut self.notes) {
                Ok(mesh) => meshes.extend(mesh),
                Err(fault) => faults.push(fault),
            }
        }
        if meshes.is_empty() && faults.is_empty() {
            faults.push(SceneError::NoTriangles { file: file.into() });
        }
        faults.extend(self.lights.iter().filter_map(|light| light.fault(file)));
        faults.extend(self.camera.as_ref().and_then(|camera| camera.fault(file)));
        if !faults.is_empty() {
            return Err(SceneError::of(faults));
        }
        let bounds = Bounds::around(meshes.iter().flat_map(|mesh| &mesh.positions));
        let camera = self.camera.unwrap_or_else(|| {
            self.notes.add(NoteKind::Derived, "no camera: looking at the bounding box", "");
            Camera::around(&bounds)
        });
        if self.lights.is_empty() {
            self.notes.add(
                NoteKind::Derived,
                "no light: a spot light from above the bounding box",
                "",
            );
            self.lights.push(Light::above(&bounds));
        }
        Ok(Scene {
            name,
            meshes,
            materials: self.materials,
            images: self.images,
            lights: self.lights,
            camera,
            notes: self.notes.into_list(),
        })
    }
}

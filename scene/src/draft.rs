//! What a loader makes, and what is checked and derived before it is a scene.

use std::path::Path;

use crate::bounds::Bounds;
use crate::camera::Camera;
use crate::error::SceneError;
use crate::images::Image;
use crate::light::Light;
use crate::material::Material;
use crate::mesh::RawMesh;
use crate::note::{NoteKind, Notes};
use crate::options::Taken;
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
    pub(crate) taken: Taken,
}

impl Draft {
    /// The index of a material, made where there is none that is the same.
    pub(crate) fn material(&mut self, material: Material) -> usize {
        let known = self.materials.iter().position(|known| *known == material);
        known.unwrap_or_else(|| {
            self.materials.push(material);
            self.materials.len() - 1
        })
    }

    /// Checks everything that a scene promises, and derives what is missing.
    pub(crate) fn finish(mut self, file: &Path, name: String) -> Result<Scene, SceneError> {
        let mut faults = Vec::new();
        for material in &mut self.materials {
            material.mend(&mut self.notes);
            material.note_samplers(&mut self.notes);
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
        // A light that is off beside others is no fault; where all are, there is nothing to see.
        if self.lights.iter().any(|light| !light.is_off()) {
            for light in self.lights.extract_if(.., |light| light.is_off()) {
                let text = "light without power: it lights nothing";
                self.notes.add(NoteKind::Ignored, text, light.name);
            }
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

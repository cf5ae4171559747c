//! What a loader makes, and what is checked and derived before it is a scene.

use std::path::Path;

use glam::DVec3;

use crate::bounds::Bounds;
use crate::camera::Camera;
use crate::error::SceneError;
use crate::images::Image;
use crate::light::Light;
use crate::material::Material;
use crate::mesh::{Mesh, RawMesh};
use crate::note::{NoteKind, Notes};
use crate::options::Taken;
use crate::origin::{self, Placed};
use crate::scene::Scene;

/// Beyond this the rounding of positions in a file is noted, in units of the scene's radius.
const NOTED_ROUNDING: f64 = 1e-3;

/// What a loader makes: a scene that is not checked yet and may lack a camera and lights.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    pub(crate) meshes: Vec<RawMesh>,
    pub(crate) materials: Vec<Material>,
    pub(crate) images: Vec<Image>,
    pub(crate) lights: Vec<Placed<Light>>,
    pub(crate) camera: Option<Placed<Camera>>,
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

    /// Checks everything that a scene promises, and derives what is missing. Positions become relative to `origin`, or to
    /// one near the scene.
    pub(crate) fn finish(
        mut self,
        file: &Path,
        name: String,
        origin: Option<[f64; 3]>,
    ) -> Result<Scene, SceneError> {
        let mut faults = Vec::new();
        for material in &mut self.materials {
            material.mend(&mut self.notes);
            material.note_samplers(&mut self.notes);
        }
        let origin = self.origin(origin);
        let mut meshes: Vec<Mesh> = Vec::new();
        for raw in self.meshes {
            match raw.clean(file, origin, &mut self.notes) {
                Ok(mesh) => meshes.extend(mesh),
                Err(fault) => faults.push(fault),
            }
        }
        for mesh in &mut meshes {
            let material = self.materials.get(mesh.material);
            match material.and_then(|material| material.normal_texture) {
                Some(map) if mesh.detail.tangents.is_empty() => mesh.derive_tangents(&map),
                Some(_) => {}
                None => mesh.detail.tangents.clear(),
            }
        }
        if meshes.is_empty() && faults.is_empty() {
            faults.push(SceneError::NoTriangles { file: file.into() });
        }
        let relative = |light: Placed<Light>| light.relative_to(origin);
        let mut lights: Vec<_> = self.lights.into_iter().map(relative).collect();
        let camera = self.camera.map(|camera| camera.relative_to(origin));
        // A light that is off beside others is no fault; where all are, there is nothing to see.
        if lights.iter().any(|light| !light.is_off()) {
            for light in lights.extract_if(.., |light| light.is_off()) {
                let text = "light without power: it lights nothing";
                self.notes.add(NoteKind::Ignored, text, light.name);
            }
        }
        faults.extend(lights.iter().filter_map(|light| light.fault(file)));
        faults.extend(camera.as_ref().and_then(|camera| camera.fault(file)));
        if !faults.is_empty() {
            return Err(SceneError::of(faults));
        }
        let bounds = Bounds::around(meshes.iter().flat_map(|mesh| mesh.triangles().flatten()));
        let camera = camera.unwrap_or_else(|| {
            self.notes.add(NoteKind::Derived, "no camera: looking at the bounding box", "");
            Camera::around(&bounds)
        });
        if lights.is_empty() {
            self.notes.add(
                NoteKind::Derived,
                "no light: a spot light from above the bounding box",
                "",
            );
            lights.push(Light::above(&bounds));
        }
        Ok(Scene {
            name,
            origin: origin.into(),
            meshes,
            materials: self.materials,
            images: self.images,
            lights,
            camera,
            notes: self.notes.into_list(),
        })
    }

    /// The origin: `given`, or one near the scene; with notes of what a user should know about it.
    fn origin(&mut self, given: Option<[f64; 3]>) -> DVec3 {
        let corners = self.meshes.iter().flat_map(RawMesh::corners);
        let Some([min, max]) = origin::box_around(corners) else { return DVec3::ZERO };
        let origin = given.map_or_else(|| origin::of([min, max]), DVec3::from);
        if given.is_none() && origin != DVec3::ZERO {
            let DVec3 { x, y, z } = origin;
            let text = format!("positions are relative to ({x}, {y}, {z}), near the scene");
            self.notes.add(NoteKind::Derived, text, "");
        }
        let radius = (0.5 * max - 0.5 * min).length();
        for mesh in self.meshes.iter().filter(|mesh| mesh.rounding > NOTED_ROUNDING * radius) {
            let text = "the file has its positions in 32 bits, which so far from its origin are \
                        rounded by more than a thousandth of the scene's radius";
            self.notes.add(NoteKind::Assumed, text, &mesh.name);
        }
        origin
    }
}

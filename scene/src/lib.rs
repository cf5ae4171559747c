//! Scenes: triangles, materials, lights and a camera as plain data on the CPU.
//!
//! A scene is a built-in one, made by code, or a file: glTF 2.0 (`.gltf`, `.glb`) or OBJ with MTL.
//! Everything is in world space, right-handed, in metres or whatever unit the file uses, y up;
//! colours are linear Rec. 709. What a file has and we ignore, what we assumed, and what we derived
//! stands in [`Scene::notes`], to be shown to the user.

use std::path::Path;

pub mod bounds;
pub mod builtin;
pub mod camera;
pub mod error;
pub mod facts;
mod gltf;
pub mod light;
pub mod material;
pub mod mesh;
pub mod note;
mod obj;
pub mod occlusion;
mod sidecar;
#[cfg(test)]
mod tests;

pub use bounds::Bounds;
pub use camera::Camera;
pub use error::SceneError;
pub use facts::{Fact, Facts, Traits};
pub use light::{Light, LightKind};
pub use material::{Filter, Image, Material, TextureUse, UvTransform, Wrap};
pub use mesh::Mesh;
pub use note::{Note, NoteKind};

use note::Notes;

/// The file name extensions [`Scene::load`] reads.
const EXTENSIONS: [&str; 3] = ["glb", "gltf", "obj"];

/// A scene that is ready to be drawn: it has at least one triangle, one light and a camera, every
/// position is finite, every light has power.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The built-in name as given, or the file's stem.
    pub name: String,
    /// Triangles in world space.
    pub meshes: Vec<Mesh>,
    /// What [`Mesh::material`] counts in.
    pub materials: Vec<Material>,
    /// What [`TextureUse::image`] counts in.
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
    /// Loads a built-in scene by name or a file by path.
    ///
    /// A sidecar `<file>.sglow.toml` beside a file gives it a camera or lights: the sidecar's camera
    /// replaces the file's, the sidecar's lights replace all of the file's.
    ///
    /// # Errors
    ///
    /// [`SceneError`] names the file and the thing in it that is at fault. Faults that do not hide
    /// each other come together, as [`SceneError::Several`].
    pub fn load(name_or_path: &str) -> Result<Self, SceneError> {
        if builtin::is_builtin(name_or_path) {
            return Self::builtin(name_or_path);
        }
        let path = Path::new(name_or_path);
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        if !path.exists() && extension.is_none() {
            return Err(builtin::unknown(name_or_path));
        }
        Self::from_file(path)
    }

    /// Makes a built-in scene: one of [`builtin::NAMES`], the atrium with its number of triangles
    /// as in `atrium:75k`.
    ///
    /// # Errors
    ///
    /// [`SceneError::UnknownBuiltin`] lists the known names, [`SceneError::Detail`] the range of the
    /// number.
    pub fn builtin(name: &str) -> Result<Self, SceneError> {
        let draft = builtin::make(name)?;
        draft.finish(Path::new(name), name.to_owned())
    }

    /// Loads a file, and its sidecar where there is one. Errors are those of [`Scene::load`].
    pub fn from_file(path: &Path) -> Result<Self, SceneError> {
        let extension =
            path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if !EXTENSIONS.contains(&extension.as_str()) {
            return Err(SceneError::Extension {
                file: path.into(),
                found: extension,
                known: EXTENSIONS.join(", "),
            });
        }
        let bytes = error::read(path)?;
        let mut draft =
            if extension == "obj" { obj::load(path, &bytes)? } else { gltf::load(path, &bytes)? };
        sidecar::apply(path, &mut draft)?;
        let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        draft.finish(path, stem)
    }

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

    /// The box around all positions.
    pub fn bounds(&self) -> Bounds {
        Bounds::around(self.meshes.iter().flat_map(|mesh| &mesh.positions))
    }
}

/// What a loader makes: a scene that is not checked yet and may lack a camera and lights.
#[derive(Debug, Default)]
struct Draft {
    meshes: Vec<mesh::RawMesh>,
    materials: Vec<Material>,
    images: Vec<Image>,
    lights: Vec<Light>,
    camera: Option<Camera>,
    notes: Notes,
}

impl Draft {
    /// Checks everything that a scene promises, and derives what is missing.
    fn finish(mut self, file: &Path, name: String) -> Result<Scene, SceneError> {
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

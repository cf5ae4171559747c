//! Scenes: triangles, materials, lights and a camera as plain data on the CPU.
//!
//! A scene is a built-in one, made by code, or a file: glTF 2.0 (`.gltf`, `.glb`) or OBJ with MTL, read within the
//! limits of its [`Options`].
//! Everything is in world space, right-handed, in metres or whatever unit the file uses, y up, relative to
//! [`Scene::origin`]; colours are linear Rec. 709. What a file has and we ignore, what we assumed, and what we derived
//! stands in [`Scene::notes`], to be shown to the user.

pub mod bounds;
pub mod builtin;
pub mod camera;
mod draft;
pub mod error;
pub mod facts;
mod files;
mod gltf;
pub mod images;
pub mod light;
mod load;
pub mod material;
pub mod mesh;
pub mod note;
mod obj;
pub mod occlusion;
pub mod options;
mod origin;
mod rebase;
mod scene;
mod sidecar;
mod tangent;
#[cfg(test)]
mod tests;
mod tint;

pub use bounds::Bounds;
pub use camera::Camera;
pub use error::SceneError;
pub use facts::{Fact, Facts, Traits};
pub use images::Image;
pub use light::{Light, LightKind};
pub use material::{Filter, Material, TextureUse, UvTransform, Wrap};
pub use mesh::{Detail, Mesh};
pub use note::{Note, NoteKind};
pub use options::{Limits, Options};
pub use scene::{Scene, Triangle};

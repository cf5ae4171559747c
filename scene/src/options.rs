//! How a scene is loaded: where its files may lie, and how much they may take.

use std::path::Path;

use super::SceneError;

/// How a scene is loaded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Whether buffers, images and material libraries may lie outside of the folder of the scene's file. A scene from
    /// somewhere else could otherwise name any file that the user can read.
    pub allow_outside: bool,
    /// What is refused before it is read or made.
    pub limits: Limits,
    /// What positions become relative to, such as an engine's own origin; else one is chosen, as [`super::Scene::origin`]
    /// says.
    pub origin: Option<[f64; 3]>,
}

/// The most that a scene may take. Counts, not bytes: they mean the same on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one file; 2 GiB.
    pub file_bytes: u64,
    /// Vertices of all meshes, after instancing; 2^26, which take 2 GiB on the device.
    pub vertices: usize,
    /// Triangles of all meshes, after instancing; 2^26.
    pub triangles: usize,
    /// Texels of one image; 2^26, a square of 8192, the largest texture that every WebGPU device has.
    pub image_texels: usize,
    /// Texels of all images; 2^28.
    pub texels: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            file_bytes: 1 << 31,
            vertices: 1 << 26,
            triangles: 1 << 26,
            image_texels: 1 << 26,
            texels: 1 << 28,
        }
    }
}

/// What a scene has taken so far of its limits.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Taken {
    vertices: usize,
    triangles: usize,
}

impl Taken {
    /// Counts vertices and triangles before they are made.
    pub(super) fn take(
        &mut self,
        file: &Path,
        limits: &Limits,
        vertices: usize,
        triangles: usize,
    ) -> Result<(), SceneError> {
        self.vertices = self.vertices.saturating_add(vertices);
        self.triangles = self.triangles.saturating_add(triangles);
        for (what, needed, limit) in [
            // Indices have 32 bits.
            ("vertices", self.vertices, limits.vertices.min(u32::MAX as usize)),
            ("triangles", self.triangles, limits.triangles),
        ] {
            if needed > limit {
                return Err(SceneError::TooMuch { file: file.into(), what, needed, limit });
            }
        }
        Ok(())
    }
}

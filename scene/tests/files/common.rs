//! Files of one test.

use std::path::PathBuf;

use sglow_scene::{Options, Scene, SceneError};

/// A folder with the files of one test.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, contents).unwrap();
        path
    }

    pub(crate) fn load(&self, name: &str, contents: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
        Scene::from_file_with(&self.write(name, contents), &Options::default())
    }
}

/// Whether some note says so.
pub(crate) fn said(scene: &Scene, text: &str) -> bool {
    scene.notes.iter().any(|note| note.to_string().contains(text))
}

/// A case of the repository.
pub(crate) fn case(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cases")).join(name)
}

/// The corners of all triangles with the names of their materials, in an order of their own.
pub(crate) fn triangles(scene: &Scene) -> Vec<(String, [[u32; 3]; 3])> {
    let bits = |corners: [[f32; 3]; 3]| corners.map(|corner| corner.map(f32::to_bits));
    let mut all: Vec<_> = scene
        .triangles()
        .map(|one| (scene.materials[one.material].name.clone(), bits(one.positions)))
        .collect();
    all.sort();
    all
}

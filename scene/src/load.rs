//! Scenes from names and files.

use std::path::Path;

use crate::error::SceneError;
use crate::files::{self, Files};
use crate::options::Options;
use crate::scene::Scene;
use crate::{builtin, gltf, obj, sidecar};

/// The file name extensions [`Scene::load`] reads.
pub(crate) const EXTENSIONS: [&str; 3] = ["glb", "gltf", "obj"];

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
        Self::load_with(name_or_path, &Options::default())
    }

    /// [`Scene::load`] with options.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::load`].
    pub fn load_with(name_or_path: &str, options: &Options) -> Result<Self, SceneError> {
        if builtin::is_builtin(name_or_path) {
            return Self::builtin_about(name_or_path, options.origin);
        }
        let path = Path::new(name_or_path);
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        if !path.exists() && extension.is_none() {
            return Err(builtin::unknown(name_or_path));
        }
        Self::from_file_with(path, options)
    }

    /// Makes a built-in scene: one of [`builtin::NAMES`], the atrium with its number of triangles
    /// as in `atrium:75k`.
    ///
    /// # Errors
    ///
    /// [`SceneError::UnknownBuiltin`] lists the known names, [`SceneError::Detail`] the range of the
    /// number.
    pub fn builtin(name: &str) -> Result<Self, SceneError> {
        Self::builtin_about(name, None)
    }

    fn builtin_about(name: &str, origin: Option<[f64; 3]>) -> Result<Self, SceneError> {
        let draft = builtin::make(name)?;
        draft.finish(Path::new(name), name.to_owned(), origin)
    }

    /// Loads a file, and its sidecar where there is one.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::load`].
    pub fn from_file(path: &Path) -> Result<Self, SceneError> {
        Self::from_file_with(path, &Options::default())
    }

    /// [`Scene::from_file`] with options.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::load`].
    pub fn from_file_with(path: &Path, options: &Options) -> Result<Self, SceneError> {
        let extension =
            path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if !EXTENSIONS.contains(&extension.as_str()) {
            return Err(SceneError::Extension {
                file: path.into(),
                found: extension,
                known: EXTENSIONS.join(", "),
            });
        }
        let bytes = files::read(path, options.limits.file_bytes)?;
        let files = Files { scene: path, options };
        let mut draft = if extension == "obj" {
            obj::load(&files, &bytes)?
        } else {
            gltf::load(&files, &bytes)?
        };
        drop(bytes);
        sidecar::apply(path, &options.limits, &mut draft)?;
        let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        draft.finish(path, stem, options.origin)
    }
}

//! The files of a scene: regular ones, of a limited size, in the scene's folder.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use super::{Options, SceneError};

/// Reads what the file of a scene refers to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Files<'a> {
    /// The scene's file.
    pub(super) scene: &'a Path,
    pub(super) options: &'a Options,
}

impl Files<'_> {
    /// The folder that the scene's file lies in.
    fn folder(&self) -> &Path {
        match self.scene.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        }
    }

    /// The path of a file by its name relative to the folder.
    ///
    /// # Errors
    /// [`SceneError::Outside`] where it leads out of the folder, by its name or by a symbolic link;
    /// [`SceneError::Missing`] where there is none.
    pub(super) fn find(&self, name: &str) -> Result<PathBuf, SceneError> {
        let path = self.folder().join(name);
        if self.options.allow_outside {
            return Ok(path);
        }
        let outside = || SceneError::Outside { file: self.scene.into(), name: name.to_owned() };
        if leaves(Path::new(name)) {
            return Err(outside());
        }
        let real = |path: &Path| fs::canonicalize(path).map_err(|source| fault(path, source));
        if !real(&path)?.starts_with(real(self.folder())?) {
            return Err(outside());
        }
        Ok(path)
    }

    /// The file that a name means, and its bytes.
    pub(super) fn read(&self, name: &str) -> Result<(PathBuf, Vec<u8>), SceneError> {
        let path = self.find(name)?;
        let bytes = read(&path, self.options.limits.file_bytes)?;
        Ok((path, bytes))
    }
}

/// Whether a relative path leads out of where it starts.
fn leaves(path: &Path) -> bool {
    let mut depth = 0_usize;
    for component in path.components() {
        match component {
            Component::Prefix(_) | Component::RootDir => return true,
            Component::ParentDir => match depth.checked_sub(1) {
                Some(above) => depth = above,
                None => return true,
            },
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
        }
    }
    // On every system: a drive, or a path of Windows.
    path.to_string_lossy().contains('\\')
}

/// Reads a whole file of at most `limit` bytes. Devices, pipes and folders are refused: they can block, or never end.
pub(super) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, SceneError> {
    let fault = |source| fault(path, source);
    let refuse = |bytes: u64| SceneError::TooLarge { file: path.into(), bytes, limit };
    // Checked before it is opened, for opening a pipe waits for its writer.
    if !fs::metadata(path).map_err(fault)?.is_file() {
        return Err(SceneError::NotRegular { file: path.into() });
    }
    let file = File::open(path).map_err(fault)?;
    let found = file.metadata().map_err(fault)?;
    if found.len() > limit {
        return Err(refuse(found.len()));
    }
    let mut bytes = Vec::new();
    // It may grow while it is read, and files of the kernel's have no length.
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(fault)?;
    if bytes.len() as u64 > limit {
        return Err(refuse(bytes.len() as u64));
    }
    Ok(bytes)
}

fn fault(path: &Path, source: io::Error) -> SceneError {
    match source.kind() {
        io::ErrorKind::NotFound => SceneError::Missing { file: path.into() },
        _ => SceneError::Read { file: path.into(), source },
    }
}

//! Regular files of a limited size, and paths that stay inside a folder.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::{Component, Path, PathBuf};

/// The maximum size of a file of a package in bytes. The largest one is the manifest.
const MAXIMUM: u64 = 256 << 20;

/// A file that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub struct Fault {
    /// The file.
    pub path: PathBuf,
    /// Why.
    pub source: io::Error,
}

/// Adds the path to an error of the system.
pub fn at(path: &Path) -> impl Fn(io::Error) -> Fault {
    let path = path.to_owned();
    move |source| Fault { path: path.clone(), source }
}

/// The bytes of a regular file: pipes and devices may never end.
///
/// # Errors
///
/// When it cannot be read; [`io::ErrorKind::InvalidInput`] if it is no regular file, or larger than `maximum` bytes.
pub fn read_regular(path: &Path, maximum: u64) -> io::Result<Vec<u8>> {
    let refuse = |why: String| Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    // Before it is opened: opening a pipe waits for its writer.
    let found = fs::metadata(path)?;
    if !found.is_file() {
        return refuse("is no regular file".to_owned());
    }
    let mut bytes = Vec::new();
    if found.len() <= maximum {
        // The file may grow meanwhile.
        File::open(path)?.take(maximum.saturating_add(1)).read_to_end(&mut bytes)?;
    }
    if found.len().max(bytes.len() as u64) > maximum {
        return refuse(format!("is larger than {maximum} bytes"));
    }
    Ok(bytes)
}

/// The bytes of a file of a package; nothing where there is none.
///
/// # Errors
///
/// As [`read_regular`].
pub fn read_if_there(path: &Path) -> Result<Option<Vec<u8>>, Fault> {
    match read_regular(path, MAXIMUM) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if missing(&error) => Ok(None),
        Err(error) => Err(at(path)(error)),
    }
}

/// Whether there is no such file: also where one of its folders is a file.
fn missing(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

/// What lies in a folder, each by its path in it with `/` between its parts: files, links and whatever else is no folder;
/// folders that are empty. Links are not followed. There is nothing in a folder that is not there.
///
/// # Errors
///
/// When a folder cannot be read.
pub fn listed(folder: &Path) -> Result<(Vec<String>, Vec<String>), Fault> {
    let (mut files, mut empty) = (Vec::new(), Vec::new());
    let mut pending = vec![folder.to_owned()];
    while let Some(next) = pending.pop() {
        let entries = match fs::read_dir(&next) {
            Ok(entries) => entries,
            Err(error) if missing(&error) && next == folder => continue,
            Err(error) => return Err(at(&next)(error)),
        };
        let mut count = 0;
        for entry in entries {
            let entry = entry.map_err(at(&next))?;
            let (path, kind) = (entry.path(), entry.file_type().map_err(at(&next))?);
            count += 1;
            if kind.is_dir() {
                pending.push(path);
            } else {
                files.push(relative(folder, &path));
            }
        }
        if count == 0 && next != folder {
            empty.push(relative(folder, &next));
        }
    }
    Ok((files, empty))
}

/// `path` relative to `root` with `/` between its parts.
fn relative(root: &Path, path: &Path) -> String {
    let inner = path.strip_prefix(root).unwrap_or(path);
    let parts: Vec<_> = inner.iter().map(|part| part.to_string_lossy()).collect();
    parts.join("/")
}

/// Whether a path in a list stays in its folder, on every system.
#[must_use]
pub fn is_inside(path: &str) -> bool {
    let normal = |part| matches!(part, Component::Normal(_));
    !path.is_empty() && !path.contains(['\\', ':']) && Path::new(path).components().all(normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_inside() {
        for path in ["a", "a/b.txt", "..a/b"] {
            assert!(is_inside(path), "{path}");
        }
        for path in ["", "/a", "../a", "a/../b", "a\\..\\b", "c:/a", "c:a"] {
            assert!(!is_inside(path), "{path}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_regular_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert!(read_if_there(&folder.path().join("none")).unwrap().is_none());
        for path in [Path::new("/dev/zero"), folder.path()] {
            let text = read_if_there(path).unwrap_err().to_string();
            assert!(text.contains("is no regular file"), "{text}");
        }
        std::os::unix::fs::symlink("/dev/zero", folder.path().join("link")).unwrap();
        assert!(read_if_there(&folder.path().join("link")).is_err());
    }

    #[test]
    fn large_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large");
        fs::write(&path, "four").unwrap();
        assert_eq!(read_regular(&path, 4).unwrap(), b"four");
        assert!(read_regular(&path, 3).is_err());
        File::create(&path).unwrap().set_len(MAXIMUM + 1).unwrap();
        let text = read_if_there(&path).unwrap_err().to_string();
        assert!(text.contains(&format!("is larger than {MAXIMUM} bytes")), "{text}");
    }
}

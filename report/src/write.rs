//! Files that are there whole or not at all.

use std::fs;
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::failure::{Context as _, Failure, Result};

/// What a file is written through.
pub trait Sink: Write + Seek {}
impl<T: Write + Seek> Sink for T {}

/// Writes a file beside its place and renames it; missing folders are made.
///
/// # Errors
///
/// When the folder or the file cannot be written, or `fill` fails; then nothing is left behind.
pub fn file<E: Into<Failure>>(
    path: &Path,
    fill: impl FnOnce(&mut dyn Sink) -> Result<(), E>,
) -> Result {
    persist(beside(path, fill)?, path)
}

/// Writes several files as [`file()`] does, which belong together: none takes its place before all are written.
pub fn texts(files: &[(&Path, &str)]) -> Result {
    let write =
        |&(path, text): &(&Path, &str)| beside(path, |sink| sink.write_all(text.as_bytes()));
    let written = files.iter().map(write).collect::<Result<Vec<_>>>()?;
    written.into_iter().zip(files).try_for_each(|(file, (path, _))| persist(file, path))
}

/// Makes sure that files can be written in a folder, which may not be there yet, before much work is done for them.
///
/// # Errors
///
/// When something else is in its place, or it may not be written.
pub fn probe(folder: &Path) -> Result {
    let place = folder.display();
    let mut there = std::path::absolute(folder).context(&place)?;
    while fs::symlink_metadata(&there).is_err() && there.pop() {}
    if !there.is_dir() {
        return Err(Failure::new(format!(
            "{place}: cannot write: {} is not a folder",
            there.display()
        )));
    }
    tempfile::Builder::new()
        .prefix(".sglow-")
        .tempfile_in(&there)
        .context(format!("{place}: cannot write"))?;
    Ok(())
}

/// Makes sure that a package can be written to a folder, and would not take the place of somebody's own files.
///
/// # Errors
///
/// When something else is in its place, it may not be written, or it holds files and no package.
pub fn probe_package(out: &Path) -> Result {
    probe(out)?;
    Ok(sglow_shader_gen::package::claim(out)?)
}

fn persist(file: NamedTempFile, path: &Path) -> Result {
    let persisted = file.persist(path).map_err(|error| error.error);
    persisted.context(format!("{}: cannot write", path.display()))?;
    Ok(())
}

/// A file that is written beside its place.
fn beside<E: Into<Failure>>(
    path: &Path,
    fill: impl FnOnce(&mut dyn Sink) -> Result<(), E>,
) -> Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    };
    let place = path.display();
    fs::create_dir_all(&folder).context(format!("{}: cannot make the folder", folder.display()))?;
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        // A temporary file is its owner's alone; what is kept follows the umask like any other file.
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let file =
        builder.prefix(".sglow-").tempfile_in(&folder).context(format!("{place}: cannot write"))?;
    let mut writer = BufWriter::new(file);
    fill(&mut writer).map_err(Into::into).context(format!("{place}: cannot write"))?;
    writer
        .into_inner()
        .map_err(io::IntoInnerError::into_error)
        .context(format!("{place}: cannot write"))
}

/// Writes `text` as [`file()`] does.
pub fn text(path: &Path, text: &str) -> Result {
    file(path, |sink| sink.write_all(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_there_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/er/file.txt");
        text(&path, "first").unwrap();
        let failed = file(&path, |sink| {
            sink.write_all(b"half")?;
            Err(io::Error::other("the disk is full"))
        });
        assert!(failed.unwrap_err().to_string().contains("the disk is full"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "first");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn a_place_that_cannot_be_written_is_found_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "mine").unwrap();
        probe(folder.path()).unwrap();
        probe(&folder.path().join("not/there/yet")).unwrap();
        for wrong in [file.clone(), file.join("below")] {
            let text = probe(&wrong).unwrap_err().to_string();
            assert!(text.contains("file is not a folder"), "{text}");
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left behind");
    }

    #[test]
    fn files_that_belong_together_come_together() {
        let folder = tempfile::tempdir().unwrap();
        let (one, other) = (folder.path().join("one"), folder.path().join("other"));
        texts(&[(&one, "1"), (&other, "1")]).unwrap();
        // The second one cannot be written: the first one stays as it was.
        let nowhere = one.join("below");
        assert!(texts(&[(&one, "2"), (&nowhere, "2")]).is_err());
        assert_eq!(fs::read_to_string(&one).unwrap(), "1");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn a_package_takes_the_place_of_a_package_alone() {
        let folder = tempfile::tempdir().unwrap();
        probe_package(folder.path()).unwrap();
        probe_package(&folder.path().join("new")).unwrap();
        fs::write(folder.path().join("README.md"), "mine").unwrap();
        for manifest in [None, Some("{}"), Some(r#"{ "manifest_version": 3, "name": "tabs" }"#)] {
            for text in manifest {
                fs::write(folder.path().join("manifest.json"), text).unwrap();
            }
            let text = probe_package(folder.path()).unwrap_err().to_string();
            assert!(text.contains("would replace files"), "{text}");
        }
        assert!(probe_package(&folder.path().join("README.md")).is_err());
    }
}

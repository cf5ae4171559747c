//! The files of a library, and places in them.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::{fs, io};

use codespan_reporting::files::SimpleFiles;
use sglow_seal::read_regular;

/// A stretch of bytes of one file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    /// Index of the file in [`Sources`].
    pub file: usize,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Span {
    /// The stretch `range` of `file`.
    #[must_use]
    pub fn new(file: usize, range: Range<usize>) -> Self {
        Self { file, start: range.start, end: range.end }
    }
}

/// A file as it was read.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// Path relative to the folder of `library.toml`, with `/` between its parts.
    pub path: String,
    /// Its text.
    pub text: String,
}

/// The files of a library: `library.toml` first, then every `.wesl` file, sorted by path.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<SourceFile>,
}

impl Sources {
    /// Adds a file and returns its index.
    pub fn add(&mut self, path: impl Into<String>, text: impl Into<String>) -> usize {
        self.files.push(SourceFile { path: path.into(), text: text.into() });
        self.files.len() - 1
    }

    /// All files.
    #[must_use]
    pub fn files(&self) -> &[SourceFile] {
        &self.files
    }

    /// The text of file `index`, empty if there is none.
    #[must_use]
    pub fn text(&self, index: usize) -> &str {
        self.files.get(index).map_or("", |file| &file.text)
    }

    /// The path of file `index`, empty if there is none.
    #[must_use]
    pub fn path(&self, index: usize) -> &str {
        self.files.get(index).map_or("", |file| &file.path)
    }

    pub(crate) fn for_report(&self) -> SimpleFiles<&str, &str> {
        let mut files = SimpleFiles::new();
        for file in &self.files {
            files.add(file.path.as_str(), file.text.as_str());
        }
        files
    }
}

/// The maximum size of a file of a library in bytes.
const MAXIMUM_SIZE: u64 = 8 << 20;

/// The maximum number of files and folders in a folder of sources.
const MAXIMUM_COUNT: usize = 10_000;

/// Whether a path that a file names stays in its folder, which is `.`, on every system.
fn is_inside(path: &str) -> bool {
    matches!(path, "." | "./") || sglow_seal::is_inside(path.strip_prefix("./").unwrap_or(path))
}

/// The path in `folder` that one of its files names; an error if it leads out of the folder, by its name or by a link.
pub(crate) fn find(folder: &Path, name: &str) -> io::Result<PathBuf> {
    let outside =
        || io::Error::new(io::ErrorKind::InvalidInput, "leads out of the library's folder");
    if !is_inside(name) {
        return Err(outside());
    }
    let path = folder.join(name);
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    if fs::canonicalize(&path)?.starts_with(fs::canonicalize(here)?) {
        Ok(path)
    } else {
        Err(outside())
    }
}

/// The text of a regular file of limited size.
pub(crate) fn read(path: &Path) -> io::Result<String> {
    String::from_utf8(read_regular(path, MAXIMUM_SIZE)?).map_err(|error| {
        let text = format!("is not UTF-8 from byte {} on", error.utf8_error().valid_up_to());
        io::Error::new(io::ErrorKind::InvalidData, text)
    })
}

/// All `.wesl` files below `folder`, sorted; links to folders are not followed.
pub(crate) fn modules_below(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let (mut found, mut count) = (Vec::new(), 0);
    let mut pending = vec![folder.to_owned()];
    while let Some(folder) = pending.pop() {
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            let path = entry.path();
            count += 1;
            if count > MAXIMUM_COUNT {
                let text = format!("has more than {MAXIMUM_COUNT} files and folders in it");
                return Err(io::Error::new(io::ErrorKind::QuotaExceeded, text));
            }
            if entry.file_type()?.is_dir() {
                pending.push(path);
            } else if path.extension().is_some_and(|extension| extension == "wesl") {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// `path` relative to `root` with `/` between its parts.
pub(crate) fn relative(root: &Path, path: &Path) -> String {
    let parts: Vec<_> = path
        .strip_prefix(root)
        .unwrap_or(path)
        .components()
        .map(|part| part.as_os_str().to_string_lossy())
        .collect();
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_inside() {
        for path in ["a", "./a/b.txt", ".", "./"] {
            assert!(is_inside(path), "{path}");
        }
        for path in ["", "..", "./..", ".//a", "a/../b"] {
            assert!(!is_inside(path), "{path}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_lead_nowhere_else_and_devices_are_no_sources() {
        let folder = tempfile::tempdir().unwrap();
        let (inside, outside) = (folder.path().join("inside"), folder.path().join("outside"));
        fs::create_dir_all(inside.join("own")).unwrap();
        fs::create_dir(&outside).unwrap();
        let link = |to: &Path, at: &str| std::os::unix::fs::symlink(to, inside.join(at)).unwrap();
        link(&outside, "link");
        link(&inside.join("own"), "own/circle");
        link(Path::new("/dev/zero"), "own/zero.wesl");
        assert!(find(&inside, "own").is_ok() && find(&inside, "./own").is_ok());
        for name in ["link", "link/none", "../outside", "/"] {
            assert!(find(&inside, name).is_err(), "{name}");
        }
        let found = modules_below(&inside).unwrap();
        assert_eq!(found, [inside.join("own/zero.wesl")]);
        assert!(read(&found[0]).unwrap_err().to_string().contains("no regular file"));
        fs::write(inside.join("latin.wesl"), b"a\xfcb").unwrap();
        let text = read(&inside.join("latin.wesl")).unwrap_err().to_string();
        assert!(text.contains("not UTF-8 from byte 1"), "{text}");
    }

    #[test]
    fn large_files_and_folders_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.wesl");
        fs::File::create(&path).unwrap().set_len(MAXIMUM_SIZE + 1).unwrap();
        let text = read(&path).unwrap_err().to_string();
        assert!(text.contains("is larger than"), "{text}");
        for number in 1..MAXIMUM_COUNT {
            fs::write(folder.path().join(format!("{number}.wesl")), "").unwrap();
        }
        assert_eq!(modules_below(folder.path()).unwrap().len(), MAXIMUM_COUNT);
        fs::create_dir(folder.path().join("one more")).unwrap();
        let text = modules_below(folder.path()).unwrap_err().to_string();
        assert!(text.contains("files and folders"), "{text}");
    }
}

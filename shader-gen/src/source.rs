//! The files of a library, and places in them.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::{fs, io};

use codespan_reporting::files::SimpleFiles;

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

/// All `.wesl` files below `folder`, sorted.
pub(crate) fn modules_below(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(folder) = pending.pop() {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
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

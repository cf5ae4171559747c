//! Finding the files that OBJ and MTL name: blanks in names, other systems' separators and paths.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::geometry::Library;
use crate::SceneError;
use crate::files::{self, Files};

/// The most words of a line that may be one name with blanks.
const MOST_WORDS: usize = 16;

/// The most words of a line that are looked for.
const MOST_NAMES: usize = 64;

/// Finds files by their names.
pub(super) struct Finder<'a> {
    pub(super) files: Files<'a>,
    /// The names in the scene's folder by what they are in lower case; the first one in order.
    listing: OnceCell<BTreeMap<String, String>>,
}

/// A file that a name means.
pub(super) struct Found {
    pub(super) path: PathBuf,
    /// Whether it is only called alike.
    pub(super) alike: bool,
    pub(super) bytes: Vec<u8>,
}

impl<'a> Finder<'a> {
    pub(super) fn new(files: Files<'a>) -> Self {
        Self { files, listing: OnceCell::new() }
    }

    /// The names of the libraries of a line: several names, or one with blanks, whatever is there.
    pub(super) fn names(&self, line: &Library) -> Vec<String> {
        let exists = |name: &str| self.find(name).is_ok_and(|(path, _)| path.is_file());
        if exists(&line.whole) {
            return vec![line.whole.clone()];
        }
        let words = line.words.get(..MOST_NAMES).unwrap_or(&line.words);
        let mut names = Vec::new();
        let mut at = 0;
        while at < words.len() {
            let most = words.len().min(at + MOST_WORDS);
            let mut together = (at + 1..=most).rev().map(|end| (end, words[at..end].join(" ")));
            let found = together.find(|(_, name)| exists(name));
            let (end, name) = found.unwrap_or_else(|| (at + 1, words[at].clone()));
            names.push(name);
            at = end;
        }
        names
    }

    /// Reads the file that a name means.
    pub(super) fn read(&self, name: &str) -> Result<Found, SceneError> {
        let (path, alike) = self.find(name)?;
        let bytes = files::read(&path, self.files.options.limits.file_bytes)?;
        Ok(Found { path, alike, bytes })
    }

    /// Where a file lies, and whether it is only called alike: a name with a path that leads nowhere or out of the
    /// folder, or in other letters' cases, means the file of that name beside the scene.
    fn find(&self, name: &str) -> Result<(PathBuf, bool), SceneError> {
        let name = name.trim_matches('"').replace('\\', "/");
        let fault = match self.files.find(&name) {
            Ok(path) if path.exists() => return Ok((path, false)),
            Ok(path) => SceneError::Missing { file: path },
            Err(fault) => fault,
        };
        let last = name.rsplit('/').next().unwrap_or_default();
        let listing = self.listing.get_or_init(|| listing(self.files.scene));
        // A name that is there is there in other cases as well.
        let Some(other) = listing.get(&last.to_lowercase()) else { return Err(fault) };
        let mut alike = [last, other].into_iter().filter_map(|name| self.files.find(name).ok());
        alike.next().map(|path| (path, true)).ok_or(fault)
    }
}

/// The names in a file's folder, by what they are in lower case.
fn listing(file: &Path) -> BTreeMap<String, String> {
    let folder = file.parent().filter(|folder| *folder != Path::new(""));
    let entries = std::fs::read_dir(folder.unwrap_or(Path::new("."))).into_iter().flatten();
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<_> = names.collect();
    names.sort_by(|a, b| b.cmp(a));
    names.into_iter().map(|name| (name.to_lowercase(), name)).collect()
}

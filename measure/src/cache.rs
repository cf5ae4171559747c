//! Results that took long, kept in files: each beside the hashes of all that it depends on, and only trusted if these are
//! the same.
//!
//! An entry is there whole or not at all: a run that is interrupted loses the result that it was at, and no more.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use thiserror::Error;

/// The form of the files.
const VERSION: u32 = 1;

/// The hash of the code that measures: of another code's results nothing is known.
pub const CODE: &str = env!("SGLOW_CODE");

/// Why a result cannot be kept.
#[derive(Debug, Error)]
pub enum CacheError {
    /// The file cannot be written: no room, no permission.
    #[error("{}: a result cannot be kept: {source}; {}", path.display(), remedy(source.kind()))]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The result has no form that can be written.
    #[error("{}: a result cannot be kept: {source}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// Why.
        source: postcard::Error,
    },
}

fn remedy(kind: io::ErrorKind) -> &'static str {
    match kind {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "free some room, or name another folder with --cache"
        }
        _ => "name another folder with --cache",
    }
}

/// SHA-256 in hexadecimal.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    base16ct::lower::encode_string(&Sha256::digest(bytes))
}

/// What a result is, and what it depends on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Key {
    /// What it is: a later result that is called the same takes its place.
    what: Vec<(String, String)>,
    /// What it depends on: with any of it changed it has to be made again.
    depends: Vec<(String, String)>,
}

impl Key {
    /// The key of what `what` names.
    #[must_use]
    pub fn new(what: &[(&str, &str)]) -> Self {
        let what = what.iter().map(|&(name, value)| (name.to_owned(), value.to_owned()));
        Self { what: what.collect(), depends: vec![("code".to_owned(), CODE.to_owned())] }
    }

    /// The same, depending on something more.
    #[must_use]
    pub fn on(mut self, name: &str, value: impl Into<String>) -> Self {
        self.depends.push((name.to_owned(), value.into()));
        self
    }

    fn file(&self) -> String {
        let mut text = String::new();
        for (name, value) in &self.what {
            text.push_str(&format!("{}:{name}={}:{value};", name.len(), value.len()));
        }
        format!("{}.result", &sha256(text.as_bytes())[..32])
    }
}

/// What stands before a result in its file.
#[derive(Serialize, Deserialize)]
struct Header {
    version: u32,
    key: Key,
    sha256: String,
}

/// A folder of results.
#[derive(Debug)]
pub struct Cache {
    folder: PathBuf,
    fresh: bool,
    found: Cell<usize>,
    made: Cell<usize>,
    outdated: Cell<usize>,
    /// Files that were there and are not trusted.
    distrusted: RefCell<BTreeSet<String>>,
    /// Files that were made since: those are trusted.
    own: RefCell<BTreeSet<String>>,
}

impl Cache {
    /// Results in a folder, which is made when there is one to keep. `fresh` trusts none that is there already.
    #[must_use]
    pub fn new(folder: &Path, fresh: bool) -> Self {
        let [found, made, outdated] = [0; 3].map(Cell::new);
        let (distrusted, own) = (RefCell::default(), RefCell::default());
        Self { folder: folder.to_owned(), fresh, found, made, outdated, distrusted, own }
    }

    /// The result of a key: a kept one if all it depends on is the same, else what `make` makes, which is then kept.
    ///
    /// # Errors
    ///
    /// Those of `make`; and that the result cannot be kept.
    pub fn get<T: Serialize + DeserializeOwned, E: From<CacheError>>(
        &self,
        key: &Key,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        if let Some(kept) = self.kept(key) {
            self.found.set(self.found.get() + 1);
            return Ok(kept);
        }
        let result = make()?;
        self.put(key, &result)?;
        Ok(result)
    }

    /// The kept result of a key, if all it depends on is the same.
    #[must_use]
    pub fn find<T: DeserializeOwned>(&self, key: &Key) -> Option<T> {
        let found = self.kept(key);
        if found.is_some() {
            self.found.set(self.found.get() + 1);
        }
        found
    }

    /// How many results were found, and were made; and how many of those took the place of one that was broken or
    /// depended on something else.
    #[must_use]
    pub fn counts(&self) -> [usize; 3] {
        [&self.found, &self.made, &self.outdated].map(Cell::get)
    }

    fn kept<T: DeserializeOwned>(&self, key: &Key) -> Option<T> {
        if self.fresh && !self.own.borrow().contains(&key.file()) {
            return None;
        }
        let bytes = fs::read(self.folder.join(key.file())).ok()?;
        let kept = trusted(&bytes, key);
        if kept.is_none() {
            self.distrusted.borrow_mut().insert(key.file());
        }
        kept
    }

    /// Keeps a result.
    ///
    /// # Errors
    ///
    /// When it cannot be written.
    pub fn put<T: Serialize>(&self, key: &Key, result: &T) -> Result<(), CacheError> {
        let path = self.folder.join(key.file());
        let payload = postcard::to_stdvec(result)
            .map_err(|source| CacheError::Form { path: path.clone(), source })?;
        let header = Header { version: VERSION, key: key.clone(), sha256: sha256(&payload) };
        let write = || {
            fs::create_dir_all(&self.folder)?;
            let mut file = tempfile::Builder::new().prefix(".sglow-").tempfile_in(&self.folder)?;
            serde_json::to_writer(&mut file, &header)?;
            file.write_all(b"\n")?;
            file.write_all(&payload)?;
            file.persist(&path).map_err(|error| error.error)?;
            Ok(())
        };
        write().map_err(|source| CacheError::Write { path: path.clone(), source })?;
        self.made.set(self.made.get() + 1);
        self.own.borrow_mut().insert(key.file());
        if self.distrusted.borrow_mut().remove(&key.file()) {
            self.outdated.set(self.outdated.get() + 1);
        }
        Ok(())
    }
}

/// What a file holds, if it is whole and made of just what the key says.
fn trusted<T: DeserializeOwned>(bytes: &[u8], key: &Key) -> Option<T> {
    let end = bytes.iter().position(|&byte| byte == b'\n')?;
    let header: Header = serde_json::from_slice(&bytes[..end]).ok()?;
    let payload = &bytes[end + 1..];
    let same = header.version == VERSION && header.key == *key;
    if same && header.sha256 == sha256(payload) { postcard::from_bytes(payload).ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(text: &str) -> Key {
        Key::new(&[("scene", "cornell"), ("size", "4x4")]).on("shader", text)
    }

    fn get(cache: &Cache, key: &Key, value: f64) -> f64 {
        cache.get::<_, CacheError>(key, || Ok(value)).unwrap()
    }

    #[test]
    fn what_is_kept_is_found_unless_something_changed() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path(), false);
        assert_eq!(get(&cache, &key("a"), 1.0), 1.0);
        assert_eq!(get(&cache, &key("a"), 2.0), 1.0);
        assert_eq!(cache.counts(), [1, 1, 0]);
        // Another shader: made again, in the same file.
        assert_eq!(get(&cache, &key("b"), 3.0), 3.0);
        assert_eq!(cache.counts(), [1, 2, 1]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        assert_eq!(get(&Cache::new(folder.path(), true), &key("b"), 4.0), 4.0, "fresh");
        assert_ne!(key("a").file(), Key::new(&[("scene", "cornel"), ("size", "l4x4")]).file());
    }

    #[test]
    fn what_is_not_a_number_is_kept_too() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path(), false);
        get(&cache, &key("a"), f64::NAN);
        assert!(get(&cache, &key("a"), 1.0).is_nan());
    }

    #[test]
    fn what_is_broken_or_of_another_version_is_made_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(key("a").file());
        let broken: [fn(&mut Vec<u8>); 5] = [
            |bytes| bytes.clear(),
            |bytes| bytes.truncate(bytes.len() - 1),
            |bytes| *bytes.last_mut().unwrap() ^= 1,
            |bytes| bytes.retain(|&byte| byte != b'\n'),
            |bytes| {
                let end = bytes.iter().position(|&byte| byte == b'\n').unwrap();
                let header = String::from_utf8(bytes[..end].to_vec()).unwrap();
                assert!(header.contains(CODE));
                bytes.splice(..end, header.replace(CODE, &"0".repeat(64)).into_bytes());
            },
        ];
        for (index, break_it) in broken.iter().enumerate() {
            let cache = Cache::new(folder.path(), false);
            get(&cache, &key("a"), 1.0);
            let mut bytes = fs::read(&path).unwrap();
            break_it(&mut bytes);
            fs::write(&path, bytes).unwrap();
            assert_eq!(get(&cache, &key("a"), 2.0), 2.0, "{index}");
            assert_eq!(cache.counts()[2], 1, "{index}");
            fs::remove_file(&path).unwrap();
        }
    }

    #[test]
    fn a_result_that_is_looked_for_twice_is_outdated_once() {
        let folder = tempfile::tempdir().unwrap();
        Cache::new(folder.path(), false).put(&key("a"), &1.0).unwrap();
        let cache = Cache::new(folder.path(), false);
        assert_eq!(cache.find::<f64>(&key("b")), None);
        assert_eq!(cache.counts(), [0, 0, 0]);
        assert_eq!(get(&cache, &key("b"), 2.0), 2.0);
        assert_eq!(cache.counts(), [0, 1, 1]);
    }

    #[test]
    fn what_would_help_depends_on_what_is_wrong() {
        let text = |kind: io::ErrorKind| {
            let path = PathBuf::from("folder/file");
            CacheError::Write { path, source: kind.into() }.to_string()
        };
        assert!(text(io::ErrorKind::StorageFull).contains("free some room"));
        let denied = text(io::ErrorKind::PermissionDenied);
        assert!(denied.contains("--cache") && !denied.contains("room"), "{denied}");
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let cache = Cache::new(&file.join("below"), false);
        let error = cache.get::<_, CacheError>(&key("a"), || Ok(1.0)).unwrap_err().to_string();
        assert!(error.contains("below") && error.contains("cannot be kept"), "{error}");
        assert_eq!(cache.counts()[1], 0);
    }
}

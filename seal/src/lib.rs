//! The files of a package on disk: `SHA256SUMS` names every file with its hash, the manifest among them.
//!
//! This guards against damage: a file that was changed, exchanged, cut off or lost, a path that leads elsewhere. It is no
//! guard against an attacker, who can write hashes as well.

mod file;
mod text;

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use base16ct::lower::encode_string;
use sha2::{Digest, Sha256};

pub use file::{Fault, at, is_inside, listed, read_if_there, read_regular};
pub use text::missing;

/// The file with the hashes of all others.
pub const SUMS: &str = "SHA256SUMS";

/// The file that describes a package.
pub const MANIFEST: &str = "manifest.json";

/// Why a file of a package cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// It cannot be read.
    #[error("{0}; a package is a folder that `cargo xtask gen-shaders --out DIR` wrote")]
    Unreadable(#[from] Fault),
    /// The list of hashes is invalid.
    #[error("{}: {reason}; generate the package again", path.display())]
    Sums {
        /// The list.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Its hash is not the one in the list.
    #[error(
        "{}: was changed after it was generated (its SHA-256 is {found}, the one in SHA256SUMS {expected}); edit the sources and \
         generate the package again",
        path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// Its hash.
        found: String,
        /// That in the list.
        expected: String,
    },
    /// A link leads out of the package.
    #[error("{}: leads out of the package", path.display())]
    Outside {
        /// The file.
        path: PathBuf,
    },
}

/// SHA-256 in hexadecimal.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    encode_string(&Sha256::digest(bytes))
}

/// The lines of `SHA256SUMS`, as `sha256sum` writes and checks them.
#[must_use]
pub fn sums(files: &BTreeMap<String, Vec<u8>>) -> String {
    files.iter().map(|(path, bytes)| format!("{}  {path}\n", sha256(bytes))).collect()
}

/// An invalid line of `SHA256SUMS`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {0} is no SHA-256 and path in the package, or its path is there already")]
pub struct BadLine(pub usize);

/// The hashes in `SHA256SUMS` by path.
///
/// # Errors
///
/// The first line of another form, with a path that leads out of the package, or one that was there before.
pub fn read_sums(text: &str) -> Result<BTreeMap<&str, &str>, BadLine> {
    let digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
    let mut sums = BTreeMap::new();
    for (index, line) in text.lines().enumerate() {
        let parts = line.split_once("  ");
        let parts = parts.filter(|(hash, path)| {
            hash.len() == 64 && hash.bytes().all(digit) && is_inside(path) && *path != SUMS
        });
        let (hash, path) = parts.ok_or(BadLine(index + 1))?;
        if sums.insert(path, hash).is_some() {
            return Err(BadLine(index + 1));
        }
    }
    Ok(sums)
}

/// The files of a package by path, each compared with its hash. Files that the list does not name are left out.
///
/// # Errors
///
/// Without a list, or with one that does not name the manifest; every file that is missing, changed, no regular file, or
/// elsewhere.
pub fn open(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>, Vec<Error>> {
    let list = folder.join(SUMS);
    let one = |error: Error| vec![error];
    let wrong = |reason: String| vec![Error::Sums { path: list.clone(), reason }];
    let there = |path: &Path| {
        let missing = || at(path)(io::Error::new(io::ErrorKind::NotFound, "is missing"));
        read_if_there(path).and_then(|bytes| bytes.ok_or_else(missing))
    };
    // First, so that the error for a folder that is no package names the manifest.
    there(&folder.join(MANIFEST)).map_err(|fault| one(fault.into()))?;
    let text = there(&list).map_err(|fault| one(fault.into()))?;
    let text = String::from_utf8(text).map_err(|error| wrong(error.to_string()))?;
    let sums = read_sums(&text).map_err(|line| wrong(line.to_string()))?;
    if !sums.contains_key(MANIFEST) {
        return Err(wrong(format!("does not name {MANIFEST}")));
    }
    let real = fs::canonicalize(folder).map_err(|error| one(at(folder)(error).into()))?;
    let (mut files, mut errors) = (BTreeMap::new(), Vec::new());
    for (name, expected) in sums {
        let path = folder.join(name);
        // Before it is read. Where there is no such path, reading has the error.
        if fs::canonicalize(&path).is_ok_and(|path| !path.starts_with(&real)) {
            errors.push(Error::Outside { path });
            continue;
        }
        match there(&path) {
            Err(fault) => errors.push(fault.into()),
            Ok(bytes) => {
                let found = sha256(&bytes);
                if found == expected {
                    files.insert(name.to_owned(), bytes);
                } else {
                    errors.push(Error::Changed { path, found, expected: expected.to_owned() });
                }
            }
        }
    }
    if errors.is_empty() { Ok(files) } else { Err(errors) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sha256_of_the_standard_example() {
        // [FIPS 180-4, Appendix B.1]
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(b"abc"), expected);
    }

    #[test]
    fn sums_can_be_read_back_and_other_lines_are_refused() {
        let files = BTreeMap::from([("a/b.txt".to_owned(), b"abc".to_vec())]);
        let text = sums(&files);
        assert_eq!(read_sums(&text), Ok(BTreeMap::from([("a/b.txt", sha256(b"abc").as_str())])));
        for (wrong, line) in [
            (text.repeat(2), 2),
            (text.to_uppercase(), 1),
            (text.clone() + "\n", 2),
            (text.replace("  ", " "), 1),
            (text.replace("a/b", "../b"), 1),
            (text.replace("a/b", "/b"), 1),
            (text.clone() + &text.replace("a/b.txt", SUMS), 2),
        ] {
            assert_eq!(read_sums(&wrong), Err(BadLine(line)), "{wrong}");
        }
    }

    fn package() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let files: BTreeMap<String, Vec<u8>> = [(MANIFEST, "{}"), ("wgsl/a.wgsl", "fn a() {}")]
            .map(|(path, text)| (path.to_owned(), text.as_bytes().to_vec()))
            .into();
        fs::create_dir(folder.path().join("wgsl")).unwrap();
        for (path, bytes) in &files {
            fs::write(folder.path().join(path), bytes).unwrap();
        }
        fs::write(folder.path().join(SUMS), sums(&files)).unwrap();
        folder
    }

    #[test]
    fn a_package_opens_as_it_was_written() {
        let folder = package();
        assert_eq!(open(folder.path()).unwrap().len(), 2);
        // A file that the list does not name.
        fs::write(folder.path().join("notes.txt"), "mine").unwrap();
        assert_eq!(open(folder.path()).unwrap().len(), 2);
    }

    /// The errors of a package after a change.
    fn after(change: impl FnOnce(&Path)) -> String {
        let folder = package();
        change(folder.path());
        let errors = open(folder.path()).unwrap_err();
        errors.iter().map(|error| format!("{error}\n")).collect()
    }

    #[test]
    fn what_was_changed_moved_or_lost_is_named() {
        let list = |folder: &Path| fs::read_to_string(folder.join(SUMS)).unwrap();
        let said = after(|folder| fs::write(folder.join("wgsl/a.wgsl"), "fn b() {}").unwrap());
        assert!(said.contains("a.wgsl: was changed"), "{said}");
        let said = after(|folder| fs::write(folder.join(MANIFEST), "{ }").unwrap());
        assert!(said.contains("manifest.json: was changed"), "{said}");
        for name in ["wgsl/a.wgsl", MANIFEST, SUMS] {
            let said = after(|folder| fs::remove_file(folder.join(name)).unwrap());
            assert!(said.contains(name) && said.lines().count() == 1, "{said}");
        }
        let said = after(|folder| {
            let text = list(folder).replace("wgsl/a.wgsl", "../a.wgsl");
            fs::write(folder.join(SUMS), text).unwrap();
        });
        assert!(said.contains("line 2"), "{said}");
        let said = after(|folder| {
            let text = list(folder);
            let second = text.lines().nth(1).unwrap();
            fs::write(folder.join(SUMS), format!("{second}\n")).unwrap();
        });
        assert!(said.contains("does not name manifest.json"), "{said}");
    }

    #[cfg(unix)]
    #[test]
    fn links_lead_nowhere_else_and_devices_are_not_read() {
        use std::os::unix::fs::symlink;
        let elsewhere = package();
        let away = elsewhere.path().join("wgsl/a.wgsl");
        for target in [away.as_path(), Path::new("/dev/zero")] {
            let said = after(|folder| {
                fs::remove_file(folder.join("wgsl/a.wgsl")).unwrap();
                symlink(target, folder.join("wgsl/a.wgsl")).unwrap();
            });
            assert!(said.contains("leads out of the package"), "{said}");
        }
        let said = after(|folder| {
            fs::remove_file(folder.join("wgsl/a.wgsl")).unwrap();
            std::os::unix::net::UnixListener::bind(folder.join("wgsl/a.wgsl")).unwrap();
        });
        assert!(said.contains("no regular file"), "{said}");
        // The folder itself may be a link.
        let folder = package();
        symlink(folder.path(), elsewhere.path().join("link")).unwrap();
        assert_eq!(open(&elsewhere.path().join("link")).unwrap().len(), 2);
    }
}

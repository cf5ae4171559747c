//! The folder of a package: how files come into it, and whether they are what they should be.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::difference::{Change, Difference, Outcome};
use super::error::Error;
use super::options::Options;
use crate::hash;

/// Where the hashes of all other files stand.
pub(super) const SUMS: &str = "SHA256SUMS";

/// Writes `files` into `out` and removes what an earlier run has written there and nothing writes now.
///
/// What differs is first written beside `out` and then renamed into place, the hashes last; a run that is cut off
/// leaves whole files only.
///
/// # Errors
///
/// When a file cannot be read, written, renamed or removed.
pub fn write(out: &Path, files: &BTreeMap<String, Vec<u8>>) -> Result<Outcome, Error> {
    let before = recorded(out)?;
    let mut outcome = Outcome::default();
    for (path, bytes) in files {
        let same = read_if_there_bytes(&out.join(path))?.is_some_and(|found| found == *bytes);
        if same { &mut outcome.unchanged } else { &mut outcome.written }.push(path.clone());
    }
    outcome.removed = before
        .into_keys()
        .filter(|path| !files.contains_key(path) && out.join(path).is_file())
        .collect();
    if !outcome.written.is_empty() {
        replace(out, files, &outcome.written)?;
    }
    for path in &outcome.removed {
        let file = out.join(path);
        fs::remove_file(&file).map_err(at(&file))?;
        // A folder is removed with its last file; one that still has files stays.
        for folder in file.ancestors().skip(1).take_while(|folder| *folder != out) {
            if fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
    Ok(outcome)
}

fn replace(out: &Path, files: &BTreeMap<String, Vec<u8>>, paths: &[String]) -> Result<(), Error> {
    let parent = match out.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    fs::create_dir_all(parent).map_err(at(parent))?;
    let beside =
        tempfile::Builder::new().prefix(".package-").tempdir_in(parent).map_err(at(parent))?;
    let create = |file: &Path| {
        let folder = file.parent().unwrap_or(file);
        fs::create_dir_all(folder).map_err(at(folder))
    };
    for path in paths {
        let file = beside.path().join(path);
        create(&file)?;
        fs::write(&file, files.get(path).map(Vec::as_slice).unwrap_or_default())
            .map_err(at(&file))?;
    }
    let (sums, others): (Vec<_>, Vec<_>) = paths.iter().partition(|path| *path == SUMS);
    for path in others.into_iter().chain(sums) {
        let file = out.join(path);
        create(&file)?;
        fs::rename(beside.path().join(path), &file).map_err(at(&file))?;
    }
    Ok(())
}

/// Compares `out` with `files`.
///
/// # Errors
///
/// Every difference; or that a file cannot be read.
pub fn compare(out: &Path, files: &BTreeMap<String, Vec<u8>>) -> Result<Outcome, Error> {
    let before = recorded(out)?;
    let mut differences = Vec::new();
    let mut unchanged = Vec::new();
    for (path, bytes) in files {
        let change = match read_if_there_bytes(&out.join(path))? {
            None => Change::Missing,
            Some(found) if found == *bytes => {
                unchanged.push(path.clone());
                continue;
            }
            Some(found) => match before.get(path) {
                Some(hash) if *hash != hash::sha256(&found) => Change::ByHand,
                _ => Change::Outdated,
            },
        };
        differences.push(Difference { path: path.clone(), change });
    }
    for path in present(out)? {
        if !files.contains_key(&path) {
            let change = if before.contains_key(&path) { Change::Stale } else { Change::Extra };
            differences.push(Difference { path, change });
        }
    }
    if differences.is_empty() {
        Ok(Outcome { unchanged, ..Outcome::default() })
    } else {
        differences.sort();
        Err(Error::Differs(differences))
    }
}

/// Compares the files of a package with its own `SHA256SUMS`: what was changed by hand, is missing, or was added.
///
/// # Errors
///
/// When a file cannot be read; a package without `SHA256SUMS` misses that file.
pub fn verify_hashes(package: &Path) -> Result<Vec<Difference>, Error> {
    let recorded = recorded(package)?;
    let present = present(package)?;
    let mut differences = Vec::new();
    if !present.contains(SUMS) {
        differences.push(Difference { path: SUMS.to_owned(), change: Change::Missing });
    }
    for (path, hash) in &recorded {
        let change = match read_if_there_bytes(&package.join(path))? {
            None => Change::Missing,
            Some(found) if hash::sha256(&found) != *hash => Change::ByHand,
            Some(_) => continue,
        };
        differences.push(Difference { path: path.clone(), change });
    }
    let extra = present.into_iter().filter(|path| path != SUMS && !recorded.contains_key(path));
    differences.extend(extra.map(|path| Difference { path, change: Change::Extra }));
    differences.sort();
    Ok(differences)
}

/// The hashes in a package's `SHA256SUMS` by path; none if there is no such file.
fn recorded(package: &Path) -> Result<BTreeMap<String, String>, Error> {
    let text = read_if_there(&package.join(SUMS))?.unwrap_or_default();
    let inside = |path: &str| {
        Path::new(path).components().all(|part| matches!(part, std::path::Component::Normal(_)))
    };
    let mut recorded: BTreeMap<_, _> = hash::read_sums(&text)
        .into_iter()
        .filter(|(path, _)| inside(path))
        .map(|(path, hash)| (path.to_owned(), hash.to_owned()))
        .collect();
    recorded.remove(SUMS);
    Ok(recorded)
}

/// The files that lie in a package.
fn present(package: &Path) -> Result<BTreeSet<String>, Error> {
    let mut found = BTreeSet::new();
    let mut folders = vec![package.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries = match fs::read_dir(&folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            Err(error) => return Err(at(&folder)(error)),
        };
        for entry in entries {
            let path = entry.map_err(at(&folder))?.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.insert(crate::source::relative(package, &path));
            }
        }
    }
    Ok(found)
}

fn at(path: &Path) -> impl Fn(io::Error) -> Error {
    let path = path.to_owned();
    move |source| Error::File { path: path.clone(), source }
}

fn read_if_there_bytes(path: &Path) -> Result<Option<Vec<u8>>, Error> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(at(path)(error)),
    }
}

pub(super) fn read_if_there(path: &Path) -> Result<Option<String>, Error> {
    match fs::read_to_string(path) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(at(path)(error)),
    }
}

/// Where it is remembered what a folder was made of.
fn stamp(options: &Options) -> Option<PathBuf> {
    let folder = std::path::absolute(&options.out).ok()?;
    let name = hash::sha256(folder.to_string_lossy().as_bytes());
    Some(options.cache.as_ref()?.join(name))
}

/// All that decides on the files of a folder, the folder's own hashes included.
fn state(source: &str, sums: &[u8]) -> String {
    hash::of_parts([
        ("source", source),
        ("generator", hash::GENERATOR),
        ("sums", &hash::sha256(sums)),
    ])
}

/// The outcome, if the folder is known to be what would be written.
pub(super) fn remembered(options: &Options, source: &str) -> Option<Outcome> {
    let known = fs::read_to_string(stamp(options)?).ok()?;
    let sums = fs::read(options.out.join(SUMS)).ok()?;
    if known != state(source, &sums) || !verify_hashes(&options.out).ok()?.is_empty() {
        return None;
    }
    let mut unchanged: Vec<_> = recorded(&options.out).ok()?.into_keys().collect();
    unchanged.push(SUMS.to_owned());
    unchanged.sort();
    Some(Outcome { unchanged, ..Outcome::default() })
}

pub(super) fn remember(
    options: &Options,
    source: &str,
    files: &BTreeMap<String, Vec<u8>>,
) -> Result<(), Error> {
    let (Some(stamp), Some(sums)) = (stamp(options), files.get(SUMS)) else {
        return Ok(());
    };
    let folder = stamp.parent().unwrap_or(&stamp);
    fs::create_dir_all(folder).map_err(at(folder))?;
    let file = tempfile::NamedTempFile::new_in(folder).map_err(at(folder))?;
    fs::write(file.path(), state(source, sums)).map_err(at(file.path()))?;
    file.persist(&stamp).map_err(|error| at(&stamp)(error.error))?;
    Ok(())
}

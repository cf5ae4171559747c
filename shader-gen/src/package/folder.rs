//! The folder of a package: how files come into it, and whether they are what they should be.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use sglow_seal::{Fault, MANIFEST, SUMS, at, is_inside, listed, read_if_there, read_sums};

use super::difference::{Change, Difference, Outcome};
use super::error::Error;
use super::exchange::{Means, Place};
use super::options::Options;
use crate::hash;

/// Writes `files` into `out` and removes what an earlier run has written there and nothing writes now.
///
/// The folder with what is new in it is filled beside `out`, and both are exchanged; so a run that is cut off leaves the old
/// package or the new one, and the next run removes what else it left. What lies in `out` and belongs to no package goes
/// into the new folder, as do files that stay the same.
///
/// # Errors
///
/// When a file cannot be read, written, renamed or removed.
pub fn write(out: &Path, files: &BTreeMap<String, Vec<u8>>) -> Result<Outcome, Error> {
    Ok(write_by(Means::Exchange, out, files)?)
}

pub(super) fn write_by(
    means: Means,
    out: &Path,
    files: &BTreeMap<String, Vec<u8>>,
) -> Result<Outcome, Fault> {
    let place = Place::take(out)?;
    let out = place.folder();
    let before = recorded(&out)?.unwrap_or_default();
    let mut outcome = Outcome::default();
    for (path, bytes) in files {
        if !is_inside(path) {
            let wrong = io::Error::new(io::ErrorKind::InvalidInput, "leads out of the package");
            return Err(at(Path::new(path))(wrong));
        }
        let same = read_if_there(&out.join(path))?.is_some_and(|found| found == *bytes);
        if same { &mut outcome.unchanged } else { &mut outcome.written }.push(path.clone());
    }
    outcome.removed = before
        .into_keys()
        .filter(|path| !files.contains_key(path) && out.join(path).is_file())
        .collect();
    if !outcome.written.is_empty() || !outcome.removed.is_empty() {
        place.replace(means, |new| fill(new, &out, files, &outcome))?;
    }
    Ok(outcome)
}

/// Fills a new folder with what is written, with what stays the same, and with what else lies in the old one.
fn fill(
    new: &Path,
    old: &Path,
    files: &BTreeMap<String, Vec<u8>>,
    outcome: &Outcome,
) -> Result<(), Fault> {
    let create = |file: &Path| {
        let folder = file.parent().unwrap_or(file);
        fs::create_dir_all(folder).map_err(at(folder))
    };
    for path in &outcome.written {
        let file = new.join(path);
        create(&file)?;
        fs::write(&file, files.get(path).map(Vec::as_slice).unwrap_or_default())
            .map_err(at(&file))?;
    }
    let (present, empty) = listed(old)?;
    // Both are sorted, as the tables that they were made from.
    let has = |list: &[String], path: &String| list.binary_search(path).is_ok();
    let stays = |path: &&String| !has(&outcome.written, path) && !has(&outcome.removed, path);
    for path in present.iter().filter(stays) {
        let (from, to) = (old.join(path), new.join(path));
        create(&to)?;
        // A hard link where the file system has them: times and other attributes stay.
        if fs::hard_link(&from, &to).is_err() {
            fs::copy(&from, &to).map_err(at(&from))?;
        }
    }
    for path in empty {
        let folder = new.join(path);
        fs::create_dir_all(&folder).map_err(at(&folder))?;
    }
    Ok(())
}

/// Removes what runs that have ended left beside `out`, and puts back what one has moved away.
///
/// # Errors
///
/// When it cannot be removed.
pub(super) fn mend(out: &Path) -> Result<(), Fault> {
    let around = std::path::absolute(out).map_err(at(out))?;
    if around.parent().is_some_and(Path::is_dir) { Place::take(out).map(drop) } else { Ok(()) }
}

/// Makes sure that a package can take the place of what is in a folder: nothing, or a package of this generator, whose
/// manifest is the one that its `SHA256SUMS` names. Other files of a package may have been changed; they are written again.
///
/// # Errors
///
/// [`Error::NotOurs`] with what it is instead; when a file cannot be read.
pub fn claim(out: &Path) -> Result<(), Error> {
    #[derive(Deserialize)]
    struct Head {
        generator: Tool,
        #[serde(rename = "schema_version")]
        _version: u32,
        #[serde(rename = "package")]
        _package: String,
    }
    #[derive(Deserialize)]
    struct Tool {
        name: String,
    }
    match fs::read_dir(out) {
        Ok(mut entries) => {
            if entries.next().is_none() {
                return Ok(());
            }
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(at(out)(error).into()),
    }
    let refuse = |why: &str| Err(Error::NotOurs { path: out.to_owned(), why: why.to_owned() });
    let manifest = read_if_there(&out.join(MANIFEST))?;
    let Some(manifest) = manifest else { return refuse("it has files and no `manifest.json`") };
    if read_if_there(&out.join(SUMS))?.is_none() {
        return refuse(
            "it has a `manifest.json` and no `SHA256SUMS`, so that it is another program's",
        );
    }
    let Some(sums) = recorded(out)? else { return refuse("its `SHA256SUMS` is none of a package") };
    if sums.get(MANIFEST) != Some(&hash::sha256(&manifest)) {
        return refuse("its `manifest.json` is not the one that its `SHA256SUMS` names");
    }
    match serde_json::from_slice::<Head>(&manifest) {
        Ok(head) if head.generator.name == env!("CARGO_PKG_NAME") => Ok(()),
        _ => refuse("its `manifest.json` is another program's"),
    }
}

/// Compares `out` with `files`.
///
/// # Errors
///
/// Every difference; or that a file cannot be read.
pub fn compare(out: &Path, files: &BTreeMap<String, Vec<u8>>) -> Result<Outcome, Error> {
    let before = recorded(out)?.unwrap_or_default();
    let mut differences = Vec::new();
    let mut unchanged = Vec::new();
    for (path, bytes) in files {
        let change = match read_if_there(&out.join(path))? {
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
    for path in listed(out)?.0 {
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
    let mut differences = Vec::new();
    let recorded = recorded(package)?;
    let present = BTreeSet::from_iter(listed(package)?.0);
    let change = if present.contains(SUMS) { Change::ByHand } else { Change::Missing };
    if change == Change::Missing || recorded.is_none() {
        differences.push(Difference { path: SUMS.to_owned(), change });
    }
    let recorded = recorded.unwrap_or_default();
    for (path, hash) in &recorded {
        let change = match read_if_there(&package.join(path)) {
            Ok(None) => Change::Missing,
            Ok(Some(found)) if hash::sha256(&found) == *hash => continue,
            Ok(Some(_)) => Change::ByHand,
            // A folder, a pipe or a device in its place.
            Err(fault) if fault.source.kind() == io::ErrorKind::InvalidInput => Change::ByHand,
            Err(fault) => return Err(fault.into()),
        };
        differences.push(Difference { path: path.clone(), change });
    }
    let extra = present.into_iter().filter(|path| path != SUMS && !recorded.contains_key(path));
    differences.extend(extra.map(|path| Difference { path, change: Change::Extra }));
    differences.sort();
    Ok(differences)
}

/// The hashes in a package's `SHA256SUMS` by path: none if there is no such file, nothing if it is not of its form.
fn recorded(package: &Path) -> Result<Option<BTreeMap<String, String>>, Fault> {
    let text = read_if_there(&package.join(SUMS))?.unwrap_or_default();
    let sums = std::str::from_utf8(&text).ok().and_then(|text| read_sums(text).ok());
    let owned = |(path, hash): (&str, &str)| (path.to_owned(), hash.to_owned());
    Ok(sums.map(|sums| sums.into_iter().map(owned).collect()))
}

/// The file of the cache for a folder.
fn stamp(options: &Options) -> Option<PathBuf> {
    let folder = std::path::absolute(&options.out).ok()?;
    let name = hash::sha256(folder.to_string_lossy().as_bytes());
    Some(options.cache.as_ref()?.join(name))
}

/// A hash of all that decides on the files of a folder, the folder's own hashes included.
fn state(source: &str, sums: &[u8]) -> String {
    hash::of_parts([
        ("source", source),
        ("generator", hash::GENERATOR),
        ("sums", &hash::sha256(sums)),
    ])
}

/// The outcome, if by the cache the folder is what would be written.
pub(super) fn remembered(options: &Options, source: &str) -> Option<Outcome> {
    let known = fs::read_to_string(stamp(options)?).ok()?;
    let sums = fs::read(options.out.join(SUMS)).ok()?;
    if known != state(source, &sums) || !verify_hashes(&options.out).ok()?.is_empty() {
        return None;
    }
    let mut unchanged: Vec<_> = recorded(&options.out).ok()??.into_keys().collect();
    unchanged.push(SUMS.to_owned());
    unchanged.sort();
    Some(Outcome { unchanged, ..Outcome::default() })
}

pub(super) fn remember(
    options: &Options,
    source: &str,
    files: &BTreeMap<String, Vec<u8>>,
) -> Result<(), Fault> {
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

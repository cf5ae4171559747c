//! Replaces a folder by another atomically, where the system can.
//!
//! The new folder is filled beside the old one. Where the system exchanges two names in one rename, there is no moment at
//! which the place has neither; elsewhere two renames do it, and the next run puts the old folder back if this one ends
//! between them. What runs that have ended left beside the place is removed by the next one.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use sglow_seal::{Fault, at};

/// The prefix of temporary folders beside the place.
pub(super) const BESIDE: &str = ".sglow-package-";

/// The part of a temporary folder that has the new folder, under the name of the place.
const NEW: &str = "new";
/// As [`NEW`], for what was there before.
const OLD: &str = "old";

/// Without a lock, temporary folders of this age are taken to be abandoned.
const ABANDONED: Duration = Duration::from_hours(1);

/// How a folder takes the place of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Means {
    /// By one rename that exchanges both; by two where the system has no such thing.
    Exchange,
    /// By two renames.
    TwoRenames,
}

/// A place for a folder that no other run changes meanwhile.
#[derive(Debug)]
pub(super) struct Place {
    parent: PathBuf,
    name: OsString,
    /// Released with this, or by the system when the process ends, however it ends.
    lock: Option<File>,
}

impl Place {
    /// Takes the place, when no other run has it any more, and mends what runs that have ended left beside it. A link is
    /// followed to the folder that it means.
    pub(super) fn take(folder: &Path) -> Result<Self, Fault> {
        let folder = std::path::absolute(folder).map_err(at(folder))?;
        let folder = fs::canonicalize(&folder).unwrap_or(folder);
        let named = folder.parent().zip(folder.file_name());
        let Some((parent, name)) = named else {
            let root = io::Error::new(io::ErrorKind::InvalidInput, "has no folder around it");
            return Err(at(&folder)(root));
        };
        fs::create_dir_all(parent).map_err(at(parent))?;
        let lock = lock(parent);
        let place = Self { parent: parent.to_owned(), name: name.to_owned(), lock };
        place.mend()?;
        Ok(place)
    }

    /// The folder.
    pub(super) fn folder(&self) -> PathBuf {
        self.parent.join(&self.name)
    }

    /// Fills a new folder and lets it take the place; then the old one is removed.
    pub(super) fn replace(
        &self,
        means: Means,
        fill: impl FnOnce(&Path) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let folder = self.folder();
        let beside = tempfile::Builder::new().prefix(BESIDE).tempdir_in(&self.parent);
        let beside = beside.map_err(at(&self.parent))?;
        let [new, old] = [NEW, OLD].map(|part| beside.path().join(part).join(&self.name));
        fs::create_dir_all(&new).map_err(at(&new))?;
        failpoint();
        fill(&new)?;
        if let Ok(found) = fs::metadata(&folder) {
            fs::set_permissions(&new, found.permissions()).map_err(at(&new))?;
        }
        failpoint();
        if !folder.exists() {
            fs::rename(&new, &folder).map_err(at(&folder))?;
        } else if means == Means::TwoRenames || exchange(&new, &folder).is_err() {
            let around = beside.path().join(OLD);
            fs::create_dir(&around).map_err(at(&around))?;
            fs::rename(&folder, &old).map_err(at(&folder))?;
            failpoint();
            fs::rename(&new, &folder).map_err(|error| {
                // What was there comes back; if it cannot, the next run puts it back.
                let _ = fs::rename(&old, &folder);
                at(&folder)(error)
            })?;
        }
        failpoint();
        // What stays of it is removed by the next run.
        let _ = beside.close();
        Ok(())
    }

    /// Puts back what a run that ended between two renames has moved away, and removes what such runs left. With the lock
    /// none of it is in use.
    fn mend(&self) -> Result<(), Fault> {
        let entries = fs::read_dir(&self.parent).map_err(at(&self.parent))?;
        for entry in entries.filter_map(Result::ok) {
            let path = entry.path();
            let ours = entry.file_name().to_string_lossy().starts_with(BESIDE);
            let folder = entry.metadata().ok().filter(|found| found.is_dir() && ours);
            // Without a lock it may be in use; then age decides.
            let age = folder.and_then(|found| found.modified().ok()?.elapsed().ok());
            let ended = age.is_some_and(|age| self.lock.is_some() || age > ABANDONED);
            if !ended || !is_beside(&path) {
                continue;
            }
            for moved in fs::read_dir(path.join(OLD)).into_iter().flatten().filter_map(Result::ok) {
                let home = self.parent.join(moved.file_name());
                if fs::symlink_metadata(&home).is_err() {
                    fs::rename(moved.path(), &home).map_err(at(&home))?;
                }
            }
            failpoint();
            fs::remove_dir_all(&path).map_err(at(&path))?;
        }
        Ok(())
    }
}

/// Whether a folder has nothing that this module does not put there.
fn is_beside(path: &Path) -> bool {
    let known = |name: &OsStr| name == NEW || name == OLD;
    fs::read_dir(path).is_ok_and(|mut entries| {
        entries.all(|entry| entry.is_ok_and(|entry| known(&entry.file_name())))
    })
}

/// Waits for a lock on the places in a folder. A file system without locks has none: two runs at once may then undo each
/// other's work, but each leaves a whole folder.
fn lock(parent: &Path) -> Option<File> {
    #[cfg(unix)]
    let file = File::open(parent).ok()?;
    #[cfg(not(unix))]
    let file = File::create(parent.join(".sglow-lock")).ok()?;
    file.lock().ok()?;
    Some(file)
}

/// Exchanges two names in one rename.
#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE)?)
}

/// Exchanges two names in one rename: not on this system.
#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn exchange(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// A point at which a run may be cut off. Tests end the process there.
#[cfg(not(test))]
fn failpoint() {}

#[cfg(test)]
use tests::failpoint;

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::env;
    use std::process::{Command, Stdio};
    use std::sync::atomic::{AtomicUsize, Ordering};

    use sglow_seal::sums;

    use super::*;
    use crate::package::folder::{verify_hashes, write_by};
    use crate::package::{Change, Difference};

    /// The test that [`run`] starts again in a process of its own.
    const CRASH_TEST: &str = concat!(
        "package::exchange::tests::",
        "a_run_that_ends_at_any_moment_leaves_what_the_next_one_mends"
    );

    /// Of that process: which failpoint it ends at, the folder that it writes, and whether by two renames.
    const SETTINGS: [&str; 3] = ["SGLOW_TEST_MOMENT", "SGLOW_TEST_FOLDER", "SGLOW_TEST_RENAMES"];

    /// Ends the process, without cleaning up, at the failpoint whose number its environment has.
    pub(super) fn failpoint() {
        static PASSED: AtomicUsize = AtomicUsize::new(0);
        let end = env::var(SETTINGS[0]).ok().and_then(|number| number.parse().ok());
        if end == Some(PASSED.fetch_add(1, Ordering::Relaxed)) {
            std::process::abort();
        }
    }

    fn package(version: &str) -> BTreeMap<String, Vec<u8>> {
        let mut files: BTreeMap<String, Vec<u8>> = ["a.txt", "deep/b.txt", "deep/er/c.txt"]
            .map(|path| (path.to_owned(), format!("{path} {version}").into_bytes()))
            .into();
        files.insert("same.txt".to_owned(), b"same".to_vec());
        files.insert(format!("{version}/only.txt"), b"only".to_vec());
        let sums = sums(&files);
        files.insert("SHA256SUMS".to_owned(), sums.into_bytes());
        files
    }

    /// Writes the package if this is a process that [`run`] started.
    fn is_started_by_run() -> bool {
        let [Ok(_), Ok(folder), Ok(renames)] = SETTINGS.map(env::var) else { return false };
        let means = if renames == "1" { Means::TwoRenames } else { Means::Exchange };
        write_by(means, Path::new(&folder), &package("new")).unwrap();
        true
    }

    /// Writes the package in a process that ends at a failpoint; whether it came to its end.
    fn run(out: &Path, means: Means, end: usize) -> bool {
        let renames = if means == Means::TwoRenames { "1" } else { "0" };
        let mut command = Command::new(env::current_exe().unwrap());
        command
            .args(["--exact", CRASH_TEST])
            .env(SETTINGS[0], end.to_string())
            .env(SETTINGS[1], out);
        command.env(SETTINGS[2], renames).stdout(Stdio::null()).stderr(Stdio::null());
        command.status().unwrap().success()
    }

    /// Whether a folder has a whole package, beside a file of its user's.
    fn is_whole(out: &Path) -> bool {
        let notes = Difference { path: "deep/notes.txt".to_owned(), change: Change::Extra };
        verify_hashes(out).unwrap() == [notes]
    }

    #[test]
    fn a_run_that_ends_at_any_moment_leaves_what_the_next_one_mends() {
        if is_started_by_run() {
            return;
        }
        for means in [Means::Exchange, Means::TwoRenames] {
            let (mut ended, mut gaps) = (0, 0);
            // The run after a run that has ended may end, too.
            'first: for first in 0.. {
                for second in 0.. {
                    let folder = tempfile::tempdir().unwrap();
                    let out = folder.path().join("out");
                    write_by(means, &out, &package("old")).unwrap();
                    fs::write(out.join("deep/notes.txt"), "mine").unwrap();
                    let whole = || match fs::metadata(&out) {
                        Ok(_) => assert!(is_whole(&out), "{means:?} {first} {second}"),
                        Err(_) => assert_eq!(means, Means::TwoRenames, "{first} {second}"),
                    };
                    if run(&out, means, first) {
                        break 'first;
                    }
                    whole();
                    gaps += usize::from(!out.exists());
                    ended += 1;
                    let finished = run(&out, means, second);
                    whole();
                    write_by(means, &out, &package("new")).unwrap();
                    assert!(is_whole(&out), "{means:?} {first} {second}");
                    assert_eq!(fs::read(out.join("a.txt")).unwrap(), b"a.txt new");
                    assert_eq!(fs::read(out.join("deep/notes.txt")).unwrap(), b"mine");
                    assert!(!out.join("old").exists());
                    // Nothing is left beside it.
                    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
                    if finished {
                        break;
                    }
                }
            }
            // Not a single moment without a package where two names are exchanged; with two renames there is one.
            assert!(ended > 6 && (gaps > 0) == (means == Means::TwoRenames), "{ended} {gaps}");
        }
    }

    #[test]
    fn runs_at_once_leave_one_whole_package() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        write_by(Means::Exchange, &out, &package("old")).unwrap();
        fs::write(out.join("deep/notes.txt"), "mine").unwrap();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for version in ["old", "new", "newer"] {
                        write_by(Means::Exchange, &out, &package(version)).unwrap();
                    }
                });
            }
        });
        assert!(is_whole(&out));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_is_no_folder_of_ours_stays() {
        let folder = tempfile::tempdir().unwrap();
        let other = folder.path().join(".sglow-package-of-somebody");
        fs::create_dir(&other).unwrap();
        fs::write(other.join("thesis.txt"), "mine").unwrap();
        write_by(Means::Exchange, &folder.path().join("out"), &package("new")).unwrap();
        assert!(other.join("thesis.txt").exists());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed_to_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let (out, link) = (folder.path().join("out"), folder.path().join("link"));
        fs::create_dir(&out).unwrap();
        std::os::unix::fs::symlink(&out, &link).unwrap();
        write_by(Means::Exchange, &link, &package("new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert!(verify_hashes(&out).unwrap().is_empty());
    }
}

//! Files that are there whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Cursor, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Duration;

use tempfile::NamedTempFile;

use crate::failure::{Context as _, Failure, Result};

/// What a file is written through.
pub trait Sink: Write + Seek {}
impl<T: Write + Seek> Sink for T {}

/// Whether a path means standard output: `-`, or what the system calls so.
#[must_use]
pub fn is_stdout(path: &Path) -> bool {
    ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].iter().any(|name| Path::new(name) == path)
}

/// Whether an argument of this process makes standard output a file that is written: messages go to standard error then.
#[must_use]
pub fn stdout_is_taken() -> bool {
    static TAKEN: LazyLock<bool> = LazyLock::new(|| {
        let arguments = std::env::args_os().skip(1);
        let names = arguments.map(|argument| argument.to_string_lossy().into_owned());
        let mut names = names.filter_map(|name| name.split('=').next_back().map(PathBuf::from));
        names.any(|name| is_stdout(&name))
    });
    *TAKEN
}

/// Writes a file beside its place and renames it; missing folders are made.
///
/// A link is followed to the file that it means. `-` is standard output. What is there and no regular file, such as a device or a
/// pipe, is written through: it is no file that could be half-written.
///
/// # Errors
///
/// When the folder or the file cannot be written, or `fill` fails; then nothing is left behind.
pub fn file<E: Into<Failure>>(
    path: &Path,
    fill: impl FnOnce(&mut dyn Sink) -> Result<(), E>,
) -> Result {
    match target(path)? {
        Target::File(path) => persist(beside(&path, fill)?, &path),
        through => {
            let mut bytes = Cursor::new(Vec::new());
            let place = path.display();
            fill(&mut bytes).map_err(Into::into).context(format!("{place}: cannot write"))?;
            let mut out: Box<dyn Write> = match through {
                Target::Stdout => Box::new(io::stdout().lock()),
                _ => Box::new(open(path).context(format!("{place}: cannot write"))?),
            };
            let written = out.write_all(&bytes.into_inner()).and_then(|()| out.flush());
            written.context(format!("{place}: cannot write"))
        }
    }
}

/// What a path leads to.
#[derive(Debug, PartialEq)]
enum Target {
    /// A file, which a rename replaces.
    File(PathBuf),
    /// Standard output.
    Stdout,
    /// A device or a pipe, or anything below /dev, /proc or /sys: written in place.
    Through,
}

fn target(path: &Path) -> Result<Target> {
    let place = path.display();
    if is_stdout(path) {
        return Ok(Target::Stdout);
    }
    let of_system = std::path::absolute(path)
        .is_ok_and(|path| ["/dev", "/proc", "/sys"].iter().any(|folder| path.starts_with(folder)));
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(Failure::new(format!("{place}: is a folder"))),
        Ok(found) if of_system || !found.is_file() => Ok(Target::Through),
        Ok(_) => Ok(Target::File(fs::canonicalize(path).context(&place)?)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            // A link to a file that is not there yet.
            let linked =
                fs::read_link(path).map(|to| path.parent().unwrap_or(Path::new("")).join(to));
            match linked {
                Ok(to) if fs::symlink_metadata(&to).is_err() => Ok(Target::File(to)),
                Ok(_) => Err(Failure::new(format!("{place}: is a link that leads to no file"))),
                Err(_) => Ok(Target::File(path.to_owned())),
            }
        }
        // Its folder is a file; or its name is too long.
        Err(error) => Err(error).context(format!("{place}: cannot write")),
    }
}

/// Opens what is no regular file, without waiting for a reader of a pipe that has none.
fn open(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.write(true);
    #[cfg(target_os = "linux")]
    let _reader_is_there = {
        use std::os::unix::fs::OpenOptionsExt as _;
        // O_NONBLOCK: a pipe without a reader is an error.
        let first = options.custom_flags(0o4000).open(path)?;
        options.custom_flags(0);
        // Kept until it is opened again, for without a writer its reader ends.
        first
    };
    options.open(path)
}

/// Writes several files as [`file()`] does, which belong together: none takes its place before all are written.
pub fn texts(files: &[(&Path, &str)]) -> Result {
    let write = |&(path, text): &(&Path, &str)| {
        let Target::File(path) = target(path)? else {
            let text = format!(
                "{}: is not a regular file, and can only be written together with others",
                path.display()
            );
            return Err(Failure::new(text));
        };
        Ok((beside(&path, |sink| sink.write_all(text.as_bytes()))?, path))
    };
    let written = files.iter().map(write).collect::<Result<Vec<_>>>()?;
    written.into_iter().try_for_each(|(file, path)| persist(file, &path))
}

/// Makes sure that a file can be written, before much work is done for it.
///
/// # Errors
///
/// When it is a folder, its name is too long, or its folder may not be written.
pub fn probe_file(path: &Path) -> Result {
    match target(path)? {
        Target::File(path) => probe(match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        }),
        Target::Stdout | Target::Through => Ok(()),
    }
}

/// `picture.png` as `picture.NAME.png`.
#[must_use]
pub fn named(path: &Path, name: &str) -> PathBuf {
    let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
    path.with_extension(format!("{name}.{extension}"))
}

/// Where a command that writes `out` writes its report: to `json`, or beside `out`. Both can be written, and what else is
/// written beside `out`.
///
/// # Errors
///
/// As [`probe_file`] and [`probe_report`].
pub fn probe_pair(out: &Path, json: Option<&Path>, others: &[PathBuf]) -> Result<PathBuf> {
    probe_file(out)?;
    others.iter().try_for_each(|other| probe_file(other))?;
    let beside = out.with_extension("json");
    match json {
        Some(json) => probe_file(json),
        None => probe_report(&beside),
    }?;
    Ok(json.map_or(beside, Path::to_owned))
}

/// As [`probe_file`], for a report that is written beside something else without being named: what is there already has to be
/// such a report, and no file of the user's.
///
/// # Errors
///
/// As [`probe_file`], and when another file is there.
pub fn probe_report(path: &Path) -> Result {
    probe_file(path)?;
    let ours = |text: &[u8]| {
        let report = serde_json::from_slice::<serde_json::Value>(text).ok()?;
        report.get("versions")?.get("sglow")?;
        report.get("checks").map(drop)
    };
    match fs::read(path) {
        Ok(text) if ours(&text).is_none() => Err(Failure::new(format!(
            "{}: would be replaced, but is not a report of sglow",
            path.display()
        ))
        .help("name another file: `--json FILE`")),
        _ => Ok(()),
    }
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
        .prefix(BESIDE.0)
        .rand_bytes(BESIDE.1)
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
    sweep(&folder);
    let file = builder.prefix(BESIDE.0).rand_bytes(BESIDE.1).tempfile_in(&folder);
    let file = file.context(format!("{place}: cannot write"))?;
    // Marks it as in use until the process ends, however it ends.
    let _ = file.as_file().try_lock();
    let mut writer = BufWriter::new(file);
    fill(&mut writer).map_err(Into::into).context(format!("{place}: cannot write"))?;
    writer
        .into_inner()
        .map_err(io::IntoInnerError::into_error)
        .context(format!("{place}: cannot write"))
}

/// The prefix of files beside their place, and how many letters and digits follow it.
const BESIDE: (&str, usize) = (".sglow-part-", 6);

/// Whether a file is named as those beside their place are: nobody else's file is to be taken for one.
fn is_beside(name: &str) -> bool {
    let random = name.strip_prefix(BESIDE.0);
    random.is_some_and(|random| {
        random.len() == BESIDE.1 && random.bytes().all(|byte| byte.is_ascii_alphanumeric())
    })
}

/// Removes files that runs that have ended left in a folder: they are no longer locked.
fn sweep(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if !is_beside(&entry.file_name().to_string_lossy()) {
            continue;
        }
        let Some(found) = entry.metadata().ok().filter(fs::Metadata::is_file) else { continue };
        let age = found.modified().ok().and_then(|time| time.elapsed().ok());
        // What is new may be about to be locked.
        let ended = || File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok());
        if age.is_some_and(|age| age > Duration::from_mins(1)) && ended() {
            let _ = fs::remove_file(entry.path());
        }
    }
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

    #[cfg(unix)]
    #[test]
    fn what_is_no_regular_file_is_written_through_and_links_are_followed() {
        use std::os::unix::fs::{FileTypeExt as _, symlink};
        text(Path::new("/dev/null"), "gone").unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        if Path::new("/dev/full").exists() {
            let full = text(Path::new("/dev/full"), "too much").unwrap_err().to_string();
            assert!(full.contains("/dev/full: cannot write"), "{full}");
        }
        for name in ["-", "/dev/stdout"] {
            assert_eq!(target(Path::new(name)).unwrap(), Target::Stdout);
        }
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("other")).unwrap();
        fs::write(path("other/file"), "old").unwrap();
        for (link, to) in [("link", "other/file"), ("again", "link"), ("new", "other/new")] {
            symlink(to, path(link)).unwrap();
        }
        for (link, file) in [("link", "other/file"), ("again", "other/file"), ("new", "other/new")]
        {
            text(&path(link), link).unwrap();
            assert!(fs::symlink_metadata(path(link)).unwrap().is_symlink());
            assert_eq!(fs::read_to_string(path(file)).unwrap(), link);
        }
        // A pipe: its reader gets what is written, and it stays one.
        let pipe = path("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        assert!(text(&pipe, "nobody reads").is_err());
        let reader = {
            let pipe = pipe.clone();
            std::thread::spawn(move || fs::read_to_string(pipe))
        };
        while text(&pipe, "read").is_err() {}
        assert_eq!(reader.join().unwrap().unwrap(), "read");
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        assert!(texts(&[(&pipe, "a")]).is_err());
    }

    #[test]
    fn what_cannot_be_written_is_found_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        probe_file(&path("new/deep.png")).unwrap();
        fs::create_dir(path("folder.png")).unwrap();
        assert!(probe_file(&path("folder.png")).unwrap_err().to_string().contains("is a folder"));
        let long = path(&("a".repeat(260) + ".png"));
        assert!(probe_file(&long).unwrap_err().to_string().contains("cannot write"));
        fs::write(path("mine.json"), "{ \"mine\": 1 }").unwrap();
        let said = probe_report(&path("mine.json")).unwrap_err().to_string();
        assert!(said.contains("would be replaced") && said.contains("--json"), "{said}");
        crate::json::Report::new().write(&path("ours.json")).unwrap();
        for name in ["ours.json", "new.json"] {
            probe_report(&path(name)).unwrap();
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "nothing is left behind");
    }

    #[test]
    fn what_runs_that_have_ended_left_is_swept() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let old = std::time::SystemTime::now() - Duration::from_hours(1);
        let names =
            [".sglow-part-ended1", ".sglow-part-locked", ".sglow-part-new123", ".sglow-notes"];
        let files = names.map(|name| {
            let file = File::create(path(name)).unwrap();
            if name != names[2] {
                file.set_modified(old).unwrap();
            }
            file
        });
        files[1].lock().unwrap();
        text(&path("out"), "out").unwrap();
        assert_eq!(names.map(|name| path(name).exists()), [false, true, true, true]);
        assert!(path("out").exists());
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
            if let Some(text) = manifest {
                fs::write(folder.path().join("manifest.json"), text).unwrap();
            }
            let text = probe_package(folder.path()).unwrap_err().to_string();
            assert!(text.contains("would replace files"), "{text}");
        }
        assert!(probe_package(&folder.path().join("README.md")).is_err());
    }
}

//! A library that has nothing to do with light, generated, broken on purpose, and compared with the `wesl` crate.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "helpers of tests are tests, too"
)]

mod errors;
mod foreign;
mod functions;
mod language;
mod overlay;
mod package;
mod proof;
mod second_opinion;
mod texts;

use std::fs;
use std::path::{Path, PathBuf};

use sglow_shader_gen::library::Library;

/// The folder of the foreign library.
fn foreign_root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign")
}

fn foreign_library() -> Library {
    Library::load(&foreign_root()).unwrap_or_else(|report| panic!("{report}"))
}

/// A copy of the foreign library with, in each file named, the second text in place of the first.
fn edited(edits: &[(&str, &str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    edited_in(&foreign_root(), folder.path(), edits);
    folder
}

/// Copies a folder, with the edits of [`edited`].
fn edited_in(root: &Path, folder: &Path, edits: &[(&str, &str, &str)]) {
    copy(root, folder);
    for (file, from, to) in edits {
        let path = folder.join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file} lacks {from}");
        fs::write(path, text.replacen(from, to, 1)).unwrap();
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

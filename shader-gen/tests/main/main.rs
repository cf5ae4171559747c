//! A library that has nothing to do with light, generated whole, broken on purpose, and read by somebody else.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "helpers of tests are tests, too"
)]

mod errors;
mod foreign;
mod package;
mod proof;
mod second_opinion;

use std::path::{Path, PathBuf};

use sglow_shader_gen::library::Library;

/// The folder of the foreign library.
fn foreign_root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign")
}

fn foreign_library() -> Library {
    Library::load(&foreign_root()).unwrap_or_else(|report| panic!("{report}"))
}

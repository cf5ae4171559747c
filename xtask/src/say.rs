//! Standard output, whose reader may leave early: `cargo xtask variants | head` is no fault of ours.

use std::fmt;
use std::io::{Write as _, stdout};

/// Prints a line.
pub(crate) fn line(text: impl fmt::Display) {
    let _ = writeln!(stdout().lock(), "{text}");
}

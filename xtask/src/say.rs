//! Standard output, whose reader may leave early: `cargo xtask variants | head` is no fault of ours.

use std::fmt;
use std::io::{Write as _, stderr, stdout};

use sglow_report::write::stdout_is_taken;

/// Prints a line; to standard error if a file that is written is standard output.
pub(crate) fn line(text: impl fmt::Display) {
    let _ = if stdout_is_taken() {
        writeln!(stderr(), "{text}")
    } else {
        writeln!(stdout().lock(), "{text}")
    };
}

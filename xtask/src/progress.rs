//! What long work shows while it lasts: on standard error, a bar on a terminal and a line elsewhere.

use std::io::{IsTerminal as _, stderr};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// Work whose length is not known.
pub(crate) fn spinner(doing: impl Into<String>) -> ProgressBar {
    let doing = doing.into();
    if !stderr().is_terminal() {
        eprintln!("{doing} …");
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner().with_message(doing);
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} [{elapsed}]") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}

/// Work of `length` steps.
pub(crate) fn bar(doing: impl Into<String>, length: usize) -> ProgressBar {
    let doing = doing.into();
    if !stderr().is_terminal() {
        eprintln!("{doing} ({length}) …");
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(length as u64).with_message(doing);
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} [{elapsed}]") {
        bar.set_style(style);
    }
    bar
}

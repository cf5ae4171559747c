//! What long work shows while it lasts: on standard error, a bar on a terminal and a line elsewhere.

use std::io::{IsTerminal as _, stderr};
use std::sync::Mutex;
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
    if let Ok(style) =
        ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} [{elapsed}, {eta} to go]")
    {
        bar.set_style(style);
    }
    bar
}

/// One bar after the other, for work that reports its progress.
#[derive(Default)]
pub(crate) struct Bars(Mutex<Option<ProgressBar>>);

impl Bars {
    /// Takes the last one away.
    pub(crate) fn clear(&self) {
        self.replace(None);
    }

    fn replace(&self, next: Option<ProgressBar>) {
        if let Ok(mut shown) = self.0.lock()
            && let Some(last) = std::mem::replace(&mut *shown, next)
        {
            last.finish_and_clear();
        }
    }
}

impl sglow_results::progress::Progress for Bars {
    fn start(&self, what: &str, steps: usize) {
        self.replace(Some(if steps == 0 { spinner(what) } else { bar(what, steps) }));
    }

    fn note(&self, text: &str) {
        eprintln!("{text}");
    }

    fn end(&self) {
        self.clear();
    }

    fn done(&self, steps: usize) {
        if let Ok(shown) = self.0.lock()
            && let Some(bar) = &*shown
        {
            bar.set_position(steps as u64);
        }
    }
}

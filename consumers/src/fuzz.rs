//! The targets of `sglow-fuzz`, all in turn, for a time: each is a test that a crate has for the input that it reads.

use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Serialize;
use sglow_report::failure::{Context as _, Failure, Result};
use sglow_report::json::Report;
use sglow_results::check::{Check, Relation};

use crate::machine::{repository, target_folder};

/// Targets by their name in the output. A test of this crate compares them with the sources.
pub const TARGETS: [&str; 7] =
    ["command-line", "image", "library", "overlay", "package", "scene", "setting"];

/// What became of a target.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Outcome {
    /// Its name.
    pub target: String,
    /// Inputs that were refused.
    pub refused: u64,
    /// Inputs that were taken.
    pub taken: u64,
}

impl fmt::Display for Outcome {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}: {} refused, {} taken", self.target, self.refused, self.taken)
    }
}

/// The lines that targets print at their end.
fn outcomes(text: &str) -> Vec<Outcome> {
    let read = |line: &str| {
        let (target, rest) = line.split_once(": ")?;
        let (refused, rest) = rest.split_once(" refused, ")?;
        let (refused, taken) = (refused.parse().ok()?, rest.strip_suffix(" taken")?.parse().ok()?);
        // Whatever the test runner has printed before it on the same line.
        let target = target.rsplit(' ').next()?.trim_start_matches('.').to_owned();
        Some(Outcome { target, refused, taken })
    };
    text.lines().filter_map(read).collect()
}

/// Runs all targets for `minutes` in all, from a seed on, and puts what became of them into `report`.
///
/// # Errors
///
/// When cargo does not run.
pub fn run(minutes: u64, seed: u64, report: &mut Report) -> Result<Vec<Outcome>> {
    let seconds = (60 * minutes).div_ceil(TARGETS.len() as u64).max(1);
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args([
        "test",
        "--quiet",
        "--workspace",
        "--no-fail-fast",
        "--test",
        "mutate",
        "--bin",
        "xtask",
    ]);
    command.args(["--", "mutated", "--nocapture", "--test-threads", "1"]);
    command.current_dir(repository()).env("SGLOW_SEED", seed.to_string());
    command.env("RUST_BACKTRACE", "0").env("SGLOW_FUZZ_SECONDS", seconds.to_string());
    let output = command.output().context("cargo does not run")?;
    let said = String::from_utf8_lossy(&output.stdout);
    let found = outcomes(&said);
    let kept = kept(&target_folder().join("fuzz"));
    let missing = TARGETS.iter().filter(|name| !found.iter().any(|one| one.target == **name));
    let missing: Vec<&str> = missing.copied().collect();
    let inputs: u64 = found.iter().map(|one| one.refused + one.taken).sum();
    report.check(Check::new("inputs tried", inputs as f64, "inputs", Relation::AtLeast, 1.0));
    let failed = missing.len() as f64;
    let check = Check::new(
        "targets that did not come to their end",
        failed,
        "targets",
        Relation::Equal,
        0.0,
    );
    report.check(check.note(missing.join(", ")));
    report.detail("seconds_per_target", seconds)?;
    report.detail("seed", seed)?;
    report.detail("targets", &found)?;
    if found.is_empty() || (missing.is_empty() && !output.status.success()) {
        // Nothing was built, or an assertion after all inputs failed.
        return Err(Failure::new(String::from_utf8_lossy(&output.stderr).into_owned()));
    }
    if !missing.is_empty() {
        eprintln!("{}", String::from_utf8_lossy(&output.stderr));
        kept.iter().for_each(|path| eprintln!("a failing input: {}", path.display()));
    }
    Ok(found)
}

/// Inputs that a target that did not come to its end has left.
fn kept(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut kept: Vec<_> = entries.map(|entry| entry.path()).collect();
    kept.sort();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_targets_print_is_read() {
        let text = "running 2 tests\ntest no_mutated_x ... image: 12 refused, 3 taken\nok\n.scene: 1 refused, 0 taken\n";
        let of =
            |target: &str, refused, taken| Outcome { target: target.to_owned(), refused, taken };
        assert_eq!(outcomes(text), [of("image", 12, 3), of("scene", 1, 0)]);
    }

    #[test]
    fn every_target_of_the_sources_is_run() {
        let mut found = Vec::new();
        for file in ["report/tests", "runtime/tests", "scene/tests", "shader-gen/tests"]
            .map(|folder| format!("{folder}/mutate.rs"))
            .into_iter()
            .chain(["xtask/src/cli.rs".to_owned()])
        {
            let text = std::fs::read_to_string(repository().join(file)).unwrap();
            let names = text.split("Target::new(\"").skip(1);
            found.extend(names.map(|rest| rest.split('"').next().unwrap_or_default().to_owned()));
        }
        found.sort();
        assert_eq!(found, TARGETS);
    }
}

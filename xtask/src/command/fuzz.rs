//! `fuzz`: mutated inputs of every kind, for a time.

use std::path::PathBuf;

use clap::Args;
use sglow_consumers::fuzz;
use sglow_report::failure::Result;
use sglow_report::json::Report;

use crate::{progress, say};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask fuzz --minutes 10
  cargo xtask fuzz --minutes 60 --seed 7 --json out/fuzz.json

No input may panic, overflow the stack, take longer than 10 s or more than 2 GB. Failing inputs are kept in target/fuzz.";

/// Options of `fuzz`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// How long all targets take together
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=10080))]
    minutes: u64,
    /// Seed of the mutations
    #[arg(long, value_name = "NUMBER", default_value_t = 2)]
    seed: u64,
    /// Also write what was tried as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Mutates.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let bar = progress::spinner(format!("{} minutes of mutated inputs", arguments.minutes));
    let mut report = Report::new();
    let found = fuzz::run(arguments.minutes, arguments.seed, &mut report)?;
    bar.finish_and_clear();
    found.iter().for_each(say::line);
    arguments.json.as_ref().map_or(Ok(()), |path| report.write(path))?;
    report.verdict()
}

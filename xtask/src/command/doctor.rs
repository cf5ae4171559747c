//! `doctor`: what this machine has and lacks.

use std::path::PathBuf;

use clap::Args;
use sglow_consumers::doctor::{Finding, findings, show};
use sglow_consumers::machine::vulkan::Vulkan;
use sglow_report::failure::Result;
use sglow_report::json::Report;

use crate::say;

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask doctor
  cargo xtask doctor --json out/doctor.json

Exits with an error if something is missing without which the tests cannot run.";

/// Options of `doctor`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Also write what was found as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Looks and prints.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let vulkan = Vulkan::find();
    let adapters = sglow_renderer::device::list();
    let line = |adapter: &sglow_renderer::device::AdapterFacts| {
        let kind = if adapter.software { "software" } else { "hardware" };
        format!("{} ({kind}, {}, {})", adapter.name, adapter.backend, adapter.driver)
    };
    let findings = findings(&vulkan, &adapters.iter().map(line).collect::<Vec<_>>());
    say::line(show(&findings));
    let mut report = Report::new();
    report.checks(findings.iter().filter(|one| one.required).map(Finding::check));
    report.detail("vulkan", &vulkan)?;
    report.detail("findings", &findings)?;
    arguments.json.as_ref().map_or(Ok(()), |path| report.write(path))?;
    report.verdict()
}

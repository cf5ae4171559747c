//! `cost`: what a GPU compiler makes of every variant, without that GPU.

use std::path::PathBuf;

use clap::Args;
use sglow_consumers::cost::{self, FAMILIES};
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;

use crate::progress::Bars;
use crate::say;

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask cost
  cargo xtask cost --family navi21 --variant sort_scan --json out/cost.json

Mesa's RADV compiles for a family of AMD GPUs on any machine. Figures of the same driver and version are compared with
those in docs/costs; spilled registers fail always. Caches, bandwidth and divergence are in none of them.";

/// Options of `cost`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Families of GPUs, as the driver names them
    #[arg(long, value_name = "NAME", value_delimiter = ',', default_values_t = FAMILIES.map(str::to_owned))]
    family: Vec<String>,
    /// Only these variants, by their identifiers
    #[arg(long, value_name = "ID", value_delimiter = ',', conflicts_with = "write")]
    variant: Vec<String>,
    /// Replace the committed figures
    #[arg(long)]
    write: bool,
    /// Also write every figure as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Compile what standard input requests: for the program itself
    #[arg(long, hide = true)]
    serve: bool,
}

/// Compiles and prints.
pub(crate) fn run(arguments: &Arguments) -> Result {
    if arguments.serve {
        return sglow_cost::serve().map_err(|error| Failure::new(error.to_string()));
    }
    let (bars, mut report) = (Bars::default(), Report::new());
    let Arguments { family, variant, write, .. } = arguments;
    let tables = cost::run(family, variant, *write, &bars, &mut report);
    bars.clear();
    for (title, table) in tables? {
        say::line(format!("{title}\n{table}"));
    }
    say::line(report.table());
    arguments.json.as_ref().map_or(Ok(()), |path| report.write(path))?;
    report.verdict()
}

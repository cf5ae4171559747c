//! `docs`: measures the tables of `docs/` that no other command writes.

use clap::Args;
use sglow_consumers::machine::repository;
use sglow_measure::{cuts, light_maps, partitions, references, specular};
use sglow_report::docs;
use sglow_report::docs::cuts::of_cuts;
use sglow_report::docs::marks;
use sglow_report::docs::references::{Measured, of_references, of_settings};
use sglow_report::docs::specular::of_specular;
use sglow_report::failure::Result;
use sglow_results::light_maps::PATHS;
use sglow_results::picture_error::Metric;

use crate::options::Over;
use crate::progress::Bars;
use crate::{options, say};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask docs
  cargo xtask docs --only references

Measures the errors of the references (docs/references.md), what the parameters of lights' maps do and what cuts take
(docs/numerics.md) and the error of specular models (docs/results.md), prints the tables and writes them between their marks; the text around them stays. The other
tables are written by `report --write-docs`, `stability --write-docs` and `reproduce --write-docs`.";

/// Options of `docs`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Only these tables; may be given more than once
    #[arg(long, value_enum, value_name = "TABLES")]
    only: Vec<Tables>,
    /// Print the tables without writing them
    #[arg(long)]
    dry_run: bool,
    /// The GPU whose name contains this [default: the most capable one]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Tables that are measured together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Tables {
    /// The errors of the references
    References,
    /// What the parameters of lights' maps do
    Visibility,
    /// Lights made by kernels, clusters and cuts
    Partitions,
    /// Lengths and errors of cuts
    Cuts,
    /// The error of specular models
    Specular,
}

/// Measures, prints and writes.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let gpu = options::open(arguments.adapter.as_deref())?;
    let chosen = |tables| arguments.only.is_empty() || arguments.only.contains(&tables);
    let bars = Bars::default();
    let mut tables = Vec::new();
    if chosen(Tables::References) {
        tables.extend(of_references(&references::all(&gpu, &bars)?));
    }
    let package = Over::default().whole_space()?;
    if chosen(Tables::Visibility) {
        let (what, size, paths) = ("visibility", light_maps::base().size, PATHS);
        let metrics = &[Metric::RelativeMse, Metric::Rmse, Metric::Flip, Metric::Bias];
        let measured = Measured { what, size, paths, metrics };
        tables.push(of_settings(&measured, &light_maps::all(&gpu, &package, &bars)?));
    }
    if chosen(Tables::Partitions) {
        let (what, size, paths) = ("partitions", partitions::base().size, partitions::PATHS);
        let measured = Measured { what, size, paths, metrics: &Metric::ALL };
        tables.push(of_settings(&measured, &partitions::all(&gpu, &package, &bars)?));
    }
    if chosen(Tables::Cuts) {
        tables.push(of_cuts(cuts::base().size, cuts::WIDER, &cuts::all(&gpu, &package, &bars)?));
    }
    if chosen(Tables::Specular) {
        tables.push(of_specular(&specular::errors()));
    }
    for table in &tables {
        say::line(&table.text);
    }
    if arguments.dry_run {
        return Ok(());
    }
    for table in &tables {
        let written = |text: &str, name: &str| marks::replaced(text, name, table.mark, &table.text);
        let path = docs::update(&repository(), table.document, written)?;
        say::line(format!("{}: {}", path.display(), table.mark));
    }
    Ok(())
}

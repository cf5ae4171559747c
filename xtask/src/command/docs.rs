//! `docs`: measures the tables of `docs/` that no other command writes.

use std::fs;
use std::path::PathBuf;

use clap::Args;
use sglow_consumers::machine::repository;
use sglow_measure::{light_maps, references};
use sglow_renderer::device::Gpu;
use sglow_report::docs::marks;
use sglow_report::docs::references::{of_references, of_visibility};
use sglow_report::failure::{Context as _, Result};
use sglow_report::write;
use sglow_results::light_maps::OnScene;
use sglow_results::references::ReferenceErrors;
use sglow_runtime::package::Package;
use sglow_scene::Scene;

use crate::options::Over;
use crate::{options, progress, say};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask docs
  cargo xtask docs --only references

Measures the errors of the references (docs/references.md) and what the parameters of lights' maps do (docs/numerics.md) on
built-in scenes, prints the tables and writes them between their marks; the text around them stays. docs/deviations.md is
written by `report --write-docs`.";

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
}

/// Measures, prints and writes.
///
/// # Errors
///
/// When a scene does not render or cannot be traced, or a document lacks its marks.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let gpu = options::open(arguments.adapter.as_deref())?;
    let chosen = |tables| arguments.only.is_empty() || arguments.only.contains(&tables);
    let mut tables = Vec::new();
    if chosen(Tables::References) {
        tables.extend(of_references(&measured_references(&gpu)?));
    }
    if chosen(Tables::Visibility) {
        tables.push(of_visibility(light_maps::base().size, &measured_visibility(&gpu)?));
    }
    for table in &tables {
        say::line(&table.text);
    }
    if arguments.dry_run {
        return Ok(());
    }
    for table in &tables {
        let path: PathBuf = repository().join(table.document);
        let document =
            fs::read_to_string(&path).context(format!("cannot read {}", path.display()))?;
        write::text(&path, &marks::replaced(&document, table.document, table.mark, &table.text)?)?;
        say::line(format!("{}: {}", path.display(), table.mark));
    }
    Ok(())
}

fn measured_references(gpu: &Gpu) -> Result<Vec<ReferenceErrors>> {
    let bar = progress::bar("references", references::SCENES.len());
    let mut all = Vec::new();
    for name in references::SCENES {
        bar.set_message(name);
        let scene = Scene::load(name)?;
        all.push(references::measure(gpu, &Package::embedded(), name, &scene)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(all)
}

fn measured_visibility(gpu: &Gpu) -> Result<Vec<(&'static str, Vec<OnScene>)>> {
    let package = Over::default().whole_space()?;
    let bar = progress::bar("maps of lights", light_maps::SCENES.len());
    let mut all = Vec::new();
    for name in light_maps::SCENES {
        bar.set_message(name);
        all.push((name, light_maps::measure(gpu, &package, Scene::load(name)?)?));
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(all)
}

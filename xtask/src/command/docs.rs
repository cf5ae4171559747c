//! `docs`: measures the tables of `docs/` that no other command writes.

use std::fs;
use std::path::PathBuf;

use clap::Args;
use sglow_measure::{light_maps, references};
use sglow_renderer::device::Gpu;
use sglow_results::light_maps::OnScene;
use sglow_results::picture_error::Metric;
use sglow_results::references::{FINEST, MAPS, MapError, Noise, PATHS, ReferenceErrors, SIZE};
use sglow_runtime::package::Package;
use sglow_scene::Scene;

use crate::failure::{Context as _, Result};
use crate::machine::repository;
use crate::selection::whole_space;
use crate::{marks, picture_error, progress, say, shot, write};

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

/// A measured table and its place.
struct Table {
    /// The document, below the repository.
    document: &'static str,
    /// Its marks.
    mark: &'static str,
    text: String,
}

/// Measures, prints and writes.
///
/// # Errors
///
/// When a scene does not render or cannot be traced, or a document lacks its marks.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let gpu = shot::open(arguments.adapter.as_deref())?;
    let chosen = |tables| arguments.only.is_empty() || arguments.only.contains(&tables);
    let mut tables = Vec::new();
    if chosen(Tables::References) {
        tables.extend(of_references(&measured_references(&gpu)?));
    }
    if chosen(Tables::Visibility) {
        tables.push(of_visibility(&measured_visibility(&gpu)?));
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
    let package = whole_space()?;
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

/// The facets of coarse maps against those of a fine one, and the noise of paths.
fn of_references(all: &[ReferenceErrors]) -> [Table; 2] {
    let [width, height] = SIZE;
    let mut facets = format!(
        "Measured by `cargo xtask docs --only references`: {width} x {height} pixels, against the facets of a map of {FINEST} x {FINEST}.\n\n"
    );
    let maps: Vec<String> = MAPS.iter().map(u32::to_string).collect();
    let maps = maps.join(", ");
    facets.push_str(&format!(
        "| scene | RMSE over the mean at {maps} | median of the relative error |\n|---|---|---|\n"
    ));
    let mut noise = format!(
        "Measured by the same command: {PATHS} paths for each pixel.\n\n\
         | scene | by directions alone | with the light's map |\n|---|---|---|\n"
    );
    for one in all {
        let percents = |digits: usize, of: &dyn Fn(&MapError) -> f64| {
            let numbers: Vec<String> =
                one.facets.iter().map(|map| format!("{:.digits$}", 100.0 * of(map))).collect();
            numbers.join(", ") + " %"
        };
        facets.push_str(&format!(
            "| {} | {} | {} |\n",
            one.scene,
            percents(1, &|map| map.rmse_over_mean),
            percents(2, &|map| map.median)
        ));
        let both = |noise: &Noise| {
            format!("{:.2} / {:.2} %", 100.0 * noise.stated, 100.0 * noise.by_halves)
        };
        noise.push_str(&format!(
            "| {} | {} | {} |\n",
            one.scene,
            both(&one.by_directions),
            both(&one.guided)
        ));
    }
    let document = "docs/references.md";
    [
        Table { document, mark: "measured maps", text: facets },
        Table { document, mark: "measured paths", text: noise },
    ]
}

/// What is shown of each picture.
const METRICS: [Metric; 4] = [Metric::RelativeMse, Metric::Rmse, Metric::Flip, Metric::Bias];

/// What each setting of lights' maps does to the picture.
fn of_visibility(all: &[(&'static str, Vec<OnScene>)]) -> Table {
    let [width, height] = light_maps::base().size;
    let paths = light_maps::PATHS;
    let titles: Vec<&str> = METRICS.iter().map(|metric| metric.title()).collect();
    let mut text = format!(
        "Measured by `cargo xtask docs --only visibility`: {width} x {height} pixels, against {paths} paths for each; {}. \
         `<` and `±`: below the noise of the paths.\n\n",
        titles.join(", ")
    );
    let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
    text.push_str(&format!("| | {} |\n|---|{}\n", names.join(" | "), "---|".repeat(names.len())));
    let rows = all.first().map(|(_, rows)| rows.as_slice()).unwrap_or_default();
    for (at, row) in rows.iter().enumerate() {
        let name = if row.default { format!("**{}**", row.name) } else { row.name.clone() };
        let cells = all.iter().map(|(_, rows)| {
            let cell = |metric| picture_error::cell(&rows[at].error, metric);
            METRICS.map(cell).join(", ")
        });
        text.push_str(&format!("| {name} | {} |\n", cells.collect::<Vec<_>>().join(" | ")));
    }
    Table { document: "docs/numerics.md", mark: "measured visibility", text }
}

#[cfg(test)]
mod tests {
    use sglow_results::picture_error::PictureError;

    use super::*;

    fn made_up() -> Vec<Table> {
        let noise = Noise { stated: 0.04, by_halves: 0.0405 };
        let errors = ReferenceErrors {
            scene: "box".to_owned(),
            facets: vec![MapError { map: 128, rmse_over_mean: 0.092, median: 0.0103 }],
            by_directions: noise,
            guided: Noise { stated: 0.0126, ..noise },
        };
        let row = |name: &str, default| OnScene {
            name: name.to_owned(),
            default,
            error: PictureError {
                relative_mse: 0.0095,
                reference_mean: 1.0,
                ..PictureError::default()
            },
        };
        let rows = vec![row("no maps", false), row("`near_scale=1.5`", true)];
        let mut tables = Vec::from(of_references(&[errors]));
        tables.push(of_visibility(&[("box", rows)]));
        tables
    }

    #[test]
    fn numbers_stand_in_their_rows_and_documents_have_the_marks() {
        let tables = made_up();
        let rows = [
            "| box | 9.2 % | 1.03 % |",
            "| box | 4.00 / 4.05 % | 1.26 / 4.05 % |",
            "| **`near_scale=1.5`** | 0.00950, ",
        ];
        for (table, row) in tables.iter().zip(rows) {
            assert!(table.text.contains(row), "{}", table.text);
            let document = fs::read_to_string(repository().join(table.document)).unwrap();
            let written =
                marks::replaced(&document, table.document, table.mark, &table.text).unwrap();
            assert!(written.contains(row));
        }
    }
}

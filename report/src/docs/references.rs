//! The errors of the references, and of pictures by setting, as tables of documents.

use sglow_results::light_maps::OnScene;
use sglow_results::picture_error::Metric;
use sglow_results::references::{FINEST, MAPS, MapError, Noise, ReferenceErrors, SIZE};

use crate::picture_error;

/// A measured table and its place.
pub struct Table {
    /// The document, below the repository.
    pub document: &'static str,
    /// Its marks.
    pub mark: &'static str,
    /// Its lines.
    pub text: String,
}

/// The facets of coarse maps against those of a fine one, and the noise of paths.
#[must_use]
pub fn of_references(all: &[ReferenceErrors]) -> [Table; 2] {
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
        "Measured by the same command: {} paths for each pixel.\n\n\
         | scene | by directions alone | with the light's map |\n|---|---|---|\n",
        sglow_results::references::PATHS
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

/// How a table of settings was measured, and where it stands.
pub struct Measured<'a> {
    /// The value of `cargo xtask docs --only`, and the end of the mark.
    pub what: &'static str,
    /// Pixels.
    pub size: [u32; 2],
    /// Paths for each of them.
    pub paths: u32,
    /// What is shown of each picture.
    pub metrics: &'a [Metric],
}

/// The errors of pictures by setting, a column for each scene.
#[must_use]
pub fn of_settings(measured: &Measured<'_>, all: &[(&'static str, Vec<OnScene>)]) -> Table {
    let &Measured { what, size: [width, height], paths, metrics } = measured;
    let titles: Vec<&str> = metrics.iter().map(|metric| metric.title()).collect();
    let mut text = format!(
        "Measured by `cargo xtask docs --only {what}`: {width} x {height} pixels, against {paths} paths for each; {}. \
         `<` and `±`: below the noise of the paths.\n\n",
        titles.join(", ")
    );
    let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
    text.push_str(&format!("| | {} |\n|---|{}\n", names.join(" | "), "---|".repeat(names.len())));
    let rows = all.first().map(|(_, rows)| rows.as_slice()).unwrap_or_default();
    for (at, row) in rows.iter().enumerate() {
        let name = if row.default { format!("**{}**", row.name) } else { row.name.clone() };
        let cells = all.iter().map(|(_, rows)| {
            let cell = |&metric| picture_error::cell(&rows[at].error, metric);
            metrics.iter().map(cell).collect::<Vec<_>>().join(", ")
        });
        text.push_str(&format!("| {name} | {} |\n", cells.collect::<Vec<_>>().join(" | ")));
    }
    Table { document: "docs/numerics.md", mark: what, text }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use sglow_results::picture_error::PictureError;

    use super::*;
    use crate::docs::marks;

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
        let metrics = [Metric::RelativeMse, Metric::Bias];
        for what in ["visibility", "partitions"] {
            let measured = Measured { what, size: [56, 32], paths: 1024, metrics: &metrics };
            tables.push(of_settings(&measured, &[("box", rows.clone())]));
        }
        tables
    }

    #[test]
    fn numbers_stand_in_their_rows_and_documents_have_the_marks() {
        let tables = made_up();
        let rows = [
            "| box | 9.2 % | 1.03 % |",
            "| box | 4.00 / 4.05 % | 1.26 / 4.05 % |",
            "| **`near_scale=1.5`** | 0.00950, ",
            "| no maps | 0.00950, ",
        ];
        assert_eq!(tables.len(), rows.len());
        for (table, row) in tables.iter().zip(rows) {
            assert!(table.text.contains(row), "{}", table.text);
            let document = fs::read_to_string(
                Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(table.document),
            )
            .unwrap();
            let written =
                marks::replaced(&document, table.document, table.mark, &table.text).unwrap();
            assert!(written.contains(row));
        }
    }
}

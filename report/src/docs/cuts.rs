//! Lengths and errors of cuts, as a table of `docs/numerics.md`.

use sglow_results::cuts::{CutError, CutOfMap, CutsOnScene};
use sglow_results::picture_error::Metric;

use crate::docs::references::Table;
use crate::picture_error;

/// A row for each scene and size of the map.
#[must_use]
pub fn of_cuts(size: [u32; 2], wider: u32, all: &[CutsOnScene]) -> Table {
    const METRICS: [Metric; 5] =
        [Metric::RelativeMse, Metric::Rmse, Metric::Median, Metric::Quantile95, Metric::Bias];
    let titles = METRICS.map(Metric::title).join(" | ");
    let [width, height] = size;
    let mut text = format!(
        "Measured by `cargo xtask docs --only cuts`: four windows of {width} x {height} pixels each of a picture {wider} \
         times as wide and as high, 16 roots, the default tolerance. Nodes are those that a pixel takes: the mean, what \
         95 % stay below, and the longest list of a tile. Errors are against all texels as lights of the same emission; \
         jumps are changes of the relative error between neighbouring pixels of one surface: what 99.9 % of them stay \
         below, and the largest.\n\n\
         | scene | map | lit texels | nodes: mean, 95 %, list | {titles} | jump: 99.9 %, largest |\n\
         |---|---|---|---|{}---|\n",
        "---|".repeat(METRICS.len())
    );
    for CutsOnScene { scene, maps } in all {
        for CutOfMap { map, leaves, nodes_mean, nodes_95, longest, error } in maps {
            let cells = error.as_ref().map_or_else(
                || vec!["–".to_owned(); METRICS.len() + 1],
                |CutError { picture, jump, jump_999 }| {
                    let cells = METRICS.iter().map(|&metric| picture_error::cell(picture, metric));
                    let jumps = format!("{:.2}, {:.2} %", 100.0 * jump_999, 100.0 * jump);
                    cells.chain([jumps]).collect()
                },
            );
            text.push_str(&format!(
                "| {scene} | {map} | {leaves} | {nodes_mean:.0}, {nodes_95}, {longest} | {} |\n",
                cells.join(" | ")
            ));
        }
    }
    Table { document: "docs/numerics.md", mark: "cuts", text }
}

#[cfg(test)]
mod tests {
    use sglow_results::picture_error::PictureError;

    use super::*;
    use crate::docs::marks;

    #[test]
    fn each_map_has_a_row_and_the_document_has_the_marks() {
        let picture =
            PictureError { relative_mse: 2e-4, reference_mean: 1.0, ..Default::default() };
        let cut = |map, error| CutOfMap {
            map,
            leaves: 9,
            nodes_mean: 101.7,
            nodes_95: 180,
            longest: 402,
            error,
        };
        let error = CutError { picture, jump: 0.3, jump_999: 0.0012 };
        let maps = vec![cut(256, Some(error)), cut(512, None)];
        let table = of_cuts([240, 135], 8, &[CutsOnScene { scene: "box".to_owned(), maps }]);
        assert!(
            table.text.contains("| box | 256 | 9 | 102, 180, 402 | 0.000200 |"),
            "{}",
            table.text
        );
        assert!(table.text.ends_with(
            "| 0.12, 30.00 % |\n| box | 512 | 9 | 102, 180, 402 | – | – | – | – | – | – |\n"
        ));
        let real = include_str!("../../../docs/numerics.md");
        assert!(marks::replaced(real, table.document, table.mark, &table.text).is_ok());
    }
}

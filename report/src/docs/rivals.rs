//! The method against its rivals, as a table of `docs/results.md`.

use sglow_results::reproduction::Findings;

use crate::docs::marks;
use crate::failure::{Failure, Result};
use crate::page::reproduce::paper_total;

/// The command that measures the table.
const HOW: &str = "cargo xtask reproduce --write-docs";
/// The density of the table.
const DENSITY: &str = "bidirectional";

/// The methods on the scene whose flicker was measured: the mark `rivals`.
///
/// # Errors
///
/// When there is no such scene, or the document lacks the mark.
pub fn written(document: &str, name: &str, found: &Findings) -> Result<String> {
    let none =
        || Failure::new("no scene has flicker, errors and times; measure the built-in scenes");
    let (scene, flickers) = found.flickers.first().ok_or_else(none)?;
    let surveyed = found.surveys.iter().find(|one| one.scene == *scene && one.density == DENSITY);
    let surveyed = surveyed.ok_or_else(none)?;
    let times = found.times.iter().find(|one| one.scene == *scene && one.density == DENSITY);
    let times = times.ok_or_else(none)?;
    let mut text = format!(
        "Measured by `{HOW}`: `{scene}`, density `{DENSITY}`, the emission of the preset `tokuyoshi2016`.\n\n\
         | method | lights made, ms: both maps / light's alone | paper, {}, both maps | variation | gaps | relative MSE | median | flicker |\n\
         |---|---|---|---|---|---|---|---|\n",
        times.name
    );
    for row in &surveyed.found.rows {
        let label = format!("{}, K = {}", row.method.name(), row.size_factor);
        let timed =
            times.methods.iter().find(|one| one.method == row.method && row.size_factor == 1.0);
        let time = timed.map_or("–".to_owned(), |one| {
            format!("{:.0} / {:.1}", one.total(None), one.total(Some(false)))
        });
        let paper = timed.and_then(|one| paper_total(times.name, one.method));
        let paper = paper.map_or("–".to_owned(), |ms| format!("{ms:.2}"));
        let flicker = flickers.contenders.iter().find(|one| one.name == label);
        let flicker = flicker.map_or("–".to_owned(), |one| format!("{:.3}", one.flicker));
        text.push_str(&format!(
            "| {label} | {time} | {paper} | {:.2} | {:.1} % | {:.2} | {:.0} % | {flicker} |\n",
            row.overlap.variation,
            100.0 * row.overlap.gaps,
            row.relative_mse,
            100.0 * row.median,
        ));
    }
    marks::replaced(document, name, "rivals", &text)
}

#[cfg(test)]
mod tests {
    use sglow_results::reproduction::{Surveyed, TimeTable};
    use sglow_results::rivals::flicker::{Flicker, Flickers, Walk};
    use sglow_results::rivals::method::Method;
    use sglow_results::rivals::overlap::{Overlap, Weighted};
    use sglow_results::rivals::stages::{Stage, Stages};
    use sglow_results::rivals::survey::{Row, Survey};
    use sglow_results::time::Time;

    use super::*;

    fn row(size_factor: f32) -> Row {
        Row {
            method: Method::Previous,
            size_factor,
            overlap: Overlap { variation: 0.53, largest: 2.0, covered: 1.0, gaps: 0.18 },
            weighted: Weighted::PARTITION,
            power: 1.0,
            brightest: 1.0,
            error: 0.5,
            relative_mse: 1.24,
            median: 0.29,
            q95: 1.0,
            bias: 0.0,
            floor: None,
            not_finite: 0,
        }
    }

    #[test]
    fn each_method_has_a_row_and_the_documents_have_the_mark() {
        let time = Time { median: 114.2, minimum: 100.0, maximum: 130.0 };
        let stage = |camera| Stage { name: "moments", camera, time, dispatches: 1 };
        let stages = vec![stage(true), stage(false)];
        let contender = Flicker {
            name: "previous, K = 1".to_owned(),
            error: 1.0,
            change: 0.1,
            flicker: 0.131,
            trimmed: 0.05,
            worst: 0.2,
            not_finite: 0,
        };
        let found = Findings {
            times: vec![TimeTable {
                name: "Table 1",
                scene: "box".to_owned(),
                density: DENSITY,
                methods: vec![Stages { method: Method::Previous, stages }],
            }],
            surveys: vec![Surveyed {
                scene: "box".to_owned(),
                density: DENSITY,
                found: Survey { pixels: 4, dark: false, rows: vec![row(1.0), row(4.0)] },
            }],
            flickers: vec![(
                "box".to_owned(),
                Flickers {
                    walk: Walk::default(),
                    reference_change: 0.1,
                    contenders: vec![contender],
                },
            )],
            ..Findings::default()
        };
        let real = include_str!("../../../docs/results.md");
        let text = written(real, "docs/results.md", &found).unwrap();
        let first =
            "| previous, K = 1 | 228 / 114.2 | 2.32 | 0.53 | 18.0 % | 1.24 | 29 % | 0.131 |";
        assert!(text.contains(first), "{text}");
        assert!(
            text.contains("| previous, K = 4 | – | – | 0.53 | 18.0 % | 1.24 | 29 % | – |"),
            "{text}"
        );
        assert!(written(real, "docs/results.md", &Findings::default()).is_err());
    }
}

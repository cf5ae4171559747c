//! The errors of a picture, for a terminal.

use std::path::Path;

use sglow_results::picture_error::{Metric, PictureError};

use crate::compare::Loaded;
use crate::picture_error::{HEADINGS, cells, text};
use crate::table;

/// The numbers as a table.
#[must_use]
pub fn show(tested: &Path, loaded: &Loaded, error: &PictureError, metrics: &[Metric]) -> String {
    let shown: Vec<usize> = (0..Metric::ALL.len())
        .filter(|&at| metrics.is_empty() || metrics.contains(&Metric::ALL[at]))
        .collect();
    let dark = error.reference_mean == 0.0;
    let mut table = table::new(["metric", "error", "uncertainty"]);
    let cells = cells(error);
    for at in shown {
        let metric = Metric::ALL[at];
        let uncertainty = error.measured(metric).uncertainty;
        table.add_row([
            format!("{} ({})", HEADINGS[at], metric.name()),
            cells[at].clone(),
            if uncertainty > 0.0 { text(uncertainty, metric, dark) } else { "–".to_owned() },
        ]);
    }
    let [width, height] = loaded.size();
    format!(
        "{}: {} of {} pixels ({}), layer {}{}\n{table}",
        tested.display(),
        error.pixels,
        width * height,
        loaded.present.as_ref().map_or("all: no file says where there is a surface", |one| one.1),
        loaded.layer,
        if dark { "; the reference is black, so errors are absolute" } else { "" },
    )
}

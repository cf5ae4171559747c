//! What kernels make of densities that stress the sampling pass, for a terminal.

use sglow_results::densities::{COUNT, OnDensity, SIZE, sampling_times};

use crate::table;

/// A row for each density and kernel, and the times of the sampling pass over those of the previous kernels.
#[must_use]
pub fn show(rows: &[OnDensity]) -> String {
    let mut table = table::new(["density", "kernel", "power", "brightest x N", "ms"]);
    for row in rows {
        table.add_row([
            row.density.clone(),
            row.kind(),
            format!("{:.4}", row.power_ratio),
            format!("{:.1}", row.brightest),
            format!("{:.3}", row.milliseconds),
        ]);
    }
    let mut text = format!("\ndensities of {SIZE} squared, {COUNT} kernels, exact filter\n{table}");
    for (solver, ratios) in sampling_times(rows) {
        let minimum = ratios.iter().copied().fold(f64::INFINITY, f64::min);
        let maximum = ratios.iter().copied().fold(0.0, f64::max);
        text.push_str(&format!(
            "\nsampling pass, modified by {solver} over previous: {minimum:.2} to {maximum:.2} times"
        ));
    }
    text
}

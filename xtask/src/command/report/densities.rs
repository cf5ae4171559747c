//! What kernels make of densities that stress the sampling pass, as a table and as promises.

use sglow_measure::densities::KERNELS;
use sglow_results::densities::{COUNT, OnDensity, SIZE};
use sglow_shaders::Kernel;

use crate::failure::Result;
use crate::json::{Check, Relation, Report};
use crate::{say, table};

/// Tells of them, and holds them to what is promised.
pub(super) fn show(rows: &[OnDensity], report: &mut Report) -> Result {
    let mut table = table::new(["density", "kernel", "power", "brightest x N", "ms"]);
    for row in rows {
        let what = if row.solver == "none" {
            row.kernel.clone()
        } else {
            format!("{} {}", row.kernel, row.solver)
        };
        table.add_row([
            row.density.clone(),
            what.clone(),
            format!("{:.4}", row.power_ratio),
            format!("{:.1}", row.brightest),
            format!("{:.3}", row.milliseconds),
        ]);
        if ["ring", "noise-2"].contains(&row.density.as_str()) {
            let error = (row.power_ratio - 1.0).abs();
            let (relation, note) = if row.kernel == Kernel::Modified.name() {
                (Relation::AtMost, "keeps the power")
            } else {
                (Relation::AtLeast, "does not keep it, which is why")
            };
            let text = format!("power of {what} kernels on {}, off by", row.density);
            report.check(Check::new(text, error, "of the total", relation, 0.03).note(note));
        }
    }
    say::line(format!("\ndensities of {SIZE} squared, {COUNT} kernels, exact filter\n{table}"));
    // Per density the kernels stand side by side, the previous ones first.
    for (index, (_, solver)) in KERNELS.into_iter().enumerate().skip(1) {
        let ratios: Vec<f64> = rows
            .chunks_exact(KERNELS.len())
            .map(|row| row[index].milliseconds / row[0].milliseconds)
            .collect();
        let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
        let most = ratios.iter().copied().fold(0.0, f64::max);
        say::line(format!(
            "sampling pass, modified by {solver} over previous: {least:.2} to {most:.2} times"
        ));
        report.detail(&format!("sampling_time_{solver}_over_previous"), ratios)?;
    }
    Ok(())
}

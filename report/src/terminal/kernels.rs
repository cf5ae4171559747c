//! Kernels on a density, for a terminal.

use sglow_results::kernels::Sizing;

use crate::table;

/// A row for each configuration to size kernels.
#[must_use]
pub fn show(found: &[Sizing], lights: u32) -> String {
    let mut table =
        table::new(["kernel", "variation", "largest", "brightest", "power", "no root", "several"]);
    for one in found {
        table.add_row([
            one.kernel.to_owned(),
            format!("{:.4}", one.mass_variation),
            format!("{:.2}", one.largest_mass),
            format!("{:.2}", one.brightest),
            format!("{:.4}", one.power),
            percent(one.without_root),
            percent(one.several_roots),
        ]);
    }
    format!(
        "{lights} kernels; masses and powers times N, of a total of 1: their variation is the standard deviation over the \
         mean\n{table}"
    )
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

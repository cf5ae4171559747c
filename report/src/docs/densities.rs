//! What kernels make of densities that stress the sampling pass, as a table of `docs/results.md`.

use sglow_results::densities::{COUNT, OnDensity, SIZE};

use crate::docs::marks;
use crate::failure::Result;

/// Power and brightest light of each kind of kernel on each density: the mark `densities`.
///
/// # Errors
///
/// When the document lacks the mark.
pub fn written(document: &str, name: &str, rows: &[OnDensity], how: &str) -> Result<String> {
    let mut kinds: Vec<String> = Vec::new();
    let mut densities: Vec<&str> = Vec::new();
    for row in rows {
        if !kinds.contains(&row.kind()) {
            kinds.push(row.kind());
        }
        if !densities.contains(&row.density.as_str()) {
            densities.push(&row.density);
        }
    }
    let headings: Vec<String> =
        kinds.iter().map(|kind| format!("{kind}: power, brightest")).collect();
    let mut text = format!(
        "Measured by `{how}`: {COUNT} kernels of K = 1 on densities of {SIZE} x {SIZE}, exact filter.\n\n| density | {} |\n|---|{}\n",
        headings.join(" | "),
        "---|".repeat(kinds.len())
    );
    for density in densities {
        let cells: Vec<String> = kinds
            .iter()
            .map(|kind| {
                let found = rows.iter().find(|row| row.density == density && row.kind() == *kind);
                found.map_or("–".to_owned(), |row| {
                    let decimals = usize::from(row.brightest < 10.0);
                    format!("{:.3}, {:.decimals$}", row.power_ratio, row.brightest)
                })
            })
            .collect();
        text.push_str(&format!("| {density} | {} |\n", cells.join(" | ")));
    }
    marks::replaced(document, name, "densities", &text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_density_has_a_row_and_the_documents_have_the_mark() {
        let row = |density: &str, kernel: &str, solver: &str, brightest| OnDensity {
            density: density.to_owned(),
            kernel: kernel.to_owned(),
            solver: solver.to_owned(),
            power_ratio: 1.0012,
            brightest,
            milliseconds: 1.0,
        };
        let rows = [
            row("ring", "previous", "none", 1024.0),
            row("ring", "modified", "bracketed", 1.26),
            row("smooth", "previous", "none", 1.1),
        ];
        let real = include_str!("../../../docs/results.md");
        let text = written(real, "docs/results.md", &rows, "cargo xtask report").unwrap();
        assert!(text.contains(
            "| density | previous: power, brightest | modified bracketed: power, brightest |"
        ));
        assert!(text.contains("| ring | 1.001, 1024 | 1.001, 1.3 |"), "{text}");
        assert!(text.contains("| smooth | 1.001, 1.1 | – |"), "{text}");
    }
}

//! What a stability run measured, as the tables of `docs/results.md`.

use sglow_results::stability::halves::HalvesReport;
use sglow_results::stability::report::FunctionReport;

use crate::docs::marks;
use crate::failure::Result;
use crate::page::number::figure;
use crate::page::stability::cosine_forms;

/// The command that measures the tables.
const HOW: &str = "cargo xtask stability --write-docs";

/// The forms of the cosine integral, and what half precision costs: the marks `cosine` and `halves`.
///
/// # Errors
///
/// When the document lacks a mark.
pub fn written(
    document: &str,
    name: &str,
    functions: &[FunctionReport],
    halves: &[HalvesReport],
) -> Result<String> {
    let document = marks::replaced(document, name, "cosine", &cosine(functions))?;
    marks::replaced(&document, name, "halves", &halved(halves))
}

fn cosine(functions: &[FunctionReport]) -> String {
    let forms = cosine_forms(functions);
    let mut text = format!(
        "Measured by `{HOW}`.\n\n| form | error | {} | |\n|---|---|---|---|\n",
        forms.x_label()
    );
    for (label, error, time, better) in forms.rows() {
        let better = better.map_or_else(String::new, |better| format!("dominated by `{better}`"));
        let time = time.map_or("–".to_owned(), figure);
        text.push_str(&format!("| `sglow_{label}` | {} | {time} | {better} |\n", figure(error)));
    }
    text
}

fn halved(halves: &[HalvesReport]) -> String {
    let names: Vec<&str> = halves
        .first()
        .map(|one| one.checks.iter().map(|check| check.name).collect())
        .unwrap_or_default();
    let mut text = format!(
        "Measured by `{HOW}`.\n\n| scene | bytes per frame, `f32` to `f16` | {} |\n|---|---|{}\n",
        names.join(" | "),
        "---|".repeat(names.len())
    );
    for one in halves {
        let [full, half] = one.bytes.map(|bytes| bytes as f64 / 1e6);
        let cells: Vec<String> = one.checks.iter().map(|check| figure(check.value)).collect();
        let cells = cells.join(" | ");
        text.push_str(&format!("| `{}` | {full:.2} to {half:.2} MB | {cells} |\n", one.scene));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::stability::made_up;

    #[test]
    fn each_form_and_each_scene_has_a_row() {
        let (functions, halves) = (made_up::functions(), made_up::halves());
        let document = "<!-- cosine: begin -->\n<!-- cosine: end -->\n<!-- halves: begin -->\n<!-- halves: end -->\n";
        let text = written(document, "x.md", &functions, &halves).unwrap();
        let forms = functions.iter().filter(|one| one.name.starts_with("sg_cosine_"));
        for form in forms {
            assert!(text.contains(&format!("| `sglow_{}` | ", form.name)), "{text}");
        }
        for half in &halves {
            assert!(text.contains(&format!("| `{}` | ", half.scene)), "{text}");
        }
        let real = include_str!("../../../docs/results.md");
        assert!(written(real, "docs/results.md", &functions, &halves).is_ok());
    }
}

//! The error of specular models, as a table of `docs/results.md`.

use sglow_results::specular::SpecularError;

use crate::docs::references::Table;

/// The error of each model against quadrature.
#[must_use]
pub fn of_specular(all: &[SpecularError]) -> Table {
    let mut text = "Measured by `cargo xtask docs --only specular`.\n\n| `specular` | white metal | dielectric |\n|---|---|---|\n".to_owned();
    for one in all {
        text.push_str(&format!("| `{}` | {:.3} | {:.3} |\n", one.model, one.white, one.dielectric));
    }
    Table { document: "docs/results.md", mark: "specular", text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::docs::marks;

    #[test]
    fn each_model_has_a_row_and_the_document_has_the_mark() {
        let one = SpecularError { model: "asg".to_owned(), white: 0.3131, dielectric: 0.21 };
        let table = of_specular(&[one]);
        assert!(table.text.ends_with("| `asg` | 0.313 | 0.210 |\n"), "{}", table.text);
        let real = include_str!("../../../docs/results.md");
        assert!(marks::replaced(real, table.document, table.mark, &table.text).is_ok());
    }
}

//! Tables that scroll in a box of their own, so that the page never does sideways.

use maud::{Markup, html};

/// A column.
#[derive(Clone, Copy, Debug)]
pub struct Column<'a> {
    /// Its heading.
    pub name: &'a str,
    /// Whether it holds numbers, which stand to the right.
    pub number: bool,
}

/// A column of text.
pub const fn text(name: &str) -> Column<'_> {
    Column { name, number: false }
}

/// A column of numbers.
pub const fn number(name: &str) -> Column<'_> {
    Column { name, number: true }
}

/// A table with these columns; `rows` are `tr` elements. `label` is what a screen reader calls it.
pub fn table(label: &str, class: &str, columns: &[Column<'_>], rows: &[Markup]) -> Markup {
    if rows.is_empty() {
        return html! { p.quiet { "Nothing was measured." } };
    }
    html! {
        div.scroll tabindex="0" role="region" aria-label=(label) {
            table class=(class) {
                thead {
                    tr {
                        @for column in columns {
                            th scope="col" class=(if column.number { "n" } else { "t" }) { (column.name) }
                        }
                    }
                }
                tbody { @for row in rows { (row) } }
            }
        }
    }
}

/// Whether something holds, in a word and a sign beside the colour.
pub fn mark(holds: bool) -> Markup {
    if holds {
        html! { span.holds-mark { "✓ passes" } }
    } else {
        html! { span.fails-mark { "✗ FAILS" } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_table_says_so() {
        let empty = table("numbers", "", &[text("a")], &[]).into_string();
        assert!(empty.contains("Nothing was measured") && !empty.contains("<table"));
        let row = html! { tr { td { "1" } } };
        let full = table("numbers", "", &[number("a")], &[row]).into_string();
        assert!(full.contains("<th scope=\"col\" class=\"n\">a</th>"), "{full}");
    }

    #[test]
    fn a_verdict_does_not_rest_on_colour() {
        assert_ne!(mark(true).into_string().replace("holds-mark", ""), mark(false).into_string());
        assert!(mark(false).into_string().contains("FAILS"));
    }
}

//! Tables for a person.

use comfy_table::{ContentArrangement, LineStyle, Table, TableStyle};

/// One line below the header, nothing else.
const STYLE: TableStyle =
    TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─'));
/// Columns where there is no terminal to ask.
const WIDTH: u16 = 120;

/// An empty table under `header`, as wide as the terminal.
pub(crate) fn new<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table.load_style(STYLE).set_content_arrangement(ContentArrangement::Dynamic).set_header(header);
    if !table.is_tty() {
        table.set_width(WIDTH);
    }
    table
}

/// Breaks what is too long for a column where its own parts end.
pub(crate) fn break_at(table: &mut Table, column: usize, delimiter: char) {
    if let Some(column) = table.column_mut(column) {
        column.set_delimiter(delimiter);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_break_between_their_parts() {
        let mut table = new(["name"]);
        table.set_width(20).add_row(["density=power,diffuse=constant"]);
        assert!(!table.to_string().contains("density=power,\n"), "{table}");
        break_at(&mut table, 0, ',');
        let lines: Vec<_> = table.lines().map(|line| line.trim().to_owned()).collect();
        assert!(lines.contains(&"density=power,".to_owned()), "{lines:?}");
        assert!(lines.contains(&"diffuse=constant".to_owned()), "{lines:?}");
    }
}

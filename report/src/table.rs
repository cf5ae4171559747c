//! Tables for a person.

use comfy_table::{ContentArrangement, LineStyle, Table, TableStyle};

/// One line below the header, nothing else.
const STYLE: TableStyle =
    TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─'));
/// Columns where there is no terminal.
const WIDTH: u16 = 100;

/// An empty table under `header`, as wide as the terminal.
pub fn new<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table.load_style(STYLE).set_content_arrangement(ContentArrangement::Dynamic).set_header(header);
    if !table.is_tty() {
        table.set_width(WIDTH);
    }
    table
}

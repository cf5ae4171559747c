//! The frame of a configuration: what it keeps and what it runs, as a table for a terminal and as a drawing.

pub mod content;
mod faults;
mod fold;
mod layout;
mod svg;

use comfy_table::CellAlignment;

use crate::page::graph::content::{Content, bytes};
use crate::page::graph::fold::{levels, rows};
use crate::table;

/// Cells of the bar of the largest resource.
const BAR: u64 = 12;

/// The frame as tables.
pub fn text(content: &Content) -> String {
    let rows = rows(&content.steps);
    let resources = resources(content);
    let steps = steps(&rows);
    format!("{}\n\n{resources}\n{}\n\n{steps}", heading(content), total(content))
}

/// The frame as a drawing that is a file of its own.
pub fn drawing(content: &Content) -> String {
    svg::file(&layout::layout(content, &rows(&content.steps)))
}

fn heading(content: &Content) -> String {
    if content.changed.is_empty() {
        format!("{}: all defaults", content.title)
    } else {
        format!("{}: {}", content.title, content.changed.join(", "))
    }
}

fn total(content: &Content) -> String {
    let external = match content.external_bytes {
        0 => String::new(),
        external => format!(", {} of them the host's", bytes(external)),
    };
    format!(
        "{} in {} resources{external}; {} steps",
        bytes(content.bytes),
        content.resources.len(),
        content.steps.len()
    )
}

fn resources(content: &Content) -> String {
    let mut table = table::new(["resource", "what", "bytes", ""]);
    if let Some(column) = table.column_mut(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let largest = content.resources.iter().map(|resource| resource.bytes).max().unwrap_or(0).max(1);
    for part in content.parts.iter().filter(|part| part.resources > 0) {
        let count = match part.resources {
            1 => "1 resource".to_owned(),
            count => format!("{count} resources"),
        };
        table.add_row([part.name.to_uppercase(), count, bytes(part.bytes), String::new()]);
        for resource in content.resources.iter().filter(|resource| resource.part == part.name) {
            let mark = match (resource.external, resource.kept) {
                (true, _) => " (the host's)",
                (_, true) => " (kept)",
                _ => "",
            };
            let cells = (resource.bytes * BAR).div_ceil(largest) as usize;
            table.add_row([
                format!("  {}{mark}", resource.name),
                resource.kind.text(),
                bytes(resource.bytes),
                "█".repeat(cells),
            ]);
        }
    }
    table.to_string()
}

fn steps(rows: &[fold::Row]) -> String {
    let mut table = table::new(["", "step", "runs", "reads", "writes"]);
    let mut label = None;
    for row in rows {
        let heading = (&row.part, &row.label);
        if label != Some(heading) {
            let text = match row.label.as_str() {
                "" => row.part.clone(),
                label => format!("{}: {label}", row.part),
            };
            table.add_row([String::new(), broken(&text, ' ')]);
        }
        label = Some(heading);
        let rounds = match (row.rounds, row.of) {
            (1, _) => String::new(),
            (rounds, 1) => format!("{rounds} times\n"),
            (rounds, of) => format!("{rounds} times, {} of {of}\n", row.place + 1),
        };
        table.add_row([
            row.number.to_string(),
            broken(&row.variant(), '-'),
            format!("{rounds}{}", row.work()),
            levels(&row.reads).join("\n"),
            levels(&row.writes).join("\n"),
        ]);
    }
    table.to_string()
}

/// A text in lines of at most so many characters, as long as there is where to break it.
fn broken(text: &str, at: char) -> String {
    const MOST: usize = 25;
    let mut lines = vec![String::new()];
    for word in text.split_inclusive(at) {
        match lines.last_mut() {
            Some(line) if line.is_empty() || line.len() + word.trim_end().len() <= MOST => {
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines.join("\n")
}

/// What is on top of something else in the drawing, or leaves it.
pub fn faults(content: &Content) -> Vec<String> {
    faults::faults(&layout::layout(content, &rows(&content.steps)))
}

#[cfg(test)]
mod tests;

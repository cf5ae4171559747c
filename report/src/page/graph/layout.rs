//! Where everything of the drawing lies: resources as lanes, steps as columns from left to right.
//!
//! Each lane says what its resource is, how large it is and, by marks, which step reads and writes it. Below stand the steps
//! by their numbers. The font has one width, so that nothing is guessed.

use crate::page::graph::content::{Content, Resource, bytes};
use crate::page::graph::fold::{Row, levels};

/// A size of text, in pixels.
pub(super) const SIZE: f64 = 12.0;
/// The same for headings.
pub(super) const LARGE: f64 = 15.0;
/// Width of a character over the size of its font: that of common fonts of one width, rounded up.
const ADVANCE: f64 = 0.62;
/// Height of a lane, and width of a column.
pub(super) const LANE: f64 = 20.0;
/// Space around everything.
const MARGIN: f64 = 24.0;
/// Space between columns of text.
const GAP: f64 = 16.0;
/// Width of the bar of the largest resource.
const BAR: f64 = 84.0;
/// Space between columns of different labels, and of different parts.
const APART: [f64; 2] = [5.0, 14.0];
/// Width of the drawing at least, so that what stands below the lanes is no narrow column.
const WIDTH: f64 = 980.0;
/// The angle of the steps' names, in degrees.
pub(super) const ANGLE: f64 = 60.0;

/// A box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Box {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

/// How a box is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fill {
    /// Every other lane.
    Stripe,
    /// Every other label's columns.
    Band,
    /// From the first use of a resource to its last one, in the colour of its part.
    Life,
    /// The same of what is there before the frame begins or stays behind its end.
    Beyond,
    /// Bytes of a resource.
    Bytes,
    /// The colour of a part.
    Part,
    /// Rounds of steps that repeat.
    Rounds,
}

/// A box with its fill and the number of its part.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shape {
    pub(super) place: Box,
    pub(super) fill: Fill,
    pub(super) part: usize,
}

/// A line of text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Text {
    /// Its left end, or its right end if it is `right`.
    pub(super) x: f64,
    /// Its base line.
    pub(super) y: f64,
    pub(super) size: f64,
    pub(super) text: String,
    pub(super) right: bool,
    /// Whether it rises from its left end by [`ANGLE`].
    pub(super) slanted: bool,
    pub(super) tone: Tone,
    /// What is said of it where there is a pointer.
    pub(super) title: String,
}

/// How text is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tone {
    Plain,
    Quiet,
    Strong,
    /// Strong, in the colour of a part.
    Part(usize),
}

/// What a step does with a resource.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mark {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) reads: bool,
    pub(super) writes: bool,
    pub(super) title: String,
}

/// A drawing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Layout {
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) title: String,
    pub(super) shapes: Vec<Shape>,
    pub(super) marks: Vec<Mark>,
    pub(super) texts: Vec<Text>,
}

/// Width of a text.
pub(super) fn wide(text: &str, size: f64) -> f64 {
    text.chars().count() as f64 * size * ADVANCE
}

fn widest<'a>(texts: impl IntoIterator<Item = &'a str>) -> f64 {
    texts.into_iter().map(|text| wide(text, SIZE)).fold(0.0, f64::max)
}

impl Text {
    fn new(x: f64, y: f64, text: impl Into<String>) -> Self {
        let (text, title) = (text.into(), String::new());
        let (right, slanted, tone) = (false, false, Tone::Plain);
        Self { x, y, size: SIZE, text, right, slanted, tone, title }
    }
}

/// The columns of the steps.
struct Columns {
    /// The middle of each.
    x: Vec<f64>,
    right: f64,
}

fn columns(rows: &[Row], left: f64) -> Columns {
    let mut x = Vec::new();
    let mut right = left;
    for (index, row) in rows.iter().enumerate() {
        if let Some(before) = index.checked_sub(1).and_then(|before| rows.get(before)) {
            right += match (before.part == row.part, before.label == row.label) {
                (true, true) => 0.0,
                (true, false) => APART[0],
                (false, _) => APART[1],
            };
        }
        x.push(right + LANE / 2.0);
        right += LANE;
    }
    Columns { x, right }
}

/// Lays out a frame.
pub(super) fn layout(content: &Content, rows: &[Row]) -> Layout {
    let mut drawing = Layout { title: content.title.clone(), ..Layout::default() };
    let what = |resource: &Resource| resource.kind.text();
    let size = |resource: &Resource| bytes(resource.bytes);
    let of = |text: &dyn Fn(&Resource) -> String| -> Vec<String> {
        content.resources.iter().map(text).collect()
    };
    let (names, kinds, sizes) = (of(&name), of(&what), of(&size));
    let width = |texts: &[String]| widest(texts.iter().map(String::as_str));
    let totals: Vec<String> = content.parts.iter().map(|part| bytes(part.bytes)).collect();
    let name_x = MARGIN + 14.0;
    let kind_x = name_x + width(&names).max(part_width(content)) + GAP;
    let size_x = kind_x + width(&kinds) + GAP + width(&sizes).max(width(&totals));
    let bar_x = size_x + GAP / 2.0;
    let columns = columns(rows, bar_x + BAR + GAP);
    let headings: Vec<String> = rows.iter().map(heading).collect();
    let (sin, cos) = ANGLE.to_radians().sin_cos();
    let ends = columns.x.iter().zip(&headings).map(|(x, text)| x + wide(text, SIZE) * cos + SIZE);
    let right = ends.fold(columns.right.max(WIDTH - MARGIN), f64::max);
    drawing.width = right + MARGIN;

    let mut y = drawing.head(content);
    // The names of the steps rise from the lanes; what is left of them belongs to the legend.
    let rise = width(&headings) * sin + SIZE;
    let legend = drawing.legend(y + LANE);
    let top = (y + rise).max(legend) + 10.0;
    y = top;
    for (index, part) in content.parts.iter().enumerate() {
        let own = || content.resources.iter().filter(|resource| resource.part == part.name);
        if own().next().is_none() {
            continue;
        }
        let base = y + 0.7 * LANE;
        let tone = Tone::Part(index);
        drawing.texts.push(Text { tone, ..Text::new(MARGIN, base, part.name.as_str()) });
        let total = bytes(part.bytes);
        drawing.texts.push(Text { tone, right: true, ..Text::new(size_x, base, total) });
        y += LANE;
        for (lane, resource) in own().enumerate() {
            let place = Box { x: MARGIN, y, width: columns.right - MARGIN, height: LANE };
            if lane % 2 == 0 {
                drawing.shapes.push(Shape { place, fill: Fill::Stripe, part: index });
            }
            let base = y + 0.7 * LANE;
            let quiet = |text: Text| Text { tone: Tone::Quiet, ..text };
            drawing.texts.push(Text::new(name_x, base, name(resource)));
            drawing.texts.push(quiet(Text::new(kind_x, base, what(resource))));
            let text = Text::new(size_x, base, size(resource));
            drawing.texts.push(Text { right: true, ..text });
            drawing.bar(content, resource, [bar_x, y], index);
            drawing.lane(rows, &columns, resource, y + LANE / 2.0, index);
            y += LANE;
        }
    }
    drawing.steps_above(content, rows, &columns, &headings, [top, y]);
    drawing.list(content, rows, y + 2.0 * LANE);
    drawing
}

/// Names of parts, in front of which there is no space for a lane's.
fn part_width(content: &Content) -> f64 {
    widest(content.parts.iter().map(|part| part.name.as_str()))
}

fn name(resource: &Resource) -> String {
    let mark = if resource.external { " (host)" } else { "" };
    format!("{}{mark}", resource.name)
}

/// What stands above a column.
fn heading(row: &Row) -> String {
    let rounds = if row.rounds > 1 { format!(" x{}", row.rounds) } else { String::new() };
    format!("{} {}{rounds}", row.number, row.pass)
}

impl Layout {
    /// The title, what is not the default, and the totals; returns where they end.
    fn head(&mut self, content: &Content) -> f64 {
        let mut y = MARGIN + LARGE;
        let tone = Tone::Strong;
        let title = Text::new(MARGIN, y, content.title.as_str());
        self.texts.push(Text { size: LARGE, tone, ..title });
        let parts = content.parts.iter().filter(|part| part.bytes > 0);
        let parts = parts.map(|part| format!("{} {}", part.name, bytes(part.bytes)));
        let mut words = vec![format!("{} in all:", bytes(content.bytes))];
        words.push(parts.collect::<Vec<_>>().join(", "));
        let changed = match content.changed.len() {
            0 => vec!["all defaults".to_owned()],
            _ => content.changed.clone(),
        };
        for (words, separator) in [(words, " "), (changed, ", ")] {
            for line in wrapped(&words, separator, self.width - 2.0 * MARGIN) {
                y += 1.5 * SIZE;
                self.texts.push(Text { tone: Tone::Quiet, ..Text::new(MARGIN, y, line) });
            }
        }
        y + LANE / 2.0
    }

    /// What the marks mean; returns where it ends.
    fn legend(&mut self, top: f64) -> f64 {
        let x = MARGIN + LANE / 2.0;
        let marks = [(true, false, "reads"), (false, true, "writes"), (true, true, "both")];
        let mut y = top;
        for (reads, writes, text) in marks {
            self.marks.push(Mark { x, y, reads, writes, title: String::new() });
            self.texts.push(Text::new(x + LANE, y + 0.2 * LANE, text));
            y += LANE;
        }
        for (fill, text) in [(Fill::Life, "in use"), (Fill::Beyond, "before or after the frame")] {
            let place = Box { x: MARGIN, y: y - 3.0, width: LANE, height: 6.0 };
            self.shapes.push(Shape { place, fill, part: 0 });
            self.texts.push(Text::new(x + LANE, y + 0.2 * LANE, text));
            y += LANE;
        }
        y
    }

    fn bar(&mut self, content: &Content, resource: &Resource, at: [f64; 2], part: usize) {
        let largest = content.resources.iter().map(|resource| resource.bytes).max().unwrap_or(0);
        let width = BAR * resource.bytes as f64 / largest.max(1) as f64;
        if resource.bytes > 0 {
            let place =
                Box { x: at[0], y: at[1] + 5.0, width: width.max(1.0), height: LANE - 10.0 };
            self.shapes.push(Shape { place, fill: Fill::Bytes, part });
        }
    }

    /// When a resource is in use, and by which steps.
    fn lane(&mut self, rows: &[Row], columns: &Columns, resource: &Resource, y: f64, part: usize) {
        let name = &resource.name;
        let uses = |row: &&Row| row.reads.contains_key(name) || row.writes.contains_key(name);
        let used: Vec<f64> =
            rows.iter().zip(&columns.x).filter(|(row, _)| uses(row)).map(|(_, x)| *x).collect();
        let ends = (used.first(), used.last(), columns.x.first(), columns.x.last());
        let (Some(&first), Some(&last), Some(&begin), Some(&end)) = ends else { return };
        let mut life = |from: f64, to: f64, fill: Fill| {
            let place = Box { x: from, y: y - 3.0, width: to - from, height: 6.0 };
            self.shapes.extend((to > from).then_some(Shape { place, fill, part }));
        };
        if resource.external || resource.kept {
            life(begin, first, Fill::Beyond);
        }
        life(first, last, Fill::Life);
        if resource.kept {
            life(last, end, Fill::Beyond);
        }
        for (row, &x) in rows.iter().zip(&columns.x) {
            let (reads, writes) = (row.reads.contains_key(name), row.writes.contains_key(name));
            if reads || writes {
                let does = match (reads, writes) {
                    (true, true) => "reads and writes",
                    (true, false) => "reads",
                    _ => "writes",
                };
                let title = format!("{} {} {does} {name}", row.number, row.pass);
                self.marks.push(Mark { x, y, reads, writes, title });
            }
        }
    }

    /// Bands of labels, colours of parts, brackets of rounds, and the names of the steps.
    fn steps_above(
        &mut self,
        content: &Content,
        rows: &[Row],
        columns: &Columns,
        headings: &[String],
        [top, bottom]: [f64; 2],
    ) {
        let mut band = false;
        for (index, row) in rows.iter().enumerate() {
            let before = index.checked_sub(1).and_then(|before| rows.get(before));
            band ^=
                before.is_some_and(|before| before.label != row.label || before.part != row.part);
            let (x, part) = (columns.x[index] - LANE / 2.0, self.part(content, row));
            let shape = |y: f64, height: f64, fill: Fill| Shape {
                place: Box { x, y, width: LANE, height },
                fill,
                part,
            };
            if band {
                self.shapes.insert(0, shape(top, bottom - top, Fill::Band));
            }
            self.shapes.push(shape(top, 4.0, Fill::Part));
            if row.rounds > 1 {
                self.shapes.push(shape(bottom + 3.0, 3.0, Fill::Rounds));
            }
            let text =
                Text::new(columns.x[index] + 0.3 * SIZE, top - 6.0, headings[index].as_str());
            let list = |what: &str, of: Vec<String>| {
                if of.is_empty() { String::new() } else { format!("\n{what} {}", of.join(", ")) }
            };
            let title = format!(
                "{}\n{}{}{}",
                row.variant(),
                row.work(),
                list("reads", levels(&row.reads)),
                list("writes", levels(&row.writes))
            );
            self.texts.push(Text { slanted: true, title, ..text });
        }
    }

    fn part(&self, content: &Content, row: &Row) -> usize {
        content.parts.iter().position(|part| part.name == row.part).unwrap_or(0)
    }

    /// The steps with their variants and what they run, in as many columns as there is room for.
    fn list(&mut self, content: &Content, rows: &[Row], top: f64) {
        let mut lines: Vec<Line> = Vec::new();
        let mut label = None;
        for row in rows {
            if label != Some((&row.part, &row.label)) {
                let text = match row.label.as_str() {
                    "" => row.part.clone(),
                    label => format!("{}: {label}", row.part),
                };
                let tone = Tone::Part(self.part(content, row));
                lines.push(Line { text, work: String::new(), tone });
            }
            label = Some((&row.part, &row.label));
            let rounds =
                if row.rounds > 1 { format!("{} times ", row.rounds) } else { String::new() };
            let text = format!("{:>3} {}", row.number, row.variant());
            lines.push(Line { text, work: rounds + &row.work(), tone: Tone::Plain });
        }
        let width = |line: &Line| {
            let work = if line.work.is_empty() { 0.0 } else { GAP + wide(&line.work, SIZE) };
            wide(&line.text, SIZE) + work
        };
        let widest = lines.iter().map(width).fold(1.0, f64::max);
        let room = self.width - 2.0 * MARGIN;
        let fits = ((room + 2.0 * GAP) / (widest + 2.0 * GAP)).floor().max(1.0) as usize;
        // What is wider than the drawing makes it wider.
        self.width = self.width.max(widest + 2.0 * MARGIN);
        let (mut height, mut places) = (0, vec![0]);
        while places.last().is_some_and(|last| *last >= fits * height) {
            height += 1;
            places = slots(&lines, height);
        }
        let step = (self.width - 2.0 * MARGIN + 2.0 * GAP) / fits as f64;
        for (Line { text, work, tone }, place) in lines.into_iter().zip(places) {
            let x = MARGIN + step * (place / height) as f64;
            let y = top + 1.5 * SIZE * (place % height) as f64;
            let end = x + wide(&text, SIZE) + GAP;
            self.texts.push(Text { tone, ..Text::new(x, y, text) });
            if !work.is_empty() {
                self.texts.push(Text { tone: Tone::Quiet, ..Text::new(end, y, work) });
            }
        }
        self.height = top + 1.5 * SIZE * height as f64 + MARGIN;
    }
}

/// A line of the list of steps: a label, or a step with what it runs.
struct Line {
    text: String,
    work: String,
    tone: Tone,
}

/// Where lines stand in columns of so many: a label is not the last one of a column.
fn slots(lines: &[Line], height: usize) -> Vec<usize> {
    let mut next = 0;
    let place = |line: &Line| {
        if matches!(line.tone, Tone::Part(_)) && height > 1 && next % height == height - 1 {
            next += 1;
        }
        next += 1;
        next - 1
    };
    lines.iter().map(place).collect()
}

/// Words in lines of at most so many pixels.
fn wrapped(words: &[String], separator: &str, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words {
        match lines.last_mut() {
            Some(line) if wide(&format!("{line}{separator}{word}"), SIZE) <= width => {
                line.push_str(separator);
                line.push_str(word);
            }
            _ => lines.push(word.clone()),
        }
    }
    lines
}

//! Error against time of every configuration, and what dominates those that are dominated.

use maud::{Markup, html};
use sglow_results::frontier::document::{Dominated, Way};

use crate::page::number::{bytes, count, figure, times};
use crate::page::plot::cloud::{Dot, Floor, Kind, cloud};
use crate::page::report::named::Named;
use crate::page::table::{number, table, text};

/// A frontier of more than these has its names in the table alone, but for the default's and those at its ends.
const MANY: usize = 9;

pub(crate) fn section(named: &Named<'_>) -> Markup {
    let crowded = named.ways().iter().filter(|way| way.on_frontier(named.metric)).count() > MANY;
    let dots: Vec<Dot> = named.ways().iter().map(|way| dot(named, way, crowded)).collect();
    let floor = Floor {
        at: named.floor(),
        says: format!(
            "uncertainty of the least error, {}: no claim below",
            named.text(named.floor())
        ),
    };
    let drawing = cloud(
        &format!(
            "{}: {} against time of every configuration",
            named.scene.measured.scene,
            named.metric.title()
        ),
        "ms of indirect light in a frame",
        &named.error_axis(),
        &dots,
        (floor.at > 0.0).then_some(&floor),
    );
    html! {
        @match drawing {
            None => p.quiet { "No configuration has an error above 0: there is nothing to plot." },
            Some(drawing) => div.explorer {
                (filter(named))
                figure {
                    (drawing.points())
                    p.readout role="status" hidden {}
                    figcaption {
                        "Lower and further left is better. Numbered discs, joined by what is reached at each time: the frontier, which nothing "
                        "dominates in error and time. Rings: dominated. Crosses: leave out light that the scene has. Diamond: the default, where it is dominated. Ring around a disc: the one to take. Bars: from least to most time; where they overlap, times are not told apart. "
                        "Point at one for its axes, or walk along them with the arrow keys."
                    }
                }
            }
        }
        (frontier(named))
        (dominated(named))
    }
}

fn dot<'a>(named: &Named<'a>, way: &'a Way, crowded: bool) -> Dot {
    let taken = named.takes(way);
    let number = named.number(way).filter(|_| way.on_frontier(named.metric));
    let kind = match number {
        Some(number) if crowded && !way.default && !taken && !named.ends(way) => {
            Kind::Frontier { number, name: String::new(), ringed: false }
        }
        Some(number) => {
            Kind::Frontier { number, name: shortened(&named.words(way)), ringed: taken }
        }
        None if way.default => Kind::Named("default".to_owned()),
        None if way.complete => Kind::Beaten,
        None => Kind::Lacking,
    };
    Dot {
        x: way.time.median,
        spread: [way.time.least, way.time.most],
        y: named.value(way),
        kind,
        says: says(named, way),
        key: key(named, way),
    }
}

/// Axes that are not the same for all, by their index.
fn key(named: &Named<'_>, way: &Way) -> String {
    let index = |(axis, values): &(&str, Vec<&str>)| {
        let value = way.axes.get(*axis);
        let found = value.and_then(|value| values.iter().position(|one| one == value));
        found.map_or_else(String::new, |index| index.to_string())
    };
    named.axes.iter().map(index).collect::<Vec<_>>().join(",")
}

fn shortened(words: &str) -> String {
    let most = 40;
    if words.chars().count() <= most {
        return words.to_owned();
    }
    words.chars().take(most - 1).chain(['…']).collect()
}

/// All that there is to say of a way in a few lines.
fn says<'a>(named: &Named<'a>, way: &'a Way) -> String {
    let time = way.time;
    let axes: Vec<String> = named
        .axes
        .iter()
        .filter_map(|(axis, _)| Some(format!("{axis} {}", way.axes.get(*axis)?)))
        .collect();
    let mut lines = vec![
        named.line(way),
        axes.join(", "),
        format!(
            "error {}, {} ms ({} to {}), {}",
            named.cell(way),
            figure(time.median),
            figure(time.least),
            figure(time.most),
            bytes(Named::bytes(way)),
        ),
    ];
    if way.default {
        lines.push("what the scene gets if nobody chooses".to_owned());
    }
    if !way.complete {
        lines.push("leaves out light that the scene has".to_owned());
    }
    if let Some(dominated) = named.dominated(way) {
        lines.push(format!(
            "dominated by {}: {}",
            caller(named, dominated),
            by_how_much(dominated)
        ));
    }
    lines.retain(|line| !line.is_empty());
    lines.join("\n")
}

fn caller(named: &Named<'_>, dominated: &Dominated) -> String {
    named.way(&dominated.by).map_or_else(|| dominated.by.clone(), |by| named.line(by))
}

fn by_how_much(dominated: &Dominated) -> String {
    let clear = if dominated.clear { "" } else { ", times within the spread" };
    let error = match dominated.error_ratio {
        // Nothing over nothing.
        ratio if ratio.is_nan() => "the same error".to_owned(),
        ratio => format!("{} the error", times(ratio)),
    };
    format!("{} the time, {error}{clear}", times(dominated.time_ratio))
}

/// One list of values for each axis; without a script there is nothing to choose.
fn filter(named: &Named<'_>) -> Markup {
    html! {
        div.filter hidden {
            span { "Show only:" }
            @for (index, (axis, values)) in named.axes.iter().enumerate() {
                label {
                    (axis) " "
                    select data-axis=(index) {
                        option value="" { "any" }
                        @for (index, value) in values.iter().enumerate() { option value=(index) { (value) } }
                    }
                }
            }
            output {}
        }
    }
}

fn frontier(named: &Named<'_>) -> Markup {
    let mut shown = named.frontier();
    shown.extend(named.default().filter(|way| !way.on_frontier(named.metric)));
    let rows: Vec<Markup> = shown
        .into_iter()
        .map(|way| {
            let ratio = |of: &dyn Fn(&Way) -> f64| {
                named.default().map_or_else(|| "–".to_owned(), |default| times(of(way) / of(default)))
            };
            html! {
                tr {
                    th scope="row" { (named.badge(way)) }
                    td.wide {
                        (named.words(way))
                        @if named.takes(way) { " " span.tag { "take this" } }
                        @if !way.complete { " " span.tag { "leaves light out" } }
                        @if let Some(dominated) = named.dominated(way) { " " span.quiet { "dominated by " (caller(named, dominated)) } }
                    }
                    td.n { (named.cell(way)) }
                    td.n { (figure(way.time.median)) }
                    td.n { (figure(way.time.least)) " to " (figure(way.time.most)) }
                    td.n { (way.whole.map_or_else(|| "–".to_owned(), |whole| figure(whole.median))) }
                    td.n { (ratio(&|way| named.value(way))) }
                    td.n { (ratio(&|way| way.time.median)) }
                    td.n { (bytes(Named::bytes(way))) }
                    td.n { (way.flicker.map_or_else(|| "–".to_owned(), |flicker| named.error(flicker))) }
                }
            }
        })
        .collect();
    let columns = [
        text(""),
        text("configuration, where it differs from the default"),
        number("error"),
        number("ms"),
        number("spread"),
        number("as one frame, ms"),
        number("error over the default's"),
        number("time over the default's"),
        number("memory"),
        number("flicker"),
    ];
    html! {
        (table(&format!("Frontier of {}", named.scene.measured.scene), "", &columns, &rows))
    }
}

/// Those that are dominated, by what dominates them.
fn dominated(named: &Named<'_>) -> Markup {
    let mut groups: Vec<(&str, Vec<(&Way, &Dominated)>)> = Vec::new();
    for way in named.ways() {
        let Some(dominated) = named.dominated(way) else { continue };
        match groups.iter_mut().find(|group| group.0 == dominated.by) {
            Some(group) => group.1.push((way, dominated)),
            None => groups.push((&dominated.by, vec![(way, dominated)])),
        }
    }
    groups.sort_by_key(|group| {
        named.way(group.0).and_then(|by| named.number(by)).unwrap_or(usize::MAX)
    });
    let total: usize = groups.iter().map(|group| group.1.len()).sum();
    let columns = [
        text("dominated configuration"),
        text("where it differs"),
        number("time over"),
        number("error over"),
        text(""),
    ];
    html! {
        @if total > 0 {
            p { (count(total)) " configurations are dominated, by:" }
            @for (by, ways) in &groups {
                details.beaten-by {
                    summary {
                        @match named.way(by) { Some(by) => (named.call(by)), None => code { (by) } }
                        ": dominates " (count(ways.len()))
                    }
                    @let rows: Vec<Markup> = ways.iter().map(|(way, dominated)| dominated_row(named, by, way, dominated)).collect();
                    (table(&format!("Configurations that {by} dominates"), "sortable", &columns, &rows))
                }
            }
        }
    }
}

fn dominated_row<'a>(named: &Named<'a>, by: &str, way: &'a Way, dominated: &Dominated) -> Markup {
    let differences = named.way(by).map_or_else(Vec::new, |by| named.differences(way, by));
    let words: Vec<String> =
        differences.iter().map(|(axis, value)| format!("{axis} {value}")).collect();
    html! {
        tr data-key=(key(named, way)) {
            td.code { (way.name) @if way.default { " " span.tag { "default" } } }
            td.wide { (words.join(", ")) }
            td.n data-value=(dominated.time_ratio) { (times(dominated.time_ratio)) }
            td.n data-value=(dominated.error_ratio) { (times(dominated.error_ratio)) }
            td { @if !dominated.clear { span.quiet { "within the spread" } } @if !way.complete { " " span.quiet { "leaves light out" } } }
        }
    }
}

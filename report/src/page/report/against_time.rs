//! Error against time of every configuration, and what dominates those that are dominated.

use maud::{Markup, html};
use sglow_results::frontier::document::{Configuration, Dominated};

use crate::page::number::{bytes, count, figure, times};
use crate::page::plot::cloud::{Dot, Floor, Kind, cloud};
use crate::page::report::named::Named;
use crate::page::table::{number, table, text};

/// A frontier of more than these has its names in the table alone, but for the default's and those at its ends.
const MANY: usize = 9;

pub(crate) fn section(named: &Named<'_>) -> Markup {
    let crowded = named
        .configurations()
        .iter()
        .filter(|configuration| configuration.on_frontier(named.metric))
        .count()
        > MANY;
    let dots: Vec<Dot> = named
        .configurations()
        .iter()
        .map(|configuration| dot(named, configuration, crowded))
        .collect();
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
                        "dominates in error and time. Rings: dominated. Crosses: leave out light that the scene has. Diamond: the default, where it is dominated. Ring around a disc: the one to take. Bars: from least to most time; where they overlap, times are not distinguished. "
                        "Point at one for its axes, or walk along them with the arrow keys."
                    }
                }
            }
        }
        (frontier(named))
        (dominated(named))
    }
}

fn dot<'a>(named: &Named<'a>, configuration: &'a Configuration, crowded: bool) -> Dot {
    let taken = named.takes(configuration);
    let number = named.number(configuration).filter(|_| configuration.on_frontier(named.metric));
    let kind = match number {
        Some(number)
            if crowded && !configuration.default && !taken && !named.ends(configuration) =>
        {
            Kind::Frontier { number, name: String::new(), ringed: false }
        }
        Some(number) => {
            Kind::Frontier { number, name: shortened(&named.words(configuration)), ringed: taken }
        }
        None if configuration.default => Kind::Named("default".to_owned()),
        None if configuration.complete => Kind::Dominated,
        None => Kind::Lacking,
    };
    Dot {
        x: configuration.time.median,
        spread: [configuration.time.minimum, configuration.time.maximum],
        y: named.value(configuration),
        kind,
        says: says(named, configuration),
        key: key(named, configuration),
    }
}

/// Axes that are not the same for all, by their index.
fn key(named: &Named<'_>, configuration: &Configuration) -> String {
    let index = |(axis, values): &(&str, Vec<&str>)| {
        let value = configuration.axes.get(*axis);
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

/// All that there is to say of a configuration in a few lines.
fn says<'a>(named: &Named<'a>, configuration: &'a Configuration) -> String {
    let time = configuration.time;
    let axes: Vec<String> = named
        .axes
        .iter()
        .filter_map(|(axis, _)| Some(format!("{axis} {}", configuration.axes.get(*axis)?)))
        .collect();
    let mut lines = vec![
        named.line(configuration),
        axes.join(", "),
        format!(
            "error {}, {} ms ({} to {}), {}",
            named.cell(configuration),
            figure(time.median),
            figure(time.minimum),
            figure(time.maximum),
            bytes(Named::bytes(configuration)),
        ),
    ];
    if configuration.default {
        lines.push("what the scene gets if nobody chooses".to_owned());
    }
    if !configuration.complete {
        lines.push("leaves out light that the scene has".to_owned());
    }
    if let Some(dominated) = named.dominated(configuration) {
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
    named.configuration(&dominated.by).map_or_else(|| dominated.by.clone(), |by| named.line(by))
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
    shown.extend(named.default().filter(|configuration| !configuration.on_frontier(named.metric)));
    let rows: Vec<Markup> = shown
        .into_iter()
        .map(|configuration| {
            let ratio = |of: &dyn Fn(&Configuration) -> f64| {
                named.default().map_or_else(|| "–".to_owned(), |default| times(of(configuration) / of(default)))
            };
            html! {
                tr {
                    th scope="row" { (named.badge(configuration)) }
                    td.wide {
                        (named.words(configuration))
                        @if named.takes(configuration) { " " span.tag { "take this" } }
                        @if !configuration.complete { " " span.tag { "leaves light out" } }
                        @if let Some(dominated) = named.dominated(configuration) { " " span.quiet { "dominated by " (caller(named, dominated)) } }
                    }
                    td.n { (named.cell(configuration)) }
                    td.n { (figure(configuration.time.median)) }
                    td.n { (figure(configuration.time.minimum)) " to " (figure(configuration.time.maximum)) }
                    td.n { (configuration.whole.map_or_else(|| "–".to_owned(), |whole| figure(whole.median))) }
                    td.n { (ratio(&|configuration| named.value(configuration))) }
                    td.n { (ratio(&|configuration| configuration.time.median)) }
                    td.n { (bytes(Named::bytes(configuration))) }
                    td.n { (configuration.flicker.map_or_else(|| "–".to_owned(), |flicker| named.error(flicker))) }
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
    let mut groups: Vec<(&str, Vec<(&Configuration, &Dominated)>)> = Vec::new();
    for configuration in named.configurations() {
        let Some(dominated) = named.dominated(configuration) else { continue };
        match groups.iter_mut().find(|group| group.0 == dominated.by) {
            Some(group) => group.1.push((configuration, dominated)),
            None => groups.push((&dominated.by, vec![(configuration, dominated)])),
        }
    }
    groups.sort_by_key(|group| {
        named.configuration(group.0).and_then(|by| named.number(by)).unwrap_or(usize::MAX)
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
            @for (by, configurations) in &groups {
                details.dominated-by {
                    summary {
                        @match named.configuration(by) { Some(by) => (named.call(by)), None => code { (by) } }
                        ": dominates " (count(configurations.len()))
                    }
                    @let rows: Vec<Markup> = configurations.iter().map(|(configuration, dominated)| dominated_row(named, by, configuration, dominated)).collect();
                    (table(&format!("Configurations that {by} dominates"), "sortable", &columns, &rows))
                }
            }
        }
    }
}

fn dominated_row<'a>(
    named: &Named<'a>,
    by: &str,
    configuration: &'a Configuration,
    dominated: &Dominated,
) -> Markup {
    let differences =
        named.configuration(by).map_or_else(Vec::new, |by| named.differences(configuration, by));
    let words: Vec<String> =
        differences.iter().map(|(axis, value)| format!("{axis} {value}")).collect();
    html! {
        tr data-key=(key(named, configuration)) {
            td.code { (configuration.name) @if configuration.default { " " span.tag { "default" } } }
            td.wide { (words.join(", ")) }
            td.n data-value=(dominated.time_ratio) { (times(dominated.time_ratio)) }
            td.n data-value=(dominated.error_ratio) { (times(dominated.error_ratio)) }
            td { @if !dominated.clear { span.quiet { "within the spread" } } @if !configuration.complete { " " span.quiet { "leaves light out" } } }
        }
    }
}

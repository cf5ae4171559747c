//! The answer: which configuration a scene should take, and why.

use maud::{Markup, html};
use sglow_results::frontier::document::{Configuration, Metric};

use crate::page::number::{bytes, figure, percent, times};
use crate::page::report::named::Named;
use crate::page::table::{number, table, text};

/// The configurations to choose between.
pub(crate) struct Advice<'a> {
    /// The cheapest of those whose error is good enough.
    pub(crate) good: &'a Configuration,
    /// The one with the least error.
    pub(crate) best: &'a Configuration,
    /// The least error that counts as good: the greater of the share and its uncertainty.
    pub(crate) limit: f64,
    /// Whether that limit is the uncertainty of the least error.
    pub(crate) by_floor: bool,
}

/// Whether a configuration is a choice: it has all that the scene needs, and its error and time are numbers.
fn choosable(named: &Named<'_>, configuration: &Configuration) -> bool {
    configuration.complete
        && named.value(configuration).is_finite()
        && configuration.time.median.is_finite()
}

/// What to take; none if no configuration is a choice.
pub(crate) fn advise<'a>(named: &Named<'a>, within: f64) -> Option<Advice<'a>> {
    let choices =
        || named.configurations().iter().filter(|configuration| choosable(named, configuration));
    let error = |configuration: &Configuration| named.value(configuration);
    let time = |configuration: &Configuration| configuration.time.median;
    let best = choices().min_by(|one, other| {
        error(one).total_cmp(&error(other)).then(time(one).total_cmp(&time(other)))
    })?;
    let near = error(best) * (1.0 + within);
    let floor = named.floor();
    let limit = if floor > near { floor } else { near };
    let good =
        choices().filter(|configuration| error(configuration) <= limit).min_by(|one, other| {
            time(one).total_cmp(&time(other)).then(error(one).total_cmp(&error(other)))
        })?;
    Some(Advice { good, best, limit, by_floor: floor > near })
}

/// One answer for each scene.
pub(crate) fn answers(scenes: &[Named<'_>], metric: Metric, within: f64) -> Markup {
    html! {
        p.quiet {
            "Error is that of the picture's indirect light against brute force, here by " strong { (metric.title()) } ". "
            "Time is that of all passes of indirect light in one frame. Numbers in discs are those of the plots below; a configuration is called by where it differs from the default, which is what the scene gets if nobody chooses."
        }
        @if scenes.is_empty() { p.quiet { "No scene was measured." } }
        @for named in scenes {
            div.answer {
                h3 { a href={ "#" (named.id()) } { (named.scene.measured.scene) } }
                @match advise(named, within) {
                    Some(advice) => (answer(named, &advice, within)),
                    None => p { strong { "No configuration has all that the scene needs and a finite error: there is nothing to recommend." } },
                }
            }
        }
    }
}

fn answer<'a>(named: &Named<'a>, advice: &Advice<'a>, within: f64) -> Markup {
    let Advice { good, best, .. } = *advice;
    let same = good.name == best.name;
    html! {
        @if named.scene.measured.reference.dark {
            p { "No indirect light reaches what the camera sees: leave it out, or take the cheapest." }
        }
        p {
            "Take " (named.call(good)) ": " strong { (named.cell(good)) } " error in "
            strong { (figure(good.time.median)) " ms" } " and " (bytes(Named::bytes(good))) ". "
            @if same {
                "It is the most accurate, and nothing " (near(named, advice, within)) " is cheaper. "
            } @else {
                "It is the cheapest " (near(named, advice, within)) "; the most accurate, " (named.call(best)) ", takes "
                (times(best.time.median / good.time.median)) " its time for " (named.cell(best)) ". "
            }
            (against_default(named, good))
        }
        (choices(named, advice, within))
    }
}

/// What counts as good here.
fn near(named: &Named<'_>, advice: &Advice<'_>, within: f64) -> String {
    if advice.by_floor {
        format!(
            "within the uncertainty of the least error, {}, below which no difference is claimed",
            named.text(advice.limit)
        )
    } else {
        format!("within {} of the best error", percent(within))
    }
}

fn against_default<'a>(named: &Named<'a>, good: &'a Configuration) -> Markup {
    let Some(default) = named.default() else {
        return html! { "The scene has no default among these." };
    };
    if default.name == good.name {
        return html! { "It is the default: what the scene gets if nobody chooses." };
    }
    let ratio = default.time.median / good.time.median;
    let errors = named.value(default) / named.value(good);
    html! {
        "The default, " (named.badge(default)) ", takes " (times(ratio)) " the time"
        @if errors.is_finite() { " with " (times(errors)) " the error" } @else { " with " (named.cell(default)) " error" }
        @match named.dominated(default) {
            Some(dominated) => {
                ", and is dominated by " @match named.configuration(&dominated.by) { Some(by) => (named.badge(by)), None => code { (dominated.by) } }
                @if !dominated.clear { ", though within the spread of the times" }
                "."
            }
            None => "; it is on the frontier, so nothing dominates it.",
        }
    }
}

fn choices(named: &Named<'_>, advice: &Advice<'_>, within: f64) -> Markup {
    let mut roles: Vec<(String, &Configuration)> =
        vec![(format!("cheapest {}", short(advice, within)), advice.good)];
    if advice.best.name == advice.good.name {
        roles[0].0 = format!("most accurate, and {}", roles[0].0);
    } else {
        roles.push(("most accurate".to_owned(), advice.best));
    }
    let fastest = named.configurations().iter().filter(|configuration| {
        choosable(named, configuration) && configuration.on_frontier(named.metric)
    });
    if let Some(fastest) =
        fastest.min_by(|one, other| one.time.median.total_cmp(&other.time.median))
        && roles.iter().all(|role| role.1.name != fastest.name)
    {
        roles.push(("fastest of the frontier".to_owned(), fastest));
    }
    if let Some(default) = named.default() {
        match roles.iter_mut().find(|role| role.1.name == default.name) {
            Some(role) => role.0.push_str(", the default"),
            None => roles.push(("the scene's default".to_owned(), default)),
        }
    }
    let rows: Vec<Markup> = roles
        .iter()
        .map(|(role, configuration)| {
            html! {
                tr {
                    th.wide scope="row" { (role) }
                    td.wide { (named.badge(configuration)) " " (named.words(configuration)) }
                    td.n data-label="error" { (named.cell(configuration)) }
                    td.n data-label="ms" { (figure(configuration.time.median)) }
                    td.n data-label="memory" { (bytes(Named::bytes(configuration))) }
                    td.n data-label="FLIP" { (figure(configuration.picture.flip)) }
                }
            }
        })
        .collect();
    let columns = [
        text(""),
        text("configuration"),
        number("error"),
        number("ms"),
        number("memory"),
        number("FLIP"),
    ];
    table(&format!("Choices for {}", named.scene.measured.scene), "choices", &columns, &rows)
}

fn short(advice: &Advice<'_>, within: f64) -> String {
    if advice.by_floor {
        "within the uncertainty of the least error".to_owned()
    } else {
        format!("within {} of the best error", percent(within))
    }
}

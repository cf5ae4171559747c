//! The page of error against time: which configuration a scene should take, why, and the measured error of each.

use maud::{Markup, html};
use sglow_results::frontier::document::{Metric, SceneReport};
use sglow_results::static_cost::StaticCost;

use crate::json::Report;
use crate::page::frame::{Extras, Section, page_with};
use crate::page::number::{count, figure};
use crate::page::table::{mark, number, table, text};

mod advice;
mod against_time;
mod compiled;
mod costs;
mod errors;
mod left_out;
mod lists;
/// Made-up scenes with everything that a page can have.
#[cfg(test)]
#[path = "../../examples/made_up/scenes.rs"]
#[expect(dead_code, reason = "a browser opens the page of one")]
pub(crate) mod made_up;
mod named;
mod pictures;
mod scene;
mod sweeps;

use named::Named;

pub use crate::scene::{Decision, Fact};
pub use scene::{LeftOut, Scene, left_out_by};

/// All that the page shows.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// Checks, machine, date, command.
    pub report: &'a Report,
    /// Each scene.
    pub scenes: &'a [Scene<'a>],
    /// How far from the best error, as a share of it, a configuration still counts as good.
    pub within: f64,
    /// How long it took.
    pub minutes: f64,
    /// What must not be concluded.
    pub does_not_show: &'a [&'a str],
    /// What compilers of GPUs make of shaders.
    pub static_costs: &'a [StaticCost],
}

/// The page.
pub fn page(input: &Input<'_>) -> String {
    let by: Vec<Vec<Named<'_>>> = Metric::ALL
        .into_iter()
        .map(|metric| {
            let scenes = input.scenes.iter().enumerate();
            let named = scenes.map(|(index, scene)| {
                let mut named = Named::new(index, scene, metric);
                let advice = advice::advise(&named, input.within);
                named.taken = advice.map(|advice| advice.good.name.as_str());
                named
            });
            named.collect()
        })
        .collect();
    let default: &[Named<'_>] = by.first().map_or(&[], Vec::as_slice);
    let ids: Vec<String> = default.iter().map(Named::id).collect();
    let answers = |metric, at: usize| advice::answers(&by[at], metric, input.within);
    let mut sections = vec![Section {
        id: "answer",
        title: "Which configuration to take",
        body: html! { (picker()) (by_metric(&answers)) },
    }];
    for (at, id) in ids.iter().enumerate() {
        let named: Vec<&Named<'_>> = by.iter().map(|named| &named[at]).collect();
        let title = &input.scenes[at].measured.scene;
        sections.push(Section { id, title, body: scene(&named, input.static_costs) });
    }
    sections.push(Section {
        id: "checks",
        title: "Numbers held to promises",
        body: checks(input.report),
    });
    sections.push(Section {
        id: "limits",
        title: "What this does not show",
        body: html! { ul { @for line in input.does_not_show { li { (line) } } } },
    });
    sections.push(Section { id: "again", title: "How to make it again", body: again(input) });
    let extras = Extras {
        style: include_str!("report/report.css"),
        script: include_str!("report/report.js"),
    };
    page_with("sglow: error against time", &verdict(input), &sections, extras)
}

/// A list to pick the metric from; without a script the default one is shown.
fn picker() -> Markup {
    html! {
        p.picker hidden {
            label {
                "Errors by "
                select { @for metric in Metric::ALL { option value=(metric.name()) { (metric.title()) } } }
            }
        }
        noscript { p.quiet { "Errors are by " (Metric::default().title()) "; a browser that runs scripts lets you pick another metric." } }
    }
}

/// One part for each metric, of which the picked one is seen.
fn by_metric(of: &dyn Fn(Metric, usize) -> Markup) -> Markup {
    html! {
        @for (at, metric) in Metric::ALL.into_iter().enumerate() {
            div data-metric=(metric.name()) hidden[metric != Metric::default()] { (of(metric, at)) }
        }
    }
}

/// A scene, `all` by each metric.
fn scene(all: &[&Named<'_>], compiled: &[StaticCost]) -> Markup {
    let Some(named) = all.first().copied() else { return html! {} };
    let measured = named.scene.measured;
    let parts = [
        ("time", "Error against time", by_metric(&|_, at| against_time::section(all[at]))),
        ("metrics", "Where metrics disagree", errors::disagreements(named)),
        ("pictures", "Pictures", pictures::section(named)),
        ("errors", "Three errors, never mixed", errors::section(named)),
        ("flicker", "Flicker", costs::flicker(named)),
        ("lists", "Lists of the cut", lists::section(named)),
        ("passes", "Where the time goes", costs::times(named)),
        ("compiled", "Compiled for GPUs", compiled::section(named, compiled)),
        ("memory", "Memory", costs::memory(named)),
        ("sweeps", "How much is enough", sweeps::section(named)),
        ("left-out", "What was left out", left_out::section(named)),
    ];
    let [width, height] = measured.size;
    html! {
        p.quiet {
            (count(measured.triangles)) " triangles, light: " (measured.light) "; " (width) " × " (height) " pixels, map of "
            (measured.rsm_size) " squared, " (count(measured.lights as usize)) " virtual lights, " (measured.iterations)
            " bisection steps, K = " (figure(measured.size_factor)) ". Times: " (measured.clock) ", median of "
            (measured.runs) " runs. " (count(measured.configurations.len())) " configurations."
            @if measured.not_finite > 0 { strong { " " (count(measured.not_finite)) " numbers are not finite." } }
        }
        (screening(measured))
        (reference(named))
        ul.parts {
            @for (part, title, _) in &parts { li { a href={ "#" (named.id()) "-" (part) } { (title) } } }
        }
        @for (part, title, body) in &parts {
            h3 id={ (named.id()) "-" (part) } { (title) }
            (body)
        }
    }
}

/// How the configurations were found, and what was left out.
fn screening(measured: &SceneReport) -> Markup {
    let Some(screening) = &measured.screening else { return html! {} };
    let several = screening.axes.iter().filter(|axis| axis.values.len() > 1);
    let crossed: Vec<String> =
        several.map(|axis| format!("{} ({})", axis.axis, axis.values.join(", "))).collect();
    let cut: Vec<String> = screening
        .axes
        .iter()
        .flat_map(|axis| axis.cut.iter().map(move |value| format!("{}={value}", axis.axis)))
        .collect();
    html! {
        p.quiet {
            "Screened: " (count(screening.single)) " configurations that differ from the default in one value; then what is "
            "on the frontier of its axis by relative MSE on any scene of this run, crossed: " (count(screening.crossed))
            " configurations"
            @if !crossed.is_empty() { " of " (crossed.join("; ")) }
            "."
            @if !cut.is_empty() {
                " Not crossed, since there would have been too many and they change the least: " (cut.join(", ")) "."
            }
        }
    }
}

/// What pictures are compared with, and how far that is off itself.
fn reference(named: &Named<'_>) -> Markup {
    let reference = &named.scene.measured.reference;
    html! {
        p.quiet {
            "Reference: paths of one bounce with exact visibility, " (count(reference.samples as usize))
            " a pixel. Its noise is " strong { (named.error(reference.noise_over_mean)) }
            ". It is taken out of squared errors by its two halves; each error has an uncertainty, within which nothing is ranked."
            @if reference.dark {
                " " strong { "No indirect light reaches what the camera sees: errors are absolute, in the scene's unit of radiance." }
            }
        }
    }
}

fn verdict(input: &Input<'_>) -> Markup {
    let checks = &input.report.checks;
    let failing: Vec<_> = checks.iter().filter(|check| !check.holds).collect();
    let held = checks.len() - failing.len();
    let configurations: usize =
        input.scenes.iter().map(|scene| scene.measured.configurations.len()).sum();
    html! {
        p class={ "verdict " (if failing.is_empty() && held > 0 { "holds" } else { "fails" }) } {
            @if checks.is_empty() {
                "✗ Nothing was checked"
            } @else if failing.is_empty() {
                "✓ " (count(held)) " promises are kept, none is broken"
            } @else {
                "✗ " (count(failing.len())) @if failing.len() == 1 { " promise is broken, " } @else { " promises are broken, " }
                (count(held)) " kept"
            }
        }
        @if !failing.is_empty() {
            ul {
                @for check in failing {
                    li { (check.name) ": " strong { (figure(check.value)) } ", has to be " (check.relation.sign()) " " (figure(check.bound)) " " (check.unit) }
                }
            }
        }
        p {
            (count(configurations)) " configurations on " (count(input.scenes.len()))
            @if input.scenes.len() == 1 { " scene" } @else { " scenes" }
            ", each with its error and its time on " (input.report.adapter) "."
        }
    }
}

fn checks(report: &Report) -> Markup {
    let rows: Vec<Markup> = report
        .checks
        .iter()
        .map(|check| {
            html! {
                tr {
                    td.text { (check.name) }
                    td.n { (figure(check.value)) }
                    td.n { (check.relation.sign()) " " (figure(check.bound)) }
                    td { (check.unit) }
                    td { (mark(check.holds)) }
                    td.text { (check.note) }
                }
            }
        })
        .collect();
    let columns = [
        text("what"),
        number("measured"),
        number("promised"),
        text("unit"),
        text(""),
        text("on what"),
    ];
    table("Numbers held to promises", "", &columns, &rows)
}

fn again(input: &Input<'_>) -> Markup {
    let report = input.report;
    let versions: Vec<String> =
        report.versions.iter().map(|(name, version)| format!("{name} {version}")).collect();
    html! {
        dl.facts {
            dt { "command" } dd { code { (report.command) } }
            dt { "adapter" } dd { (report.adapter) }
            dt { "driver" } dd { (report.driver) }
            dt { "versions" } dd { (versions.join(", ")) }
            dt { "date" } dd { (report.date) }
            dt { "minutes" } dd { (figure(input.minutes)) }
        }
        p { code { "report.json" } " beside this page has every number, and its form in " code { "report.schema.json" } "." }
    }
}

#[cfg(test)]
mod tests;

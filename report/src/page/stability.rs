//! The page of the stability run.

use maud::{Markup, html};
use sglow_results::check::Relation;
use sglow_results::stability::halves::HalvesReport;
use sglow_results::stability::report::{ExtremeReport, FunctionReport};

use crate::json::Report;
use crate::page::frame::{Section, page};
use crate::page::number::{count, figure};

mod against_time;
mod bounds;
mod extremes;
mod functions;
mod halves;
mod literal;
mod numbers;
mod order;

pub use against_time::{CosineForms, cosine_forms, without_time};
pub use numbers::{holds, measured, most, sum, whole, worst};

/// All that was found.
pub struct Findings<'a> {
    /// Checks, machine, date, command.
    pub report: &'a Report,
    /// Each function.
    pub functions: &'a [FunctionReport],
    /// Each extreme case of the pipeline.
    pub extremes: &'a [ExtremeReport],
    /// Each scene in both precisions.
    pub halves: &'a [HalvesReport],
    /// How long it took.
    pub minutes: f64,
    /// What must not be concluded.
    pub does_not_show: &'a [&'a str],
}

impl Findings<'_> {
    /// Inputs of all functions.
    pub fn inputs(&self) -> usize {
        self.functions.iter().map(FunctionReport::inputs).sum()
    }

    /// The page.
    pub fn page(&self) -> String {
        let time = cosine_forms(self.functions);
        let sections = [
            Section {
                id: "cosine",
                title: "Error against time for the cosine forms",
                body: against_time::section(&time),
            },
            Section {
                id: "stable",
                title: "What stability buys",
                body: literal::section(self.functions),
            },
            Section {
                id: "functions",
                title: "Functions",
                body: functions::section(self.functions),
            },
            Section {
                id: "order",
                title: "Order of operations",
                body: order::section(self.functions),
            },
            Section { id: "extremes", title: "Extremes", body: extremes::section(self.extremes) },
            Section { id: "halves", title: "Half precision", body: halves::section(self.halves) },
            Section {
                id: "bounds",
                title: "Bounds and their reasons",
                body: bounds::bounds(self.functions, self.extremes),
            },
            Section {
                id: "limits",
                title: "What this does not show",
                body: html! { ul { @for line in self.does_not_show { li { (line) } } } },
            },
        ];
        page("sglow: stability", &self.verdict(), &sections)
    }

    fn verdict(&self) -> Markup {
        let report = self.report;
        let failing: Vec<_> = report.checks.iter().filter(|check| !check.holds).collect();
        let held = report.checks.len() - failing.len();
        let holds = failing.is_empty() && held > 0;
        let versions: Vec<String> =
            report.versions.iter().map(|(name, version)| format!("{name} {version}")).collect();
        let facts = [
            ("inputs", count(self.inputs())),
            ("minutes", figure(self.minutes)),
            ("adapter", report.adapter.clone()),
            ("driver", report.driver.clone()),
            ("versions", versions.join(", ")),
            ("date", report.date.clone()),
        ];
        html! {
            p class={ "verdict " (if holds { "holds" } else { "fails" }) } {
                @if report.checks.is_empty() {
                    "✗ Nothing was checked"
                } @else if holds {
                    "✓ " (count(held)) " checks pass, none fails"
                } @else {
                    "✗ " (count(failing.len())) @if failing.len() == 1 { " check fails, " } @else { " checks fail, " }
                    (count(held)) " pass"
                }
            }
            @if !failing.is_empty() {
                ul {
                    @for check in failing {
                        li {
                            (check.name) ": " strong { (measured(check.value)) } ", " (relation(check.relation)) " " (figure(check.bound)) " " (check.unit)
                        }
                    }
                }
            }
            dl.facts {
                @for (name, value) in facts { dt { (name) } dd { (value) } }
                dt { "command" } dd { code { (report.command) } }
            }
        }
    }
}

fn relation(relation: Relation) -> &'static str {
    match relation {
        Relation::AtMost => "at most",
        Relation::AtLeast => "at least",
        Relation::Equal => "has to be",
    }
}

/// Made-up findings, with everything that a page can have.
#[cfg(test)]
pub mod made_up;

#[cfg(test)]
mod tests;

//! The page of the stability run.

use maud::{Markup, html};
use sglow_results::check::Relation;
use sglow_results::error::Worst;
use sglow_results::stability::halves::HalvesReport;
use sglow_results::stability::held::Held;
use sglow_results::stability::quantity::{Quantity, Verdict};
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
mod order;

pub use against_time::{CosineForms, cosine_forms, without_time};

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

/// Whether every variant of an extreme case does as it should; none at all is a failure.
pub fn holds(extreme: &ExtremeReport) -> bool {
    !extreme.variants.is_empty() && extreme.variants.iter().all(|variant| variant.holds)
}

/// What was held against a bound; a NaN says that nothing was.
pub fn measured(value: f64) -> String {
    if value.is_nan() { "not measured".to_owned() } else { figure(value) }
}

/// The largest of a quantity over regimes, and the regime.
fn largest<'a>(
    held: impl IntoIterator<Item = &'a Held>,
    quantity: Quantity,
) -> Option<(f64, &'static str)> {
    held.into_iter()
        .filter_map(|held| Some((quantity.of(held)?, held.regime)))
        .reduce(|worst, one| if one.0 > worst.0 || one.0.is_nan() { one } else { worst })
}

/// The largest of a quantity over all regimes.
pub fn most(function: &FunctionReport, quantity: Quantity) -> Option<f64> {
    largest(&function.held, quantity).map(|(value, _)| value)
}

/// The arithmetic that is worst in a regime, and its worst number.
fn worst_arithmetic(held: &Held) -> Option<(&'static str, &Worst)> {
    held.conditioning
        .iter()
        .map(|(name, errors)| (*name, &errors.share))
        .reduce(|worst, one| if one.1.error > worst.1.error { one } else { worst })
}

/// The number that a verdict is about, with its input, where one is kept.
pub fn worst<'a>(function: &'a FunctionReport, verdict: &Verdict) -> Option<&'a Worst> {
    let held = function.held.iter().find(|held| held.regime == verdict.regime)?;
    let worst = match verdict.quantity {
        Quantity::RoundingShare => &held.rounding.share,
        Quantity::ArithmeticShare => worst_arithmetic(held)?.1,
        Quantity::TotalOverPeak => &held.total.as_ref()?.over_peak,
        Quantity::ModelOverPeak => &held.model.as_ref()?.over_peak,
        Quantity::RoundingOverPeak => &held.rounding.over_peak,
        Quantity::NotFinite => std::iter::once(&held.rounding)
            .chain(held.conditioning.values())
            .map(|errors| &errors.ulps)
            .find(|worst| !worst.measured.is_finite())?,
        Quantity::Negative | Quantity::NotMonotone | Quantity::WithoutPromise => return None,
    };
    (!worst.input.bits.is_empty()).then_some(worst)
}

/// The sum of a count over all regimes.
pub fn sum(function: &FunctionReport, quantity: Quantity) -> Option<f64> {
    let counts: Vec<f64> = function.held.iter().filter_map(|held| quantity.of(held)).collect();
    (!counts.is_empty()).then(|| counts.iter().sum())
}

/// A count that is kept as a number.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
pub fn whole(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |value| count(value as usize))
}

/// Whether a share is more than was granted.
fn exceeds(share: f64) -> bool {
    share.is_nan() || share > 1.0
}

/// Made-up findings, with everything that a page can have.
#[cfg(test)]
pub mod made_up;

#[cfg(test)]
mod tests;

//! What stability buys: the papers' literal forms beside the stable ones.

use maud::{Markup, html};
use sglow_results::stability::quantity::Quantity;
use sglow_results::stability::regime::REGIMES;
use sglow_results::stability::report::FunctionReport;

use crate::page::number::maybe;
use crate::page::plot::{Curve, curves};
use crate::page::stability::against_time::{COSINE, short};
use crate::page::stability::numbers::{sum, whole};
use crate::page::table::{number, table, text};

/// What a literal form's name ends in.
const LITERAL: &str = "_literal";
/// Errors below this are drawn at it: less than a hundredth of a rounding.
const LEAST: f64 = 1e-10;

pub(super) fn section(functions: &[FunctionReport]) -> Markup {
    let lines: Vec<Curve> = functions
        .iter()
        .filter_map(|function| {
            let points = function.curve.as_ref().filter(|_| function.name.starts_with(COSINE))?;
            Some(Curve {
                label: short(function.name).replace('_', " "),
                points: points.iter().map(|point| [point.sharpness, point.total]).collect(),
                literal: function.literal,
            })
        })
        .collect();
    let drawing = curves(
        "Error of each form of the cosine integral along sharpness",
        "sharpness",
        "largest error over the peak, over all angles",
        &lines,
        LEAST,
    );
    let rows: Vec<Markup> = functions
        .iter()
        .filter_map(|literal| {
            let stem = literal.name.strip_suffix(LITERAL)?;
            let stable = functions.iter().find(|function| function.name == stem)?;
            Some(pair(stable, literal))
        })
        .collect();
    let mut columns = vec![text("function"), text("form")];
    columns.extend(REGIMES.iter().map(|regime| number(regime.name)));
    columns.push(number("not finite"));
    columns.push(number("not monotone"));
    html! {
        @match drawing {
            Some(drawing) => (drawing.figure(&html! {
                "Device against quadrature. Where a form gives infinity or NaN, a block above the plot stands for it."
            })),
            None => p.quiet { "No form of the cosine integral was followed along sharpness." },
        }
        h3 { "Literal forms beside the stable ones" }
        p {
            "Largest error of the device over the peak, per regime of sharpness: against the reference where there is one (not marked), otherwise against the oracle (marked ∘)."
        }
        (table("Literal and stable forms", "", &columns, &rows))
    }
}

/// Two rows: a stable form, and the literal one.
fn pair(stable: &FunctionReport, literal: &FunctionReport) -> Markup {
    html! {
        @for (first, function) in [(true, stable), (false, literal)] {
            tr class=(if first { "head" } else { "" }) {
                @if first {
                    th scope="rowgroup" rowspan="2" { (stable.name) }
                }
                td { (if first { "stable" } else { "literal" }) }
                @for regime in REGIMES {
                    (pair_cell(function, regime.name))
                }
                @for quantity in [Quantity::NotFinite, Quantity::NotMonotone] {
                    @let found = sum(function, quantity);
                    td class=(if found.is_some_and(|found| found > 0.0) { "n bad" } else { "n" }) { (whole(found)) }
                }
            }
        }
    }
}

fn pair_cell(function: &FunctionReport, regime: &str) -> Markup {
    let held = function.held.iter().find(|held| held.regime == regime);
    let total = held.and_then(|held| Quantity::TotalOverPeak.of(held));
    let rounding = held.and_then(|held| Quantity::RoundingOverPeak.of(held));
    let value = total.or(rounding);
    let bad = value.is_some_and(|value| !value.is_finite() || value > 1.0);
    html! {
        td class=(if bad { "n bad" } else { "n" }) {
            (maybe(value)) @if total.is_none() && value.is_some() { " ∘" }
        }
    }
}

//! Every bound with its reason, and what came nearest to it.

use maud::{Markup, html};
use sglow_results::stability::quantity::Verdict;
use sglow_results::stability::report::{ExtremeReport, FunctionReport};

use crate::page::number::{figure, maybe};
use crate::page::stability::numbers::{holds, measured};
use crate::page::table::{mark, number, table, text};

pub(super) fn bounds(functions: &[FunctionReport], extremes: &[ExtremeReport]) -> Markup {
    // Bounds about several functions are one promise.
    let mut promises: Vec<(&Verdict, Vec<&Verdict>)> = Vec::new();
    for verdict in functions.iter().flat_map(|function| &function.verdicts) {
        let same = |one: &&mut (&Verdict, Vec<&Verdict>)| {
            let first = one.0;
            (first.quantity, first.reason) == (verdict.quantity, verdict.reason)
                && first.at_most.to_bits() == verdict.at_most.to_bits()
        };
        match promises.iter_mut().find(same) {
            Some(promise) => promise.1.push(verdict),
            None => promises.push((verdict, vec![verdict])),
        }
    }
    let rows: Vec<Markup> = promises
        .iter()
        .map(|(promise, verdicts)| {
            let failing = verdicts.iter().filter(|verdict| !verdict.holds).count();
            let nearest = verdicts
                .iter()
                .copied()
                .reduce(|worst, one| {
                    let worse = !worst.value.is_nan() && (one.value > worst.value || one.value.is_nan());
                    if worse { one } else { worst }
                })
                .unwrap_or(promise);
            html! {
                tr {
                    th scope="row" { (promise.quantity.name()) }
                    td.n { (figure(promise.at_most)) } td { (promise.quantity.unit()) }
                    td.n { (verdicts.len()) }
                    td.n { (measured(nearest.value)) } td { (nearest.function) ", " (nearest.regime) }
                    td { (mark(failing == 0)) @if failing > 0 { " for " (failing) } }
                    td.text { (promise.reason) }
                }
            }
        })
        .collect();
    let columns = [
        text("bound on"),
        number("at most"),
        text("unit"),
        number("functions"),
        number("largest"),
        text("of, in"),
        text(""),
        text("reason"),
    ];
    let own: Vec<Markup> = extremes
        .iter()
        .map(|extreme| {
            html! {
                tr {
                    th scope="row" { (extreme.name) }
                    td.n { (maybe(extreme.bound)) }
                    td { (mark(holds(extreme))) }
                    td.text { (extreme.reason) }
                }
            }
        })
        .collect();
    html! {
        h3 { "Of functions" }
        (table("Bounds of functions", "", &columns, &rows))
        h3 { "Of the pipeline in extreme cases" }
        p.quiet { "How far the mean may deviate, as a share of what is expected; without a number, only that all is finite and not negative." }
        (table("Bounds of extremes", "", &[text("case"), number("deviation at most"), text(""), text("reason")], &own))
    }
}

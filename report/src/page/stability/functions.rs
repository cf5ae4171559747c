//! Each function over all regimes, with its worst inputs.

use maud::{Markup, html};
use sglow_results::stability::quantity::Quantity;
use sglow_results::stability::report::{FunctionReport, RELATIVE_TO};

use crate::page::number::{count, exact, figure, maybe};
use crate::page::stability::numbers::{exceeds, most, sum, whole, worst_arithmetic};
use crate::page::table::{mark, number, table, text};

pub(super) fn section(functions: &[FunctionReport]) -> Markup {
    let columns = [
        text("function"),
        text("bounds"),
        number("rounding, ULP"),
        number("of the grant"),
        number("any arithmetic"),
        text("the worst"),
        number("model"),
        number("total"),
        number("not finite"),
        number("not monotone"),
        number("time"),
    ];
    let rows: Vec<Markup> =
        functions.iter().map(|function| function_rows(function, columns.len())).collect();
    html! {
        p {
            "Largest over all regimes. " em { "Rounding" } ": device against oracle, in ULP and as a share of what GPU languages grant. "
            em { "Any arithmetic" } ": the same text on the CPU in every order of operations a driver may choose, as a share of the grant. "
            em { "Model" } " and " em { "total" } ": oracle and device against the reference, over the peak. "
            em { "Time" } ": less that of reading, " code { (RELATIVE_TO) } " = 1. Counts are of the device and of the CPU under every arithmetic."
        }
        (table("Functions", "", &columns, &rows))
    }
}

fn verdict_of(function: &FunctionReport) -> Markup {
    if function.verdicts.is_empty() {
        return html! { span.quiet { "no guarantee" } };
    }
    mark(function.verdicts.iter().all(|verdict| verdict.holds))
}

fn function_rows(function: &FunctionReport, width: usize) -> Markup {
    let ulps = function.held.iter().map(|held| held.rounding.ulps.error).fold(0.0, f64::max);
    let arithmetic = function
        .held
        .iter()
        .filter_map(worst_arithmetic)
        .reduce(|worst, one| if one.1.error > worst.1.error { one } else { worst });
    let rounding = most(function, Quantity::RoundingShare);
    let over = |value: Option<f64>| {
        if value.is_some_and(exceeds) { "n bad" } else { "n" }
    };
    let some = |value: Option<f64>| {
        if value.is_some_and(|value| value > 0.0) { "n bad" } else { "n" }
    };
    let [not_finite, not_monotone] =
        [Quantity::NotFinite, Quantity::NotMonotone].map(|quantity| sum(function, quantity));
    html! {
        tr.head {
            th scope="row" { (function.name) @if function.literal { " " span.tag { "literal" } } }
            td { (verdict_of(function)) }
            td.n { (figure(ulps)) }
            td class=(over(rounding)) { (maybe(rounding)) }
            td class=(over(arithmetic.map(|one| one.1.error))) { (maybe(arithmetic.map(|one| one.1.error))) }
            td { (arithmetic.map_or("–", |one| one.0)) }
            td.n { (maybe(most(function, Quantity::ModelOverPeak))) }
            td.n { (maybe(most(function, Quantity::TotalOverPeak))) }
            td class=(some(not_finite)) { (whole(not_finite)) }
            td class=(some(not_monotone)) { (whole(not_monotone)) }
            td.n { (time(function)) }
        }
        tr {
            td.more colspan=(width) {
                details {
                    summary { "regimes and worst inputs of " (function.name) }
                    (regimes(function))
                    (worst_inputs(function))
                    p.quiet { (count(function.inputs())) " inputs; " (function.operations) " operations; " (figure(function.net.median)) " ns; results: " (function.results.join(", ")) }
                }
            }
        }
    }
}

/// The time over that of the function which all are relative to; without it, nanoseconds.
fn time(function: &FunctionReport) -> String {
    if function.relative_time.is_nan() {
        format!("{} ns", figure(function.net.median))
    } else {
        figure(function.relative_time)
    }
}

fn regimes(function: &FunctionReport) -> Markup {
    let columns = [
        text("regime"),
        number("compared"),
        number("ULP"),
        number("99.9 %"),
        number("of the grant"),
        number("any arithmetic"),
        number("model"),
        number("model RMSE"),
        number("total"),
        number("total, 99.9 %"),
        number("relative above 1e-3"),
        number("above 1e-6"),
        number("negative"),
        number("not finite"),
        number("no promise"),
        number("not monotone"),
    ];
    let rows: Vec<Markup> = function
        .held
        .iter()
        .map(|held| {
            let rounding = &held.rounding;
            let total = held.total.as_ref();
            let count_of = |quantity: Quantity| whole(quantity.of(held));
            html! {
                tr {
                    th scope="row" { (held.regime) }
                    td.n { (count(rounding.compared)) }
                    td.n { (figure(rounding.ulps.error)) }
                    td.n { (figure(rounding.ulps_999)) }
                    td.n { (figure(rounding.share.error)) }
                    td.n { (maybe(Quantity::ArithmeticShare.of(held))) }
                    td.n { (maybe(Quantity::ModelOverPeak.of(held))) }
                    td.n { (maybe(held.model.as_ref().map(|errors| errors.rmse_over_peak))) }
                    td.n { (maybe(Quantity::TotalOverPeak.of(held))) }
                    td.n { (maybe(total.map(|errors| errors.over_peak_999))) }
                    td.n { (maybe(total.map(|errors| errors.relative_above_1e3))) }
                    td.n { (maybe(total.map(|errors| errors.relative_above_1e6))) }
                    td.n { (count_of(Quantity::Negative)) }
                    td.n { (count_of(Quantity::NotFinite)) }
                    td.n { (count(rounding.without_promise)) }
                    td.n { (count_of(Quantity::NotMonotone)) }
                }
            }
        })
        .collect();
    table(&format!("Regimes of {}", function.name), "", &columns, &rows)
}

fn worst_inputs(function: &FunctionReport) -> Markup {
    let columns = [
        text("regime"),
        text("the worst"),
        number("error"),
        text("unit"),
        text("input, bits"),
        text("input"),
        number("measured"),
        number("expected"),
    ];
    let mut rows = Vec::new();
    for held in &function.held {
        let mut kinds = vec![("rounding".to_owned(), &held.rounding.share, "of the grant")];
        if let Some((arithmetic, worst)) = worst_arithmetic(held) {
            kinds.push((arithmetic.to_owned(), worst, "of the grant"));
        }
        if let Some(total) = &held.total {
            kinds.push(("total".to_owned(), &total.over_peak, "of the peak"));
        }
        // A comparison whose every number is exact has no worst one.
        for (name, worst, unit) in kinds.into_iter().filter(|one| !one.1.input.bits.is_empty()) {
            let values: Vec<String> =
                worst.input.values.iter().map(|value| format!("{value:e}")).collect();
            rows.push(html! {
                tr {
                    th scope="row" { (held.regime) }
                    td { (name) }
                    td.n { (figure(worst.error)) } td { (unit) }
                    td.code { (worst.input.bits.join(" ")) }
                    td.code { (values.join(" ")) }
                    td.n { (exact(worst.measured)) }
                    td.n { (exact(worst.expected)) }
                }
            });
        }
    }
    table(&format!("Worst inputs of {}", function.name), "", &columns, &rows)
}

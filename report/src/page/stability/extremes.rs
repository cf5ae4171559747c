//! The whole pipeline in extreme cases.

use maud::{Markup, html};
use sglow_results::stability::report::{ExtremeReport, ExtremeVariant};

use crate::page::number::{count, figure, maybe};
use crate::page::stability::numbers::holds;
use crate::page::table::{mark, number, table, text};

pub(super) fn section(extremes: &[ExtremeReport]) -> Markup {
    if extremes.is_empty() {
        return html! { p.quiet { "The pipeline was not tried in extreme cases." } };
    }
    html! {
        p { "The whole pipeline where something is extreme: the default settings, and each other value of each axis. Deviation is the mean over what is expected, less 1." }
        @for extreme in extremes {
            h3 { (extreme.name) " " (mark(holds(extreme))) }
            p { (extreme.description) @if !extreme.description.ends_with('.') { "." } }
            p.quiet {
                @match extreme.bound {
                    Some(bound) => { "Deviation at most " (figure(bound)) ": " (extreme.reason) }
                    None => { "Finite and not negative: " (extreme.reason) }
                }
            }
            @let failing = extreme.variants.iter().filter(|variant| !variant.holds).count();
            details open[failing > 0] {
                summary { (summary(extreme)) }
                (variants(extreme))
            }
        }
    }
}

/// The variants in a line: those that have to keep the bound, then those that are shown beside them.
pub(super) fn summary(extreme: &ExtremeReport) -> String {
    // A bound may leave out variants, for a reason that it gives.
    let beyond = |variant: &ExtremeVariant| {
        let deviation = variant.deviation.zip(extreme.bound);
        variant.holds && deviation.is_some_and(|(deviation, bound)| deviation.abs() > bound)
    };
    let largest = |beside: bool| {
        let chosen = extreme.variants.iter().filter(|variant| beyond(variant) == beside);
        let largest = chosen
            .filter_map(|variant| variant.deviation)
            .map(f64::abs)
            .reduce(|worst, one| if one > worst || one.is_nan() { one } else { worst });
        largest
            .map_or_else(String::new, |largest| format!(", largest deviation {}", figure(largest)))
    };
    let odd: usize =
        extreme.variants.iter().map(|variant| variant.not_finite + variant.negative).sum();
    let beside = extreme.variants.iter().filter(|variant| beyond(variant)).count();
    let (bounded, odd) = (count(extreme.variants.len() - beside), count(odd));
    let shown = match beside {
        0 => String::new(),
        beside => format!("; {} without a bound{}", count(beside), largest(true)),
    };
    format!("{bounded} variants{}{shown}; {odd} numbers not finite or negative", largest(false))
}

fn variants(extreme: &ExtremeReport) -> Markup {
    let columns = [
        text("variant"),
        number("mean"),
        number("expected"),
        number("deviation"),
        number("not finite"),
        number("negative"),
        text(""),
    ];
    let row = |variant: &ExtremeVariant| {
        html! {
            tr {
                th scope="row" { (variant.variant) }
                td.n { (figure(variant.mean)) }
                td.n { (maybe(variant.expected)) }
                td.n { (maybe(variant.deviation)) }
                td.n { (count(variant.not_finite)) }
                td.n { (count(variant.negative)) }
                td { (mark(variant.holds)) }
            }
        }
    };
    let rows: Vec<Markup> = extreme.variants.iter().map(row).collect();
    table(&format!("Variants: {}", extreme.name), "", &columns, &rows)
}

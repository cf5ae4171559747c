//! The share of the grant under each arithmetic.

use maud::{Markup, html};
use sglow_results::arithmetic::Arithmetic;
use sglow_results::stability::quantity::Quantity;
use sglow_results::stability::report::FunctionReport;

use crate::page::number::maybe;
use crate::page::stability::numbers::{exceeds, most};
use crate::page::table::{number, table, text};

/// Arithmetics in the order of the table.
const ARITHMETICS: [Arithmetic; 5] = [
    Arithmetic::Written,
    Arithmetic::Contracted,
    Arithmetic::Reassociated(1),
    Arithmetic::Flushed,
    Arithmetic::Granted(1),
];

pub(super) fn section(functions: &[FunctionReport]) -> Markup {
    let mut columns = vec![text("function"), number("device")];
    columns.extend(ARITHMETICS.iter().map(|arithmetic| number(arithmetic.name())));
    let rows: Vec<Markup> = functions
        .iter()
        .map(|function| {
            let device = most(function, Quantity::RoundingShare);
            let shares = ARITHMETICS.iter().map(|arithmetic| {
                let shares = function
                    .held
                    .iter()
                    .filter_map(|held| held.conditioning.get(arithmetic.name()))
                    .map(|errors| errors.share.error);
                shares.reduce(f64::max)
            });
            html! {
                tr {
                    th scope="row" { (function.name) @if function.literal { " " span.tag { "literal" } } }
                    @for share in std::iter::once(device).chain(shares) {
                        td class={ "n " (heat(share)) } { (maybe(share)) @if share.is_some_and(exceeds) { " ▲" } }
                    }
                }
            }
        })
        .collect();
    html! {
        p {
            "The largest error, as a share of what GPU languages grant, when the same text is evaluated in other ways. Up to 1 a function keeps its tolerance whatever the driver
             makes of it; ▲ marks more. Darker or warmer is larger, by powers of ten."
        }
        (table("Share of the grant under each arithmetic", "heat", &columns, &rows))
    }
}

/// A shade by magnitude; three within the grant, three beyond it.
pub(super) fn heat(share: Option<f64>) -> &'static str {
    match share {
        None => "",
        Some(share) if share <= 0.1 => "h0",
        Some(share) if share <= 0.5 => "h1",
        Some(share) if share <= 1.0 => "h2",
        Some(share) if share <= 10.0 => "h3",
        Some(share) if share <= 1e4 => "h4",
        // What is not finite is here too.
        Some(_) => "h5",
    }
}

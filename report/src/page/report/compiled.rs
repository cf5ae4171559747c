//! What compilers of GPUs make of the shading pass of each configuration.

use maud::{Markup, html};
use sglow_results::frontier::document::Configuration;
use sglow_results::static_cost::StaticCost;

use crate::page::number::count;
use crate::page::report::named::Named;
use crate::page::table::{number, table, text};

/// The pass that takes most of a frame.
const PASS: &str = "shade";

pub(crate) fn section(named: &Named<'_>, all: &[StaticCost]) -> Markup {
    let shown = named.shown();
    let rows: Vec<Markup> = shown
        .iter()
        .flat_map(|configuration| of(configuration, all).map(move |cost| (configuration, cost)))
        .map(|(configuration, cost)| {
            html! {
                tr {
                    th scope="row" { (configuration.name) }
                    td { (cost.family) }
                    td.n { (count(amount(cost.instructions))) }
                    td.n { (cost.loop_issue_cycles.map_or_else(|| "–".to_owned(), |cycles| count(amount(cycles)))) }
                    td.n { (cost.vgprs) }
                    td.n { (cost.subgroups_per_simd) }
                }
            }
        })
        .collect();
    let mut drivers: Vec<&str> = all.iter().map(|cost| cost.driver.as_str()).collect();
    drivers.sort_unstable();
    drivers.dedup();
    html! {
        @if rows.is_empty() {
            p.quiet { "No figures are committed of these variants: " code { "cargo xtask cost --write" } " makes them." }
        } @else {
            p.quiet {
                "The shading pass as " (drivers.join(", ")) " compiles it, on a machine without such a GPU ("
                code { "cargo xtask cost" } "). Cycles are those of the longest loop, once through: of flat lights the price \
                of one light. Nothing ran: caches, bandwidth and divergence are not in it, and shaders of another control \
                flow are not to be compared by it. Variants that are not committed are left out."
            }
            (table(
                "The shading pass, compiled",
                "",
                &[
                    text("configuration"),
                    text("family"),
                    number("instructions"),
                    number("issue cycles of the loop"),
                    number("vector registers"),
                    number("subgroups per SIMD"),
                ],
                &rows,
            ))
        }
    }
}

fn amount(value: u64) -> usize {
    usize::try_from(value).unwrap_or(usize::MAX)
}

/// What is known of a configuration's shading pass.
fn of<'a>(
    configuration: &'a Configuration,
    all: &'a [StaticCost],
) -> impl Iterator<Item = &'a StaticCost> {
    let shades = |id: &str| id.split('-').next() == Some(PASS);
    let runs = move |id: &str| shades(id) && configuration.variants.iter().any(|one| one == id);
    all.iter().filter(move |cost| runs(&cost.variant))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::report::made_up;
    use sglow_results::frontier::document::Metric;

    #[test]
    fn shading_passes_have_rows_and_what_is_unknown_is_said() {
        let scenes = made_up::scenes();
        let scene = scenes[0].scene();
        let named = Named::new(0, &scene, Metric::default());
        let variant = named.shown()[0].variants.iter().find(|id| id.starts_with("shade")).unwrap();
        let cost = |variant: &str| StaticCost {
            variant: variant.to_owned(),
            family: "navi21".to_owned(),
            driver: "radv".to_owned(),
            instructions: 1234,
            loop_issue_cycles: Some(567),
            vgprs: 64,
            subgroups_per_simd: 16,
        };
        let page = section(&named, &[cost(variant), cost("sample-warped")]).into_string();
        assert!(page.contains("567") && page.contains("as radv compiles it"), "{page}");
        assert!(!section(&named, &[cost("sample-warped")]).into_string().contains("567"));
        assert!(section(&named, &[]).into_string().contains("cargo xtask cost --write"));
    }
}

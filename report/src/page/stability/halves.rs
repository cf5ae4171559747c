//! What 16 bits save and cost.

use maud::{Markup, html};
use sglow_results::stability::halves::HalvesReport;

use crate::page::number::{count, figure};
use crate::page::stability::numbers::measured;
use crate::page::table::{mark, number, table, text};

/// What 16 bits save and cost, scene by scene.
pub(super) fn section(halves: &[HalvesReport]) -> Markup {
    if halves.is_empty() {
        return html! { p.quiet { "No scene was rendered in both precisions." } };
    }
    let errors: Vec<Markup> = halves
        .iter()
        .flat_map(|half| half.checks.iter().map(move |check| (half.scene, check)))
        .map(|(scene, check)| {
            html! {
                tr {
                    th scope="row" { (scene) }
                    td.t { (check.name) }
                    td.n { (measured(check.value)) }
                    td.n { (figure(check.at_most)) }
                    td.t { (mark(check.holds())) }
                }
            }
        })
        .collect();
    let costs: Vec<Markup> = halves
        .iter()
        .map(|half| {
            let [full, halved] = half.bytes.map(|bytes| bytes as f64);
            let time = |which: usize| -> f64 {
                half.passes.iter().filter_map(|(_, times)| times[which]).sum()
            };
            html! {
                tr {
                    th scope="row" { (half.scene) }
                    td.n { (count(half.bytes[0] as usize)) }
                    td.n { (count(half.bytes[1] as usize)) }
                    td.n { (figure(halved / full)) }
                    td.n { (figure(half.axis)) }
                    td.n { (figure(time(1) / time(0))) }
                }
            }
        })
        .collect();
    let error_columns =
        [text("scene"), text("error of f16"), number("value"), number("at most"), text("")];
    let cost_columns = [
        text("scene"),
        number("bytes, f32"),
        number("bytes, f16"),
        number("ratio"),
        number("axis, rad"),
        number("frame time, f16 over f32"),
    ];
    html! {
        p { "Moments, mips and virtual lights in 16 bits where they suffice, against 32 bits, with the same light. Positions, their weight and the specular direction stay in 32 bits: what is computed from them is a difference." }
        (table("Bytes and time of half precision", "", &cost_columns, &costs))
        (table("Errors of half precision", "", &error_columns, &errors))
    }
}

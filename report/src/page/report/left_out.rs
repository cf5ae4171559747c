//! What the scene does not need and does not pay for, and how that is known.

use std::collections::BTreeSet;

use maud::{Markup, html};
use sglow_results::frontier::document::{Pruned, Side};

use crate::page::number::{bytes, count, figure, percent, times};
use crate::page::report::named::Named;
use crate::page::report::scene::LeftOut;
use crate::page::table::{Column, number, table, text};

pub(crate) fn section(named: &Named<'_>) -> Markup {
    let scene = named.scene;
    html! {
        @match &scene.measured.pruned {
            Some(pruned) => (saved(pruned)),
            None => p.quiet { "What leaving out saves in all was not measured." },
        }
        (left_out(scene.left_out))
        h4 { "What the scene has" }
        (facts(named))
        h4 { "What was decided for it" }
        (decisions(named))
    }
}

fn saved(pruned: &Pruned) -> Markup {
    let Pruned { full, needed, size: [width, height], differing, .. } = pruned;
    let share = 1.0 - needed.texture_bytes as f64 / full.texture_bytes as f64;
    let shading = full.shade_time.median / needed.shade_time.median;
    let row = |what: &str, of: &dyn Fn(&Side) -> f64, amount: &dyn Fn(f64) -> String| {
        html! {
            tr {
                th scope="row" { (what) }
                td.n { (amount(of(full))) }
                td.n { (amount(of(needed))) }
                td.n { (times(of(full) / of(needed))) }
            }
        }
    };
    let rows = [
        row("textures", &|side| side.texture_bytes as f64, &bytes),
        row("buffers", &|side| side.buffer_bytes as f64, &bytes),
        row("shading pass, ms", &|side| side.shade_time.median, &figure),
        row("all passes, ms", &|side| side.time.median, &figure),
    ];
    let columns = [text(""), number("with everything"), number("what it needs"), number("ratio")];
    html! {
        p {
            "With what it needs alone the scene keeps " strong { (percent(share)) } " fewer bytes of textures, and shading is "
            strong { (times(shading)) } " as fast (" (width) " × " (height) " pixels, in turns). "
            @if *differing == 0 {
                "Both pictures are the same, bit for bit."
            } @else {
                strong { (count(*differing)) " numbers of the pictures differ." }
            }
        }
        (table("With everything and with what the scene needs", "", &columns, &rows))
        p.quiet { "Shading variants: " code { (full.shade) } " and " code { (needed.shade) } "." }
    }
}

fn left_out(left_out: &[LeftOut]) -> Markup {
    if left_out.is_empty() {
        return html! { p { "Nothing was left out: the scene needs all that there is." } };
    }
    let savings: BTreeSet<&str> =
        left_out.iter().flat_map(|one| one.saved.keys()).map(String::as_str).collect();
    let heads: Vec<String> = savings.iter().map(|name| name.replace('_', " ")).collect();
    let mut columns: Vec<Column<'_>> = vec![text("left out"), text("rule"), text("reason")];
    columns.extend(heads.iter().map(|name| number(name)));
    let rows: Vec<Markup> = left_out
        .iter()
        .map(|one| {
            html! {
                tr {
                    th scope="row" { (one.what) }
                    td.code { (one.rule) }
                    td.text { (one.reason) }
                    @for name in &savings {
                        td.n { (one.saved.get(*name).map_or_else(|| "–".to_owned(), |value| amount(name, *value))) }
                    }
                }
            }
        })
        .collect();
    html! {
        p.quiet { "Savings are those of one thing alone, all others left out too: they need not add up." }
        (table("What was left out", "", &columns, &rows))
    }
}

/// A saving in the unit that its name says.
fn amount(name: &str, value: f64) -> String {
    if name.ends_with("bytes") { bytes(value) } else { figure(value) }
}

fn facts(named: &Named<'_>) -> Markup {
    let rows: Vec<Markup> = named
        .scene
        .facts
        .iter()
        .map(|fact| {
            html! {
                tr {
                    th scope="row" { (fact.name) }
                    td { (if fact.holds { "✓ yes" } else { "– no" }) }
                    td.text { (fact.evidence) }
                }
            }
        })
        .collect();
    table("Facts", "", &[text("fact"), text("holds"), text("how it is known")], &rows)
}

fn decisions(named: &Named<'_>) -> Markup {
    let rows: Vec<Markup> = named
        .scene
        .decisions
        .iter()
        .map(|decision| {
            html! {
                tr {
                    th scope="row" { (decision.what) }
                    td { (decision.value) }
                    td.text { (decision.reason) }
                }
            }
        })
        .collect();
    table("Decisions", "", &[text("what"), text("value"), text("why")], &rows)
}

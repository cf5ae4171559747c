//! What each configuration costs, as bars: time of each pass, bytes of each texture and buffer, flicker.

use maud::{Markup, html};
use sglow_results::frontier::document::Configuration;

use crate::page::number::{bytes, figure};
use crate::page::plot::bars::{Bar, bars, legend, letter};
use crate::page::report::named::Named;

/// What a configuration is made of: names and amounts.
type Parts<'a> = Vec<(&'a str, f64)>;

pub(crate) fn times(named: &Named<'_>) -> Markup {
    let shown = named.shown();
    let of: Vec<Parts<'_>> = shown
        .iter()
        .map(|configuration| {
            configuration.passes.iter().map(|pass| (pass.name.as_str(), pass.time.median)).collect()
        })
        .collect();
    let spread = |configuration: &Configuration, name: &str| {
        let pass = configuration.passes.iter().find(|pass| pass.name == name);
        pass.map(|pass| format!("{} to {}", figure(pass.time.minimum), figure(pass.time.maximum)))
    };
    let marks =
        shown.iter().map(|configuration| configuration.whole.map(|whole| whole.median)).collect();
    html! {
        (chart(named, &format!("{}: time of each pass", named.scene.measured.scene), "ms, median", &of, marks, &|value| figure(value)))
        p.quiet { "The mark across a bar is the whole frame measured as one, in turns with the others." }
        (numbers(named, "Times of passes in milliseconds: median, and from least to most", &of, &|configuration, name, value| {
            html! { (figure(value)) @if let Some(spread) = spread(configuration, name) { br; span.quiet { (spread) } } }
        }))
    }
}

pub(crate) fn memory(named: &Named<'_>) -> Markup {
    let of: Vec<Parts<'_>> = named
        .shown()
        .iter()
        .map(|configuration| {
            configuration.bytes.iter().map(|(name, bytes)| (name.as_str(), *bytes as f64)).collect()
        })
        .collect();
    let marks = of.iter().map(|_| None).collect();
    html! {
        (chart(named, &format!("{}: bytes of each texture and buffer", named.scene.measured.scene), "bytes kept", &of, marks, &bytes))
        (numbers(named, "Bytes of each texture and buffer", &of, &|_, _, value| html! { (bytes(value)) }))
    }
}

/// How restless each configuration is, as far as it was measured.
pub(crate) fn flicker(named: &Named<'_>) -> Markup {
    let of: Vec<Parts<'_>> = named
        .shown()
        .iter()
        .map(|configuration| {
            configuration.flicker.iter().map(|flicker| ("flicker", *flicker)).collect()
        })
        .collect();
    let marks = of.iter().map(|_| None).collect();
    html! {
        p.quiet {
            "How much more a configuration changes from frame to frame under a moving light than it has to, over the mean. It was measured of the frontier alone."
        }
        @if of.iter().all(Vec::is_empty) {
            p.quiet { "Nothing was measured." }
        } @else {
            (chart(named, &format!("{}: flicker", named.scene.measured.scene), "flicker", &of, marks, &|value| named.error(value)))
        }
    }
}

/// Names of all parts in the order in which they come up.
fn kinds(of: &[Parts<'_>]) -> Vec<String> {
    let mut kinds: Vec<String> = Vec::new();
    for (name, _) in of.iter().flatten() {
        if !kinds.iter().any(|kind| kind == name) {
            kinds.push((*name).to_owned());
        }
    }
    kinds
}

fn chart(
    named: &Named<'_>,
    title: &str,
    axis: &str,
    of: &[Parts<'_>],
    marks: Vec<Option<f64>>,
    amount: &dyn Fn(f64) -> String,
) -> Markup {
    let kinds = kinds(of);
    let rows: Vec<Bar> = named
        .shown()
        .iter()
        .zip(of)
        .zip(marks)
        .map(|((configuration, parts), mark)| Bar {
            label: named.line(configuration),
            parts: parts
                .iter()
                .filter_map(|(name, amount)| {
                    Some((kinds.iter().position(|kind| kind == name)?, *amount))
                })
                .collect(),
            mark,
        })
        .collect();
    html! {
        @match bars(title, axis, &kinds, &rows, amount) {
            None => p.quiet { "Nothing was measured." },
            Some(drawing) => { @if kinds.len() > 1 { (legend(&kinds)) } (drawing.figure(&html! {})) }
        }
    }
}

fn numbers(
    named: &Named<'_>,
    title: &str,
    of: &[Parts<'_>],
    cell: &dyn Fn(&Configuration, &str, f64) -> Markup,
) -> Markup {
    let kinds = kinds(of);
    let shown = named.shown();
    let rows: Vec<Markup> = kinds
        .iter()
        .enumerate()
        .map(|(index, kind)| {
            html! {
                tr {
                    th scope="row" { (letter(index)) " " (kind) }
                    @for (configuration, parts) in shown.iter().zip(of) {
                        td.n {
                            @match parts.iter().find(|part| part.0 == kind) {
                                Some(part) => (cell(configuration, kind, part.1)),
                                None => "–",
                            }
                        }
                    }
                }
            }
        })
        .collect();
    let head = html! {
        tr {
            th scope="col" {}
            @for configuration in &shown { th.n scope="col" { (named.badge(configuration)) @if configuration.default { " default" } } }
        }
    };
    html! {
        details {
            summary { (title) }
            div.scroll tabindex="0" role="region" aria-label=(title) {
                table { thead { (head) } tbody { @for row in &rows { (row) } } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_keep_the_order_of_the_frame() {
        let of = [vec![("moments", 1.0), ("shade", 2.0)], vec![("cluster", 1.0), ("shade", 2.0)]];
        assert_eq!(kinds(&of), ["moments", "shade", "cluster"]);
    }
}

//! The three errors of each way, apart: rounding, model, picture; and where each is worst.

use maud::{Markup, html};
use sglow_measure::frontier::document::{Way, Worst};

use super::named::Named;
use crate::page::number::{exact, figure, maybe, percent};
use crate::page::table::{number, table, text};

pub(crate) fn section(named: &Named<'_>) -> Markup {
    let shown = named.shown();
    let rows: Vec<Markup> = shown.iter().map(|way| row(named, way)).collect();
    let columns = [
        text("way"),
        number("rounding, over the mean"),
        number("model"),
        number("picture"),
        number("relative MSE"),
        number("bias"),
        number("FLIP"),
        number("flicker"),
    ];
    html! {
        p {
            em { "Rounding" } ": the device against the oracle's f64 with the same lights. " em { "Model" }
            ": the oracle with these lights against the sum over all points of the map, neither with visibility. " em { "Picture" }
            ": against the reference, so with all of it. " em { "Bias" } ": the mean over the reference's, less 1. "
            "– was not measured: with visibility there is no rounding and no model, and flicker is of the frontier alone."
        }
        (table(&format!("Errors of {}", named.scene.measured.scene), "", &columns, &rows))
        details {
            summary { "Worst pixels, and the bits of what was shaded there" }
            (worst(named, &shown))
        }
    }
}

fn row<'a>(named: &Named<'a>, way: &'a Way) -> Markup {
    let picture = &way.picture;
    let of = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| named.error(value));
    let odd = |value: f64| if value.is_finite() { "n" } else { "n bad" };
    html! {
        tr {
            th scope="row" { (named.line(way)) }
            td.n { (maybe(way.rounding.as_ref().map(|rounding| rounding.rms_over_mean))) }
            td.n { (of(way.model_rms_over_mean)) }
            td class=(odd(picture.rmse_over_mean)) { (named.error(picture.rmse_over_mean)) }
            td class=(odd(picture.relative_mse)) { (figure(picture.relative_mse)) }
            td class=(odd(picture.bias)) { (if picture.bias > 0.0 { "+" } else { "" }) (percent(picture.bias)) }
            td.n { (figure(picture.flip)) }
            td.n { (of(way.flicker)) }
        }
    }
}

fn worst(named: &Named<'_>, shown: &[&Way]) -> Markup {
    let rows: Vec<Markup> = shown
        .iter()
        .flat_map(|way| {
            let rounding = way.rounding.as_ref().map(|rounding| ("rounding", &rounding.worst));
            rounding.into_iter().chain([("picture", &way.picture.worst)]).map(move |one| (way, one))
        })
        .map(|(way, (kind, worst))| worst_row(named, way, kind, worst))
        .collect();
    let columns = [
        text("way"),
        text("error"),
        text("pixel"),
        text("found"),
        text("expected"),
        text("position, bits"),
        text("normal, bits"),
        text("base colour, bits"),
    ];
    table(&format!("Worst pixels of {}", named.scene.measured.scene), "", &columns, &rows)
}

fn worst_row<'a>(named: &Named<'a>, way: &'a Way, kind: &str, worst: &Worst) -> Markup {
    let numbers = |values: [f64; 3]| values.map(exact).join(" ");
    html! {
        tr {
            th scope="row" { (named.badge(way)) @if way.default { " default" } }
            td { (kind) }
            td.code { (worst.pixel[0]) ", " (worst.pixel[1]) }
            td.code { (numbers(worst.found)) }
            td.code { (numbers(worst.expected)) }
            @for texel in &worst.surface { td.code { (texel.join(" ")) } }
        }
    }
}

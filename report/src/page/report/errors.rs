//! The three errors of each configuration, apart: rounding, model, picture by every metric; where each is worst; and
//! where metrics disagree.

use maud::{Markup, html};
use sglow_results::frontier::document::{Configuration, Metric, PictureError, Worst};

use crate::page::number::{count, exact, maybe};
use crate::page::report::named::Named;
use crate::page::table::{Column, number, table, text};
use crate::picture_error;

pub(crate) fn section(named: &Named<'_>) -> Markup {
    let shown = named.shown();
    let rows: Vec<Markup> = shown.iter().map(|configuration| row(named, configuration)).collect();
    let mut columns =
        vec![text("configuration"), number("rounding, over the mean"), number("model")];
    columns.extend(picture_error::HEADINGS.map(number));
    columns.push(number("flicker"));
    let unshadowed: Vec<Markup> = shown
        .iter()
        .filter_map(|configuration| {
            let error = configuration.unshadowed.as_ref()?;
            Some(html! { tr { th scope="row" { (named.line(configuration)) } (cells(error)) } })
        })
        .collect();
    html! {
        p {
            em { "Rounding" } ": the device against the oracle's f64 with the same lights. " em { "Model" }
            ": the oracle with these lights against the sum over all facets of the map, neither with visibility; RMS over the mean. "
            "The others are those of the picture against the reference, over pixels that show a surface. " em { "relMSE" }
            ": mean of the squared difference over the squared reference plus 1e-2 times its mean. " em { "RMSE" }
            ": over the mean. " em { "Median" } " and " em { "95 %" }
            ": quantiles of the relative error, the luminance of the absolute difference over that of the reference plus 1e-2 times its mean. "
            em { "Bias" } ": the mean over the reference's, less 1. "
            "Squared errors are free of the reference's noise; what is written < or ± is below it. "
            "– was not measured: with visibility there is no rounding and no model, and flicker is of the frontiers alone."
        }
        (table(&format!("Errors of {}", named.scene.measured.scene), "", &columns, &rows))
        @if !unshadowed.is_empty() {
            h4 { "Against the reference without visibility" }
            @let columns: Vec<Column<'_>> = [text("configuration")].into_iter().chain(picture_error::HEADINGS.map(number)).collect();
            (table(&format!("Errors of {} without visibility", named.scene.measured.scene), "", &columns, &unshadowed))
        }
        details {
            summary { "Worst pixels, and the bits of what was shaded there" }
            (worst(named, &shown))
        }
    }
}

fn row<'a>(named: &Named<'a>, configuration: &'a Configuration) -> Markup {
    let of = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| named.error(value));
    html! {
        tr {
            th scope="row" { (named.line(configuration)) }
            td.n { (maybe(configuration.rounding.as_ref().map(|rounding| rounding.rms_over_mean))) }
            td.n { (of(configuration.model_rms_over_mean)) }
            (cells(&configuration.picture))
            td.n { (of(configuration.flicker)) }
        }
    }
}

/// An error by every metric.
fn cells(error: &PictureError) -> Markup {
    html! {
        @for (metric, cell) in Metric::ALL.into_iter().zip(picture_error::cells(error)) {
            td class=(if error.of(metric).is_finite() { "n" } else { "n bad" }) { (cell.replace(' ', "\u{a0}")) }
        }
    }
}

/// By which metrics each configuration is on the frontier, where that is not the same for all.
pub(crate) fn disagreements(named: &Named<'_>) -> Markup {
    let shown = named.shown();
    let disputed: Vec<&&Configuration> = shown
        .iter()
        .filter(|configuration| {
            !configuration.frontiers.is_empty() && configuration.frontiers.len() < Metric::ALL.len()
        })
        .collect();
    let rows: Vec<Markup> = disputed
        .iter()
        .map(|configuration| {
            html! {
                tr {
                    td.wide { (named.call(configuration)) }
                    @for metric in Metric::ALL {
                        td {
                            @match configuration.dominated.get(&metric) {
                                None => "on it",
                                Some(dominated) => span.quiet {
                                    "dominated by " @match named.configuration(&dominated.by) { Some(by) => (named.badge(by)), None => (dominated.by) }
                                },
                            }
                        }
                    }
                }
            }
        })
        .collect();
    let mut columns = vec![text("configuration")];
    columns.extend(Metric::ALL.map(|metric| text(metric.title())));
    let all = shown.len() - disputed.len();
    html! {
        @if rows.is_empty() {
            p { "They do not: each configuration on one frontier is on all of them." }
        } @else {
            p {
                (count(disputed.len())) " of " (count(shown.len())) " configurations are on the frontier by some metrics and dominated by others"
                @if all > 0 { "; the others are the same by each" } "."
            }
            (table(&format!("Frontiers of {} by metric", named.scene.measured.scene), "", &columns, &rows))
        }
    }
}

fn worst(named: &Named<'_>, shown: &[&Configuration]) -> Markup {
    let rows: Vec<Markup> = shown
        .iter()
        .flat_map(|configuration| {
            let rounding =
                configuration.rounding.as_ref().map(|rounding| ("rounding", &rounding.worst));
            rounding
                .into_iter()
                .chain([("picture", &configuration.worst)])
                .map(move |one| (configuration, one))
        })
        .map(|(configuration, (kind, worst))| worst_row(named, configuration, kind, worst))
        .collect();
    let columns = [
        text("configuration"),
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

fn worst_row<'a>(
    named: &Named<'a>,
    configuration: &'a Configuration,
    kind: &str,
    worst: &Worst,
) -> Markup {
    let numbers = |values: [f64; 3]| values.map(exact).join(" ");
    html! {
        tr {
            th scope="row" { (named.badge(configuration)) @if configuration.default { " default" } }
            td { (kind) }
            td.code { (worst.pixel[0]) ", " (worst.pixel[1]) }
            td.code { (numbers(worst.found)) }
            td.code { (numbers(worst.expected)) }
            @for texel in &worst.surface { td.code { (texel.join(" ")) } }
        }
    }
}

//! Error and time against one number: where more of it stops paying.

use maud::{Markup, html};
use sglow_results::frontier::document::{Series, Straddling, Sweep, SweepOver, SweepPoint};

use crate::page::number::{figure, maybe};
use crate::page::plot::lines::{Line, legend, lines};
use crate::page::report::named::Named;
use crate::page::table::{number, table, text};
use crate::picture_error::{HEADINGS, cells};

pub(crate) fn section(named: &Named<'_>) -> Markup {
    let sweeps = &named.scene.measured.sweeps;
    html! {
        @if sweeps.is_empty() { p.quiet { "Nothing was varied." } }
        @for sweep in sweeps { (one(named, sweep)) }
        p { (straddling(&named.scene.measured.straddling)) }
    }
}

/// What kernels cost by the texels that they put together, in words.
fn straddling(found: &Straddling) -> String {
    format!(
        "Without visibility, kernels drawn by power, K = {}: the relative MSE of the lights is {} (median {} %), that of \
         the same kernels with their texels summed exactly {} (median {} %). The second is what kernels cost by where \
         they lie and how large they are; the rest is the form of a light, which knows only the mean of what its kernel \
         holds across edges of depth and of normals.",
        figure(found.size_factor),
        figure(found.lights_relative_mse),
        figure(100.0 * found.lights_median),
        figure(found.texels_relative_mse),
        figure(100.0 * found.texels_median),
    )
}

/// What is varied, as a heading and as the name of an axis.
fn over(sweep: &Sweep) -> [&'static str; 2] {
    match sweep.over {
        SweepOver::Iterations => ["Bisection steps", "bisection steps"],
        SweepOver::SizeFactor => ["Size of kernels", "K"],
        SweepOver::Lights => ["Virtual lights", "virtual lights"],
        SweepOver::Map => ["The light's map", "texels a side"],
    }
}

fn one(named: &Named<'_>, sweep: &Sweep) -> Markup {
    let [heading, axis] = over(sweep);
    let floor = named.scene.measured.reference.noise_over_mean;
    let picture = |point: &SweepPoint| point.picture.map(|one| one.rmse_over_mean);
    let own = |point: &SweepPoint| point.own_rms_over_mean;
    let flicker = |point: &SweepPoint| point.flicker;
    let time = |point: &SweepPoint| point.time.map(|time| time.median);
    // The ring stands for the picture's error, so it is drawn where that is and where its price is.
    let picture_lines = of(sweep, &picture, true);
    let least = picture_lines
        .iter()
        .flat_map(|line| &line.points)
        .map(|point| point[1])
        .fold(f64::INFINITY, f64::min);
    let drawings = [
        (
            lines(
                &format!("{heading}: error of the picture"),
                axis,
                "picture error, RMSE",
                &picture_lines,
                // A floor far below would flatten the lines.
                (floor > least / 4.0).then_some(floor),
            ),
            "Against the reference; the dashed line is the reference's own noise.",
        ),
        (
            lines(
                &format!("{heading}: own error"),
                axis,
                "own error",
                &of(sweep, &own, false),
                None,
            ),
            "From the limit of the same configuration: what this number is to blame for.",
        ),
        (
            lines(&format!("{heading}: time"), axis, "ms", &of(sweep, &time, true), None),
            "Of the passes that the number bears on.",
        ),
        (
            lines(
                &format!("{heading}: flicker"),
                axis,
                "flicker",
                &of(sweep, &flicker, false),
                None,
            ),
            "Change from frame to frame under a moving light that the reference does not have.",
        ),
    ];
    let names: Vec<String> = sweep.series.iter().map(|series| series.name.clone()).collect();
    html! {
        h4 { (heading) }
        p { (verdict(sweep)) }
        (legend(&names))
        div.smalls {
            @for (drawing, caption) in drawings {
                @if let Some(drawing) = drawing { (drawing.small(caption)) }
            }
        }
        p.quiet {
            "Ringed: the least number whose RMSE is within 1 % of the best."
            @if sweep.over == SweepOver::Map { " A cut is left out where its tree exceeds what the device binds." }
            @if !sweep.limit.is_empty() { " Own errors are differences from " (sweep.limit) "." }
        }
        details {
            summary { "Numbers" }
            (numbers(sweep, axis))
        }
    }
}

/// Where it stops paying, in words.
fn verdict(sweep: &Sweep) -> Markup {
    let [_, axis] = over(sweep);
    let amount = |last: f64| match sweep.over {
        SweepOver::SizeFactor => format!("{axis} = {}", figure(last)),
        SweepOver::Iterations | SweepOver::Lights | SweepOver::Map => {
            format!("{} {axis}", figure(last))
        }
    };
    let measured = sweep
        .series
        .iter()
        .filter(|series| series.points.iter().any(|point| point.picture.is_some()));
    html! {
        @for series in measured {
            em { (series.name) } ": "
            @match series.pays_until {
                Some(last) => { "more than " strong { (amount(last)) } " does not pay. " },
                None => "no end is seen. ",
            }
        }
    }
}

fn of(sweep: &Sweep, value: &dyn Fn(&SweepPoint) -> Option<f64>, ringed: bool) -> Vec<Line> {
    // A line without points keeps its place, so that colours and shapes stay those of the legend.
    let points = |series: &Series| {
        series.points.iter().filter_map(|point| Some([point.at, value(point)?])).collect()
    };
    sweep
        .series
        .iter()
        .map(|series| Line {
            name: series.name.clone(),
            points: points(series),
            ringed: series.pays_until.filter(|_| ringed),
        })
        .collect()
}

fn numbers(sweep: &Sweep, axis: &'static str) -> Markup {
    let rows: Vec<Markup> = sweep
        .series
        .iter()
        .flat_map(|series| series.points.iter().map(move |point| (series, point)))
        .map(|(series, point)| {
            html! {
                tr {
                    th scope="row" { (series.name) }
                    td.n { (figure(point.at)) }
                    @for cell in point.picture.map_or_else(|| HEADINGS.map(|_| "–".to_owned()), |one| cells(&one)) {
                        td.n { (cell.replace(' ', "\u{a0}")) }
                    }
                    td.n { (maybe(point.own_rms_over_mean)) }
                    td.n { (maybe(point.flicker)) }
                    td.n { (maybe(point.time.map(|time| time.median))) }
                }
            }
        })
        .collect();
    let mut columns = vec![text("line"), number(axis)];
    columns.extend(HEADINGS.map(number));
    columns.extend([number("own error"), number("flicker"), number("ms")]);
    table(&format!("Numbers along {axis}"), "", &columns, &rows)
}

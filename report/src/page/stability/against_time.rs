//! Error of the forms of the cosine integral against their time.

use maud::{Markup, html};
use sglow_results::stability::held::Held;
use sglow_results::stability::quantity::Quantity;
use sglow_results::stability::report::{FunctionReport, RELATIVE_TO};

use crate::page::number::figure;
use crate::page::plot::{Drawing, Rank, Spot, scatter};
use crate::page::stability::numbers::largest;
use crate::page::table::{number, table, text};

/// Regimes that virtual lights are in.
const USUAL: [&str; 3] = ["soft", "medium", "sharp"];
/// What the names of the forms of the cosine integral begin with.
pub(super) const COSINE: &str = "sg_cosine_";

fn usual(function: &FunctionReport) -> impl Iterator<Item = &Held> {
    function.held.iter().filter(|held| USUAL.contains(&held.regime))
}

/// The cosine forms as points, and how their time is measured.
pub struct CosineForms {
    pub(super) spots: Vec<Spot>,
    /// Each dominated form, and the form that dominates it.
    pub(super) dominated: Vec<(String, String)>,
    /// Forms whose time does not differ from that of reading, with their error.
    untimed: Vec<(String, f64)>,
    pub(super) x_label: String,
}

/// The forms of the cosine integral: error over the peak where virtual lights are, against time.
pub fn cosine_forms(functions: &[FunctionReport]) -> CosineForms {
    let forms: Vec<(&FunctionReport, f64)> = functions
        .iter()
        .filter(|function| function.name.starts_with(COSINE))
        .filter_map(|function| {
            Some((function, largest(usual(function), Quantity::TotalOverPeak)?.0))
        })
        .collect();
    // Without the function that all are relative to, there are nanoseconds.
    let relative = !forms.is_empty() && forms.iter().all(|one| one.0.relative_time.is_finite());
    // Time in the plot's unit, of nanoseconds.
    let unit = forms.iter().map(|one| one.0).find(|one| relative && one.relative_time > 0.0);
    let unit = unit.map_or(1.0, |one| one.relative_time / one.net.median);
    let x = |function: &FunctionReport| {
        if relative { function.relative_time } else { function.net.median }
    };
    // What is lost in the time of reading has no place on the axis, and dominates nothing.
    let (forms, untimed): (Vec<_>, Vec<_>) =
        forms.into_iter().partition(|one| x(one.0).is_finite() && x(one.0) > 0.0);
    let untimed = untimed.iter().map(|(form, error)| (form.name.to_owned(), *error)).collect();
    let mut dominated = Vec::new();
    let spots = forms
        .iter()
        .map(|&(function, error)| {
            // Literal forms are no choice, so they neither dominate nor are dominated.
            let better = forms
                .iter()
                .filter(|(other, other_error)| {
                    let as_good = *other_error <= error && x(other) <= x(function);
                    as_good && (*other_error < error || x(other) < x(function)) && !other.literal
                })
                .min_by(|one, other| one.1.total_cmp(&other.1));
            let mut rank = Rank::Best;
            let mut aside = String::new();
            if function.literal {
                rank = Rank::Literal;
            } else if let Some((better, _)) = better {
                rank = Rank::Dominated;
                aside = format!("dominated by {}", short(better.name));
                dominated.push((function.name.to_owned(), better.name.to_owned()));
            }
            let spread = [function.net.minimum, function.net.maximum].map(|time| time * unit);
            Spot { label: function.name.to_owned(), aside, x: x(function), spread, y: error, rank }
        })
        .collect();
    let x_label = if relative {
        format!("time, {RELATIVE_TO} = 1")
    } else {
        "nanoseconds, less those of reading".to_owned()
    };
    CosineForms { spots, dominated, untimed, x_label }
}

pub(super) fn short(name: &str) -> &str {
    name.strip_prefix(COSINE).unwrap_or(name)
}

impl CosineForms {
    /// What the time is relative to.
    pub fn x_label(&self) -> &str {
        &self.x_label
    }

    /// Each form with its error, its time if it is known, and the form that dominates it.
    pub fn rows(&self) -> impl Iterator<Item = (&str, f64, Option<f64>, Option<&str>)> {
        let better = |label: &str| {
            let found = self.dominated.iter().find(|(name, _)| name == label);
            found.map(|(_, better)| better.as_str())
        };
        let timed = self
            .spots
            .iter()
            .map(move |spot| (spot.label.as_str(), spot.y, Some(spot.x), better(&spot.label)));
        timed.chain(self.untimed.iter().map(|(label, error)| (label.as_str(), *error, None, None)))
    }

    /// As a plot; none without forms.
    pub fn drawing(&self) -> Option<Drawing> {
        scatter(
            "Largest error of each form of the cosine integral against its time",
            &self.x_label,
            "largest error over the peak",
            &self.spots,
        )
    }
}

/// Says of which forms there is no time.
pub fn without_time(forms: &CosineForms) -> Option<String> {
    let names: Vec<&str> = forms.untimed.iter().map(|(name, _)| name.as_str()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "The time of these does not differ from that of reading arguments: {}.",
            names.join(", ")
        )
    })
}

pub(super) fn section(forms: &CosineForms) -> Markup {
    if forms.spots.is_empty() && forms.untimed.is_empty() {
        return html! { p.quiet { "None of the cosine forms was measured." } };
    }
    let rows: Vec<Markup> = forms
        .spots
        .iter()
        .map(|spot| {
            let better = forms.dominated.iter().find(|(name, _)| *name == spot.label);
            html! {
                tr {
                    th scope="row" { (spot.label) }
                    td.n { (figure(spot.y)) }
                    td.n { (figure(spot.x)) }
                    td.n { (figure(spot.spread[0])) " to " (figure(spot.spread[1])) }
                    td {
                        @match (spot.rank, better) {
                            (Rank::Literal, _) => "literal form: shown, no choice",
                            (_, Some((_, better))) => { "dominated by " (better) }
                            _ => "on the frontier",
                        }
                    }
                }
            }
        })
        .chain(forms.untimed.iter().map(|(name, error)| {
            html! {
                tr {
                    th scope="row" { (name) }
                    td.n { (figure(*error)) }
                    td.n { "–" }
                    td.n { "–" }
                    td { "as long as reading: not drawn" }
                }
            }
        }))
        .collect();
    let columns =
        [text("form"), number("largest error"), number("time"), number("from, to"), text("")];
    html! {
        p {
            "The integral of a spherical Gaussian times a clamped cosine has no closed form; these stand in for it. Error is that of the device
             against quadrature, over the upper cosine integral (the largest value at that sharpness), at sharpness 1e-3 to 1e6. Lower and further left is better."
        }
        @if let Some(drawing) = forms.drawing() {
            (drawing.figure(&html! {
                "Discs: nothing is both faster and more accurate. Rings: something is. Triangle: the paper's literal form. Bars: minimum to maximum time of several runs; the mark is the median, which decides. Where bars overlap, the order is uncertain."
            }))
        }
        @if let Some(warning) = without_time(forms) {
            p { strong { "⚠ " (warning) } " They are not drawn, and nothing is said of which is faster." }
        }
        (table("Cosine forms", "", &columns, &rows))
    }
}

//! The page of the stability run.

use maud::{Markup, html};
use sglow_measure::arithmetic::Arithmetic;
use sglow_measure::bound::{Quantity, Verdict};
use sglow_measure::error::Worst;
use sglow_measure::halves::HalvesReport;
use sglow_measure::hold::Held;
use sglow_measure::input::REGIMES;
use sglow_measure::stability::{ExtremeReport, ExtremeVariant, FunctionReport, RELATIVE_TO};

use super::frame::{Section, page};
use super::number::{count, exact, figure, maybe};
use super::plot::{Curve, Drawing, Rank, Spot, curves, scatter};
use super::table::{mark, number, table, text};
use crate::json::{Relation, Report};

/// All that was found.
pub(crate) struct Findings<'a> {
    /// Checks, machine, date, command.
    pub(crate) report: &'a Report,
    /// Each function.
    pub(crate) functions: &'a [FunctionReport],
    /// Each extreme case of the pipeline.
    pub(crate) extremes: &'a [ExtremeReport],
    /// Each scene in both precisions.
    pub(crate) halves: &'a [HalvesReport],
    /// How long it took.
    pub(crate) minutes: f64,
    /// What must not be concluded.
    pub(crate) does_not_show: &'a [&'a str],
}

/// Regimes that virtual lights are in.
const USUAL: [&str; 3] = ["soft", "medium", "sharp"];
/// What the names of the forms of the cosine integral begin with.
const COSINE: &str = "sg_cosine_";
/// What a literal form's name ends in.
const LITERAL: &str = "_literal";
/// Errors below this are drawn at it: less than a hundredth of a rounding.
const LEAST: f64 = 1e-10;

/// Arithmetics in the order of the table.
const ARITHMETICS: [Arithmetic; 5] = [
    Arithmetic::Written,
    Arithmetic::Contracted,
    Arithmetic::Reassociated(1),
    Arithmetic::Flushed,
    Arithmetic::Granted(1),
];

impl Findings<'_> {
    /// Inputs of all functions.
    pub(crate) fn inputs(&self) -> usize {
        self.functions.iter().map(FunctionReport::inputs).sum()
    }

    /// The page.
    pub(crate) fn page(&self) -> String {
        let time = cosine_forms(self.functions);
        let sections = [
            Section {
                id: "cosine",
                title: "Error against time for the cosine forms",
                body: against_time(&time),
            },
            Section {
                id: "stable",
                title: "What stability buys",
                body: what_stability_buys(self.functions),
            },
            Section { id: "functions", title: "Functions", body: functions(self.functions) },
            Section {
                id: "order",
                title: "Order of operations",
                body: order_of_operations(self.functions),
            },
            Section { id: "extremes", title: "Extremes", body: extremes(self.extremes) },
            Section { id: "halves", title: "Half precision", body: halves(self.halves) },
            Section { id: "bounds", title: "Bounds and their reasons", body: self.bounds() },
            Section {
                id: "limits",
                title: "What this does not show",
                body: html! { ul { @for line in self.does_not_show { li { (line) } } } },
            },
        ];
        page("sglow: stability", &self.verdict(), &sections)
    }

    fn verdict(&self) -> Markup {
        let report = self.report;
        let failing: Vec<_> = report.checks.iter().filter(|check| !check.holds).collect();
        let held = report.checks.len() - failing.len();
        let holds = failing.is_empty() && held > 0;
        let versions: Vec<String> =
            report.versions.iter().map(|(name, version)| format!("{name} {version}")).collect();
        let facts = [
            ("inputs", count(self.inputs())),
            ("minutes", figure(self.minutes)),
            ("adapter", report.adapter.clone()),
            ("driver", report.driver.clone()),
            ("versions", versions.join(", ")),
            ("date", report.date.clone()),
        ];
        html! {
            p class={ "verdict " (if holds { "holds" } else { "fails" }) } {
                @if report.checks.is_empty() {
                    "✗ Nothing was checked"
                } @else if holds {
                    "✓ " (count(held)) " bounds hold, none fails"
                } @else {
                    "✗ " (count(failing.len())) @if failing.len() == 1 { " bound fails, " } @else { " bounds fail, " }
                    (count(held)) " hold"
                }
            }
            @if !failing.is_empty() {
                ul {
                    @for check in failing {
                        li {
                            (check.name) ": " strong { (measured(check.value)) } ", " (relation(check.relation)) " " (figure(check.bound)) " " (check.unit)
                        }
                    }
                }
            }
            dl.facts {
                @for (name, value) in facts { dt { (name) } dd { (value) } }
                dt { "command" } dd { code { (report.command) } }
            }
        }
    }

    fn bounds(&self) -> Markup {
        // Bounds about several functions are one promise.
        let mut promises: Vec<(&Verdict, Vec<&Verdict>)> = Vec::new();
        for verdict in self.functions.iter().flat_map(|function| &function.verdicts) {
            let same = |one: &&mut (&Verdict, Vec<&Verdict>)| {
                let first = one.0;
                (first.quantity, first.reason) == (verdict.quantity, verdict.reason)
                    && first.at_most.to_bits() == verdict.at_most.to_bits()
            };
            match promises.iter_mut().find(same) {
                Some(promise) => promise.1.push(verdict),
                None => promises.push((verdict, vec![verdict])),
            }
        }
        let rows: Vec<Markup> = promises
            .iter()
            .map(|(promise, verdicts)| {
                let failing = verdicts.iter().filter(|verdict| !verdict.holds).count();
                let nearest = verdicts
                    .iter()
                    .copied()
                    .reduce(|worst, one| {
                        let worse = !worst.value.is_nan() && (one.value > worst.value || one.value.is_nan());
                        if worse { one } else { worst }
                    })
                    .unwrap_or(promise);
                html! {
                    tr {
                        th scope="row" { (promise.quantity.name()) }
                        td.n { (figure(promise.at_most)) } td { (promise.quantity.unit()) }
                        td.n { (verdicts.len()) }
                        td.n { (measured(nearest.value)) } td { (nearest.function) ", " (nearest.regime) }
                        td { (mark(failing == 0)) @if failing > 0 { " for " (failing) } }
                        td.text { (promise.reason) }
                    }
                }
            })
            .collect();
        let columns = [
            text("bound on"),
            number("at most"),
            text("unit"),
            number("functions"),
            number("largest"),
            text("of, in"),
            text(""),
            text("reason"),
        ];
        let own: Vec<Markup> = self
            .extremes
            .iter()
            .map(|extreme| {
                html! {
                    tr {
                        th scope="row" { (extreme.name) }
                        td.n { (maybe(extreme.bound)) }
                        td { (mark(holds(extreme))) }
                        td.text { (extreme.reason) }
                    }
                }
            })
            .collect();
        html! {
            h3 { "Of functions" }
            (table("Bounds of functions", "", &columns, &rows))
            h3 { "Of the pipeline in extreme cases" }
            p.quiet { "How far the mean may deviate, as a share of what is expected; without a number, only that all is finite and not negative." }
            (table("Bounds of extremes", "", &[text("case"), number("deviation at most"), text(""), text("reason")], &own))
        }
    }
}

fn relation(relation: Relation) -> &'static str {
    match relation {
        Relation::AtMost => "at most",
        Relation::AtLeast => "at least",
        Relation::Equal => "has to be",
    }
}

/// Whether every variant of an extreme case does as it should; none at all is a failure.
pub(crate) fn holds(extreme: &ExtremeReport) -> bool {
    !extreme.variants.is_empty() && extreme.variants.iter().all(|variant| variant.holds)
}

/// What was held against a bound; a NaN says that nothing was.
pub(crate) fn measured(value: f64) -> String {
    if value.is_nan() { "not measured".to_owned() } else { figure(value) }
}

/// The largest of a quantity over regimes, and the regime.
fn largest<'a>(
    held: impl IntoIterator<Item = &'a Held>,
    quantity: Quantity,
) -> Option<(f64, &'static str)> {
    held.into_iter()
        .filter_map(|held| Some((quantity.of(held)?, held.regime)))
        .reduce(|worst, one| if one.0 > worst.0 || one.0.is_nan() { one } else { worst })
}

/// The largest of a quantity over all regimes.
pub(crate) fn most(function: &FunctionReport, quantity: Quantity) -> Option<f64> {
    largest(&function.held, quantity).map(|(value, _)| value)
}

fn usual(function: &FunctionReport) -> impl Iterator<Item = &Held> {
    function.held.iter().filter(|held| USUAL.contains(&held.regime))
}

/// The arithmetic that is worst in a regime, and its worst number.
fn worst_arithmetic(held: &Held) -> Option<(&'static str, &Worst)> {
    held.conditioning
        .iter()
        .map(|(name, errors)| (*name, &errors.share))
        .reduce(|worst, one| if one.1.error > worst.1.error { one } else { worst })
}

/// The number that a verdict is about, with its input, where one is kept.
pub(crate) fn worst<'a>(function: &'a FunctionReport, verdict: &Verdict) -> Option<&'a Worst> {
    let held = function.held.iter().find(|held| held.regime == verdict.regime)?;
    let worst = match verdict.quantity {
        Quantity::RoundingShare => &held.rounding.share,
        Quantity::ArithmeticShare => worst_arithmetic(held)?.1,
        Quantity::TotalOverPeak => &held.total.as_ref()?.over_peak,
        Quantity::ModelOverPeak => &held.model.as_ref()?.over_peak,
        Quantity::RoundingOverPeak => &held.rounding.over_peak,
        Quantity::NotFinite => std::iter::once(&held.rounding)
            .chain(held.conditioning.values())
            .map(|errors| &errors.ulps)
            .find(|worst| !worst.measured.is_finite())?,
        Quantity::Negative | Quantity::NotMonotone | Quantity::WithoutPromise => return None,
    };
    (!worst.input.bits.is_empty()).then_some(worst)
}

// ------------------------------------------------------------------------------------------------ error against time

/// The cosine forms as points, and how their time is measured.
pub(crate) struct CosineForms {
    spots: Vec<Spot>,
    /// Per form that is beaten, by which.
    beaten: Vec<(String, String)>,
    /// Forms whose time cannot be told from that of reading, with their error.
    untimed: Vec<(String, f64)>,
    x_label: String,
}

/// The forms of the cosine integral: error over the peak where virtual lights are, against time.
pub(crate) fn cosine_forms(functions: &[FunctionReport]) -> CosineForms {
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
    // What is lost in the time of reading has no place on the axis, and beats nothing.
    let (forms, untimed): (Vec<_>, Vec<_>) =
        forms.into_iter().partition(|one| x(one.0).is_finite() && x(one.0) > 0.0);
    let untimed = untimed.iter().map(|(form, error)| (form.name.to_owned(), *error)).collect();
    let mut beaten = Vec::new();
    let spots = forms
        .iter()
        .map(|&(function, error)| {
            // Literal forms are no choice, so they neither beat nor are beaten.
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
                rank = Rank::Beaten;
                aside = format!("beaten by {}", short(better.name));
                beaten.push((function.name.to_owned(), better.name.to_owned()));
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
    CosineForms { spots, beaten, untimed, x_label }
}

fn short(name: &str) -> &str {
    name.strip_prefix(COSINE).unwrap_or(name)
}

impl CosineForms {
    /// As a plot; none without forms.
    pub(crate) fn drawing(&self) -> Option<Drawing> {
        scatter(
            "Largest error of each form of the cosine integral against its time",
            &self.x_label,
            "largest error over the peak",
            &self.spots,
        )
    }
}

/// Says of which forms there is no time.
pub(crate) fn without_time(forms: &CosineForms) -> Option<String> {
    let names: Vec<&str> = forms.untimed.iter().map(|(name, _)| name.as_str()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "The time of these is not told from that of reading arguments: {}.",
            names.join(", ")
        )
    })
}

fn against_time(forms: &CosineForms) -> Markup {
    if forms.spots.is_empty() && forms.untimed.is_empty() {
        return html! { p.quiet { "None of the cosine forms was measured." } };
    }
    let rows: Vec<Markup> = forms
        .spots
        .iter()
        .map(|spot| {
            let better = forms.beaten.iter().find(|(name, _)| *name == spot.label);
            html! {
                tr {
                    th scope="row" { (spot.label) }
                    td.n { (figure(spot.y)) }
                    td.n { (figure(spot.x)) }
                    td.n { (figure(spot.spread[0])) " to " (figure(spot.spread[1])) }
                    td {
                        @match (spot.rank, better) {
                            (Rank::Literal, _) => "literal form: shown, no choice",
                            (_, Some((_, better))) => { "beaten by " (better) }
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
                    td { "not told from reading: not drawn" }
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
                "Discs: nothing is both faster and more accurate. Rings: something is. Triangle: the paper's literal form. Bars: least to most time of several runs; the mark is the median, and decides. Where bars overlap, times are not told apart."
            }))
        }
        @if let Some(warning) = without_time(forms) {
            p { strong { "⚠ " (warning) } " They are not drawn, and nothing is said of which is faster." }
        }
        (table("Cosine forms", "", &columns, &rows))
    }
}

// ---------------------------------------------------------------------------------------------- what stability buys

fn what_stability_buys(functions: &[FunctionReport]) -> Markup {
    let lines: Vec<Curve> = functions
        .iter()
        .filter_map(|function| {
            let points = function.curve.as_ref().filter(|_| function.name.starts_with(COSINE))?;
            Some(Curve {
                label: short(function.name).replace('_', " "),
                points: points.iter().map(|point| [point.sharpness, point.total]).collect(),
                literal: function.literal,
            })
        })
        .collect();
    let drawing = curves(
        "Error of each form of the cosine integral along sharpness",
        "sharpness",
        "largest error over the peak, over all angles",
        &lines,
        LEAST,
    );
    let rows: Vec<Markup> = functions
        .iter()
        .filter_map(|literal| {
            let stem = literal.name.strip_suffix(LITERAL)?;
            let stable = functions.iter().find(|function| function.name == stem)?;
            Some(pair(stable, literal))
        })
        .collect();
    let mut columns = vec![text("function"), text("form")];
    columns.extend(REGIMES.iter().map(|regime| number(regime.name)));
    columns.push(number("not finite"));
    columns.push(number("not monotone"));
    html! {
        @match drawing {
            Some(drawing) => (drawing.figure(&html! {
                "Device against quadrature. Where a form gives infinity or NaN, a block above the plot stands for it."
            })),
            None => p.quiet { "No form of the cosine integral was followed along sharpness." },
        }
        h3 { "Literal forms beside the stable ones" }
        p {
            "Largest error of the device over the peak, per regime of sharpness: against the truth where there is one (not marked), otherwise against the oracle (marked ∘)."
        }
        (table("Literal and stable forms", "", &columns, &rows))
    }
}

/// Two rows: a stable form, and the literal one.
fn pair(stable: &FunctionReport, literal: &FunctionReport) -> Markup {
    html! {
        @for (first, function) in [(true, stable), (false, literal)] {
            tr class=(if first { "head" } else { "" }) {
                @if first {
                    th scope="rowgroup" rowspan="2" { (stable.name) }
                }
                td { (if first { "stable" } else { "literal" }) }
                @for regime in REGIMES {
                    (pair_cell(function, regime.name))
                }
                @for quantity in [Quantity::NotFinite, Quantity::NotMonotone] {
                    @let found = sum(function, quantity);
                    td class=(if found.is_some_and(|found| found > 0.0) { "n bad" } else { "n" }) { (whole(found)) }
                }
            }
        }
    }
}

fn pair_cell(function: &FunctionReport, regime: &str) -> Markup {
    let held = function.held.iter().find(|held| held.regime == regime);
    let total = held.and_then(|held| Quantity::TotalOverPeak.of(held));
    let rounding = held.and_then(|held| Quantity::RoundingOverPeak.of(held));
    let value = total.or(rounding);
    let bad = value.is_some_and(|value| !value.is_finite() || value > 1.0);
    html! {
        td class=(if bad { "n bad" } else { "n" }) {
            (maybe(value)) @if total.is_none() && value.is_some() { " ∘" }
        }
    }
}

/// The sum of a count over all regimes.
pub(crate) fn sum(function: &FunctionReport, quantity: Quantity) -> Option<f64> {
    let counts: Vec<f64> = function.held.iter().filter_map(|held| quantity.of(held)).collect();
    (!counts.is_empty()).then(|| counts.iter().sum())
}

/// A count that is kept as a number.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
pub(crate) fn whole(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |value| count(value as usize))
}

// ---------------------------------------------------------------------------------------------------- functions

fn functions(functions: &[FunctionReport]) -> Markup {
    let columns = [
        text("function"),
        text("bounds"),
        number("inputs"),
        number("rounding, ULP"),
        number("99.9 %"),
        number("of the grant"),
        number("any arithmetic"),
        text("the worst"),
        number("model"),
        number("total"),
        number("negative"),
        number("not finite"),
        number("not monotone"),
        number("ns"),
        number("time"),
    ];
    let rows: Vec<Markup> =
        functions.iter().map(|function| function_rows(function, columns.len())).collect();
    html! {
        p {
            "Largest over all regimes. " em { "Rounding" } ": device against oracle, in ULP and as a share of what GPU languages grant. "
            em { "Any arithmetic" } ": the same text on the CPU in every order of operations a driver may choose, as a share of the grant. "
            em { "Model" } " and " em { "total" } ": oracle and device against the truth, over the peak. "
            em { "Time" } ": less that of reading, " code { (RELATIVE_TO) } " = 1. Counts are of the device and of the CPU under every arithmetic."
        }
        (table("Functions", "", &columns, &rows))
    }
}

fn verdict_of(function: &FunctionReport) -> Markup {
    if function.verdicts.is_empty() {
        return html! { span.quiet { "held to nothing" } };
    }
    mark(function.verdicts.iter().all(|verdict| verdict.holds))
}

fn function_rows(function: &FunctionReport, width: usize) -> Markup {
    let ulps = function.held.iter().map(|held| held.rounding.ulps.error).fold(0.0, f64::max);
    let ulps_999 = function.held.iter().map(|held| held.rounding.ulps_999).fold(0.0, f64::max);
    let arithmetic = function
        .held
        .iter()
        .filter_map(worst_arithmetic)
        .reduce(|worst, one| if one.1.error > worst.1.error { one } else { worst });
    let rounding = most(function, Quantity::RoundingShare);
    let over = |value: Option<f64>| {
        if value.is_some_and(exceeds) { "n bad" } else { "n" }
    };
    let some = |value: Option<f64>| {
        if value.is_some_and(|value| value > 0.0) { "n bad" } else { "n" }
    };
    let [not_finite, not_monotone] =
        [Quantity::NotFinite, Quantity::NotMonotone].map(|quantity| sum(function, quantity));
    html! {
        tr.head {
            th scope="row" { (function.name) @if function.literal { " " span.tag { "literal" } } }
            td { (verdict_of(function)) }
            td.n { (count(function.inputs())) }
            td.n { (figure(ulps)) }
            td.n { (figure(ulps_999)) }
            td class=(over(rounding)) { (maybe(rounding)) }
            td class=(over(arithmetic.map(|one| one.1.error))) { (maybe(arithmetic.map(|one| one.1.error))) }
            td { (arithmetic.map_or("–", |one| one.0)) }
            td.n { (maybe(most(function, Quantity::ModelOverPeak))) }
            td.n { (maybe(most(function, Quantity::TotalOverPeak))) }
            td.n { (whole(sum(function, Quantity::Negative))) }
            td class=(some(not_finite)) { (whole(not_finite)) }
            td class=(some(not_monotone)) { (whole(not_monotone)) }
            td.n { (figure(function.net.median)) }
            td.n { (if function.relative_time.is_nan() { "–".to_owned() } else { figure(function.relative_time) }) }
        }
        tr {
            td.more colspan=(width) {
                details {
                    summary { "regimes and worst inputs of " (function.name) }
                    (regimes(function))
                    (worst_inputs(function))
                    p.quiet { (function.operations) " operations; results: " (function.results.join(", ")) }
                }
            }
        }
    }
}

fn regimes(function: &FunctionReport) -> Markup {
    let columns = [
        text("regime"),
        number("compared"),
        number("ULP"),
        number("99.9 %"),
        number("of the grant"),
        number("any arithmetic"),
        number("model"),
        number("model RMSE"),
        number("total"),
        number("total, 99.9 %"),
        number("relative above 1e-3"),
        number("above 1e-6"),
        number("negative"),
        number("not finite"),
        number("no promise"),
        number("not monotone"),
    ];
    let rows: Vec<Markup> = function
        .held
        .iter()
        .map(|held| {
            let rounding = &held.rounding;
            let total = held.total.as_ref();
            let count_of = |quantity: Quantity| whole(quantity.of(held));
            html! {
                tr {
                    th scope="row" { (held.regime) }
                    td.n { (count(rounding.compared)) }
                    td.n { (figure(rounding.ulps.error)) }
                    td.n { (figure(rounding.ulps_999)) }
                    td.n { (figure(rounding.share.error)) }
                    td.n { (maybe(Quantity::ArithmeticShare.of(held))) }
                    td.n { (maybe(Quantity::ModelOverPeak.of(held))) }
                    td.n { (maybe(held.model.as_ref().map(|errors| errors.rmse_over_peak))) }
                    td.n { (maybe(Quantity::TotalOverPeak.of(held))) }
                    td.n { (maybe(total.map(|errors| errors.over_peak_999))) }
                    td.n { (maybe(total.map(|errors| errors.relative_above_1e3))) }
                    td.n { (maybe(total.map(|errors| errors.relative_above_1e6))) }
                    td.n { (count_of(Quantity::Negative)) }
                    td.n { (count_of(Quantity::NotFinite)) }
                    td.n { (count(rounding.without_promise)) }
                    td.n { (count_of(Quantity::NotMonotone)) }
                }
            }
        })
        .collect();
    table(&format!("Regimes of {}", function.name), "", &columns, &rows)
}

fn worst_inputs(function: &FunctionReport) -> Markup {
    let columns = [
        text("regime"),
        text("the worst"),
        number("error"),
        text("unit"),
        text("input, bits"),
        text("input"),
        number("measured"),
        number("expected"),
    ];
    let mut rows = Vec::new();
    for held in &function.held {
        let mut kinds = vec![("rounding".to_owned(), &held.rounding.share, "of the grant")];
        if let Some((arithmetic, worst)) = worst_arithmetic(held) {
            kinds.push((arithmetic.to_owned(), worst, "of the grant"));
        }
        if let Some(total) = &held.total {
            kinds.push(("total".to_owned(), &total.over_peak, "of the peak"));
        }
        // A comparison whose every number is exact has no worst one.
        for (name, worst, unit) in kinds.into_iter().filter(|one| !one.1.input.bits.is_empty()) {
            let values: Vec<String> =
                worst.input.values.iter().map(|value| format!("{value:e}")).collect();
            rows.push(html! {
                tr {
                    th scope="row" { (held.regime) }
                    td { (name) }
                    td.n { (figure(worst.error)) } td { (unit) }
                    td.code { (worst.input.bits.join(" ")) }
                    td.code { (values.join(" ")) }
                    td.n { (exact(worst.measured)) }
                    td.n { (exact(worst.expected)) }
                }
            });
        }
    }
    table(&format!("Worst inputs of {}", function.name), "", &columns, &rows)
}

// ------------------------------------------------------------------------------------------- order of operations

fn order_of_operations(functions: &[FunctionReport]) -> Markup {
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
            "The largest error, as a share of what GPU languages grant, when the same text is evaluated in other ways. Up to 1 a function does as promised whatever the driver
             makes of it; ▲ marks more. Darker or warmer is larger, by powers of ten."
        }
        (table("Share of the grant under each arithmetic", "heat", &columns, &rows))
    }
}

/// Whether a share is more than was granted.
fn exceeds(share: f64) -> bool {
    share.is_nan() || share > 1.0
}

/// A shade by magnitude; three within the grant, three beyond it.
fn heat(share: Option<f64>) -> &'static str {
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

// ------------------------------------------------------------------------------------------------------ extremes

fn extremes(extremes: &[ExtremeReport]) -> Markup {
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

/// What 16 bits save and cost, scene by scene.
fn halves(halves: &[HalvesReport]) -> Markup {
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

/// The variants in a line.
fn summary(extreme: &ExtremeReport) -> String {
    let deviations = extreme.variants.iter().filter_map(|variant| variant.deviation);
    let largest = deviations
        .map(f64::abs)
        .reduce(|worst, one| if one > worst || one.is_nan() { one } else { worst });
    let odd: usize =
        extreme.variants.iter().map(|variant| variant.not_finite + variant.negative).sum();
    let count_of = count(extreme.variants.len());
    let largest = largest
        .map_or_else(String::new, |largest| format!(", largest deviation {}", figure(largest)));
    // A bound may leave out variants, for a reason that it gives.
    let beyond = |variant: &&ExtremeVariant| {
        let deviation = variant.deviation.zip(extreme.bound);
        variant.holds && deviation.is_some_and(|(deviation, bound)| deviation.abs() > bound)
    };
    let exempt = match extreme.variants.iter().filter(beyond).count() {
        0 => String::new(),
        exempt => format!(" ({} beyond the bound, which is not about them)", count(exempt)),
    };
    format!("{count_of} variants{largest}{exempt}, {} numbers not finite or negative", count(odd))
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

/// Made-up findings, with everything that a page can have.
#[cfg(test)]
pub(crate) mod made_up;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::json::Check;

    fn page_of(functions: &[FunctionReport], extremes: &[ExtremeReport]) -> String {
        let report = made_up::report();
        let findings = Findings {
            report: &report,
            functions,
            extremes,
            halves: &made_up::halves(),
            minutes: 3.25,
            does_not_show: &["how fast a GPU is & more"],
        };
        findings.page()
    }

    #[test]
    fn every_section_is_there_and_nothing_comes_from_elsewhere() {
        let page = page_of(&made_up::functions(), &made_up::extremes());
        let titles = [
            "Error against time for the cosine forms",
            "What stability buys",
            "Functions",
            "Order of operations",
            "Extremes",
            "Half precision",
            "Bounds and their reasons",
            "What this does not show",
        ];
        let places = titles.map(|title| page.find(&format!("<h2>{title}</h2>")));
        assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{places:?}");
        for word in ["http:", "https:", "<script", "src=", "@import", "url("] {
            assert!(!page.contains(word), "{word}");
        }
        let drawings: Vec<&str> =
            page.split("<svg").skip(1).filter_map(|rest| rest.split("</svg>").next()).collect();
        assert_eq!(drawings.len(), 2);
        for drawing in drawings {
            assert!(!drawing.contains("NaN") && !drawing.contains("inf"), "{drawing}");
        }
    }

    #[test]
    fn what_fails_is_told_with_its_input() {
        let page = page_of(&made_up::functions(), &made_up::extremes());
        let verdict = page.find("bound fails, 1 hold").unwrap();
        assert!(verdict < page.find("<h2>").unwrap(), "the verdict stands at the top");
        for part in ["not finite", "✗ FAILS", "0x42b20000", "how fast a GPU is &amp; more"] {
            assert!(page.contains(part), "{part}");
        }
    }

    #[test]
    fn nothing_measured_is_no_success() {
        let page = page_of(&[], &[]);
        for part in ["None of the cosine forms", "was not tried", "Nothing was measured"] {
            assert!(page.contains(part), "{part}");
        }
        let report = Report::new();
        let empty = Findings {
            report: &report,
            functions: &[],
            extremes: &[],
            halves: &[],
            minutes: 0.0,
            does_not_show: &[],
        };
        assert!(empty.page().contains("Nothing was checked"));
    }

    #[test]
    fn a_form_that_is_beaten_says_by_what_and_a_literal_one_does_not_count() {
        let forms = cosine_forms(&made_up::functions());
        let of = |name: &str| forms.spots.iter().find(|spot| spot.label == name).unwrap();
        assert_eq!(of("sg_cosine_gaussian").rank, Rank::Beaten);
        assert_eq!(of("sg_cosine_gaussian").aside, "beaten by logistic");
        assert_eq!(of("sg_cosine_constant").rank, Rank::Best);
        assert_eq!(of("sg_cosine_fitted").rank, Rank::Best);
        let literal = of("sg_cosine_logistic_literal");
        assert_eq!((literal.rank, literal.y.is_finite()), (Rank::Literal, false));
        assert!(of("sg_cosine_fitted").spread[0] < of("sg_cosine_fitted").x);
        assert!(forms.drawing().unwrap().file().starts_with("<svg"));
    }

    #[test]
    fn without_what_times_are_relative_to_there_are_nanoseconds() {
        let mut functions = made_up::functions();
        functions.iter_mut().for_each(|function| function.relative_time = f64::NAN);
        let forms = cosine_forms(&functions);
        assert!(forms.x_label.starts_with("nanoseconds"));
        assert!(forms.spots.iter().all(|spot| spot.x.is_finite()));
    }

    #[test]
    fn a_form_without_a_time_is_neither_drawn_nor_beats_another() {
        let mut functions = made_up::functions();
        for function in &mut functions {
            function.relative_time = f64::NAN;
            if function.name == "sg_cosine_fitted_fine" {
                function.net = sglow_measure::hold::Time::default();
            }
        }
        let forms = cosine_forms(&functions);
        assert!(forms.spots.iter().all(|spot| spot.label != "sg_cosine_fitted_fine"));
        assert!(forms.beaten.iter().all(|(_, by)| by != "sg_cosine_fitted_fine"));
        let page = page_of(&functions, &[]);
        assert!(
            page.contains("is not told from that of reading arguments: sg_cosine_fitted_fine.")
        );
        functions.iter_mut().for_each(|function| function.net = Default::default());
        let page = page_of(&functions, &[]);
        assert!(page.contains("not drawn") && !page.contains("on the frontier"));
    }

    #[test]
    fn a_deviation_beyond_a_bound_that_is_not_about_it_is_told() {
        let mut extremes = made_up::extremes();
        assert!(!summary(&extremes[0]).contains("beyond"));
        extremes[0].variants[1].deviation = Some(0.5);
        assert!(summary(&extremes[0]).contains("(1 beyond the bound, which is not about them)"));
    }

    #[test]
    fn a_bound_from_below_is_called_so() {
        let mut report = made_up::report();
        report.check(Check::new("inputs", 3.0, "inputs", Relation::AtLeast, 1e7));
        let findings = Findings {
            report: &report,
            functions: &[],
            extremes: &[],
            halves: &[],
            minutes: 1.0,
            does_not_show: &[],
        };
        assert!(findings.page().contains("at least 10000000 inputs"));
    }

    #[test]
    fn the_same_findings_give_the_same_bytes() {
        let page = || page_of(&made_up::functions(), &made_up::extremes());
        assert_eq!(page(), page());
    }

    #[test]
    fn shades_tell_the_grant_apart_and_what_is_not_finite_is_the_darkest() {
        let shades = [0.05, 0.3, 1.0, 1.01, 1e3, f64::INFINITY].map(|share| heat(Some(share)));
        assert_eq!(shades, ["h0", "h1", "h2", "h3", "h4", "h5"]);
        assert_eq!(heat(Some(f64::NAN)), "h5");
    }
}

use std::collections::BTreeMap;

use sglow_results::arithmetic::Arithmetic;
use sglow_results::check::{Check, Relation};
use sglow_results::error::{Errors, Pair};
use sglow_results::stability::halves::{HalfCheck, HalvesReport};
use sglow_results::stability::held::{Held, Time};
use sglow_results::stability::quantity::{Quantity, Verdict};
use sglow_results::stability::regime::REGIMES;
use sglow_results::stability::report::{ExtremeReport, ExtremeVariant, FunctionReport, Point};

use crate::json::Report;

/// Errors of this size over the peak; a NaN at 89 if it is not finite.
fn errors(size: f64) -> Errors {
    let mut errors = Errors::default();
    let pair = |measured| Pair { measured, expected: 1.0, tolerance: 1e-6, peak: 1.0 };
    for index in 0..50_u8 {
        errors.add(pair(1.0), &[f32::from(index); 12], &[0, 3]);
    }
    let worst = if size.is_finite() { 1.0 + size } else { f64::NAN };
    errors.add(pair(worst), &[89.0; 12], &[0, 3]);
    Errors::default().merge(errors)
}

fn function(name: &'static str, total: f64, relative_time: f64) -> FunctionReport {
    let literal = name.ends_with("_literal");
    let held = REGIMES
        .iter()
        .map(|regime| {
            let sharp = ["sharp", "extreme", "adversarial"].contains(&regime.name);
            let total = if literal && !sharp { 1e-2 } else { total };
            let rounding = if total.is_finite() { 3e-7 } else { total };
            let conditioning = Arithmetic::ALL
                .iter()
                .map(|arithmetic| {
                    let reassociated = matches!(arithmetic, Arithmetic::Reassociated(_));
                    let size = if literal && reassociated { 2e-4 } else { 0.7 * rounding };
                    (arithmetic.name(), errors(size))
                })
                .collect::<BTreeMap<_, _>>();
            Held {
                regime: regime.name,
                rounding: errors(rounding),
                conditioning,
                model: Some(errors(if literal { 8.7e-3 } else { total })),
                total: Some(errors(total)),
                neighbours: 100,
                not_monotone: usize::from(literal) * 7,
                wrong_step_over_peak: 0.0,
            }
        })
        .collect();
    let verdict = Verdict {
        function: name,
        regime: "sharp",
        quantity: Quantity::TotalOverPeak,
        value: total,
        at_most: 0.1,
        holds: total <= 0.1,
        reason: "as the form was published",
    };
    let time = |factor: f64| 0.4 * factor * relative_time;
    let net = Time { minimum: time(0.9), median: time(1.0), maximum: time(1.3) };
    let curve = (0..=120)
        .map(|step| {
            let sharpness = 10.0_f64.powf(-6.0 + f64::from(step) / 8.0);
            let bump =
                (total.min(1e-2) * (-(sharpness.log10() - 0.5).powi(2) / 4.0).exp()).max(6e-8);
            let lost = literal && sharpness > 88.7;
            Point { sharpness, model: bump, total: if lost { f64::INFINITY } else { bump } }
        })
        .collect();
    FunctionReport {
        name,
        literal,
        results: &["integral"],
        held,
        verdicts: if literal { Vec::new() } else { vec![verdict] },
        time: net,
        net,
        relative_time,
        operations: 40,
        curve: Some(curve),
    }
}

pub(crate) fn functions() -> Vec<FunctionReport> {
    vec![
        function("sg_cosine_constant", 3.0, 1.0),
        function("sg_cosine_gaussian", 0.153, 3.4),
        function("sg_cosine_logistic", 8.7e-3, 3.1),
        function("sg_cosine_erf", 1.6e-3, 4.6),
        function("sg_cosine_fitted", 5.9e-5, 4.9),
        function("sg_cosine_fitted_fine", 1.7e-5, 5.3),
        function("sg_cosine_logistic_literal", f64::INFINITY, 3.3),
    ]
}

pub(crate) fn extremes() -> Vec<ExtremeReport> {
    let variant = |variant: &str, deviation: Option<f64>, not_finite| ExtremeVariant {
        variant: variant.to_owned(),
        not_finite,
        negative: 0,
        mean: deviation.map_or(f64::INFINITY, |deviation| 0.25 * (1.0 + deviation)),
        expected: Some(0.25),
        deviation,
        holds: not_finite == 0,
    };
    vec![
        ExtremeReport {
            name: "far away",
            description: "the scene stands 1e6 metres from the origin",
            bound: Some(1e-3),
            reason: "positions lose 20 bits, and moments are about a point of the scene",
            variants: vec![
                variant("default", Some(1e-5), 0),
                variant("kernel=previous", Some(-2e-4), 0),
            ],
        },
        ExtremeReport {
            name: "mirrors",
            description: "every surface has roughness 1e-4",
            bound: None,
            reason: "nothing is known of the mean",
            variants: vec![variant("default", None, 3)],
        },
    ]
}

pub(crate) fn report() -> Report {
    let mut report = Report::new();
    report.date = "2000-01-01T00:00:00Z".to_owned();
    report.adapter = "an adapter <made up>".to_owned();
    report.check(Check::new("one", 0.5, "of the grant", Relation::AtMost, 1.0));
    report.check(Check::new("two", f64::INFINITY, "of the grant", Relation::AtMost, 1.0));
    report
}

pub(crate) fn halves() -> Vec<HalvesReport> {
    vec![HalvesReport {
        scene: "cornell",
        bytes: [100, 70],
        axis: 1e-4,
        passes: vec![
            ("density".to_owned(), [Some(1.0), None]),
            ("shade".to_owned(), [Some(3.0), Some(2.0)]),
        ],
        checks: vec![HalfCheck {
            name: "picture, RMSE over mean",
            value: 1e-4,
            at_most: 4.9e-4,
            reason: "made up",
        }],
    }]
}

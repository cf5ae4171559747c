//! What the stability run found, as checks.

use super::halves::HalvesReport;
use super::report::{ExtremeReport, FunctionReport};
use crate::check::{Check, Relation};

/// Inputs of a whole run, at least.
const INPUTS: f64 = 1e7;
/// Minutes of a run, at most: on the two cores of a small machine.
const MINUTES: f64 = 10.0;

/// The extent and the duration of a run, which is `whole` with every function and all inputs.
#[must_use]
pub fn of_run(functions: &[FunctionReport], whole: bool, minutes: f64) -> Vec<Check> {
    let inputs: usize = functions.iter().map(FunctionReport::inputs).sum();
    let inputs = Check::new("inputs", inputs as f64, "inputs", Relation::AtLeast, INPUTS);
    let inputs = inputs.note("on the device, of all functions");
    let time = Check::new("run time", minutes, "minutes", Relation::AtMost, MINUTES);
    let time = time.note("on two cores, a software driver included");
    if whole { vec![inputs, time] } else { vec![time] }
}

/// Everything that was compared with a bound, as checks. `fitted_over_erf` bounds the time of the fitted form of the cosine
/// over that of the published one.
#[must_use]
pub fn checks(
    functions: &[FunctionReport],
    extremes: &[ExtremeReport],
    halves: &[HalvesReport],
    fitted_over_erf: f64,
) -> Vec<Check> {
    let mut checks = Vec::new();
    for verdict in functions.iter().flat_map(|function| &function.verdicts) {
        let name =
            format!("{}: {} ({})", verdict.function, verdict.quantity.name(), verdict.regime);
        let (unit, bound) = (verdict.quantity.unit(), verdict.at_most);
        let check = Check::new(name, verdict.value, unit, Relation::AtMost, bound);
        checks.push(check.note(verdict.reason));
    }
    for extreme in extremes {
        let failing = extreme.variants.iter().filter(|variant| !variant.holds).count() as f64;
        // No variant at all is no success.
        let failing = if extreme.variants.is_empty() { f64::NAN } else { failing };
        let name = format!("{}: variants that fail", extreme.name);
        let check = Check::new(name, failing, "variants", Relation::AtMost, 0.0);
        checks.push(check.note(extreme.reason));
    }
    for half in halves {
        for held in &half.checks {
            let name = format!("f16 in {}, {}", half.scene, held.name);
            let check = Check::new(name, held.value, "", Relation::AtMost, held.at_most);
            checks.push(check.note(held.reason));
        }
    }
    let net = |name: &str| {
        let one = functions.iter().find(|function| function.name == name);
        one.map(|function| function.net.median)
    };
    if let (Some(fitted), Some(erf)) = (net("sg_cosine_fitted"), net("sg_cosine_erf")) {
        let name = "time of sg_cosine_fitted over that of sg_cosine_erf";
        let bound = fitted_over_erf;
        let check = Check::new(name, fitted / erf, "times", Relation::AtMost, bound);
        checks.push(check.note("a better form has to cost no more than a third on top"));
    }
    checks
}

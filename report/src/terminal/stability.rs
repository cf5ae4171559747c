//! What the stability run found, for a terminal.

use sglow_results::stability::quantity::Quantity;

use crate::page::number::{count, figure, maybe};
use crate::page::stability::{
    Findings, cosine_forms, holds, measured, most, sum, whole, without_time, worst,
};
use crate::table;

/// What must not be concluded.
pub const DOES_NOT_SHOW: [&str; 6] = [
    "How fast a GPU is. Times on a software driver such as lavapipe compare variants and do not predict those of GPUs, \
     where special functions cost less beside the rest, and registers and divergence cost more.",
    "What one driver does with these texts beyond the one that ran. The mirror evaluates them on the CPU in configurations that \
     drivers were seen to use; it models drivers, it is none of them.",
    "That every device keeps to the grants. They are those of the table of the Vulkan specification, environment for \
     SPIR-V; drivers were seen to break promises.",
    "Every input. Inputs are drawn, log-uniformly in each regime and around what breaks things; a largest error is the \
     largest that was found.",
    "Model and total errors on every input: quadratures are slow, so that the reference is known for a part of the inputs \
     of each regime, and for some functions not at all.",
    "What is seen in a picture. Errors of functions are over their peak; how they add up in a scene, `cargo xtask \
     report` measures.",
];

/// What a person at a terminal sees.
#[must_use]
pub fn show(findings: &Findings<'_>) -> String {
    let mut table = table::new([
        "function",
        "rounding",
        "any arithmetic",
        "model",
        "total",
        "not finite",
        "time",
    ]);
    for function in findings.functions {
        let mark = if function.literal { " (literal)" } else { "" };
        table.add_row([
            format!("{}{mark}", function.name),
            maybe(most(function, Quantity::RoundingShare)),
            maybe(most(function, Quantity::ArithmeticShare)),
            maybe(most(function, Quantity::ModelOverPeak)),
            maybe(most(function, Quantity::TotalOverPeak)),
            whole(sum(function, Quantity::NotFinite)),
            if function.relative_time.is_nan() {
                format!("{} ns", figure(function.net.median))
            } else {
                figure(function.relative_time)
            },
        ]);
    }
    let mut lines = vec![format!("\n{table}\n")];
    lines.push(
        "Rounding and any arithmetic are shares of what GPU languages grant; model and total are over the peak.".to_owned(),
    );
    lines.extend(failing(findings));
    if let Some(warning) = without_time(&cosine_forms(findings.functions)) {
        lines.push(warning);
    }
    lines.push(format!(
        "{} inputs, {} minutes; {}, {}",
        count(findings.inputs()),
        figure(findings.minutes),
        findings.report.adapter,
        findings.report.driver
    ));
    lines.join("\n")
}

/// A line for each bound that does not hold, with the worst input.
fn failing(findings: &Findings<'_>) -> Vec<String> {
    let mut lines = Vec::new();
    for function in findings.functions {
        for verdict in function.verdicts.iter().filter(|verdict| !verdict.holds) {
            let at = worst(function, verdict)
                .map_or_else(String::new, |worst| format!(" at {}", worst.input.bits.join(" ")));
            lines.push(format!(
                "FAILS {}: {} is {}, at most {} {}, in {}{at}",
                verdict.function,
                verdict.quantity.name(),
                measured(verdict.value),
                figure(verdict.at_most),
                verdict.quantity.unit(),
                verdict.regime
            ));
        }
    }
    for extreme in findings.extremes.iter().filter(|extreme| !holds(extreme)) {
        let variants = extreme.variants.iter().filter(|variant| !variant.holds);
        let variants: Vec<&str> = variants.map(|variant| variant.variant.as_str()).collect();
        lines.push(format!("FAILS {}: {}", extreme.name, variants.join(", ")));
    }
    // Checks of functions and extremes have a colon in their names; the others say all there is to say.
    let others = findings.report.checks.iter().filter(|check| !check.name.contains(": "));
    for check in others.filter(|check| !check.holds) {
        let (value, bound) = (measured(check.value), figure(check.bound));
        lines.push(format!("FAILS {}: {value} {}, bound {bound}", check.name, check.unit));
    }
    lines
}

#[cfg(test)]
mod tests {
    use sglow_results::stability::checks::checks;

    use super::*;
    use crate::json::Report;
    use crate::page::stability::made_up;

    #[test]
    fn every_bound_is_a_check_and_what_fails_is_told_with_its_input() {
        let (functions, extremes) = (made_up::functions(), made_up::extremes());
        let mut report = Report::new();
        checks(&functions, &extremes, &[], 1.3).into_iter().for_each(|check| report.check(check));
        let verdicts: usize = functions.iter().map(|function| function.verdicts.len()).sum();
        // One more: the time of the fitted form over that of the published one.
        assert_eq!(report.checks.len(), verdicts + extremes.len() + 1);
        assert!(report.verdict().is_err());
        let findings = Findings {
            report: &report,
            functions: &functions,
            extremes: &extremes,
            halves: &[],
            minutes: 1.0,
            does_not_show: &[],
        };
        let lines = failing(&findings);
        let first = "FAILS sg_cosine_constant: device against reference is 3, at most 0.100 of the peak, \
                     in sharp at 0x42b20000 0x42b20000";
        assert_eq!(lines[0], first);
        assert!(lines.iter().any(|line| line == "FAILS mirrors: default"), "{lines:?}");
        let failing_checks = report.checks.iter().filter(|check| !check.holds).count();
        assert_eq!(lines.len(), failing_checks);
    }

    #[test]
    fn an_extreme_case_without_variants_fails() {
        let mut extremes = made_up::extremes();
        extremes.truncate(1);
        extremes[0].variants.clear();
        let mut report = Report::new();
        checks(&[], &extremes, &[], 1.3).into_iter().for_each(|check| report.check(check));
        assert!(report.verdict().is_err() && !holds(&extremes[0]));
    }
}

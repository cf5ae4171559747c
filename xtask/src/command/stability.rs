//! `stability`: every function and the whole pipeline, over every regime, against the bounds.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use sglow_measure::function::Function;
use sglow_measure::halves::SCENES;
use sglow_measure::hold::Extent;
use sglow_renderer::device::Gpu;
use sglow_results::arithmetic::Arithmetic;
use sglow_results::stability::halves::HalvesReport;
use sglow_results::stability::quantity::Quantity;
use sglow_results::stability::report::{ExtremeReport, FunctionReport};
use sglow_runtime::package::Package;
use sglow_shader_gen::generate;
use sglow_shader_gen::validate::Validated;

use crate::failure::{self, Failure, Result};
use crate::json::{Check, Relation, Report};
use crate::page::number::{count, figure, maybe};
use crate::page::stability::{
    Findings, cosine_forms, holds, measured, most, sum, whole, without_time, worst,
};
use crate::selection::{library, whole_space};
use crate::{progress, say, shot, table, write};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask stability
  cargo xtask stability --quick --only sg_integral --out out/integral
  cargo xtask stability --picture docs/pictures/cosine_forms.svg

Every function of the library runs on random and on hostile inputs, on the device and, under every arithmetic that a
driver may use, on the CPU; it is held against the oracle and the truth, and timed. Then the whole pipeline meets
extreme scenes. DIR/index.html shows it, DIR/stability.json has every number and every bound.";

/// Options of `stability`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder that receives index.html and stability.json
    #[arg(long, value_name = "DIR", default_value = "out/stability")]
    out: PathBuf,
    /// Only this function, without the pipeline; may be given more than once
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// A sixteenth of the inputs: to see whether something is broken, not to promise anything
    #[arg(long)]
    quick: bool,
    /// Also write the plot of error against time of the cosine forms, as SVG on white
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// The GPU whose name contains this [default: the most capable one]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Inputs of a whole run, at least.
const INPUTS: f64 = 1e7;
/// Minutes of a run, at most: on the two cores of a small machine.
const MINUTES: f64 = 10.0;

/// What must not be concluded.
const DOES_NOT_SHOW: [&str; 6] = [
    "How fast a GPU is. Times on a software driver such as lavapipe compare variants and promise nothing about GPUs, \
     where special functions cost less beside the rest, and registers and divergence cost more.",
    "What one driver does with these texts beyond the one that ran. The mirror evaluates them on the CPU in ways that \
     drivers were seen to use; it models drivers, it is none of them.",
    "That every device keeps to the grants. They are those of the table of the Vulkan specification, environment for \
     SPIR-V; drivers were seen to break promises.",
    "Every input. Inputs are drawn, log-uniformly in each regime and around what breaks things; a largest error is the \
     largest that was found.",
    "Model and total errors on every input: quadratures are slow, so that the truth is known for a part of the inputs \
     of each regime, and for some functions not at all.",
    "What is seen in a picture. Errors of functions are over their peak; how they add up in a scene, `cargo xtask \
     report` measures.",
];

/// Measures and tells.
///
/// # Errors
///
/// When a function, a variant or the device does not allow it, or a bound does not hold.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let start = Instant::now();
    let chosen = choose(sglow_measure::functions::all(), &arguments.only)?;
    let whole_run = arguments.only.is_empty();
    let gpu = shot::open(arguments.adapter.as_deref())?;
    let mut report = Report::new();
    report.adapter.clone_from(&gpu.adapter.name);
    report.driver.clone_from(&gpu.adapter.driver);
    report.versions.insert("naga".to_owned(), sglow_shader_gen::hash::NAGA.to_owned());

    let spinner = progress::spinner("generating the functions' variants");
    let variants = variants()?;
    let texts = variants.iter().map(|one| (one.variant.id(), one.text.clone()));
    let package = Package::generated("the functions of the library", texts);
    spinner.finish_and_clear();

    // One more: that of all times.
    let bar = progress::bar("functions", chosen.len() + 1);
    let extent = if arguments.quick { Extent::QUICK } else { Extent::FULL };
    let functions =
        sglow_measure::stability::functions(&gpu, &package, &variants, &chosen, &extent, |name| {
            bar.set_message(name.to_owned());
            bar.inc(1);
        })?;
    bar.finish_and_clear();
    let (extremes, halves) = if whole_run { pipeline(&gpu)? } else { (Vec::new(), Vec::new()) };
    let minutes = start.elapsed().as_secs_f64() / 60.0;

    checks(&mut report, &functions, &extremes, &halves);
    if whole_run && !arguments.quick {
        let inputs: usize = functions.iter().map(FunctionReport::inputs).sum();
        let check = Check::new("inputs", inputs as f64, "inputs", Relation::AtLeast, INPUTS);
        report.check(check.note("on the device, of all functions"));
    }
    let check = Check::new("run time", minutes, "minutes", Relation::AtMost, MINUTES);
    report.check(check.note("on two cores, a software driver included"));

    report.detail("functions", &functions)?;
    report.detail("extremes", &extremes)?;
    report.detail("halves", &halves)?;
    report.detail("arithmetics", Arithmetic::ALL.map(Arithmetic::name))?;
    report.detail("does_not_show", DOES_NOT_SHOW)?;
    let findings = Findings {
        report: &report,
        functions: &functions,
        extremes: &extremes,
        halves: &halves,
        minutes,
        does_not_show: &DOES_NOT_SHOW,
    };
    let page = arguments.out.join("index.html");
    write::text(&page, &findings.page())?;
    report.write(&arguments.out.join("stability.json"))?;
    tell(&findings);
    say::line(page.display());
    if let Some(path) = &arguments.picture {
        let drawing = cosine_forms(&functions).drawing().ok_or_else(|| {
            Failure::new("there is no picture: no cosine form was measured")
                .help("leave `--only` out, or name functions that begin with sg_cosine_")
        })?;
        write::text(path, &drawing.file())?;
    }
    report.verdict()
}

/// The functions that are asked for: all, or those of these names.
fn choose(all: Vec<Function>, only: &[String]) -> Result<Vec<Function>> {
    let known = |name: &String| all.iter().any(|function| function.name == name);
    let unknown: Vec<&str> = only.iter().filter(|name| !known(name)).map(String::as_str).collect();
    if !unknown.is_empty() {
        let names: Vec<&str> = all.iter().map(|function| function.name).collect();
        return Err(Failure::new(format!(
            "no function '{}'; known: {}",
            unknown.join("', '"),
            names.join(", ")
        )));
    }
    let wanted =
        |function: &Function| only.is_empty() || only.iter().any(|name| name == function.name);
    Ok(all.into_iter().filter(wanted).collect())
}

/// The variants of the functions, generated in memory: most are not committed.
fn variants() -> Result<Vec<Validated>> {
    let library = library()?;
    let mut variants = library.variants();
    variants.retain(|variant| variant.pass == "function");
    generate::variants(&library, &variants).map_err(failure::rendered)
}

/// The whole pipeline in extreme cases and in both precisions, every variant generated in memory.
fn pipeline(gpu: &Gpu) -> Result<(Vec<ExtremeReport>, Vec<HalvesReport>)> {
    let package = whole_space()?;
    let names = sglow_measure::extreme::names();
    let bar = progress::bar("extremes", names.len() + SCENES.len());
    let (mut extremes, mut halves) = (Vec::new(), Vec::new());
    for name in names {
        bar.set_message(name);
        extremes.extend(sglow_measure::extreme::attempt(gpu, &package, name)?);
        bar.inc(1);
    }
    for scene in SCENES {
        bar.set_message(scene);
        halves.push(sglow_measure::halves::in_scene(gpu, &package, scene)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok((extremes, halves))
}

/// Everything that was held against a bound, as checks.
fn checks(
    report: &mut Report,
    functions: &[FunctionReport],
    extremes: &[ExtremeReport],
    halves: &[HalvesReport],
) {
    for verdict in functions.iter().flat_map(|function| &function.verdicts) {
        let name =
            format!("{}: {} ({})", verdict.function, verdict.quantity.name(), verdict.regime);
        let (unit, bound) = (verdict.quantity.unit(), verdict.at_most);
        let check = Check::new(name, verdict.value, unit, Relation::AtMost, bound);
        report.check(check.note(verdict.reason));
    }
    for extreme in extremes {
        let failing = extreme.variants.iter().filter(|variant| !variant.holds).count() as f64;
        // No variant at all is no success.
        let failing = if extreme.variants.is_empty() { f64::NAN } else { failing };
        let name = format!("{}: variants that fail", extreme.name);
        let check = Check::new(name, failing, "variants", Relation::AtMost, 0.0);
        report.check(check.note(extreme.reason));
    }
    for half in halves {
        for held in &half.checks {
            let name = format!("f16 in {}, {}", half.scene, held.name);
            let check = Check::new(name, held.value, "", Relation::AtMost, held.at_most);
            report.check(check.note(held.reason));
        }
    }
    let net = |name: &str| {
        let one = functions.iter().find(|function| function.name == name);
        one.map(|function| function.net.median)
    };
    if let (Some(fitted), Some(erf)) = (net("sg_cosine_fitted"), net("sg_cosine_erf")) {
        let name = "time of sg_cosine_fitted over that of sg_cosine_erf";
        let bound = sglow_measure::bound::FITTED_OVER_ERF;
        let check = Check::new(name, fitted / erf, "times", Relation::AtMost, bound);
        report.check(check.note("a better form has to cost no more than a third on top"));
    }
}

/// What a person at a terminal sees.
fn tell(findings: &Findings<'_>) {
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
    say::line(format!("\n{table}\n"));
    say::line(
        "Rounding and any arithmetic are shares of what GPU languages grant; model and total are over the peak.",
    );
    for line in failing(findings) {
        say::line(line);
    }
    if let Some(warning) = without_time(&cosine_forms(findings.functions)) {
        say::line(warning);
    }
    say::line(format!(
        "{} inputs, {} minutes; {}, {}",
        count(findings.inputs()),
        figure(findings.minutes),
        findings.report.adapter,
        findings.report.driver
    ));
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
    use super::*;
    use crate::page::stability::made_up;

    #[test]
    fn functions_are_chosen_by_name_and_unknown_ones_are_told_with_those_that_are_known() {
        let all = sglow_measure::functions::all;
        assert_eq!(choose(all(), &[]).unwrap().len(), all().len());
        let one = choose(all(), &["sg_integral".to_owned()]).unwrap();
        assert_eq!(one.iter().map(|function| function.name).collect::<Vec<_>>(), ["sg_integral"]);
        let wrong = ["sg_integral", "sg_colour", "light"].map(str::to_owned);
        let text = choose(all(), &wrong).unwrap_err().to_string();
        assert!(text.contains("'sg_colour', 'light'") && text.contains("sg_evaluate"), "{text}");
    }

    #[test]
    fn every_bound_is_a_check_and_what_fails_is_told_with_its_input() {
        let (functions, extremes) = (made_up::functions(), made_up::extremes());
        let mut report = Report::new();
        checks(&mut report, &functions, &extremes, &[]);
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
        let first = "FAILS sg_cosine_constant: device against truth is 3, at most 0.100 of the peak, \
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
        checks(&mut report, &[], &extremes, &[]);
        assert!(report.verdict().is_err() && !holds(&extremes[0]));
    }
}

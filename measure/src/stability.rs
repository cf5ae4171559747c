//! The stability run: every function and the whole pipeline, over every regime, against the bounds.

use std::collections::BTreeMap;

use sglow_renderer::device::Gpu;
use sglow_renderer::function::{Arguments, Function as Pipeline};
use sglow_results::arithmetic::Arithmetic;
use sglow_results::stability::held::Time;
use sglow_results::stability::regime::REGIMES;
use sglow_results::stability::report::{FunctionReport, RELATIVE_TO};
use sglow_runtime::package::Package;
use sglow_shader_gen::error::Report;
use sglow_shader_gen::generate;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::validate::Validated;

use crate::bound::judge;
use crate::curve::follow;
use crate::function::Function;
use crate::hold::{Extent, HoldError, Subject, hold};

/// What stands for reading arguments alone.
const READING: &str = "none";

/// Evaluations of each invocation of a timed dispatch.
const REPETITIONS: u32 = 1024;
/// Timed dispatches of each function.
const RUNS: usize = 15;
/// Inputs of a timed dispatch: few enough to stay in a cache.
const TIMED_INPUTS: usize = 1024;

/// The variants of the functions, generated in memory: most are not committed.
///
/// # Errors
///
/// Everything that is wrong with them.
pub fn variants(library: &Library) -> Result<Vec<Validated>, Report> {
    let mut variants = library.variants();
    variants.retain(|variant| variant.pass == "function");
    generate::variants(library, &variants)
}

/// Holds every function to its bounds and times it. `progress` receives the name of each before it is measured.
///
/// # Errors
///
/// When a function has no variant, or cannot be run or mirrored.
pub fn functions(
    gpu: &Gpu,
    package: &Package,
    variants: &[Validated],
    functions: &[Function],
    extent: &Extent,
    mut progress: impl FnMut(&str),
) -> Result<Vec<FunctionReport>, HoldError> {
    let mut reports = Vec::with_capacity(functions.len());
    for function in functions {
        progress(function.name);
        let subject = Subject::find(function, variants)?;
        let held = hold(gpu, package, &subject, extent)?;
        let curve = if function.is_of_cosine_and_sharpness() {
            follow(gpu, package, function)?
        } else {
            None
        };
        reports.push(FunctionReport {
            name: function.name,
            literal: function.literal,
            results: function.results,
            verdicts: judge(function, &held),
            held,
            time: Time::default(),
            net: Time::default(),
            relative_time: f64::NAN,
            operations: subject.mirror(Arithmetic::Written)?.step_count(),
            curve,
        });
    }
    progress("times");
    time(gpu, package, variants, functions, &mut reports)?;
    Ok(reports)
}

/// Times every function in one go, reading alone among them. One dispatch of each follows upon the other, round after
/// round, so that whatever else the machine does falls on all of them alike.
fn time(
    gpu: &Gpu,
    package: &Package,
    variants: &[Validated],
    functions: &[Function],
    reports: &mut [FunctionReport],
) -> Result<(), HoldError> {
    let nothing = Pipeline::new(gpu, package, "function-none")?;
    let mut subjects = vec![(READING, nothing, vec![[0.5; 12]; TIMED_INPUTS])];
    for function in functions {
        let subject = Subject::find(function, variants)?;
        // What virtual lights have: from soft to sharp.
        let mut inputs: Vec<Arguments> = Vec::with_capacity(TIMED_INPUTS);
        for regime in REGIMES.iter().filter(|one| ["soft", "medium", "sharp"].contains(&one.name)) {
            inputs.extend(subject.inputs(regime, TIMED_INPUTS.div_ceil(3), 3)?);
        }
        inputs.truncate(TIMED_INPUTS);
        subjects.push((function.name, Pipeline::new(gpu, package, &function.id())?, inputs));
    }
    let mut stopwatches = Vec::with_capacity(subjects.len());
    for (name, pipeline, inputs) in &subjects {
        stopwatches.push((*name, pipeline.stopwatch(inputs, REPETITIONS)?));
    }
    let mut times: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for _ in 0..RUNS {
        for (name, stopwatch) in &stopwatches {
            times.entry(*name).or_default().push(stopwatch.nanoseconds()?);
        }
    }
    // Each round's reading is taken from the same round: what slows both is gone.
    let reading = times.get(READING).cloned().unwrap_or_default();
    let net = |name: &str| -> Time {
        let all = times.get(name).map(Vec::as_slice).unwrap_or_default();
        Time::of(
            all.iter().zip(&reading).map(|(time, reading)| (time - reading).max(0.0)).collect(),
        )
    };
    // Without it, or where it does not differ from reading, there is nothing to be relative to.
    let unit = Some(net(RELATIVE_TO).median).filter(|unit| *unit > 0.0).unwrap_or(f64::NAN);
    for report in reports {
        report.time = Time::of(times.get(report.name).cloned().unwrap_or_default());
        report.net = net(report.name);
        report.relative_time = report.net.median / unit;
    }
    Ok(())
}

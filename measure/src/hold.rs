//! Compares functions with their oracles and references: on the device, on the CPU under every arithmetic, in f64.

use std::collections::BTreeMap;

use rayon::prelude::*;
use sglow_oracle::Bounded;
use sglow_renderer::device::{DeviceError, Gpu};
use sglow_renderer::function::{Arguments, Function as Pipeline, FunctionError};
use sglow_results::arithmetic::Arithmetic;
use sglow_results::error::{Errors, Pair, against};
use sglow_results::stability::held::Held;
use sglow_results::stability::regime::{REGIMES, Regime};
use sglow_runtime::package::Package;
use sglow_runtime::pipeline::PipelineError;
use sglow_shader_gen::validate::Validated;
use thiserror::Error;

use crate::function::{Function, Results};
use crate::input::Inputs;
use crate::mirror::{Mirror, MirrorError};

/// Why a function cannot be compared with anything.
#[derive(Debug, Error)]
pub enum HoldError {
    /// The library has no variant for it.
    #[error("the library has no variant '{id}': add the value to the axis `function`")]
    NoVariant {
        /// The variant.
        id: String,
    },
    /// Its text is not mirrored.
    #[error(transparent)]
    Mirror(#[from] MirrorError),
    /// Its variant does not become a pipeline.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// The device fails.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// It cannot be timed.
    #[error(transparent)]
    Time(#[from] FunctionError),
}

/// How many inputs each function gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Inputs per regime on the device and on the CPU.
    pub inputs: usize,
    /// Of these, inputs per regime that are compared with the reference.
    pub references: usize,
    /// Inputs per regime that are followed by their neighbours to see whether the function is monotone.
    pub neighbours: usize,
}

impl Extent {
    /// What `cargo xtask stability` does by default.
    pub const FULL: Self = Self { inputs: 32_768, references: 8_192, neighbours: 512 };
    /// What the tests do.
    pub const QUICK: Self = Self { inputs: 2_048, references: 256, neighbours: 64 };
}

/// A slow reference is known of one in so many of the inputs that a fast one is known of.
const SLOW: usize = 64;

/// The text of a function's variant, and how to run it.
pub struct Subject<'a> {
    /// The function.
    pub function: &'a Function,
    /// Its variant as the generator makes it.
    pub variant: &'a Validated,
}

impl<'a> Subject<'a> {
    /// The variant of a function among all that were generated.
    ///
    /// # Errors
    ///
    /// When there is none.
    pub fn find(function: &'a Function, variants: &'a [Validated]) -> Result<Self, HoldError> {
        let id = function.id();
        let variant = variants.iter().find(|one| one.variant.id() == id);
        variant.map(|variant| Self { function, variant }).ok_or(HoldError::NoVariant { id })
    }

    /// The function on the CPU.
    ///
    /// # Errors
    ///
    /// When it does what is not mirrored.
    pub fn mirror(&self, arithmetic: Arithmetic) -> Result<Mirror, MirrorError> {
        let Validated { module, info, .. } = self.variant;
        Mirror::new(module, info, "sglow_function", arithmetic)
    }

    /// Inputs of a regime; the same for the same seed.
    ///
    /// # Errors
    ///
    /// When the function is not mirrored, for its literals are those of its mirror.
    pub fn inputs(
        &self,
        regime: &Regime,
        count: usize,
        seed: u64,
    ) -> Result<Vec<Arguments>, MirrorError> {
        let literals = self.mirror(Arithmetic::Written)?.literals();
        let mut inputs = Inputs::new(self.function.arguments, literals, seed);
        Ok((0..count).map(|_| inputs.draw(regime)).collect())
    }
}

/// Runs a mirror on many inputs, on all cores.
#[must_use]
pub fn mirrored(mirror: &Mirror, inputs: &[Arguments]) -> Vec<[f32; 4]> {
    inputs
        .par_chunks(1024)
        .flat_map_iter(|chunk| {
            let mut registers = mirror.registers();
            chunk
                .iter()
                .map(|arguments| {
                    let mut output = [0; 4];
                    mirror.run(&mut registers, &arguments.map(f32::to_bits), &mut output);
                    output.map(f32::from_bits)
                })
                .collect::<Vec<_>>()
        })
        .collect()
}

/// The numbers of an oracle, on all cores.
fn of_all<T: Send>(
    inputs: &[Arguments],
    function: impl Fn(&Arguments) -> T + Sync + Send,
) -> Vec<T> {
    inputs.par_iter().with_min_len(64).map(function).collect()
}

/// Compares what was measured with what is expected, on all cores.
fn compare(
    function: &Function,
    inputs: &[Arguments],
    measured: &[[f32; 4]],
    expected: &[Results<Bounded>],
    peaks: &[Results<f64>],
) -> Errors {
    let components = function.components();
    collect(inputs.len(), |index, errors| {
        for result in 0..function.results.len() {
            let peak = peaks[index][result];
            let mut pair = against(measured[index][result], expected[index][result], peak);
            if function.floor > 0.0 {
                pair.tolerance = pair.tolerance.max(function.floor * peak);
            }
            errors.add(pair, &inputs[index], &components);
        }
    })
}

fn collect(count: usize, add: impl Fn(usize, &mut Errors) + Sync) -> Errors {
    (0..count)
        .into_par_iter()
        .with_min_len(512)
        .fold(Errors::default, |mut errors, index| {
            add(index, &mut errors);
            errors
        })
        .reduce(Errors::default, Errors::merge)
        .merge(Errors::default())
}

/// What the oracle says of inputs.
pub struct Expected {
    bounded: Vec<Results<Bounded>>,
    peaks: Vec<Results<f64>>,
}

impl Expected {
    /// Of a function at its inputs.
    #[must_use]
    pub fn of(function: &Function, inputs: &[Arguments]) -> Self {
        Self {
            bounded: of_all(inputs, |input| (function.bounded)(Function::buffered(input))),
            peaks: of_all(inputs, |input| (function.peak)(Function::exact(input))),
        }
    }

    /// The errors of what was measured at the same inputs.
    #[must_use]
    pub fn errors(
        &self,
        function: &Function,
        inputs: &[Arguments],
        measured: &[[f32; 4]],
    ) -> Errors {
        compare(function, inputs, measured, &self.bounded, &self.peaks)
    }
}

/// Compares a function with its oracle and its reference in every regime.
///
/// # Errors
///
/// When the function cannot be run or mirrored.
pub fn hold(
    gpu: &Gpu,
    package: &Package,
    subject: &Subject<'_>,
    extent: &Extent,
) -> Result<Vec<Held>, HoldError> {
    let pipeline = Pipeline::new(gpu, package, &subject.function.id())?;
    let mirrors = Arithmetic::ALL
        .into_iter()
        .map(|arithmetic| Ok((arithmetic, subject.mirror(arithmetic)?)))
        .collect::<Result<Vec<_>, MirrorError>>()?;
    REGIMES.iter().map(|regime| in_regime(&pipeline, &mirrors, subject, regime, extent)).collect()
}

fn in_regime(
    pipeline: &Pipeline<'_>,
    mirrors: &[(Arithmetic, Mirror)],
    subject: &Subject<'_>,
    regime: &Regime,
    extent: &Extent,
) -> Result<Held, HoldError> {
    let function = subject.function;
    let seed = regime.name.bytes().fold(17, |seed, byte| seed * 31 + u64::from(byte));
    let inputs = subject.inputs(regime, extent.inputs, seed)?;
    let expected = Expected::of(function, &inputs);
    let measured = pipeline.evaluate(&inputs)?;
    let rounding = expected.errors(function, &inputs, &measured);
    let mut conditioning: BTreeMap<&'static str, Errors> = BTreeMap::new();
    for (arithmetic, mirror) in mirrors {
        let errors = expected.errors(function, &inputs, &mirrored(mirror, &inputs));
        let entry = conditioning.entry(arithmetic.name()).or_default();
        *entry = std::mem::take(entry).merge(errors);
    }
    let (mut model, mut total) = (None, None);
    if let Some(reference) = function.reference {
        let share = if function.slow_reference { SLOW } else { 1 };
        let count = (extent.references / share).min(inputs.len());
        let references = of_all(&inputs[..count], |input| reference(Function::exact(input)));
        let components = function.components();
        let errors = |values: &(dyn Fn(usize) -> Results<f64> + Sync)| {
            collect(count, |index, errors| {
                let numbers = values(index).into_iter().zip(references[index]);
                let known = numbers
                    .zip(expected.peaks[index])
                    .take(function.results.len())
                    // Where there is no reference it is not a number.
                    .filter(|((_, reference), _)| !reference.is_nan());
                for ((measured, expected), peak) in known {
                    let pair = Pair { measured, expected, tolerance: f64::INFINITY, peak };
                    errors.add(pair, &inputs[index], &components);
                }
            })
        };
        model = Some(errors(&|index| expected.bounded[index].map(|result| result.value)));
        total = Some(errors(&|index| measured[index].map(f64::from)));
    }
    let mut held = Held {
        regime: regime.name,
        rounding,
        conditioning,
        model,
        total,
        neighbours: 0,
        not_monotone: 0,
        wrong_step_over_peak: 0.0,
    };
    monotone(pipeline, function, &inputs, extent, &mut held)?;
    Ok(held)
}

/// Follows a function along one component, from each input to its neighbours and beyond.
fn monotone(
    pipeline: &Pipeline<'_>,
    function: &Function,
    inputs: &[Arguments],
    extent: &Extent,
    held: &mut Held,
) -> Result<(), HoldError> {
    let Some(monotone) = function.monotone else {
        return Ok(());
    };
    /// Steps up from each input: neighbours first, then farther and farther.
    const CHAIN: usize = 12;
    let mut chain = Vec::with_capacity(extent.neighbours * CHAIN);
    for input in &inputs[..extent.neighbours.min(inputs.len())] {
        let mut next = *input;
        for step in 0..CHAIN {
            chain.push(next);
            let value = &mut next[monotone.component];
            for _ in 0..(1_u32 << step) {
                *value = value.next_up();
            }
            let most = if function.is_bounded_by_one(monotone.component) { 1.0 } else { f32::MAX };
            *value = value.min(most);
        }
    }
    let expected = Expected::of(function, &chain);
    let measured = pipeline.evaluate(&chain)?;
    let sign = if monotone.grows { 1.0 } else { -1.0 };
    for pair in 0..chain.len() - 1 {
        if pair % CHAIN == CHAIN - 1 {
            continue;
        }
        held.neighbours += 1;
        let [low, high] = [pair, pair + 1].map(|index| f64::from(measured[index][0]));
        let wrong = sign * (low - high);
        if wrong.is_nan() {
            held.not_monotone += 1;
            continue;
        }
        held.wrong_step_over_peak =
            held.wrong_step_over_peak.max(wrong / expected.peaks[pair][0].max(f64::MIN_POSITIVE));
        let allowed: f64 =
            [pair, pair + 1].iter().map(|index| expected.bounded[*index][0].error).sum();
        if wrong > allowed {
            held.not_monotone += 1;
        }
    }
    Ok(())
}

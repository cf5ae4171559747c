//! Functions and extreme cases, as the stability run found them.

use serde::Serialize;

use super::held::{Held, Time};
use super::quantity::Verdict;

/// The largest errors at one sharpness, over all angles, over the peak.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Point {
    /// The sharpness.
    pub sharpness: f64,
    /// Oracle against reference.
    pub model: f64,
    /// Device against reference; infinite where a result is not finite.
    pub total: f64,
}

/// What was found of one function.
#[derive(Clone, Debug, Serialize)]
pub struct FunctionReport {
    /// As on the axis `function`; the shader's function is `sglow_` and this.
    pub name: &'static str,
    /// Whether it is the paper's literal form, which has no guarantee.
    pub literal: bool,
    /// What its results are called.
    pub results: &'static [&'static str],
    /// Per regime.
    pub held: Vec<Held>,
    /// Every bound that is about it.
    pub verdicts: Vec<Verdict>,
    /// Nanoseconds of one evaluation on the device, all cores at work, reading of arguments included.
    pub time: Time,
    /// The same less that of reading alone, round by round.
    pub net: Time,
    /// The median less that of reading alone, over the same of `sg_cosine_constant`.
    pub relative_time: f64,
    /// Operations of its text on scalars, all branches counted, built-in functions as one.
    pub operations: usize,
    /// Error along sharpness, for functions of a cosine and a sharpness.
    pub curve: Option<Vec<Point>>,
}

impl FunctionReport {
    /// Inputs on the device.
    #[must_use]
    pub fn inputs(&self) -> usize {
        let results = self.results.len().max(1);
        self.held.iter().map(|held| held.rounding.compared / results + held.neighbours).sum()
    }
}

/// What all times are relative to.
pub const RELATIVE_TO: &str = "sg_cosine_constant";

/// What became of the whole pipeline in one extreme case.
#[derive(Clone, Debug, Serialize)]
pub struct ExtremeReport {
    /// Its name.
    pub name: &'static str,
    /// What is extreme, in a sentence.
    pub description: &'static str,
    /// How far the mean of the picture may be from what is expected, as a share of it; nothing where only finiteness
    /// is required.
    pub bound: Option<f64>,
    /// Why so far and no farther.
    pub reason: &'static str,
    /// Each variant.
    pub variants: Vec<ExtremeVariant>,
}

/// One variant in one extreme case.
#[derive(Clone, Debug, Serialize)]
pub struct ExtremeVariant {
    /// What differs from the default settings, as `axis=value`; `default` for these.
    pub variant: String,
    /// Numbers of the lights and of the picture that are not finite.
    pub not_finite: usize,
    /// Numbers below 0 that cannot be.
    pub negative: usize,
    /// Mean of the picture's indirect light, or of what stands for it.
    pub mean: f64,
    /// What the mean should be.
    pub expected: Option<f64>,
    /// `mean / expected - 1`.
    pub deviation: Option<f64>,
    /// Whether all of it is within the bound.
    pub holds: bool,
}

//! What was found of one function in one regime.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::error::Errors;

/// Everything that was found of one function in one regime.
#[derive(Clone, Debug, Serialize)]
pub struct Held {
    /// The regime.
    pub regime: &'static str,
    /// Device against oracle.
    pub rounding: Errors,
    /// The shader's text on the CPU against the oracle, per arithmetic.
    pub conditioning: BTreeMap<&'static str, Errors>,
    /// Oracle against reference.
    pub model: Option<Errors>,
    /// Device against reference.
    pub total: Option<Errors>,
    /// Pairs of neighbouring inputs.
    pub neighbours: usize,
    /// Pairs whose results run the wrong way by more than both may be off.
    pub not_monotone: usize,
    /// The largest step the wrong way over the peak, whether allowed or not.
    pub wrong_step_over_peak: f64,
}

/// How long one evaluation takes, in nanoseconds, all cores at work: least, median and most of several runs.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Time {
    /// The least.
    pub minimum: f64,
    /// The median.
    pub median: f64,
    /// The most.
    pub maximum: f64,
}

impl Time {
    /// Of several runs, each in nanoseconds.
    #[must_use]
    pub fn of(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        let at = |index: usize| times.get(index).copied().unwrap_or_default();
        Self {
            minimum: at(0),
            median: at(times.len() / 2),
            maximum: at(times.len().saturating_sub(1)),
        }
    }
}

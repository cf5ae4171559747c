//! How long something takes: a median of some runs, and their spread.

use std::iter::Sum;
use std::time::Duration;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A median and its spread, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Time {
    /// The median.
    pub median: f64,
    /// The minimum.
    pub minimum: f64,
    /// The maximum.
    pub maximum: f64,
}

impl Time {
    /// Of some runs; all 0 of none.
    #[must_use]
    pub fn of(mut runs: Vec<Duration>) -> Self {
        runs.sort();
        let at = |index: usize| runs.get(index).map_or(0.0, |time| time.as_secs_f64() * 1e3);
        Self {
            median: at(runs.len() / 2),
            minimum: at(0),
            maximum: at(runs.len().saturating_sub(1)),
        }
    }
}

impl Sum for Time {
    /// One after the other.
    fn sum<I: Iterator<Item = Self>>(times: I) -> Self {
        times.fold(Self::default(), |sum, next| Self {
            median: sum.median + next.median,
            minimum: sum.minimum + next.minimum,
            maximum: sum.maximum + next.maximum,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_slow_run_moves_the_spread_and_not_the_median() {
        let of = |runs: &[u64]| Time::of(runs.iter().copied().map(Duration::from_millis).collect());
        let time = of(&[3, 900, 1, 2, 4]);
        assert_eq!((time.median, time.minimum, time.maximum), (3.0, 1.0, 900.0));
        assert_eq!(of(&[]), Time::default());
        let sum: Time = [time, of(&[5])].into_iter().sum();
        assert_eq!((sum.median, sum.minimum, sum.maximum), (8.0, 6.0, 905.0));
    }
}

//! Statistics of errors, with the input of the worst.

use serde::Serialize;
use sglow_oracle::Bounded;
use sglow_oracle::tolerance::{SMALLEST_NORMAL, ULP};

/// An input, as its bits and as numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Input {
    /// Each component in hexadecimal bits.
    pub bits: Vec<String>,
    /// The same as numbers.
    pub values: Vec<f32>,
}

impl Input {
    /// Of a function's arguments: those components that it reads.
    #[must_use]
    pub fn of(arguments: &[f32], components: &[usize]) -> Self {
        let values: Vec<f32> = components.iter().map(|at| arguments[*at]).collect();
        let bits = values.iter().map(|value| format!("{:#010x}", value.to_bits())).collect();
        Self { bits, values }
    }
}

/// A largest error and where it was.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Worst {
    /// The error; infinite where a number that has to be finite is not.
    #[serde(serialize_with = "finite_or_text")]
    pub error: f64,
    /// The input.
    pub input: Input,
    /// What was measured there.
    pub measured: f64,
    /// What it was compared with.
    pub expected: f64,
}

/// JSON has no infinity: its name then.
fn finite_or_text<S: serde::Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() {
        serializer.serialize_f64(*value)
    } else {
        serializer.serialize_str("not finite")
    }
}

/// One comparison: a measured number and what it was compared with.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// The measured number.
    pub measured: f64,
    /// The number it should be.
    pub expected: f64,
    /// What GPU languages allow it to be off; infinite where they promise nothing.
    pub tolerance: f64,
    /// The largest value of the function for this input, which its error is seen against.
    pub peak: f64,
}

/// Errors of one function, in one regime, of one kind.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Errors {
    /// Numbers that were compared.
    pub compared: usize,
    /// Largest error in ULP of the expected number (those of the smallest normal one below that).
    pub ulps: Worst,
    /// 99.9 % of the errors in ULP are at most this, to a quarter of a binade.
    pub ulps_999: f64,
    /// Largest error as a share of what GPU languages allow: at most 1 is right.
    pub share: Worst,
    /// Largest error over the peak.
    pub over_peak: Worst,
    /// 99.9 % of the errors over the peak are at most this, to a quarter of a binade.
    pub over_peak_999: f64,
    /// Root mean square of the errors over the peak.
    pub rmse_over_peak: f64,
    /// Largest relative error where the value is above 1e-3 of its peak.
    pub relative_above_1e3: f64,
    /// Largest relative error where the value is above 1e-6 of its peak.
    pub relative_above_1e6: f64,
    /// Measured numbers that are not finite.
    pub not_finite: usize,
    /// Measured numbers below 0.
    pub negative: usize,
    /// Numbers for which GPU languages promise nothing.
    pub without_promise: usize,
    #[serde(skip)]
    squares: f64,
    #[serde(skip)]
    ulps_histogram: Histogram,
    #[serde(skip)]
    peak_histogram: Histogram,
}

/// Counts by magnitude, four bins to a binade, from 2^-64 to 2^64.
#[derive(Clone, Debug)]
struct Histogram(Vec<u32>);

impl Default for Histogram {
    fn default() -> Self {
        Self(vec![0; 512])
    }
}

impl Histogram {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a bin's number")]
    fn add(&mut self, value: f64) {
        let bin =
            if value > 0.0 { (4.0 * value.log2() + 256.0).clamp(0.0, 511.0) as usize } else { 0 };
        self.0[bin] += 1;
    }

    /// The upper end of the bin below which this share lies: the values themselves are too many to be kept and sorted, as a
    /// quantile needs.
    fn upper_end(&self, share: f64) -> f64 {
        let total: u64 = self.0.iter().map(|count| u64::from(*count)).sum();
        let mut below = 0;
        for (bin, count) in self.0.iter().enumerate() {
            below += u64::from(*count);
            if below as f64 >= share * total as f64 {
                return if bin == 0 { 0.0 } else { ((bin as f64 + 1.0 - 256.0) / 4.0).exp2() };
            }
        }
        f64::INFINITY
    }

    fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.0.iter_mut().zip(&other.0) {
            *mine += theirs;
        }
    }
}

/// An ULP of f32 at a value.
#[must_use]
pub fn ulp(value: f64) -> f64 {
    let magnitude = value.abs().max(SMALLEST_NORMAL);
    magnitude.log2().floor().exp2() * ULP
}

impl Errors {
    /// Counts one comparison.
    pub fn add(&mut self, pair: Pair, arguments: &[f32], components: &[usize]) {
        self.compared += 1;
        if pair.measured < 0.0 {
            self.negative += 1;
        }
        if !pair.measured.is_finite() {
            self.not_finite += 1;
        }
        let distance = (pair.measured - pair.expected).abs();
        let distance = if distance.is_nan() { f64::INFINITY } else { distance };
        let note = |worst: &mut Worst, error: f64| {
            if error > worst.error {
                *worst = Worst {
                    error,
                    input: Input::of(arguments, components),
                    measured: pair.measured,
                    expected: pair.expected,
                };
            }
        };
        let ulps = distance / ulp(pair.expected);
        note(&mut self.ulps, ulps);
        if !pair.tolerance.is_finite() {
            self.without_promise += 1;
        } else if distance > 0.0 {
            note(&mut self.share, distance / pair.tolerance.max(f64::MIN_POSITIVE));
        }
        let over_peak = distance / pair.peak.max(f64::MIN_POSITIVE);
        note(&mut self.over_peak, over_peak);
        let expected = pair.expected.abs();
        for (threshold, largest) in
            [(1e-3, &mut self.relative_above_1e3), (1e-6, &mut self.relative_above_1e6)]
        {
            if expected > threshold * pair.peak {
                *largest = largest.max(distance / expected);
            }
        }
        self.ulps_histogram.add(ulps);
        self.peak_histogram.add(over_peak);
        if over_peak.is_finite() {
            self.squares += over_peak * over_peak;
        }
    }

    /// Counts what another thread has counted.
    #[must_use]
    pub fn merge(mut self, other: Self) -> Self {
        self.compared += other.compared;
        for (mine, theirs) in [
            (&mut self.ulps, other.ulps),
            (&mut self.share, other.share),
            (&mut self.over_peak, other.over_peak),
        ] {
            if theirs.error > mine.error {
                *mine = theirs;
            }
        }
        self.relative_above_1e3 = self.relative_above_1e3.max(other.relative_above_1e3);
        self.relative_above_1e6 = self.relative_above_1e6.max(other.relative_above_1e6);
        self.not_finite += other.not_finite;
        self.negative += other.negative;
        self.without_promise += other.without_promise;
        self.squares += other.squares;
        self.ulps_histogram.merge(&other.ulps_histogram);
        self.peak_histogram.merge(&other.peak_histogram);
        self.ulps_999 = self.ulps_histogram.upper_end(0.999);
        self.over_peak_999 = self.peak_histogram.upper_end(0.999);
        self.rmse_over_peak = (self.squares / self.compared.max(1) as f64).sqrt();
        self
    }
}

/// A pair of a device's number and a bounded one.
#[must_use]
pub fn against(measured: f32, expected: Bounded, peak: f64) -> Pair {
    Pair {
        measured: f64::from(measured),
        expected: expected.value,
        tolerance: if expected.promises() { expected.error } else { f64::INFINITY },
        peak,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(pairs: &[(f64, f64)]) -> Errors {
        let mut errors = Errors::default();
        for (index, &(measured, expected)) in pairs.iter().enumerate() {
            let pair = Pair { measured, expected, tolerance: 1e-3, peak: 2.0 };
            errors.add(pair, &[index as f32; 12], &[0]);
        }
        Errors::default().merge(errors)
    }

    #[test]
    fn the_worst_is_kept_with_its_input() {
        let found = errors(&[(1.0, 1.0), (1.5, 1.0), (-1.0, -1.0 - 1e-4), (1.0, 1.0)]);
        assert_eq!((found.compared, found.negative, found.not_finite), (4, 1, 0));
        assert_eq!(found.over_peak.error, 0.25);
        assert_eq!(found.over_peak.input.bits, [format!("{:#010x}", 1.0_f32.to_bits())]);
        assert!((found.share.error - 500.0).abs() < 1e-9);
        assert!((found.rmse_over_peak - 0.125).abs() < 1e-5);
        assert_eq!(found.ulps.error, 0.5 / f64::from(f32::EPSILON));
    }

    #[test]
    fn what_is_not_finite_is_the_worst_there_is() {
        let found = errors(&[(1.0, 1.0), (f64::NAN, 1.0)]);
        assert_eq!(found.not_finite, 1);
        assert!(found.share.error.is_infinite() && found.ulps.error.is_infinite());
        let json = serde_json::to_value(&found.ulps).unwrap();
        assert_eq!(json["error"], "not finite");
    }

    #[test]
    fn shares_have_upper_ends_of_bins() {
        let mut histogram = Histogram::default();
        (0..999).for_each(|_| histogram.add(1.0));
        histogram.add(1e6);
        assert!(histogram.upper_end(0.999) >= 1.0 && histogram.upper_end(0.999) < 1.2);
        assert!(histogram.upper_end(1.0) > 1e6);
    }
}

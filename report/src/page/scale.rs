//! A logarithmic axis: its range, its ticks, and where a value lies on it.

/// An axis from one positive number to a larger one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    low: f64,
    high: f64,
}

/// A line across a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Where.
    pub value: f64,
    /// What stands beside it; nothing at minor ticks.
    pub label: Option<String>,
}

/// Ticks that have a label, at most.
const LABELS: i32 = 9;

impl Scale {
    /// The axis that has every value that is finite and positive, with some air at both ends; none if there is none.
    pub fn around(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let Self { low, high } = Self::from_to(values)?;
        // At least a factor of four, so that one value alone has an axis too.
        let air = (4.0 * low / high).sqrt().max((high / low).powf(0.06)).max(1.1);
        Some(Self { low: low / air, high: high * air })
    }

    /// The axis that ends at whole powers of ten around every value that is finite and positive.
    pub fn decades(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let Self { low, high } = Self::from_to(values)?;
        let low = low.log10().floor();
        let high = high.log10().ceil().max(low + 1.0);
        Some(Self { low: 10_f64.powf(low), high: 10_f64.powf(high) })
    }

    fn from_to(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let (low, high) = values
            .into_iter()
            .filter(|value| value.is_finite() && *value > 0.0)
            .fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        (high > 0.0).then_some(Self { low, high })
    }

    /// The same axis, down to `least` at most.
    pub fn not_below(self, least: f64) -> Self {
        Self { low: self.low.max(least).min(self.high / 10.0), ..self }
    }

    /// Where a value lies, 0 at the low end and 1 at the high one; at an end if it is beyond.
    pub fn place(&self, value: f64) -> f64 {
        if value.is_nan() || value <= self.low {
            return 0.0;
        }
        (value / self.low).ln().min((self.high / self.low).ln()) / (self.high / self.low).ln()
    }

    /// Powers of ten, 1, 2 and 5 times these on a short axis, all digits on a very short one.
    pub fn ticks(&self) -> Vec<Tick> {
        let (first, last) = (whole(self.low.log10().floor()), whole(self.high.log10().ceil()));
        let decades = (self.high / self.low).log10();
        let digits: &[i32] = if decades < 0.75 { &[1, 2, 3, 4, 5, 6, 7, 8, 9] } else { &[1, 2, 5] };
        let stride = (last - first) / LABELS + 1;
        let mut ticks = Vec::new();
        for power in first..=last {
            for digit in 1..=9 {
                let value = f64::from(digit) * 10_f64.powi(power);
                // The ends themselves are within, in spite of rounding.
                if value < self.low * 0.9999 || value > self.high * 1.0001 {
                    continue;
                }
                let label = if decades < 2.5 {
                    digits.contains(&digit).then(|| plain(digit, power))
                } else if digit == 1 {
                    (power.rem_euclid(stride) == 0).then(|| plain(1, power))
                } else {
                    continue;
                };
                ticks.push(Tick { value, label });
            }
        }
        ticks
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the exponent of an f64")]
fn whole(value: f64) -> i32 {
    value as i32
}

/// `digit` times a power of ten.
fn plain(digit: i32, power: i32) -> String {
    match power {
        0..=3 => (i64::from(digit) * 10_i64.pow(power.unsigned_abs())).to_string(),
        -2..=-1 => {
            format!("{:.*}", power.unsigned_abs() as usize, f64::from(digit) * 10_f64.powi(power))
        }
        _ => format!("{digit}e{power}"),
    }
}

/// Round numbers from 0 to `high` on a linear axis, at most six.
pub fn linear(high: f64) -> Vec<f64> {
    if !(high.is_finite() && high > 0.0) {
        return vec![0.0];
    }
    let power = 10_f64.powf((high / 5.0).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|digit| digit * power)
        .into_iter()
        .find(|step| high / step <= 5.0);
    let step = step.unwrap_or(10.0 * power);
    (0..=5).map(|index| f64::from(index) * step).filter(|value| *value <= high * 1.0001).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64) -> Vec<String> {
        Scale { low, high }.ticks().into_iter().filter_map(|tick| tick.label).collect()
    }

    #[test]
    fn ticks_are_powers_of_ten_or_finer() {
        assert_eq!(labels(1e-3, 1e2), ["1e-3", "0.01", "0.1", "1", "10", "100"]);
        assert_eq!(labels(0.9, 12.0), ["1", "2", "5", "10"]);
        assert_eq!(labels(0.28, 0.75), ["0.3", "0.4", "0.5", "0.6", "0.7"]);
        assert!(labels(1e-300, 1e300).len() <= LABELS as usize + 1);
        let many = Scale { low: 1e-6, high: 1e9 }.ticks();
        assert_eq!(many.len(), 16, "each power of ten has a line, if not a label");
    }

    #[test]
    fn places_grow_from_end_to_end() {
        let scale = Scale::decades([2e-5, 30.0]).unwrap();
        assert_eq!((scale.low, scale.high), (1e-5, 100.0));
        assert!((scale.place(0.1) - 4.0 / 7.0).abs() < 1e-12);
        for (value, place) in [
            (1e-9, 0.0),
            (0.0, 0.0),
            (-1.0, 0.0),
            (f64::NAN, 0.0),
            (1e9, 1.0),
            (f64::INFINITY, 1.0),
        ] {
            assert_eq!(scale.place(value), place, "{value}");
        }
    }

    #[test]
    fn what_is_not_finite_or_not_positive_makes_no_axis() {
        assert_eq!(Scale::around([]), None);
        assert_eq!(Scale::around([0.0, -1.0, f64::NAN, f64::INFINITY]), None);
        let one = Scale::around([5.0, f64::INFINITY]).unwrap();
        assert!(one.low < 5.0 && one.high > 5.0 && one.high.is_finite());
    }

    #[test]
    fn a_linear_axis_has_round_numbers() {
        assert_eq!(linear(10.0), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(linear(7.3), [0.0, 2.0, 4.0, 6.0]);
        assert_eq!(linear(0.011).len(), 3);
        for odd in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(linear(odd), [0.0]);
        }
    }

    #[test]
    fn an_axis_can_be_cut() {
        let scale = Scale::decades([1e-20, 1.0]).unwrap().not_below(1e-9);
        assert_eq!(scale.low, 1e-9);
    }
}

//! Numbers as a person reads them.

/// A measured number with three digits, a count with all of them; what is not finite is called so.
pub fn figure(value: f64) -> String {
    if !value.is_finite() {
        "not finite".to_owned()
    } else if value == 0.0 {
        "0".to_owned()
    } else if value.fract() == 0.0 && (1e4..1e9).contains(&value) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "whole, up to 1e9"
        )]
        count(value as usize)
    } else if value.fract() == 0.0 && value.abs() < 1e9 {
        format!("{value}")
    } else if (0.01..1e4).contains(&value.abs()) {
        let decimals = match value.abs() {
            small if small < 0.1 => 4,
            small if small < 1.0 => 3,
            small if small < 10.0 => 2,
            large => usize::from(large < 100.0),
        };
        format!("{value:.decimals$}")
    } else {
        format!("{value:.2e}")
    }
}

/// The same of what may not have been measured.
pub fn maybe(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), figure)
}

/// All digits of f32, so that a difference is seen.
pub fn exact(value: f64) -> String {
    if value.is_finite() { format!("{value:.9e}") } else { format!("{value}") }
}

/// A count with its thousands apart.
pub fn count(value: usize) -> String {
    let digits = value.to_string();
    let mut text = String::with_capacity(digits.len() * 2);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Between a number and its unit, where no line may end.
const BOUND: char = '\u{a0}';

/// A share of a whole.
pub fn percent(share: f64) -> String {
    if share.is_finite() { format!("{}{BOUND}%", figure(100.0 * share)) } else { figure(share) }
}

/// How often one goes into another; nothing into nothing is no number at all.
pub fn times(ratio: f64) -> String {
    if ratio.is_nan() {
        "–".to_owned()
    } else if ratio.is_finite() {
        format!("{}{BOUND}×", figure(ratio))
    } else {
        figure(ratio)
    }
}

/// Bytes in the largest unit of thousands that leaves a whole number before the point.
pub fn bytes(value: f64) -> String {
    let units = ["B", "kB", "MB", "GB"];
    let mut scaled = value;
    let mut unit = 0;
    while scaled.abs() >= 1e3 && unit + 1 < units.len() {
        scaled /= 1e3;
        unit += 1;
    }
    format!("{}{BOUND}{}", figure(scaled), units[unit])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_three_digits_and_say_when_they_are_none() {
        for (value, text) in [
            (0.0, "0"),
            (3.0, "3"),
            (0.012_34, "0.0123"),
            (0.123_4, "0.123"),
            (1.234, "1.23"),
            (-12.34, "-12.3"),
            (1234.6, "1235"),
            (1.553e-3, "1.55e-3"),
            (123_456.5, "1.23e5"),
            (15_571.0, "15,571"),
            (f64::INFINITY, "not finite"),
            (f64::NAN, "not finite"),
        ] {
            assert_eq!(figure(value), text);
        }
        assert_eq!(maybe(None), "–");
    }

    #[test]
    fn shares_ratios_and_bytes_have_their_unit() {
        assert_eq!(
            [percent(0.123_4), percent(-0.5), percent(f64::NAN)],
            ["12.3\u{a0}%", "-50\u{a0}%", "not finite"]
        );
        assert_eq!(
            [times(1.849), times(f64::INFINITY), times(f64::NAN)],
            ["1.85\u{a0}×", "not finite", "–"]
        );
        for (value, text) in [
            (0.0, "0\u{a0}B"),
            (999.0, "999\u{a0}B"),
            (5_291_000.0, "5.29\u{a0}MB"),
            (3e12, "3000\u{a0}GB"),
        ] {
            assert_eq!(bytes(value), text);
        }
    }

    #[test]
    fn counts_are_in_thousands() {
        for (value, text) in [(0, "0"), (999, "999"), (1000, "1,000"), (12_345_678, "12,345,678")] {
            assert_eq!(count(value), text);
        }
    }
}

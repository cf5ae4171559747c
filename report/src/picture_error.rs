//! Errors of pictures as a person reads them, the same in every table.

use sglow_results::picture_error::{Metric, PictureError};

/// Headings of [`cells`].
pub const HEADINGS: [&str; 6] = ["relMSE", "RMSE", "median", "95 %", "FLIP", "bias"];

/// A number by every metric, in the order of [`Metric::ALL`].
pub fn cells(error: &PictureError) -> [String; 6] {
    Metric::ALL.map(|metric| cell(error, metric))
}

/// A number by one metric. What is below the reference's noise has the largest error that it may be instead.
pub fn cell(error: &PictureError, metric: Metric) -> String {
    let measured = error.measured(metric);
    let dark = error.reference_mean == 0.0;
    match (measured.below_noise(), metric) {
        (true, Metric::Bias) => format!("±{}", text(measured.uncertainty, metric, dark)),
        (true, _) => {
            format!("< {}", text(measured.value.max(0.0) + measured.uncertainty, metric, dark))
        }
        (false, Metric::Bias) if measured.value > 0.0 => {
            format!("+{}", text(measured.value, metric, dark))
        }
        (false, _) => text(measured.value, metric, dark),
    }
}

/// A number of a metric: a share of the reference in percent, or in the picture's unit where that is black.
pub fn text(value: f64, metric: Metric, dark: bool) -> String {
    if !value.is_finite() || value.abs() >= 1e300 {
        "not finite".to_owned()
    } else if metric.is_share() && !dark {
        format!("{} %", digits(100.0 * value))
    } else {
        digits(value)
    }
}

/// Three digits.
fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if !(1e-4..1e5).contains(&size) {
        format!("{value:.1e}")
    } else {
        let decimals = (2 - size.log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.decimals$}")
    }
}

#[cfg(test)]
mod tests {
    use sglow_results::picture_error::Uncertainty;

    use super::*;

    #[test]
    fn an_error_below_the_noise_is_a_bound_and_never_no_number() {
        let mut error = PictureError {
            rmse_over_mean: 0.063,
            relative_mse: -1e-5,
            median: 0.0124,
            q95: 0.5,
            bias: 0.003,
            flip: 0.01,
            reference_mean: 1.0,
            uncertainty: Uncertainty { relative_mse: 3e-3, bias: 0.01, ..Uncertainty::default() },
            ..PictureError::default()
        };
        assert_eq!(
            cells(&error),
            ["< 0.00300", "6.30 %", "1.24 %", "50.0 %", "0.0100", "±1.00 %"].map(str::to_owned)
        );
        error.uncertainty = Uncertainty::default();
        assert_eq!(cell(&error, Metric::Bias), "+0.300 %");
        error.reference_mean = 0.0;
        assert_eq!(cell(&error, Metric::Rmse), "0.0630");
        let unknown = PictureError::unknown(3);
        assert_eq!(cell(&unknown, Metric::RelativeMse), "not finite");
    }
}

//! How far a picture is from its reference.

/// Differences of a picture from its reference; every number counts alike, whatever its channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metrics {
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Mean of the squared difference over the squared reference, plus 1e-2 times the reference's mean square.
    pub relative_mse: f64,
    /// Largest difference.
    pub maximum: f64,
    /// Mean of the absolute difference.
    pub mean_absolute: f64,
    /// Mean of the picture over mean of the reference, minus 1.
    pub bias: f64,
    /// Mean of the reference.
    pub reference_mean: f64,
    /// Numbers that are not finite in either; they count in nothing else.
    pub not_finite: usize,
}

/// Compares a picture with its reference, number by number; `None` if the lengths differ or nothing is finite.
#[must_use]
pub fn compare<P: Into<f64> + Copy, Q: Into<f64> + Copy>(
    picture: &[P],
    reference: &[Q],
) -> Option<Metrics> {
    if picture.len() != reference.len() {
        return None;
    }
    let pairs =
        || picture.iter().zip(reference).map(|(&found, &expected)| (found.into(), expected.into()));
    let finite = || {
        pairs().filter(|(found, expected): &(f64, f64)| found.is_finite() && expected.is_finite())
    };
    let count = finite().count();
    if count == 0 {
        return None;
    }
    let mean = |value: &dyn Fn(f64, f64) -> f64| {
        finite().map(|(p, q)| value(p, q)).sum::<f64>() / count as f64
    };
    let floor = 1e-2 * mean(&|_, q| q * q);
    let relative = |p: f64, q: f64| {
        if p == q { 0.0 } else { (p - q).powi(2) / (q * q + floor) }
    };
    let reference_mean = mean(&|_, q| q);
    Some(Metrics {
        rmse: mean(&|p, q| (p - q).powi(2)).sqrt(),
        relative_mse: mean(&relative),
        maximum: finite().map(|(p, q)| (p - q).abs()).fold(0.0, f64::max),
        mean_absolute: mean(&|p, q| (p - q).abs()),
        bias: mean(&|p, _| p) / reference_mean - 1.0,
        reference_mean,
        not_finite: picture.len() - count,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_what_it_says() {
        let metrics = compare(&[1.0_f32, 2.0, 5.0, f32::NAN], &[1.0_f64, 2.0, 3.0, 1.0]).unwrap();
        assert!((metrics.rmse - (4.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        let floor = 1e-2 * 14.0 / 3.0;
        assert!((metrics.relative_mse - 4.0 / (9.0 + floor) / 3.0).abs() < 1e-12);
        assert_eq!((metrics.maximum, metrics.not_finite), (2.0, 1));
        assert!((metrics.bias - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(compare(&[1.0], &[1.0, 2.0]), None);
        let same = compare(&[0.0, 4.0], &[0.0, 4.0]).unwrap();
        assert_eq!((same.rmse, same.relative_mse), (0.0, 0.0));
    }
}

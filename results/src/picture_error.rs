//! How far a picture is from its reference, by every metric: the same for all that compares pictures.

use core::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sglow_oracle::Vector3;
use sglow_oracle::flip::{PIXELS_PER_DEGREE, decoded, flip};
use sglow_oracle::metrics::{self, Measured};

use crate::display::Exposure;

/// Linear radiance of a picture, three numbers each pixel, row by row from the top.
pub type Radiance = Vec<[f32; 3]>;

/// One number for the difference of two pictures.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    Deserialize,
    JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// Mean of the squared difference over the squared reference plus a floor.
    #[default]
    RelativeMse,
    /// Root of the mean squared difference over the mean of the reference.
    Rmse,
    /// Median over pixels of the relative error.
    Median,
    /// The relative error that 95 % of the pixels stay below.
    #[serde(rename = "q95")]
    Quantile95,
    /// Mean of the FLIP map.
    Flip,
    /// Size of the mean's difference over the mean of the reference.
    Bias,
}

impl Metric {
    /// All of them, the default first.
    pub const ALL: [Self; 6] =
        [Self::RelativeMse, Self::Rmse, Self::Median, Self::Quantile95, Self::Flip, Self::Bias];

    /// The name, as the command line and `report.json` have it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RelativeMse => "relative_mse",
            Self::Rmse => "rmse",
            Self::Median => "median",
            Self::Quantile95 => "q95",
            Self::Flip => "flip",
            Self::Bias => "bias",
        }
    }

    /// A few words for a person.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::RelativeMse => "relative MSE",
            Self::Rmse => "RMSE over the mean",
            Self::Median => "median relative error",
            Self::Quantile95 => "95 % quantile of the relative error",
            Self::Flip => "FLIP",
            Self::Bias => "bias",
        }
    }

    /// Whether it is a share of the reference, which is written in percent.
    #[must_use]
    pub fn is_share(self) -> bool {
        !matches!(self, Self::RelativeMse | Self::Flip)
    }
}

impl fmt::Display for Metric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl core::str::FromStr for Metric {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|metric| metric.name() == text);
        found.ok_or_else(|| {
            let known = Self::ALL.map(Self::name).join(", ");
            format!("unknown metric '{text}'; expected one of {known}")
        })
    }
}

/// How far the reference's noise may have moved each number of a [`PictureError`]: two standard errors of
/// `relative_mse`, `rmse_over_mean` and `bias`, the largest rise that noise explains of the others. An error of at most
/// its uncertainty is below the noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Uncertainty {
    /// Of `rmse_over_mean`.
    #[schemars(with = "Option<f64>")]
    pub rmse_over_mean: f64,
    /// Of `relative_mse`.
    #[schemars(with = "Option<f64>")]
    pub relative_mse: f64,
    /// Of `median`.
    #[schemars(with = "Option<f64>")]
    pub median: f64,
    /// Of `q95`.
    #[schemars(with = "Option<f64>")]
    pub q95: f64,
    /// Of `bias`.
    #[schemars(with = "Option<f64>")]
    pub bias: f64,
    /// Of `flip`.
    #[schemars(with = "Option<f64>")]
    pub flip: f64,
}

/// How far a picture is from its reference, over pixels that show a surface. Where the reference is black everywhere,
/// what is relative elsewhere is absolute, in the unit of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PictureError {
    /// Root of the mean squared difference over the mean of the reference; 0 where the estimate of the square is
    /// negative.
    #[schemars(with = "Option<f64>")]
    pub rmse_over_mean: f64,
    /// Mean of the squared difference over the squared reference plus 1e-2 times its mean square. An estimate without
    /// the reference's noise, so it may be negative, below the noise.
    #[schemars(with = "Option<f64>")]
    pub relative_mse: f64,
    /// Median over pixels of the relative error: luminance of the absolute difference over the luminance of the
    /// reference plus 1e-2 times its mean.
    #[schemars(with = "Option<f64>")]
    pub median: f64,
    /// The relative error that 95 % of the pixels stay below.
    #[schemars(with = "Option<f64>")]
    pub q95: f64,
    /// Mean of the picture over that of the reference, minus 1.
    #[schemars(with = "Option<f64>")]
    pub bias: f64,
    /// Mean of the FLIP map of both whole pictures as they are shown, direct light and all; 0 to 1.
    #[schemars(with = "Option<f64>")]
    pub flip: f64,
    /// How far the reference's noise may have moved each of them.
    pub uncertainty: Uncertainty,
    /// Mean of the reference over the numbers that were compared.
    #[schemars(with = "Option<f64>")]
    pub reference_mean: f64,
    /// Pixels that were compared.
    pub pixels: usize,
    /// Numbers that were not finite; their pixels count in nothing else.
    pub not_finite: usize,
}

impl PictureError {
    /// A picture of which nothing can be compared.
    #[must_use]
    pub fn unknown(not_finite: usize) -> Self {
        let [rmse_over_mean, relative_mse, median, q95] = [f64::MAX; 4];
        Self {
            rmse_over_mean,
            relative_mse,
            median,
            q95,
            bias: f64::MAX,
            flip: 1.0,
            not_finite,
            ..Self::default()
        }
    }

    /// The number of a metric as it is, with its uncertainty: a bias has its sign.
    #[must_use]
    pub fn measured(&self, metric: Metric) -> Measured {
        let Uncertainty { rmse_over_mean, relative_mse, median, q95, bias, flip } =
            self.uncertainty;
        let (value, uncertainty) = match metric {
            Metric::RelativeMse => (self.relative_mse, relative_mse),
            Metric::Rmse => (self.rmse_over_mean, rmse_over_mean),
            Metric::Median => (self.median, median),
            Metric::Quantile95 => (self.q95, q95),
            Metric::Flip => (self.flip, flip),
            Metric::Bias => (self.bias, bias),
        };
        Measured { value, uncertainty }
    }

    /// The number that ranks: at least 0, the less the better; infinite if it is not finite.
    #[must_use]
    pub fn of(&self, metric: Metric) -> f64 {
        let value = self.measured(metric).value;
        match metric {
            _ if !value.is_finite() => f64::INFINITY,
            Metric::Bias => value.abs(),
            _ => value.max(0.0),
        }
    }
}

/// Two pictures that are compared.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    /// Width and height.
    pub size: [u32; 2],
    /// Indices of the pixels that count in all metrics but FLIP; all if there are none.
    pub present: Option<&'a [usize]>,
    /// The light that is compared.
    pub picture: &'a Radiance,
    /// Two independent halves of its reference, or the same twice if it is exact.
    pub halves: [&'a Radiance; 2],
    /// The whole picture of which that light is a part, for FLIP.
    pub whole: &'a Radiance,
    /// The whole pictures of both halves.
    pub whole_halves: [&'a Radiance; 2],
    /// How both are shown, for FLIP.
    pub display: Display,
}

/// How pictures are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Display {
    /// Radiance with the exposure of the reference, through the curve of [`Exposure`].
    Automatic,
    /// Radiance with this exposure, through the same curve.
    Exposed(Exposure),
    /// Light of a screen, 0 to 1.
    AsIs,
}

/// Compares two pictures by every metric; an error that says so where nothing can be compared.
///
/// FLIP is that of the whole pictures as they are shown with one exposure, [`PIXELS_PER_DEGREE`]; it is 1 if there is
/// none, since sizes differ or a number is not finite.
#[must_use]
pub fn compare(pair: &Pair<'_>) -> PictureError {
    let Some(found) = metrics::compare(pair.picture, pair.halves.map(Vec::as_slice), pair.present)
    else {
        let odd = pair.picture.iter().flatten().filter(|value| !value.is_finite()).count();
        return PictureError::unknown(odd);
    };
    let flip = shown(pair);
    let rmse = found.rmse_over_mean();
    PictureError {
        rmse_over_mean: rmse.value,
        relative_mse: found.relative_mse.value,
        median: found.median.value,
        q95: found.quantile_95.value,
        bias: found.bias.value,
        flip: flip.value,
        uncertainty: Uncertainty {
            rmse_over_mean: rmse.uncertainty,
            relative_mse: found.relative_mse.uncertainty,
            median: found.median.uncertainty,
            q95: found.quantile_95.uncertainty,
            bias: found.bias.uncertainty,
            flip: flip.uncertainty,
        },
        reference_mean: found.reference_mean,
        pixels: found.pixels,
        not_finite: found.not_finite,
    }
}

/// The mean of the FLIP map against the mean of the halves; what noise does to it is found as of a quantile.
fn shown(pair: &Pair<'_>) -> Measured {
    let [one, other] = pair.whole_halves;
    let mean = mean(pair.whole_halves);
    let display = match pair.display {
        Display::Automatic => Display::Exposed(Exposure::automatic(&mean)),
        chosen => chosen,
    };
    let ours = displayed(pair.whole, display);
    let size = pair.size.map(|side| side as usize);
    let against = |reference: &Radiance| {
        let reference = displayed(reference, display);
        flip(&reference, &ours, size, PIXELS_PER_DEGREE).map_or(1.0, |flip| flip.mean)
    };
    let value = against(&mean);
    let uncertainty =
        if one == other { 0.0 } else { metrics::rise(value, pair.whole_halves.map(against)) };
    Measured { value, uncertainty }
}

/// The relative error of every pixel against the mean of the halves; see [`metrics::relative_error`].
#[must_use]
pub fn relative_errors(pair: &Pair<'_>) -> Vec<f32> {
    let reference = mean(pair.halves);
    let luminance = |at: usize| metrics::luminance(reference[at].map(f64::from));
    let all: Vec<usize> = (0..reference.len()).collect();
    let present = pair.present.unwrap_or(&all);
    let mean = present.iter().map(|&at| luminance(at)).sum::<f64>() / present.len().max(1) as f64;
    let mean = (mean != 0.0).then_some(mean);
    let pixels = pair.picture.iter().zip(&reference);
    pixels
        .map(|(found, expected)| {
            let [found, expected] = [found, expected].map(|pixel| pixel.map(f64::from));
            metrics::relative_error(found, expected, mean) as f32
        })
        .collect()
}

/// The mean of two halves.
#[must_use]
pub fn mean([one, other]: [&Radiance; 2]) -> Radiance {
    let both = one.iter().zip(other);
    both.map(|(one, other)| core::array::from_fn(|at| 0.5 * (one[at] + other[at]))).collect()
}

/// The FLIP map of a whole picture against its reference, 0 to 1 each pixel, as both are shown; 1
/// everywhere if a number is not finite.
#[must_use]
pub fn flip_map(
    reference: &Radiance,
    picture: &Radiance,
    size: [u32; 2],
    display: Display,
) -> Vec<f32> {
    let display = match display {
        Display::Automatic => Display::Exposed(Exposure::automatic(reference)),
        chosen => chosen,
    };
    let shown = [reference, picture].map(|radiance| displayed(radiance, display));
    let size = size.map(|side| side as usize);
    match flip(&shown[0], &shown[1], size, PIXELS_PER_DEGREE) {
        Ok(flip) => flip.errors.into_iter().map(|error| error as f32).collect(),
        Err(_) => vec![1.0; picture.len()],
    }
}

/// What a screen shows of radiance, as light again: linear, 0 to 1.
fn displayed(radiance: &Radiance, display: Display) -> Vec<Vector3> {
    let linear = |value: f32| decoded(f64::from(value));
    let shown = radiance.iter().map(|&pixel| match display {
        Display::Exposed(exposure) => exposure.shown(pixel).map(linear),
        Display::Automatic | Display::AsIs => pixel.map(f64::from),
    });
    shown.map(|[r, g, b]| Vector3::new(r, g, b)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair<'a>(picture: &'a Radiance, halves: [&'a Radiance; 2]) -> Pair<'a> {
        Pair {
            size: [2, 2],
            present: None,
            picture,
            halves,
            whole: picture,
            whole_halves: halves,
            display: Display::Automatic,
        }
    }

    #[test]
    fn every_metric_has_its_name_and_its_number() {
        let reference = vec![[1.0, 0.5, 0.25]; 4];
        let picture: Radiance =
            reference.iter().map(|pixel| pixel.map(|part| 0.5 * part)).collect();
        let error = compare(&pair(&picture, [&reference, &reference]));
        assert_eq!((error.bias, error.pixels), (-0.5, 4));
        for metric in Metric::ALL {
            assert_eq!(metric.name().parse(), Ok(metric));
            let json = serde_json::to_value(metric).unwrap();
            assert_eq!(json, metric.name());
            assert!(error.of(metric) > 0.0, "{metric}");
            assert_eq!(error.measured(metric).uncertainty, 0.0);
        }
        assert!("mean".parse::<Metric>().unwrap_err().contains("relative_mse, rmse, median"));
        let same = compare(&pair(&reference, [&reference, &reference]));
        assert!(Metric::ALL.iter().all(|&metric| same.of(metric) == 0.0));
        let other: Radiance = vec![[0.9, 0.6, 0.2], [1.1, 0.4, 0.3], [1.0; 3], [0.5; 3]];
        let noisy = compare(&pair(&picture, [&reference, &other]));
        assert!(Metric::ALL.iter().all(|&metric| noisy.measured(metric).uncertainty > 0.0));
    }

    #[test]
    fn what_cannot_be_compared_ranks_last() {
        let reference = vec![[1.0_f32; 3]; 4];
        let broken = vec![[f32::NAN; 3]; 4];
        let error = compare(&pair(&broken, [&reference, &reference]));
        assert_eq!(error.not_finite, 12);
        assert!(error.of(Metric::RelativeMse) > 1e300 && error.flip == 1.0);
        let mut partly = reference.clone();
        partly[1][2] = f32::NAN;
        let error = compare(&pair(&partly, [&reference, &reference]));
        assert_eq!((error.not_finite, error.pixels, error.flip), (1, 3, 1.0));
        let odd = PictureError { relative_mse: f64::NAN, ..PictureError::default() };
        assert_eq!(odd.of(Metric::RelativeMse), f64::INFINITY);
        let below = PictureError { relative_mse: -1e-5, bias: -0.5, ..PictureError::default() };
        assert_eq!((below.of(Metric::RelativeMse), below.of(Metric::Bias)), (0.0, 0.5));
    }
}

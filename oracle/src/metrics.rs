//! How far a picture is from its reference: one definition for all that compares pictures.
//!
//! A reference that was drawn has noise, which every squared difference from it contains. So a reference comes as two
//! independent halves R1 and R2 (one that is exact twice as itself): with I the picture and mu what the halves scatter
//! about, the mean of (I - R1)(I - R2) is (I - mu)^2, free of the reference's noise. It may come out negative where the
//! error is below the noise.

use core::f64::consts::SQRT_2;

/// The floor below squared references in [`Metrics::relative_mse`], over the mean of the squared reference.
pub const RELATIVE_MSE_FLOOR: f64 = 1e-2;
/// The floor that is added to a pixel's luminance in the relative error, over the mean luminance of the reference.
pub const RELATIVE_ERROR_FLOOR: f64 = 1e-2;
/// Standard errors in an uncertainty: about 95 % of normally distributed errors are within it.
pub const STANDARD_ERRORS: f64 = 2.0;

/// A number with how far the reference's noise may have moved it; the uncertainty of an exact reference is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// The number.
    pub value: f64,
    /// Two standard errors of a mean; of a quantile, the largest rise that noise explains.
    pub uncertainty: f64,
}

impl Measured {
    /// Whether the reference's noise alone may be the cause of it.
    #[must_use]
    pub fn below_noise(self) -> bool {
        self.uncertainty > 0.0 && self.value.abs() <= self.uncertainty
    }

    /// The same in another unit.
    #[must_use]
    pub fn over(self, unit: f64) -> Self {
        Self { value: self.value / unit, uncertainty: self.uncertainty / unit }
    }
}

/// Differences of a picture from its reference over the pixels that were compared. Where the reference is black
/// everywhere, what is relative elsewhere is absolute, in the unit of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Metrics {
    /// Root of the mean squared difference over all numbers, in the unit of the picture; 0 where its square came out
    /// negative.
    pub rmse: Measured,
    /// Mean over all numbers of (I - R)^2 / (R^2 + 1e-2 mean(R^2)). It may be negative, below the noise.
    pub relative_mse: Measured,
    /// Median over pixels of the relative error: the luminance of |I - R| over that of the reference plus
    /// [`RELATIVE_ERROR_FLOOR`] times its mean. The mean of both halves is the reference, whose noise raises it.
    pub median: Measured,
    /// The relative error that 95 % of the pixels stay below.
    pub quantile_95: Measured,
    /// Mean of the picture over mean of the reference, minus 1; noise moves it either way.
    pub bias: Measured,
    /// Mean of the reference over all numbers.
    pub reference_mean: f64,
    /// Pixels that count: those with three finite numbers in the picture and in both halves.
    pub pixels: usize,
    /// Numbers that are not finite, in the picture or the reference; a pixel with one counts in nothing else.
    pub not_finite: usize,
}

impl Metrics {
    /// The root mean square over the mean of the reference; itself where that is black.
    #[must_use]
    pub fn rmse_over_mean(&self) -> Measured {
        if self.reference_mean > 0.0 { self.rmse.over(self.reference_mean) } else { self.rmse }
    }
}

/// A pixel of the picture and of both halves of the reference.
#[derive(Clone, Copy)]
struct Pixel {
    found: [f64; 3],
    halves: [[f64; 3]; 2],
}

impl Pixel {
    fn mean(&self) -> [f64; 3] {
        let [one, other] = self.halves;
        core::array::from_fn(|channel| 0.5 * (one[channel] + other[channel]))
    }

    fn numbers(&self) -> impl Iterator<Item = (f64, [f64; 2])> {
        let [one, other] = self.halves;
        (0..3).map(move |channel| (self.found[channel], [one[channel], other[channel]]))
    }
}

/// Compares a picture with a reference in two halves, over the pixels whose indices are in `present`, or all; `None` if
/// the lengths differ, an index has no pixel or no pixel is finite.
#[must_use]
pub fn compare<P: Into<f64> + Copy, Q: Into<f64> + Copy>(
    picture: &[[P; 3]],
    halves: [&[[Q; 3]]; 2],
    present: Option<&[usize]>,
) -> Option<Metrics> {
    if halves.iter().any(|half| half.len() != picture.len()) {
        return None;
    }
    let all: Vec<usize>;
    let present = match present {
        Some(present) => present,
        None => {
            all = (0..picture.len()).collect();
            &all
        }
    };
    let mut not_finite = 0;
    let mut pixels = Vec::with_capacity(present.len());
    for &at in present {
        let found = picture.get(at)?.map(Into::into);
        let pixel = Pixel { found, halves: halves.map(|half| half[at].map(Into::into)) };
        let odd = |(found, halves): &(f64, [f64; 2])| {
            !(found.is_finite() && halves.iter().all(|half| half.is_finite()))
        };
        match pixel.numbers().filter(odd).count() {
            0 => pixels.push(pixel),
            odd => not_finite += odd,
        }
    }
    if pixels.is_empty() {
        return None;
    }
    Some(Metrics { not_finite, ..metrics(&pixels) })
}

/// Compares a picture with a reference that is exact, over all pixels.
#[must_use]
pub fn compare_exact<P: Into<f64> + Copy, Q: Into<f64> + Copy>(
    picture: &[[P; 3]],
    reference: &[[Q; 3]],
) -> Option<Metrics> {
    compare(picture, [reference; 2], None)
}

fn metrics(pixels: &[Pixel]) -> Metrics {
    let numbers = 3.0 * pixels.len() as f64;
    let sum = |value: &dyn Fn(&Pixel) -> f64| pixels.iter().map(value).sum::<f64>();
    let mean = sum(&|pixel| pixel.mean().iter().sum()) / numbers;
    // The product of the halves: the square without the noise.
    let square = sum(&|pixel| pixel.numbers().map(|(_, [one, other])| one * other).sum()) / numbers;
    let dark = square == 0.0 && mean == 0.0;
    // Noise may take it below 0 where there is hardly any light.
    let noisy = || sum(&|pixel| pixel.mean().iter().map(|part| part * part).sum()) / numbers;
    let floor = RELATIVE_MSE_FLOOR * if square > 0.0 { square } else { noisy() };
    let picture_mean = sum(&|pixel| pixel.found.iter().sum()) / numbers;
    let lit = mean > 0.0;
    let bias = if lit {
        let deviation =
            |pixel: &Pixel| pixel.numbers().map(|(_, [one, other])| 0.5 * (one - other)).sum();
        let variance = sum(&|pixel| {
            let deviation: f64 = deviation(pixel);
            deviation * deviation
        });
        // d(picture / mean) / d mean = -picture / mean^2
        let error = variance.sqrt() / numbers * (picture_mean / mean).abs() / mean;
        Measured { value: picture_mean / mean - 1.0, uncertainty: STANDARD_ERRORS * error }
    } else {
        Measured::default()
    };
    let mse = squared(pixels, Weight::One);
    let relative_mse = if dark { mse } else { squared(pixels, Weight::Squared { floor }) };
    let [median, quantile_95] = quantiles(pixels, dark);
    Metrics {
        rmse: root(mse),
        relative_mse,
        median,
        quantile_95,
        bias,
        reference_mean: mean,
        pixels: pixels.len(),
        not_finite: 0,
    }
}

/// What squared differences are divided by.
#[derive(Clone, Copy)]
enum Weight {
    /// Nothing.
    One,
    /// The squared reference plus a floor.
    Squared { floor: f64 },
}

impl Weight {
    fn at(self, reference: f64) -> f64 {
        match self {
            Self::One => 1.0,
            Self::Squared { floor } => reference * reference + floor,
        }
    }

    /// Half of F''(R) of F = u^2/w(R), u = I - R, times a variance; see [`squared`].
    fn excess(self, u: f64, reference: f64, variance: f64) -> f64 {
        let w = self.at(reference);
        match self {
            // F'' = 2/w + 4 u w'/w^2 + u^2 (2 w'^2/w^3 - w''/w^2), with w' = 2 R and w'' = 2.
            // Where the variance is not small against the weight the series does not converge.
            Self::Squared { .. } if variance < 0.25 * w => {
                let slope = reference / w;
                variance
                    * (1.0 / w + 4.0 * u * slope / w + u * u * (4.0 * slope * slope - 1.0 / w) / w)
            }
            _ => variance / w,
        }
    }
}

/// The mean of F(R) = (I - R)^2 / w(R) at what both halves scatter about, w constant or R^2 plus a floor.
///
/// With M the mean of the halves and D half their difference, whose square's mean is the variance of M, the mean of
/// F(M) exceeds F(mu) by half F'' times that variance: F(M) - F''(M) D^2 / 2. With a constant w it is
/// (I - R1)(I - R2) / w to the letter; with another, the weight's own noise is free of its first order as well, which
/// the product over w(M) is not: its error 2 (I - mu) var / mu^3 has the sign of the picture's error. Where D^2 is not
/// small against w the product is taken.
///
/// The variance of a pixel's share is the square of half the difference of F(R1) and F(R2): for normally distributed
/// noise, which may hang together among channels but not among pixels, that is unbiased if w is constant; noise with
/// heavier tails makes it too large.
fn squared(pixels: &[Pixel], weight: Weight) -> Measured {
    let of = |found: f64, reference: f64| {
        let difference = found - reference;
        // Nothing over nothing is no error.
        if difference == 0.0 { 0.0 } else { difference * difference / weight.at(reference) }
    };
    let (mut sum, mut variance) = (0.0, 0.0);
    for pixel in pixels {
        let mut half_difference = 0.0;
        for (found, [one, other]) in pixel.numbers() {
            let middle = 0.5 * (one + other);
            let deviation = 0.25 * (one - other) * (one - other);
            sum += of(found, middle);
            if deviation > 0.0 {
                sum -= weight.excess(found - middle, middle, deviation);
                half_difference += 0.5 * (of(found, one) - of(found, other));
            }
        }
        variance += half_difference * half_difference;
    }
    let numbers = 3.0 * pixels.len() as f64;
    Measured { value: sum / numbers, uncertainty: STANDARD_ERRORS * variance.sqrt() / numbers }
}

/// The root of a mean square.
fn root(square: Measured) -> Measured {
    let value = square.value.max(0.0);
    let [root, above] = [value, value + square.uncertainty].map(f64::sqrt);
    let below = (value - square.uncertainty).max(0.0).sqrt();
    Measured { value: root, uncertainty: (above - root).max(root - below) }
}

/// The relative error of a pixel, as [`Metrics::median`] has it: the luminance of the absolute difference over that of
/// the reference plus [`RELATIVE_ERROR_FLOOR`] times `mean`, the reference's mean luminance over all pixels; without a
/// mean, as where the reference is black everywhere, over 1.
#[must_use]
pub fn relative_error(found: [f64; 3], reference: [f64; 3], mean: Option<f64>) -> f64 {
    let apart = core::array::from_fn(|channel| f64::abs(found[channel] - reference[channel]));
    let unit =
        mean.map_or(1.0, |mean| luminance(reference).abs() + RELATIVE_ERROR_FLOOR * mean.max(0.0));
    match luminance(apart) {
        0.0 => 0.0,
        apart => apart / unit,
    }
}

/// The luminance of a linear Rec. 709 colour.
#[must_use]
pub fn luminance(color: [f64; 3]) -> f64 {
    color.into_iter().zip(LUMINANCE).map(|(part, weight)| part * weight).sum()
}

/// Weights of the channels in luminance.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Median and 95 % quantile of the pixels' relative errors.
///
/// Noise raises them: by an amount in proportion to its standard deviation at most (where the error is all noise), to
/// its variance where it is small. A half has twice the variance of the mean, so what a half's quantile is above the
/// mean's is at least sqrt(2) - 1 of what noise raises the mean's.
fn quantiles(pixels: &[Pixel], dark: bool) -> [Measured; 2] {
    let mean =
        pixels.iter().map(|pixel| luminance(pixel.mean())).sum::<f64>() / pixels.len() as f64;
    let errors = |reference: &dyn Fn(&Pixel) -> [f64; 3]| {
        let mean = (!dark).then_some(mean);
        let error = |pixel: &Pixel| relative_error(pixel.found, reference(pixel), mean);
        let mut errors: Vec<f64> = pixels.iter().map(error).collect();
        errors.sort_by(f64::total_cmp);
        errors
    };
    let middle = errors(&Pixel::mean);
    let exact = pixels.iter().all(|pixel| pixel.halves[0] == pixel.halves[1]);
    let halves = (!exact).then(|| [0, 1].map(|half| errors(&|pixel| pixel.halves[half])));
    [0.5, 0.95].map(|share| {
        let value = quantile(&middle, share);
        let uncertainty = halves
            .as_ref()
            .map_or(0.0, |halves| rise(value, [0, 1].map(|half| quantile(&halves[half], share))));
        Measured { value, uncertainty }
    })
}

/// How far noise may have raised a number that is no mean of squares, from what it is with the mean of the reference's
/// halves and with each of them: see [`Metrics::median`].
#[must_use]
pub fn rise(of_mean: f64, of_halves: [f64; 2]) -> f64 {
    let [one, other] = of_halves;
    let rise = (0.5 * (one + other) - of_mean).abs() / (SQRT_2 - 1.0);
    rise.max(0.5 * (one - other).abs())
}

/// The value that a share of sorted values stay below, linear between two.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * sorted.len().saturating_sub(1) as f64;
    let [low, high] = [at.floor(), at.ceil()].map(|at| sorted[at as usize]);
    let between = at.fract();
    if between == 0.0 { low } else { low + between * (high - low) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::stress::Random;

    type Pixels = Vec<[f64; 3]>;

    /// A picture, the exact, and noisy halves of it: Gaussian with a standard deviation of `noise` times the exact.
    fn noisy(seed: u64, error: f64, noise: f64) -> (Pixels, Pixels, [Pixels; 2]) {
        let mut random = Random::new(seed);
        let exact: Vec<[f64; 3]> =
            (0..4000).map(|_| [1.0, 0.7, 0.3].map(|part| part * random.normal().exp())).collect();
        let mut apart = |share: f64, together: bool| -> Vec<[f64; 3]> {
            let scaled = |pixel: &[f64; 3]| {
                let one = random.normal();
                pixel
                    .map(|part| part * (1.0 + share * if together { one } else { random.normal() }))
            };
            exact.iter().map(scaled).collect()
        };
        // All channels of a pixel share its paths, so their noise hangs together.
        let halves = [apart(noise, true), apart(noise, true)];
        let picture =
            apart(error, false).iter().map(|pixel| pixel.map(|part| 1.05 * part)).collect();
        (picture, exact, halves)
    }

    fn against(picture: &[[f64; 3]], halves: &[Vec<[f64; 3]>; 2]) -> Metrics {
        compare(picture, [&halves[0], &halves[1]], None).unwrap()
    }

    #[test]
    fn measures_what_it_says() {
        let found = [[1.0_f32, 2.0, 5.0], [f32::NAN, 1.0, f32::INFINITY], [0.0; 3]];
        let reference = [[1.0_f64, 2.0, 3.0], [1.0; 3], [0.0; 3]];
        let metrics = compare_exact(&found, &reference).unwrap();
        assert_eq!((metrics.pixels, metrics.not_finite), (2, 2));
        assert!((metrics.rmse.value - (4.0_f64 / 6.0).sqrt()).abs() < 1e-12);
        let floor = RELATIVE_MSE_FLOOR * 14.0 / 6.0;
        assert!((metrics.relative_mse.value - 4.0 / (9.0 + floor) / 6.0).abs() < 1e-12);
        assert!((metrics.bias.value - 2.0 / 6.0).abs() < 1e-12);
        let luminance = 0.2126 + 2.0 * 0.7152 + 3.0 * 0.0722;
        let error = 2.0 * 0.0722 / (luminance + RELATIVE_ERROR_FLOOR * 0.5 * luminance);
        assert!((metrics.median.value - 0.5 * error).abs() < 1e-12);
        assert!((metrics.quantile_95.value - 0.95 * error).abs() < 1e-12);
        assert_eq!(metrics.rmse.uncertainty + metrics.bias.uncertainty, 0.0, "it is exact");
        // Over pixels that are named alone.
        let none: Option<&[usize]> = Some(&[2]);
        let black = compare(&found, [&reference, &reference], none).unwrap();
        assert_eq!((black.rmse.value, black.relative_mse.value, black.pixels), (0.0, 0.0, 1));
    }

    #[test]
    fn what_cannot_be_compared_is_none() {
        let one = [[1.0_f64; 3]];
        assert_eq!(compare_exact(&one, &[[1.0_f64; 3]; 2]), None);
        assert_eq!(compare(&one, [&one, &one], Some(&[1])), None);
        assert_eq!(compare(&one, [&one, &one], Some(&[])), None);
        assert_eq!(compare_exact(&one, &[[f64::NAN, 1.0, 1.0]]), None);
    }

    #[test]
    fn in_the_dark_errors_are_absolute() {
        let metrics = compare_exact(&[[0.5_f64; 3]; 2], &[[0.0_f64; 3]; 2]).unwrap();
        assert_eq!((metrics.rmse_over_mean().value, metrics.relative_mse.value), (0.5, 0.25));
        assert_eq!((metrics.median.value, metrics.bias.value), (0.5, 0.0));
        let same = compare_exact(&[[0.0_f64; 3]], &[[0.0_f64; 3]]).unwrap();
        assert_eq!(
            (same.rmse.value, same.relative_mse.value, same.quantile_95.value),
            (0.0, 0.0, 0.0)
        );
    }

    #[test]
    fn halves_free_squared_errors_of_the_references_noise() {
        let repeats = 24;
        for (error, noise) in [(0.05, 0.1), (0.02, 0.05), (0.0, 0.1)] {
            let mut sums = [0.0; 2];
            let mut naive = [0.0; 2];
            let mut known_sums = [0.0; 2];
            let mut within = [0; 2];
            for seed in 0..repeats {
                let (picture, exact, halves) = noisy(seed, error, noise);
                let known = compare_exact(&picture, &exact).unwrap();
                let found = against(&picture, &halves);
                let mean: Vec<[f64; 3]> = halves[0]
                    .iter()
                    .zip(&halves[1])
                    .map(|(one, other)| core::array::from_fn(|at| 0.5 * (one[at] + other[at])))
                    .collect();
                let blind = compare_exact(&picture, &mean).unwrap();
                let of = |metrics: &Metrics| {
                    [metrics.rmse, metrics.relative_mse].map(|one| (one.value, one.uncertainty))
                };
                for at in 0..2 {
                    let power = if at == 0 { 2 } else { 1 };
                    sums[at] += of(&found)[at].0.powi(power);
                    known_sums[at] += of(&known)[at].0.powi(power);
                    naive[at] += of(&blind)[at].0.powi(power);
                    let apart = (of(&found)[at].0 - of(&known)[at].0).abs();
                    within[at] += u64::from(apart <= of(&found)[at].1);
                }
            }
            for at in 0..2 {
                let [free, blind] =
                    [sums[at], naive[at]].map(|sum| (sum / known_sums[at] - 1.0).abs());
                let case =
                    format!("error {error}, noise {noise}, metric {at}: {free:.4} {blind:.4}");
                assert!(free < 0.1, "{case}");
                assert!(blind > 0.3, "the noise is in the squares of one reference: {case}");
                // Two standard errors hold 95 %; none below 3/4 of 24 by chance.
                assert!(within[at] >= 18, "{case}: {within:?}");
            }
        }
    }

    #[test]
    fn the_product_over_a_noisy_weight_is_biased_and_ours_is_not() {
        let (mut product, mut ours, mut best) = (0.0, 0.0, 0.0);
        for seed in 0..16 {
            let (_, exact, halves) = noisy(seed, 0.0, 0.2);
            let picture: Vec<[f64; 3]> =
                exact.iter().map(|pixel| pixel.map(|part| 1.1 * part)).collect();
            best += compare_exact(&picture, &exact).unwrap().relative_mse.value;
            ours += against(&picture, &halves).relative_mse.value;
            let square: f64 = exact.iter().flatten().map(|part| part * part).sum();
            let floor = RELATIVE_MSE_FLOOR * square / (3 * exact.len()) as f64;
            let term = |((found, one), other): ((f64, f64), f64)| {
                let middle = 0.5 * (one + other);
                (found - one) * (found - other) / (middle * middle + floor)
            };
            let flat = |pixels: &[[f64; 3]]| pixels.iter().flatten().copied().collect::<Vec<f64>>();
            let terms = flat(&picture).into_iter().zip(flat(&halves[0])).zip(flat(&halves[1]));
            product += terms.map(term).sum::<f64>() / (3 * exact.len()) as f64;
        }
        assert!(product > 1.5 * best, "{} of {best}", product / best);
        assert!((ours / best - 1.0).abs() < 0.5 * (product / best - 1.0), "{}", ours / best);
    }

    #[test]
    fn an_error_below_the_noise_is_called_so() {
        let (_, exact, halves) = noisy(3, 0.0, 0.2);
        let metrics = against(&exact, &halves);
        let all = [metrics.rmse, metrics.relative_mse, metrics.median, metrics.quantile_95];
        assert!(all.iter().all(|one| one.below_noise() && !one.value.is_nan()), "{metrics:?}");
        assert!(metrics.bias.below_noise());
        let off: Vec<[f64; 3]> = exact.iter().map(|pixel| pixel.map(|part| 2.0 * part)).collect();
        let metrics = against(&off, &halves);
        let all = [metrics.rmse, metrics.relative_mse, metrics.median, metrics.bias];
        assert!(all.iter().all(|one| !one.below_noise()), "{metrics:?}");
        // What is known exactly has no noise to be below.
        let same = compare_exact(&exact, &exact).unwrap();
        assert!(!same.rmse.below_noise() && same.rmse.value == 0.0);
    }

    #[test]
    fn noise_raises_quantiles_by_no_more_than_is_said() {
        for (error, noise) in [(0.0, 0.1), (0.1, 0.05), (0.1, 0.2), (0.3, 0.1)] {
            let (picture, exact, halves) = noisy(5, error, noise);
            let known = compare_exact(&picture, &exact).unwrap();
            let found = against(&picture, &halves);
            for (found, known) in
                [(found.median, known.median), (found.quantile_95, known.quantile_95)]
            {
                let apart = found.value - known.value;
                assert!(
                    apart.abs() <= 1.1 * found.uncertainty + 2e-3,
                    "{error} {noise}: {apart} {found:?}"
                );
            }
        }
    }
}

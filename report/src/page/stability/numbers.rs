//! Numbers of functions as the page shows them.

use sglow_results::error::Worst;
use sglow_results::stability::held::Held;
use sglow_results::stability::quantity::{Quantity, Verdict};
use sglow_results::stability::report::{ExtremeReport, FunctionReport};

use crate::page::number::{count, figure};

/// Whether every variant of an extreme case does as it should; none at all is a failure.
pub fn holds(extreme: &ExtremeReport) -> bool {
    !extreme.variants.is_empty() && extreme.variants.iter().all(|variant| variant.holds)
}

/// What was compared with a bound; NaN if nothing was.
pub fn measured(value: f64) -> String {
    if value.is_nan() { "not measured".to_owned() } else { figure(value) }
}

/// The largest of a quantity over regimes, and the regime.
pub(super) fn largest<'a>(
    held: impl IntoIterator<Item = &'a Held>,
    quantity: Quantity,
) -> Option<(f64, &'static str)> {
    held.into_iter()
        .filter_map(|held| Some((quantity.of(held)?, held.regime)))
        .reduce(|worst, one| if one.0 > worst.0 || one.0.is_nan() { one } else { worst })
}

/// The largest of a quantity over all regimes.
pub fn most(function: &FunctionReport, quantity: Quantity) -> Option<f64> {
    largest(&function.held, quantity).map(|(value, _)| value)
}

/// The arithmetic that is worst in a regime, and its worst number.
pub(super) fn worst_arithmetic(held: &Held) -> Option<(&'static str, &Worst)> {
    held.conditioning
        .iter()
        .map(|(name, errors)| (*name, &errors.share))
        .reduce(|worst, one| if one.1.error > worst.1.error { one } else { worst })
}

/// The number that a verdict is about, with its input, where one is kept.
pub fn worst<'a>(function: &'a FunctionReport, verdict: &Verdict) -> Option<&'a Worst> {
    let held = function.held.iter().find(|held| held.regime == verdict.regime)?;
    let worst = match verdict.quantity {
        Quantity::RoundingShare => &held.rounding.share,
        Quantity::ArithmeticShare => worst_arithmetic(held)?.1,
        Quantity::TotalOverPeak => &held.total.as_ref()?.over_peak,
        Quantity::ModelOverPeak => &held.model.as_ref()?.over_peak,
        Quantity::RoundingOverPeak => &held.rounding.over_peak,
        Quantity::NotFinite => std::iter::once(&held.rounding)
            .chain(held.conditioning.values())
            .map(|errors| &errors.ulps)
            .find(|worst| !worst.measured.is_finite())?,
        Quantity::Negative | Quantity::NotMonotone | Quantity::WithoutPromise => return None,
    };
    (!worst.input.bits.is_empty()).then_some(worst)
}

/// The sum of a count over all regimes.
pub fn sum(function: &FunctionReport, quantity: Quantity) -> Option<f64> {
    let counts: Vec<f64> = function.held.iter().filter_map(|held| quantity.of(held)).collect();
    (!counts.is_empty()).then(|| counts.iter().sum())
}

/// A count that is kept as a number.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
pub fn whole(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |value| count(value as usize))
}

/// Whether a share is more than was granted.
pub(super) fn exceeds(share: f64) -> bool {
    share.is_nan() || share > 1.0
}

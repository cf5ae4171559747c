//! What of a function is compared with a bound, and what came of it.

use serde::Serialize;

use super::held::Held;

/// What of a function is compared with a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Results that are not finite, on the device and on the CPU under every arithmetic.
    NotFinite,
    /// Results below 0, likewise.
    Negative,
    /// Largest error on the device over what GPU languages allow.
    RoundingShare,
    /// Largest error on the CPU, under any arithmetic that a driver may use, over what GPU languages allow.
    ArithmeticShare,
    /// Largest error of the device against the reference, over the peak.
    TotalOverPeak,
    /// Largest error of the oracle against the reference, over the peak.
    ModelOverPeak,
    /// Largest error of the device against the oracle, over the peak.
    RoundingOverPeak,
    /// Neighbouring inputs whose results run the wrong way by more than both may be off.
    NotMonotone,
    /// The share of results for which GPU languages promise nothing, so that nothing holds them.
    WithoutPromise,
}

impl Quantity {
    /// What was measured of it; nothing where it was not measured.
    #[must_use]
    pub fn of(self, held: &Held) -> Option<f64> {
        let on_cpu = held.conditioning.values();
        let count = |on_device: usize, on_cpu: usize| Some((on_device + on_cpu) as f64);
        match self {
            Self::NotFinite => {
                count(held.rounding.not_finite, on_cpu.map(|errors| errors.not_finite).sum())
            }
            Self::Negative => {
                count(held.rounding.negative, on_cpu.map(|errors| errors.negative).sum())
            }
            Self::RoundingShare => Some(held.rounding.share.error),
            Self::ArithmeticShare => {
                Some(on_cpu.map(|errors| errors.share.error).fold(0.0, f64::max))
            }
            Self::TotalOverPeak => held.total.as_ref().map(|errors| errors.over_peak.error),
            Self::ModelOverPeak => held.model.as_ref().map(|errors| errors.over_peak.error),
            Self::RoundingOverPeak => Some(held.rounding.over_peak.error),
            Self::NotMonotone => (held.neighbours > 0).then_some(held.not_monotone as f64),
            Self::WithoutPromise => {
                let compared = held.rounding.compared.max(1) as f64;
                Some(held.rounding.without_promise as f64 / compared)
            }
        }
    }

    /// What it counts or is relative to.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::NotFinite | Self::Negative => "results",
            Self::RoundingShare | Self::ArithmeticShare => "of the grant",
            Self::TotalOverPeak | Self::ModelOverPeak | Self::RoundingOverPeak => "of the peak",
            Self::NotMonotone => "pairs",
            Self::WithoutPromise => "of the results",
        }
    }

    /// What it is, for a person.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "not finite",
            Self::Negative => "negative",
            Self::RoundingShare => "rounding",
            Self::ArithmeticShare => "any arithmetic",
            Self::TotalOverPeak => "device against reference",
            Self::ModelOverPeak => "model",
            Self::RoundingOverPeak => "device against oracle",
            Self::NotMonotone => "not monotone",
            Self::WithoutPromise => "no guarantee",
        }
    }
}

/// A bound and what was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// The function.
    pub function: &'static str,
    /// The regime in which the quantity was largest.
    pub regime: &'static str,
    /// What was compared.
    pub quantity: Quantity,
    /// What was measured.
    pub value: f64,
    /// The bound.
    pub at_most: f64,
    /// Whether it holds.
    pub holds: bool,
    /// Why this much and no more.
    pub reason: &'static str,
}

//! The regimes of arguments.

/// A part of the range of arguments that has a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regime {
    /// Its name.
    pub name: &'static str,
    /// The least magnitude.
    pub low: f64,
    /// The greatest magnitude.
    pub high: f64,
}

/// Every regime; together they cover each f32 that is at least 0.
pub const REGIMES: [Regime; 7] = [
    Regime { name: "subnormal", low: 1e-45, high: f32::MIN_POSITIVE as f64 },
    Regime { name: "tiny", low: f32::MIN_POSITIVE as f64, high: 1e-3 },
    Regime { name: "soft", low: 1e-3, high: 1.0 },
    Regime { name: "medium", low: 1.0, high: 1e3 },
    Regime { name: "sharp", low: 1e3, high: 1e6 },
    Regime { name: "extreme", low: 1e6, high: f32::MAX as f64 },
    // Drawn from what breaks things, see `special`.
    Regime { name: "adversarial", low: 0.0, high: 0.0 },
];

impl Regime {
    /// Whether the arguments are drawn from what breaks things.
    #[must_use]
    pub fn is_adversarial(&self) -> bool {
        self.high == 0.0
    }
}

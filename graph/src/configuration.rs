//! What a frame is evaluated for.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::description::{Number, Parameter, ParameterType, Setting, Table};

/// A value on axes, numbers, facts, and what the host brings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Configuration {
    /// Values of axes; the others have their defaults.
    pub axes: Table<String>,
    /// Values of parameters; the others have their defaults.
    pub parameters: Table<Number>,
    /// Facts of the input; the others are false.
    pub facts: Table<bool>,
    /// For each of the host's lists of draws, the values of its axes that occur.
    pub draws: Table<BTreeSet<BTreeMap<String, String>>>,
    /// Resources that the host supplies, beside those that it must.
    pub supplied: BTreeSet<String>,
    /// The parts of the frame that run; all without it. The host supplies what the others would hold.
    pub parts: Option<BTreeSet<String>>,
}

impl Setting {
    /// What a text stands for, as behind the `=` of `name=value`.
    pub fn read(text: &str) -> Self {
        let number = text.parse().map(Number::Whole).or_else(|_| text.parse().map(Number::Real));
        number.map_or_else(|_| Self::Name(text.to_owned()), Self::Number)
    }
}

impl fmt::Display for Number {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.real().fmt(out)
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(out),
            Self::Name(name) => name.fmt(out),
        }
    }
}

impl Number {
    /// The number as a real one.
    #[expect(clippy::cast_precision_loss, reason = "whole parameters are far below 2^53")]
    pub fn real(self) -> f64 {
        match self {
            Self::Whole(number) => number as f64,
            Self::Real(number) => number,
        }
    }
}

impl Parameter {
    /// Whether it may have this value.
    pub fn allows(&self, number: Number) -> bool {
        let whole = matches!(number, Number::Whole(_)) || self.kind == ParameterType::Real;
        let real = number.real();
        whole
            && real.is_finite()
            && self.minimum.is_none_or(|minimum| real >= minimum)
            && self.above.is_none_or(|above| real > above)
            && self.maximum.is_none_or(|maximum| real <= maximum)
    }

    /// Its range in words.
    pub fn range(&self) -> String {
        let kind = if self.kind == ParameterType::Whole { "a whole number" } else { "a number" };
        let bounds = [("at least", self.minimum), ("above", self.above), ("at most", self.maximum)];
        let words = |(text, bound): (&str, Option<f64>)| Some(format!(", {text} {}", bound?));
        format!("{kind}{}", bounds.into_iter().filter_map(words).collect::<String>())
    }
}

//! What a frame is evaluated for.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::description::{Description, Number, Parameter, ParameterType, Setting, Table};
use crate::error::{Error, Kind, Place, unknown};

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

impl Configuration {
    /// What names nothing, and parameters out of their ranges; the place is one in the configuration.
    pub(crate) fn check(&self, of: &Description) -> Vec<Error> {
        let mut errors = Vec::new();
        let mut wrong = |table: &str, name: &String, kind, text| {
            let place = Place(vec![table.to_owned(), name.clone()]);
            errors.push(Error { place, kind, text, formula: None });
        };
        for (name, value) in &self.axes {
            let text = match of.axes.get(name) {
                Some(axis) if axis.values.contains(value) => continue,
                Some(axis) => unknown("value", value, &axis.values),
                None => unknown("axis", name, of.axes.keys()),
            };
            wrong("axes", name, Kind::Unknown, text);
        }
        for name in self.facts.keys().filter(|name| !of.facts.contains(*name)) {
            wrong("facts", name, Kind::Unknown, unknown("fact", name, &of.facts));
        }
        for (name, number) in &self.parameters {
            let Some(parameter) = of.parameter.get(name) else {
                let text = unknown("parameter", name, of.parameter.keys());
                wrong("parameters", name, Kind::Unknown, text);
                continue;
            };
            if !parameter.allows(*number) {
                let (value, range) = (number.real(), parameter.range());
                let text = format!("parameter `{name}` is {value}; expected {range}");
                wrong("parameters", name, Kind::Invalid, text);
            }
        }
        errors
    }
}

impl Setting {
    /// What a text stands for, as behind the `=` of `name=value`.
    pub fn read(text: &str) -> Self {
        let real = || text.parse().map(Number::Real);
        let number = text.parse().map(Number::Whole).or_else(|_| real());
        number.map_or_else(|_| Self::Name(text.to_owned()), Self::Number)
    }
}

impl fmt::Display for Number {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(number) => number.fmt(out),
            Self::Real(number) => number.fmt(out),
        }
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
        let bound = |text: &str, bound: Option<f64>| {
            bound.map_or(String::new(), |bound| format!(", {text} {bound}"))
        };
        let lower = bound("at least", self.minimum) + &bound("above", self.above);
        format!("{kind}{lower}{}", bound("at most", self.maximum))
    }
}

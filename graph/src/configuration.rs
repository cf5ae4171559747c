//! What a frame is evaluated for.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::description::{Description, Number, Parameter, ParameterType, Table};
use crate::error::{At, Error, Problem};

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
    pub(crate) fn check(&self, description: &Description, errors: &mut Vec<Error>) {
        let mut wrong = |table: &str, name: &str, problem| {
            let path = [table.to_owned(), name.to_owned()];
            errors.push(At::base(&path, None).error(problem));
        };
        for (name, value) in &self.axes {
            match description.axes.get(name) {
                None => {
                    wrong("axes", name, Problem::unknown("axis", name, description.axes.keys()))
                }
                Some(axis) if axis.values.contains(value) => {}
                Some(axis) => {
                    wrong("axes", name, Problem::unknown("value", value, axis.values.iter()))
                }
            }
        }
        for name in self.facts.keys().filter(|name| !description.facts.contains(*name)) {
            wrong("facts", name, Problem::unknown("fact", name, description.facts.iter()));
        }
        for (name, number) in &self.parameters {
            match description.parameter.get(name) {
                None => {
                    wrong(
                        "parameters",
                        name,
                        Problem::unknown("parameter", name, description.parameter.keys()),
                    );
                }
                Some(parameter) if parameter.allows(*number) => {}
                Some(parameter) => {
                    let (value, range) = (number.real().to_string(), parameter.range());
                    wrong("parameters", name, Problem::Range { name: name.clone(), value, range });
                }
            }
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

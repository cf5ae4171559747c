//! What a frame is evaluated for.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::description::{
    ClassDefault, Description, Exclusion, Number, Parameter, ParameterType, Setting, Table,
};
use crate::error::{At, Error, Errors, Problem};

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
        let axes = self.axes.iter().filter_map(|(name, value)| {
            let problem = match of.axes.get(name) {
                None => Problem::unknown("axis", name, of.axes.keys()),
                Some(axis) if axis.values.contains(value) => return None,
                Some(axis) => Problem::unknown("value", value, axis.values.iter()),
            };
            Some(("axes", name, problem))
        });
        let unknown = self.facts.keys().filter(|name| !of.facts.contains(*name));
        let facts =
            unknown.map(|name| ("facts", name, Problem::unknown("fact", name, of.facts.iter())));
        let parameters = self.parameters.iter().filter_map(|(name, number)| {
            let problem = match of.parameter.get(name) {
                None => Problem::unknown("parameter", name, of.parameter.keys()),
                Some(parameter) if parameter.allows(*number) => return None,
                Some(parameter) => {
                    let (value, range) = (number.real().to_string(), parameter.range());
                    Problem::Range { name: name.clone(), value, range }
                }
            };
            Some(("parameters", name, problem))
        });
        let error = |(table, name, problem): (&str, &String, Problem)| {
            At::base(&[table.to_owned(), name.clone()], None).error(problem)
        };
        axes.chain(facts).chain(parameters).map(error).collect()
    }
}

impl Description {
    /// What an input with these facts is rendered with: the defaults of its class, changed by a preset, changed by `set`.
    ///
    /// # Errors
    ///
    /// An unknown preset. Whether the result is legal, [`Self::evaluate`] says.
    pub fn configure(
        &self,
        facts: &Table<bool>,
        preset: Option<&str>,
        set: &Table<Setting>,
    ) -> Result<Configuration, Errors> {
        let by_hand = || set.keys().map(String::as_str);
        let defaults = self.default.iter().filter(|rule| rule.holds(facts, by_hand()));
        let mut all: Table<_> = defaults.flat_map(|rule| rule.set.clone()).collect();
        if let Some(name) = preset {
            let unknown = || Problem::unknown("preset", name, self.preset.keys());
            let unknown = || Errors(vec![At::base(&["preset".to_owned()], None).error(unknown())]);
            all.extend(self.preset.get(name).ok_or_else(unknown)?.set.clone());
        }
        all.extend(set.clone());
        let mut made = Configuration { facts: facts.clone(), ..Configuration::default() };
        for (name, setting) in all {
            match setting {
                Setting::Number(number) if !self.axes.contains_key(&name) => {
                    made.parameters.insert(name, number);
                }
                setting => drop(made.axes.insert(name, setting.to_string())),
            }
        }
        Ok(made)
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

impl ClassDefault {
    /// Whether the rule holds: these facts are known, and of axes and parameters these are set by hand.
    pub fn holds<'a>(&self, facts: &Table<bool>, set: impl IntoIterator<Item = &'a str>) -> bool {
        self.when.iter().all(|(fact, holds)| facts.get(fact) == Some(holds))
            && !set.into_iter().any(|name| self.unless.iter().any(|unless| unless == name))
    }
}

impl Exclusion {
    /// Whether it holds for a pass with these values on its axes.
    pub fn excludes<'a>(&self, pass: &str, value: impl Fn(&str) -> Option<&'a str>) -> bool {
        self.pass.as_ref().is_none_or(|own| own == pass)
            && self.when.iter().all(|(axis, illegal)| {
                value(axis).is_some_and(|value| illegal.iter().any(|one| one == value))
            })
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

//! Named configurations, and defaults by class of input.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::Library;
use super::check::{is_kebab, is_snake, names};
use super::place::Places;
use crate::error::{Code, Diagnostic, Report};

/// A number that a host sets, beside its axes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// Its name; no axis is called so.
    pub name: String,
    /// What it is, with its unit and range.
    pub description: String,
}

/// A value of an axis by its name, or a number for a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Setting {
    /// A whole number.
    Whole(i64),
    /// A real number.
    Real(f64),
    /// The name of a value.
    Name(String),
}

impl Setting {
    /// A setting from what follows the `=` of `name=value`.
    #[must_use]
    pub fn read(text: &str) -> Self {
        if let Ok(whole) = text.parse() {
            return Self::Whole(whole);
        }
        text.parse().map_or_else(|_| Self::Name(text.to_owned()), Self::Real)
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(number) => number.fmt(out),
            Self::Real(number) => number.fmt(out),
            Self::Name(name) => name.fmt(out),
        }
    }
}

/// A named configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Preset {
    /// Its name.
    pub name: String,
    /// What it is.
    pub description: String,
    /// Values of axes and parameters; the others keep their defaults.
    pub set: BTreeMap<String, Setting>,
    /// The measurements that chose it, if measurements did.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<Measurement>,
}

/// What was measured of a [`Preset`] on one input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measurement {
    /// The input.
    pub input: String,
    /// The device, and how times were taken.
    pub device: String,
    /// The time of indirect light.
    pub milliseconds: f64,
    /// Each error by its metric, in the unit of the metric.
    pub errors: BTreeMap<String, f64>,
}

/// A file of presets.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PresetFile {
    /// The presets.
    #[serde(default)]
    pub preset: Vec<Preset>,
}

impl PresetFile {
    /// The presets of a file's text.
    ///
    /// # Errors
    ///
    /// What is no preset.
    pub fn read(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }

    /// The file's text.
    ///
    /// # Errors
    ///
    /// What TOML cannot hold.
    pub fn text(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }
}

/// A rule that changes defaults for a class of input.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassDefault {
    /// Name of the rule.
    pub name: String,
    /// Facts and what they must be for the rule to hold; of every input if there are none.
    pub when: BTreeMap<String, bool>,
    /// Values of axes and parameters.
    pub set: BTreeMap<String, Setting>,
    /// Axes and parameters that these values make meaningless: the rule does not hold where one of them is set.
    #[serde(default)]
    pub unless: Vec<String>,
    /// Why.
    pub reason: String,
}

impl ClassDefault {
    /// Whether the rule holds: these facts are known, and of axes and parameters these are set by hand.
    #[must_use]
    pub fn holds<'a>(
        &self,
        facts: &BTreeMap<String, bool>,
        set: impl IntoIterator<Item = &'a str>,
    ) -> bool {
        self.when.iter().all(|(fact, holds)| facts.get(fact) == Some(holds))
            && !set.into_iter().any(|name| self.unless.iter().any(|unless| unless == name))
    }
}

impl Library {
    /// The preset called `name`.
    ///
    /// # Errors
    ///
    /// That there is none, with those that there are.
    pub fn find_preset(&self, name: &str) -> Result<&Preset, Report> {
        self.preset.iter().find(|preset| preset.name == name).ok_or_else(|| {
            let known = self.preset.iter().map(|preset| preset.name.as_str());
            let unknown = Diagnostic::unknown("preset", name, known);
            Report::new(vec![unknown], self.sources().clone())
        })
    }

    /// Checks parameters, presets and defaults by class.
    pub(super) fn check_presets(&self, places: &Places<'_>, errors: &mut Vec<Diagnostic>) {
        let parameters = names(&self.parameter, |one| &one.name);
        for (index, name) in parameters.iter().enumerate() {
            let index = index.to_string();
            let path = ["parameter", index.as_str(), "name"];
            if !is_snake(name) {
                let error =
                    Diagnostic::new(Code::Name, format!("`{name}` is no name for a parameter"));
                let help = "names of this kind are in snake case";
                errors.push(places.mark(error.help(help), &path, "here"));
            }
            if self.axis.contains_key(*name) {
                let text = format!("`{name}` is an axis and a parameter");
                errors.push(places.mark(Diagnostic::new(Code::Duplicate, text), &path, "here"));
            }
        }
        unique("parameter", &parameters, places, errors);
        unique("preset", &names(&self.preset, |one| &one.name), places, errors);
        for (index, preset) in self.preset.iter().enumerate() {
            let index = index.to_string();
            if !is_snake(&preset.name) {
                let text = format!("`{}` is no name for a preset", preset.name);
                let error =
                    Diagnostic::new(Code::Name, text).help("names of this kind are in snake case");
                errors.push(places.mark(error, &["preset", &index, "name"], "here"));
            }
            self.check_settings(&preset.set, &["preset", &index, "set"], places, errors);
        }
        unique("default", &names(&self.class_default, |one| &one.name), places, errors);
        for (index, rule) in self.class_default.iter().enumerate() {
            let index = index.to_string();
            if !is_kebab(&rule.name) {
                let text = format!("`{}` is no name for a default", rule.name);
                let error =
                    Diagnostic::new(Code::Name, text).help("names of this kind are in kebab case");
                errors.push(places.mark(error, &["default", &index, "name"], "here"));
            }
            for fact in rule.when.keys() {
                if !self.fact.iter().any(|known| known.name == *fact) {
                    let known = self.fact.iter().map(|fact| fact.name.as_str());
                    let error = Diagnostic::unknown("fact", fact, known);
                    errors.push(places.mark(error, &["default", &index, "when", fact], "here"));
                }
            }
            self.check_settings(&rule.set, &["default", &index, "set"], places, errors);
            for (at, name) in rule.unless.iter().enumerate() {
                if !self.axis.contains_key(name) && !parameters.contains(&name.as_str()) {
                    let at = at.to_string();
                    let unknown = self.unknown_setting(name);
                    errors.push(places.mark(unknown, &["default", &index, "unless", &at], "here"));
                }
            }
        }
    }

    /// An error about a name that is neither an axis nor a parameter.
    fn unknown_setting(&self, name: &str) -> Diagnostic {
        let axes = self.axis.keys().map(String::as_str);
        let parameters = self.parameter.iter().map(|one| one.name.as_str());
        Diagnostic::unknown("axis or parameter", name, axes.chain(parameters))
    }

    fn check_settings(
        &self,
        set: &BTreeMap<String, Setting>,
        path: &[&str],
        places: &Places<'_>,
        errors: &mut Vec<Diagnostic>,
    ) {
        for (name, setting) in set {
            let path = [path, &[name.as_str()]].concat();
            let error = match self.axis.get(name) {
                Some(axis) => {
                    let value = setting.to_string();
                    if axis.value.iter().any(|known| known.name == value) {
                        continue;
                    }
                    let known = axis.value.iter().map(|value| value.name.as_str());
                    Diagnostic::unknown(&format!("value of axis `{name}`"), &value, known)
                }
                None if !self.parameter.iter().any(|known| known.name == *name) => {
                    self.unknown_setting(name)
                }
                None if matches!(setting, Setting::Name(_)) => {
                    let text = format!("parameter `{name}` is a number, not `{setting}`");
                    Diagnostic::new(Code::Declaration, text)
                }
                None => continue,
            };
            errors.push(places.mark(error, &path, "here"));
        }
    }
}

/// Names that are there twice.
fn unique(table: &str, names: &[&str], places: &Places<'_>, errors: &mut Vec<Diagnostic>) {
    for (index, name) in names.iter().enumerate() {
        if names[..index].contains(name) {
            let text = format!("{table} `{name}` is declared twice");
            let error = Diagnostic::new(Code::Duplicate, text);
            errors.push(places.mark(error, &[table, &index.to_string(), "name"], "again here"));
        }
    }
}

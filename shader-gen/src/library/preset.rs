//! Named configurations, and defaults by class of input.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sglow_graph::description::Setting;

use super::Library;
use super::check::{is_kebab, is_snake, names};
use super::place::Places;
use super::rule::Condition;
use crate::error::{Code, Diagnostic, Report};

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

    /// Checks presets and defaults by class; not where the frame, which has the parameters, could not be read.
    pub(super) fn check_presets(&self, places: &Places<'_>, errors: &mut Vec<Diagnostic>) {
        if self.library.frame.is_some() && self.frame().is_none() {
            return;
        }
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
            for (name, condition) in &rule.when {
                if let Some(error) = self.check_condition(name, condition) {
                    errors.push(places.mark(error, &["default", &index, "when", name], "here"));
                }
            }
            self.check_settings(&rule.set, &["default", &index, "set"], places, errors);
            for (at, name) in rule.unless.iter().enumerate() {
                if !self.axis.contains_key(name) && self.parameter(name).is_none() {
                    let at = at.to_string();
                    let unknown = self.unknown_setting(name);
                    errors.push(places.mark(unknown, &["default", &index, "unless", &at], "here"));
                }
            }
        }
    }

    /// What is wrong with a condition of a default.
    fn check_condition(&self, name: &str, condition: &Condition) -> Option<Diagnostic> {
        let Condition::Values(values) = condition else {
            let known = || self.fact.iter().map(|fact| fact.name.as_str());
            return (!known().any(|known| known == name))
                .then(|| Diagnostic::unknown("fact", name, known()));
        };
        let Some(axis) = self.axis.get(name) else {
            return Some(Diagnostic::unknown("axis", name, self.axis.keys().map(String::as_str)));
        };
        let known = || axis.value.iter().map(|value| value.name.as_str());
        let unknown = values.iter().find(|value| !known().any(|known| known == **value))?;
        Some(Diagnostic::unknown(&format!("value of axis `{name}`"), unknown, known()))
    }

    /// An error about a name that is neither an axis nor a parameter.
    fn unknown_setting(&self, name: &str) -> Diagnostic {
        let axes = self.axis.keys().map(String::as_str);
        let parameters = self.parameters().map(|(name, _)| name.as_str());
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
            let error = match (self.axis.get(name), self.parameter(name), setting) {
                (Some(axis), ..) => {
                    let value = setting.to_string();
                    if axis.value.iter().any(|known| known.name == value) {
                        continue;
                    }
                    let known = axis.value.iter().map(|value| value.name.as_str());
                    Diagnostic::unknown(&format!("value of axis `{name}`"), &value, known)
                }
                (None, None, _) => self.unknown_setting(name),
                (None, Some(parameter), Setting::Number(number)) if parameter.allows(*number) => {
                    continue;
                }
                (None, Some(parameter), _) => {
                    let range = parameter.range();
                    let text = format!("parameter `{name}` is {setting}; expected {range}");
                    Diagnostic::new(Code::Declaration, text)
                }
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

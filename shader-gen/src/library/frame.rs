//! Reading the frame of a library, and what is wrong with it in itself.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde_json::Value;
use sglow_graph::description::{self as flat, Axis, Number, Parameter, ParameterType, Preset};
use sglow_graph::error::Kind;
use sglow_graph::{Configuration, Description, Formula};

use super::check::is_snake;
use super::document::Read;
use super::place::Places;
use super::rule::Condition;
use super::{Exclusion, Library};
use crate::error::{Code, Diagnostic};
use crate::frame::authored::{Authored, Template};
use crate::frame::distinct::distinct;
use crate::frame::{Expanded, Faults, Origin, expand, formula};
use crate::source::{Sources, find, read, relative};

/// The frame of a library, with the files that describe it.
#[derive(Clone, Debug)]
pub struct Frame {
    /// What the files say.
    pub authored: Authored,
    /// The same without templates, with the axes, passes and facts of the library.
    pub description: Description,
    /// Indices in [`Library::sources`] of the file and of those that are laid over it.
    pub files: Vec<usize>,
    expanded: Expanded,
    /// What the library declares beside it.
    library: Description,
    exclusions: Vec<Exclusion>,
}

/// So many configurations are all tried.
const ALL: usize = 1 << 10;

/// The maximum number of kinds of draws in a list of the host, legal or not.
const KINDS: usize = 1 << 12;

impl Library {
    /// Reads the frame that the header names, with those of what is laid over the library.
    pub(super) fn read_frame(
        &mut self,
        root: &Path,
        places: &Places<'_>,
        headers: &[Places<'_>],
        sources: &mut Sources,
        errors: &mut Vec<Diagnostic>,
    ) {
        let own = self
            .library
            .frame
            .as_ref()
            .map(|name| (relative(root, &root.join(name)), find(root, name), places));
        let over = self.overlays.iter().zip(headers).filter_map(|(overlay, header)| {
            let (root, name) = (&overlay.root, overlay.frame.as_ref()?);
            Some((overlay.shown(&root.join(name)), find(root, name), header))
        });
        let mut texts = Vec::new();
        for (shown, path, places) in own.into_iter().chain(over) {
            match path.and_then(|path| read(&path)) {
                Ok(text) => texts.push((sources.add(shown, text.as_str()), text)),
                Err(error) => {
                    let error = Diagnostic::new(Code::Read, format!("{shown}: {error}"));
                    errors.push(places.mark(error, &["library", "frame"], "read from here"));
                }
            }
        }
        if texts.is_empty() {
            return;
        }
        let files: Vec<_> = texts.iter().map(|(file, text)| (*file, text.as_str())).collect();
        let laid = Read::new(&files).and_then(Read::laid);
        let parsed = laid.and_then(|laid| laid.parsed().map_err(|error| vec![error]));
        let authored: Authored = match parsed {
            Ok(authored) => authored,
            Err(found) => return errors.extend(found),
        };
        let files = texts.iter().map(|(file, _)| *file).collect();
        let library = self.declared();
        let expanded = expand(&authored, library.clone());
        let description = expanded.description.clone();
        let exclusions = self.exclusion.clone();
        self.frame = Some(Frame { authored, description, files, expanded, library, exclusions });
    }

    /// What a description has that the library declares beside its frame.
    fn declared(&self) -> Description {
        let mut description = Description::default();
        for (name, axis) in &self.axis {
            let values = axis.value.iter().map(|value| value.name.clone()).collect();
            let (default, implied) = (axis.default.clone(), axis.implied);
            let axis = Axis { default, values, implied };
            description.axes.insert(name.clone(), axis);
        }
        let passes = self.pass.iter().map(|pass| (pass.name.clone(), pass.axes.clone()));
        description.passes.extend(passes);
        description.facts.extend(self.fact.iter().map(|fact| fact.name.clone()));
        let preset = |of: &super::Preset| {
            let (description, set) = (of.description.clone(), of.set.clone());
            (of.name.clone(), Preset { description, set })
        };
        description.preset.extend(self.preset.iter().map(preset));
        let defaults = self.class_default.iter().map(|rule| flat::ClassDefault {
            name: rule.name.clone(),
            when: all(rule.when.iter().map(|(name, condition)| match condition {
                Condition::Fact(true) => formula::name(name),
                Condition::Fact(false) => formula::apply("!", [formula::name(name)]),
                Condition::Values(values) => either(name, values),
            })),
            set: rule.set.clone(),
            unless: rule.unless.clone(),
            reason: rule.reason.clone(),
        });
        description.default.extend(defaults);
        let exclusions = self.exclusion.iter().map(|rule| flat::Exclusion {
            name: rule.name.clone(),
            passes: rule.of_passes(&self.pass).map(|pass| pass.name.clone()).collect(),
            when: all(rule.when.iter().map(|(axis, values)| either(axis, values)))
                .unwrap_or(Formula::Number(1)),
            reason: rule.reason.clone(),
        });
        // What excludes no pass would exclude every configuration.
        let exclusions = exclusions.filter(|rule| !rule.passes.is_empty());
        description.exclusion.extend(exclusions);
        description
    }

    /// Whether the frame can be evaluated; only of a library with which nothing else is wrong, or errors would follow from
    /// errors.
    pub(super) fn check_frame(&self, sources: &Sources, errors: &mut Vec<Diagnostic>) {
        if let Some(frame) = self.frame.as_ref().filter(|_| errors.is_empty()) {
            let places = frame.places(sources);
            for (name, parameter) in &frame.description.parameter {
                if !parameter.allows(parameter.default) {
                    let (value, range) = (parameter.default.real(), parameter.range());
                    let text = format!("the default of `{name}` is {value}; expected {range}");
                    let error = Diagnostic::new(Code::Declaration, text);
                    errors.push(places.mark(error, &["parameter", name, "default"], "here"));
                }
                let (code, text) = if self.axis.contains_key(name) {
                    (Code::Duplicate, format!("`{name}` is an axis and a parameter"))
                } else if !is_snake(name) {
                    (Code::Name, format!("`{name}` is no name for a parameter: snake case"))
                } else {
                    continue;
                };
                let error = Diagnostic::new(code, text);
                errors.push(places.mark(error, &["parameter", name], "here"));
            }
            for (name, list) in &frame.description.draws {
                let values = |axis| self.axis.get(axis).map_or(1, |axis| axis.value.len());
                if list.axes.iter().map(values).fold(1, usize::saturating_mul) > KINDS {
                    let text = format!("the list `{name}` has more than {KINDS} kinds of draws");
                    let error = Diagnostic::new(Code::Declaration, text);
                    errors.push(places.mark(error, &["draws", name, "axes"], "here"));
                    return;
                }
            }
            errors.extend(frame.faults(&places, 1));
        }
    }

    /// The numbers that a person or an engine sets: those of the frame.
    pub fn parameters(&self) -> impl Iterator<Item = (&String, &Parameter)> {
        self.frame.iter().flat_map(|frame| &frame.description.parameter)
    }

    /// The parameter called `name`.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.frame.as_ref()?.description.parameter.get(name)
    }

    /// The frame, if the library describes one.
    #[must_use]
    pub fn frame(&self) -> Option<&Frame> {
        self.frame.as_ref()
    }
}

impl Frame {
    /// Where everything stands that it says.
    pub(crate) fn places<'a>(&self, sources: &'a Sources) -> Places<'a> {
        let files = self.files.iter().map(|&file| (file, sources.text(file)));
        Places::of(&files.collect::<Vec<_>>())
    }

    /// What is wrong with it in the configurations of [`Self::configurations`], at the defaults of its parameters, at
    /// their minima, and with one for every zero.
    pub(crate) fn faults(&self, places: &Places<'_>, differences: usize) -> Vec<Diagnostic> {
        let description = &self.description;
        let least = |parameter: &Parameter| match parameter.kind {
            ParameterType::Real => None,
            ParameterType::Whole => parameter.minimum.map(|minimum| Number::Whole(minimum as u64)),
        };
        let minima = description.parameter.iter();
        let minima: BTreeMap<_, _> =
            minima.filter_map(|(name, of)| Some((name.clone(), least(of)?))).collect();
        // So that what depends on something that is not there by default is seen, too.
        let zeros = description.parameter.iter().filter(|(_, of)| of.default == Number::Whole(0));
        let ones: BTreeMap<_, _> =
            zeros.map(|(name, _)| (name.clone(), Number::Whole(1))).collect();
        let mut found = BTreeMap::new();
        let all = self.configurations(differences);
        for parameters in [BTreeMap::new(), minima, ones] {
            let with = |one: &Configuration| Configuration {
                parameters: parameters.clone(),
                ..one.clone()
            };
            let all: Vec<_> = all.iter().map(with).collect();
            distinct(description, &all, |configuration, frame| {
                // What is no legal configuration says nothing about the frame.
                let errors = frame.err().filter(|errors| !errors.is_illegal());
                for error in errors.into_iter().flat_map(|errors| errors.0) {
                    found.entry(error).or_insert_with(|| configuration.axes.clone());
                }
            });
        }
        let whole = serde_json::to_value(description).unwrap_or_default();
        let diagnostic = |(error, axes): (sglow_graph::Error, BTreeMap<String, String>)| {
            let diagnostic = Diagnostic::new(code(error.kind == Kind::Unknown), error.text.clone());
            let origin = self.origin(&within(&whole, &error));
            let diagnostic = self.mark(places, diagnostic, &origin);
            let other = |(axis, value): &(&String, &String)| {
                description.axes.get(*axis).is_some_and(|axis| axis.default != **value)
            };
            let axes = axes.iter().filter(other).map(|(axis, value)| format!("{axis}={value}"));
            match axes.collect::<Vec<_>>() {
                axes if axes.is_empty() => diagnostic,
                axes => diagnostic.help(format!("in the configuration {}", axes.join(","))),
            }
        };
        let everywhere = self.expanded.faults.iter().map(|fault| {
            let diagnostic = Diagnostic::new(code(fault.unknown), fault.text.clone());
            self.mark(places, diagnostic, &fault.origin)
        });
        everywhere.chain(found.into_iter().map(diagnostic)).collect()
    }

    /// Where something was written that a description has at a place.
    pub(crate) fn origin(&self, place: &[String]) -> Origin {
        let known = |length: usize| {
            let origin = self.expanded.origins.get(&place[..length])?;
            let rest: Vec<&str> = place[length..].iter().map(String::as_str).collect();
            Some(origin.at(&rest))
        };
        let place = || Origin { path: place.to_vec(), used: None };
        (0..=place().path.len()).rev().find_map(known).unwrap_or_else(place)
    }

    /// Adds to a diagnostic where something was written.
    pub(crate) fn mark(
        &self,
        places: &Places<'_>,
        mut diagnostic: Diagnostic,
        origin: &Origin,
    ) -> Diagnostic {
        for (place, label) in [(Some(&origin.path), "here"), (origin.used.as_ref(), "in this use")]
        {
            let path: Vec<&str> = place.into_iter().flatten().map(String::as_str).collect();
            if !path.is_empty() {
                diagnostic = places.mark(diagnostic, &path, label);
            }
        }
        diagnostic
    }

    /// The description of another frame over the library's templates: its template `frame`.
    ///
    /// # Errors
    ///
    /// What is wrong with it whatever the configuration.
    pub fn other(&self, frame: Template) -> Result<Description, Faults> {
        let mut authored = self.authored.clone();
        authored.template.insert("frame".to_owned(), frame);
        authored.description(self.library.clone())
    }

    /// The configurations that conditions tell apart: on each axis the values that they name, and one that they do not; with
    /// all facts that formulas name either way, and each kind of the host's draws. If there are many, those alone that
    /// differ from the default on so many axes at most. Illegal ones are among them.
    #[must_use]
    pub fn configurations(&self, differences: usize) -> Vec<Configuration> {
        let (mut named, mut words) = (BTreeMap::new(), BTreeSet::new());
        let value = serde_json::to_value(&self.description).unwrap_or_default();
        collect(&value, &mut named, &mut words);
        let axes = &self.description.axes;
        let choices: Vec<(&str, Vec<&str>)> = named
            .iter()
            .filter_map(|(axis, named)| Some((axis.as_str(), axes.get(axis)?, named)))
            .map(|(name, axis, named)| {
                let other = axis.values.iter().find(|value| !named.contains(*value));
                let values = axis.values.iter().filter(|value| named.contains(*value));
                let mut values: Vec<_> = values.chain(other).map(String::as_str).collect();
                values.sort_by_key(|value| *value != axis.default);
                (name, values)
            })
            .collect();
        let facts: Vec<_> =
            self.description.facts.iter().filter(|fact| words.contains(*fact)).collect();
        let count = choices.iter().map(|(_, values)| values.len()).product::<usize>();
        let at_most = if count <= ALL { choices.len() } else { differences };
        let mut all = vec![(Configuration { draws: self.draws(), ..Default::default() }, 0)];
        for (axis, values) in choices {
            for index in 0..all.len() {
                let (base, differences) = all[index].clone();
                for (number, value) in values.iter().enumerate() {
                    if number > 0 && differences == at_most {
                        break;
                    }
                    let mut with = base.clone();
                    with.axes.insert(axis.to_owned(), (*value).to_owned());
                    match number {
                        0 => all[index] = (with, differences),
                        _ => all.push((with, differences + 1)),
                    }
                }
            }
        }
        let all = all.into_iter().map(|(configuration, _)| configuration);
        let either = if facts.is_empty() { &[false][..] } else { &[false, true] };
        all.flat_map(|configuration| {
            let facts = &facts;
            either.iter().map(move |holds| {
                let facts = facts.iter().map(|fact| ((*fact).clone(), *holds));
                Configuration { facts: facts.collect(), ..configuration.clone() }
            })
        })
        .collect()
    }

    /// Every legal kind of each list of the host's draws.
    fn draws(&self) -> BTreeMap<String, BTreeSet<BTreeMap<String, String>>> {
        let kinds = |axes: &[String]| {
            let mut kinds = vec![BTreeMap::new()];
            for axis in axes {
                let values = self.description.axes.get(axis).map_or(&[][..], |axis| &axis.values);
                let with = |kind: &BTreeMap<String, String>, value: &String| {
                    let mut kind = kind.clone();
                    kind.insert(axis.clone(), value.clone());
                    kind
                };
                let each = |kind| values.iter().map(move |value| with(&kind, value));
                kinds = kinds.into_iter().flat_map(each).collect();
            }
            let excluded = |kind: &BTreeMap<String, String>| {
                let value = |axis: &str| kind.get(axis).map(String::as_str);
                self.exclusions.iter().any(|rule| rule.excludes("", value))
            };
            kinds.into_iter().filter(|kind| !excluded(kind)).collect()
        };
        let lists = self.description.draws.iter();
        lists.map(|(name, list)| (name.clone(), kinds(&list.axes))).collect()
    }
}

fn code(unknown: bool) -> Code {
    if unknown { Code::Unknown } else { Code::Declaration }
}

/// That an axis has one of these values.
fn either(axis: &str, values: &[String]) -> Formula {
    let either = values.iter().map(|value| formula::is(axis, value));
    let either = either.reduce(|a, b| formula::apply("||", [a, b]));
    either.unwrap_or(Formula::Number(0))
}

/// A formula that holds if all do; nothing if there is none.
fn all(formulas: impl Iterator<Item = Formula>) -> Option<Formula> {
    formulas.reduce(|a, b| formula::apply("&&", [a, b]))
}

/// The place of what is wrong in an entry: of the formula, or of the name that the text begins with.
fn within(description: &Value, error: &sglow_graph::Error) -> Vec<String> {
    fn path(value: &Value, of: &impl Fn(&Value) -> bool, name: &str) -> Option<Vec<String>> {
        if of(value) {
            return Some(Vec::new());
        }
        let below = |key: String, value: &Value| {
            let found = if key == name { Some(Vec::new()) } else { path(value, of, name) };
            found.map(|rest| [vec![key], rest].concat())
        };
        match value {
            Value::Object(map) => map.iter().find_map(|(key, value)| below(key.clone(), value)),
            Value::Array(list) => {
                list.iter().enumerate().find_map(|(index, value)| below(index.to_string(), value))
            }
            _ => None,
        }
    }
    let place = &error.place;
    let pointer = place.iter().map(|key| format!("/{key}")).collect::<String>();
    let formula = error.formula.as_ref().and_then(|formula| serde_json::to_value(formula).ok());
    let name = error.text.split('`').nth(1).unwrap_or_default();
    let found = description.pointer(&pointer).and_then(|entry| match &formula {
        Some(formula) => path(entry, &|value| value == formula, ""),
        None => path(entry, &|value| value.as_str() == Some(name), name),
    });
    [&place[..], &found.unwrap_or_default()].concat()
}

/// The values of axes that conditions name, and all names in formulas.
fn collect(
    value: &Value,
    named: &mut BTreeMap<String, BTreeSet<String>>,
    words: &mut BTreeSet<String>,
) {
    match value {
        Value::Object(map) => {
            if let Some(Value::Array(is)) = map.get("is")
                && let [Value::String(axis), Value::String(value)] = &is[..]
            {
                named.entry(axis.clone()).or_default().insert(value.clone());
            }
            map.values().for_each(|value| collect(value, named, words));
        }
        Value::Array(list) => list.iter().for_each(|value| collect(value, named, words)),
        Value::String(word) => drop(words.insert(word.clone())),
        _ => {}
    }
}

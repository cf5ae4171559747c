//! What is wrong with a declaration in itself.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::Library;
use super::place::Places;
use crate::error::{Code, Diagnostic};
use crate::validate::{features, is_feature};

/// The maximum number of combinations of values of all passes, legal or not.
const VARIANTS: u64 = 1 << 20;

impl Library {
    pub(super) fn check(&self, places: &Places<'_>, errors: &mut Vec<Diagnostic>) {
        let prefix = &self.library.prefix;
        if !prefix.ends_with('_') || !is_snake(prefix) {
            errors.push(
                places.mark(
                    Diagnostic::new(Code::Name, format!("`{prefix}` is no prefix"))
                        .help("a prefix is in snake case and ends with `_`, as in `abc_`"),
                    &["library", "prefix"],
                    "here",
                ),
            );
        }
        let names_of_files = [
            ("a library", "library", &self.library.name),
            ("a package", "package", &self.package.name),
        ];
        for (kind, table, name) in names_of_files {
            if !is_file(name) {
                let error = Diagnostic::new(Code::Name, format!("`{name}` is no name for {kind}"))
                    .help("names of this kind are those of files: letters, digits, `-` and `_`");
                errors.push(places.mark(error, &[table, "name"], "here"));
            }
        }
        let mut list = |kind: &str,
                        table: &[&str],
                        names: Vec<&str>,
                        is_name: fn(&str) -> bool,
                        form: &str| {
            for (index, name) in names.iter().enumerate() {
                let number = index.to_string();
                let path = [table, &[&number, "name"]].concat();
                if !is_name(name) {
                    let error =
                        Diagnostic::new(Code::Name, format!("`{name}` is no name for {kind}"))
                            .help(format!("names of this kind are in {form}"));
                    errors.push(places.mark(error, &path, "here"));
                }
                if let Some(first) = names[..index].iter().position(|other| other == name) {
                    let number = first.to_string();
                    let error = Diagnostic::new(
                        Code::Duplicate,
                        format!("{kind} `{name}` is declared twice"),
                    );
                    let error = places.mark(error, &path, "again here");
                    errors.push(places.mark(
                        error,
                        &[table, &[&number, "name"]].concat(),
                        "first here",
                    ));
                }
            }
        };
        let snake = "snake case";
        let kebab = "kebab case";
        let lower = "snake case, a digit may come first";
        list("a pass", &["pass"], names(&self.pass, |pass| &pass.name), is_snake, snake);
        list("a fact", &["fact"], names(&self.fact, |fact| &fact.name), is_snake, snake);
        list(
            "an exclusion",
            &["exclusion"],
            names(&self.exclusion, |rule| &rule.name),
            is_kebab,
            kebab,
        );
        list("a need", &["need"], names(&self.need, |rule| &rule.name), is_kebab, kebab);
        list(
            "a presence rule",
            &["presence"],
            names(&self.presence, |rule| &rule.name),
            is_kebab,
            kebab,
        );
        list(
            "a function library",
            &["package", "lib"],
            names(&self.package.lib, |lib| &lib.name),
            is_snake,
            snake,
        );
        for (name, axis) in &self.axis {
            let table = ["axis", name, "value"];
            list("a value", &table, names(&axis.value, |value| &value.name), is_value, lower);
        }
        for (index, pass) in self.pass.iter().enumerate() {
            let number = index.to_string();
            let table = ["pass", &number, "override"];
            list("an override", &table, names(&pass.overrides, |item| &item.name), is_snake, snake);
        }
        self.check_axes(places, errors);
        self.check_passes(places, errors);
        self.check_rules(places, errors);
        self.check_presence(places, errors);
        self.check_presets(places, errors);
        for (index, select) in self.package.select.iter().enumerate() {
            let number = index.to_string();
            let path = ["package", "select", &number];
            let axes =
                self.check_pass(&select.pass, &[&path[..], &["pass"]].concat(), places, errors);
            let path = [&path[..], &["axes"]].concat();
            self.check_values(&select.axes, axes, &path, places, errors);
        }
    }

    /// Whether the space of variants is small enough to enumerate.
    pub(super) fn is_bounded(&self, places: &Places<'_>, errors: &mut Vec<Diagnostic>) -> bool {
        let mut total = 0_u64;
        for (index, pass) in self.pass.iter().enumerate() {
            let values = |axis: &String| self.axis.get(axis).map_or(1, |axis| axis.value.len());
            let counts = pass.axes.iter().map(|axis| values(axis) as u64);
            total = total.saturating_add(counts.fold(1, u64::saturating_mul));
            if total > VARIANTS {
                let text = format!(
                    "the passes up to `{}` have more than {VARIANTS} combinations of values",
                    pass.name
                );
                let error = Diagnostic::new(Code::Declaration, text);
                let path = ["pass", &index.to_string(), "axes"];
                errors.push(places.mark(error, &path, "here"));
                return false;
            }
        }
        true
    }

    fn check_axes(&self, places: &Places<'_>, errors: &mut Vec<Diagnostic>) {
        for (name, axis) in &self.axis {
            if !is_snake(name) {
                let error = Diagnostic::new(Code::Name, format!("`{name}` is no name for an axis"));
                errors.push(places.mark(
                    error.help("names of this kind are in snake case"),
                    &["axis", name],
                    "here",
                ));
            }
            if !axis.value.iter().any(|value| value.name == axis.default) {
                let known = axis.value.iter().map(|value| value.name.as_str());
                let error =
                    Diagnostic::unknown(&format!("value of axis `{name}`"), &axis.default, known);
                errors.push(places.mark(
                    error,
                    &["axis", name, "default"],
                    "not one of its values",
                ));
            }
            for (index, value) in axis.value.iter().enumerate() {
                let index = index.to_string();
                for (number, flag) in value.flags.iter().enumerate() {
                    if !is_snake(flag) || matches!(flag.as_str(), "true" | "false") {
                        let error =
                            Diagnostic::new(Code::Name, format!("`{flag}` is no name for a flag"))
                                .help("names of this kind are in snake case");
                        let path = ["axis", name, "value", &index, "flags", &number.to_string()];
                        errors.push(places.mark(error, &path, "here"));
                    }
                }
                for (number, feature) in value.requires.iter().enumerate() {
                    if !is_feature(feature) {
                        let error = Diagnostic::unknown("WebGPU feature", feature, features());
                        let path = ["axis", name, "value", &index, "requires", &number.to_string()];
                        errors.push(places.mark(error, &path, "here"));
                    }
                }
            }
        }
    }

    fn check_passes(&self, places: &Places<'_>, errors: &mut Vec<Diagnostic>) {
        for (index, pass) in self.pass.iter().enumerate() {
            let index = index.to_string();
            if pass.name == self.library.name {
                let error = Diagnostic::new(
                    Code::Duplicate,
                    format!("pass `{}` has the name of the library", pass.name),
                );
                let error = error.help("a file of that name has the library's functions");
                errors.push(places.mark(error, &["pass", &index, "name"], "here"));
            }
            for (number, axis) in pass.axes.iter().enumerate() {
                let path = ["pass", &index, "axes", &number.to_string()];
                if !self.axis.contains_key(axis) {
                    let error =
                        Diagnostic::unknown("axis", axis, self.axis.keys().map(String::as_str));
                    errors.push(places.mark(error, &path, "here"));
                }
                let implied = |axis: &String| self.axis.get(axis).filter(|axis| axis.implied);
                if let Some(own) = implied(axis) {
                    let later = &pass.axes[number + 1..];
                    if let Some(other) = later.iter().find(|other| implied(other).is_none()) {
                        let error = Diagnostic::new(
                            Code::Declaration,
                            format!(
                                "axis `{axis}` is implied and stands before `{other}` in pass `{}`",
                                pass.name
                            ),
                        );
                        let error = error.help(
                            "identifiers leave its default out, so that only axes that are implied may follow it",
                        );
                        errors.push(places.mark(error, &path, "put it last"));
                    }
                    for other in later {
                        let values = implied(other).map_or(&[][..], |axis| &axis.value);
                        let shared = values
                            .iter()
                            .find(|value| own.value.iter().any(|of_own| of_own.name == value.name));
                        if let Some(shared) = shared {
                            let error = Diagnostic::new(
                                Code::Declaration,
                                format!(
                                    "axes `{axis}` and `{other}` of pass `{}` are implied and both have the value `{}`",
                                    pass.name, shared.name
                                ),
                            );
                            let error = error.help(
                                "identifiers leave their defaults out, so that their values need names of their own",
                            );
                            errors.push(places.mark(error, &path, "this one"));
                        }
                    }
                }
                if pass.axes[..number].contains(axis) {
                    let error =
                        Diagnostic::new(Code::Duplicate, format!("axis `{axis}` is named twice"));
                    errors.push(places.mark(error, &path, "again here"));
                }
            }
            if pass.entry_points.is_empty() {
                let error = Diagnostic::new(
                    Code::Declaration,
                    format!("pass `{}` has no entry point", pass.name),
                );
                errors.push(places.mark(
                    error,
                    &["pass", &index, "entry_points"],
                    "name at least one",
                ));
            }
            for (number, line) in pass.contract.iter().enumerate() {
                let path = ["pass", &index, "contract", &number.to_string(), "when"];
                self.check_values(&line.when, Some(&pass.axes), &path, places, errors);
            }
            for (number, item) in pass.overrides.iter().enumerate() {
                // A bound that is not a number makes an empty range, too.
                if item.minimum.partial_cmp(&item.maximum).is_none_or(Ordering::is_gt) {
                    let error = Diagnostic::new(
                        Code::Declaration,
                        format!("override `{}` has an empty range", item.name),
                    );
                    let path = ["pass", &index, "override", &number.to_string(), "minimum"];
                    errors.push(places.mark(error, &path, "above its maximum"));
                }
            }
        }
    }

    fn check_rules(&self, places: &Places<'_>, errors: &mut Vec<Diagnostic>) {
        for (index, rule) in self.exclusion.iter().enumerate() {
            let index = index.to_string();
            let axes = rule.pass.as_ref().and_then(|pass| {
                self.check_pass(pass, &["exclusion", &index, "pass"], places, errors)
            });
            self.check_values(&rule.when, axes, &["exclusion", &index, "when"], places, errors);
        }
        for (index, rule) in self.need.iter().enumerate() {
            let index = index.to_string();
            for fact in rule.when.keys() {
                if !self.fact.iter().any(|known| known.name == *fact) {
                    let known = self.fact.iter().map(|fact| fact.name.as_str());
                    let error = Diagnostic::unknown("fact", fact, known);
                    errors.push(places.mark(error, &["need", &index, "when", fact], "here"));
                }
            }
            self.check_values(&rule.set, None, &["need", &index, "set"], places, errors);
        }
    }

    fn check_presence(&self, places: &Places<'_>, errors: &mut Vec<Diagnostic>) {
        for (index, rule) in self.presence.iter().enumerate() {
            let index = index.to_string();
            let path = ["presence", &index];
            let empty = |what: &str| {
                Diagnostic::new(Code::Declaration, format!("rule `{}` {what}", rule.name))
            };
            if rule.passes.is_empty() {
                let path = [&path[..], &["passes"]].concat();
                errors.push(places.mark(empty("holds for no pass"), &path, "name at least one"));
            }
            for (number, pass) in rule.passes.iter().enumerate() {
                let number = number.to_string();
                let path = [&path[..], &["passes", &number]].concat();
                let known = self.check_pass(pass, &path, places, errors).is_some();
                if known {
                    let axes = self.find_pass(pass).map(|pass| pass.axes.as_slice());
                    self.check_values(
                        &rule.when,
                        axes,
                        &["presence", &index, "when"],
                        places,
                        errors,
                    );
                }
            }
            if rule.only_with.is_empty() || rule.only_with.iter().any(BTreeMap::is_empty) {
                let path = [&path[..], &["only_with"]].concat();
                let error = empty("leaves nothing out")
                    .help("each of its alternatives names an axis and values of it");
                errors.push(places.mark(error, &path, "here"));
            }
            for (number, values) in rule.only_with.iter().enumerate() {
                let number = number.to_string();
                let path = [&path[..], &["only_with", &number]].concat();
                self.check_values(values, None, &path, places, errors);
            }
        }
    }

    /// Checks a pass's name and returns its axes.
    fn check_pass(
        &self,
        name: &str,
        path: &[&str],
        places: &Places<'_>,
        errors: &mut Vec<Diagnostic>,
    ) -> Option<&[String]> {
        let pass = self.find_pass(name);
        if pass.is_none() {
            let error =
                Diagnostic::unknown("pass", name, self.pass.iter().map(|pass| pass.name.as_str()));
            errors.push(places.mark(error, path, "here"));
        }
        pass.map(|pass| pass.axes.as_slice())
    }

    /// Checks names of axes and of their values; with `axes` given, only those are allowed.
    fn check_values(
        &self,
        values: &BTreeMap<String, Vec<String>>,
        axes: Option<&[String]>,
        path: &[&str],
        places: &Places<'_>,
        errors: &mut Vec<Diagnostic>,
    ) {
        for (axis, values) in values {
            let declared =
                self.axis.get(axis).filter(|_| axes.is_none_or(|axes| axes.contains(axis)));
            let path = [path, &[axis.as_str()]].concat();
            let Some(declared) = declared else {
                let error = match axes {
                    Some(axes) => Diagnostic::unknown(
                        "axis of this pass",
                        axis,
                        axes.iter().map(String::as_str),
                    ),
                    None => Diagnostic::unknown("axis", axis, self.axis.keys().map(String::as_str)),
                };
                errors.push(places.mark(error, &path, "here"));
                continue;
            };
            for (index, value) in values.iter().enumerate() {
                if !declared.value.iter().any(|known| known.name == *value) {
                    let known = declared.value.iter().map(|value| value.name.as_str());
                    let error =
                        Diagnostic::unknown(&format!("value of axis `{axis}`"), value, known);
                    errors.push(places.mark(
                        error,
                        &[&path[..], &[&index.to_string()]].concat(),
                        "here",
                    ));
                }
            }
        }
    }
}

pub(super) fn names<T>(items: &[T], name: impl Fn(&T) -> &String) -> Vec<&str> {
    items.iter().map(|item| name(item).as_str()).collect()
}

pub(super) fn is_snake(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

fn is_value(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_digit()) && is_snake(&format!("n{name}"))
        || is_snake(name)
}

/// Whether a file or a folder may be called so, on every system.
fn is_file(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    (1..=64).contains(&name.len()) && name.chars().all(plain)
}

pub(super) fn is_kebab(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
}

//! `library.toml`: what a library offers, in the author's own words.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;
use toml::de::{DeTable, DeValue};

use crate::error::{Code, Diagnostic, Report};
use crate::link::Graph;
use crate::parse::{Kind, Module, parse};
use crate::source::{Sources, modules_below, relative};

/// A library of shaders as its `library.toml` declares it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Library {
    /// Name, version and rules of the whole.
    pub library: Header,
    /// Works that comments and descriptions refer to.
    #[serde(default)]
    pub citation: Vec<Citation>,
    /// Facts of a user's input that [`Need`]s may depend on.
    #[serde(default)]
    pub fact: Vec<Fact>,
    /// Choices that passes offer, by name.
    #[serde(default)]
    pub axis: BTreeMap<String, Axis>,
    /// Passes, in the order in which they run.
    #[serde(default)]
    pub pass: Vec<Pass>,
    /// Combinations of values that are illegal.
    #[serde(default)]
    pub exclusion: Vec<Exclusion>,
    /// What facts require of axes.
    #[serde(default)]
    pub need: Vec<Need>,
    /// The committed selection.
    pub package: PackageSelection,
    #[serde(skip)]
    sources: Arc<Sources>,
    #[serde(skip)]
    graph: Arc<Graph>,
}

/// The `[library]` table.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    /// Name of the library.
    pub name: String,
    /// Version of the library, as in `1.2.3`.
    pub version: String,
    /// One sentence.
    pub description: String,
    /// SPDX licence expression.
    pub license: String,
    /// What every name at module scope starts with, in snake case with its underscore: `abc_`. Types start with the
    /// same in camel case (`Abc`), constants in capitals (`ABC_`).
    pub prefix: String,
    /// Folder of the sources, relative to `library.toml`.
    pub source: String,
}

/// A work that the sources cite.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Citation {
    /// How the sources call it, as in `[Key, Eq. (1)]`.
    pub key: String,
    /// The full reference.
    pub text: String,
}

/// Something that is true or false of a user's input.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fact {
    /// Name of the fact.
    pub name: String,
    /// What it means that the fact holds.
    pub description: String,
}

/// A typed choice.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// What is chosen.
    pub description: String,
    /// Name of the value that is taken when none is given.
    pub default: String,
    /// The values, in the author's order.
    pub value: Vec<AxisValue>,
}

/// One value of an [`Axis`].
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisValue {
    /// Name of the value.
    pub name: String,
    /// What choosing it means.
    pub description: String,
    /// Flags that hold in the sources when it is chosen.
    #[serde(default)]
    pub flags: Vec<String>,
    /// WebGPU features that a device must have.
    #[serde(default)]
    pub requires: Vec<String>,
}

/// One or more entry points with their bindings.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pass {
    /// Name of the pass.
    pub name: String,
    /// What it does.
    pub description: String,
    /// The module that holds its entry points, relative to [`Header::source`].
    pub source: String,
    /// Names of its entry points.
    pub entry_points: Vec<String>,
    /// Names of its axes; their order is the order of values in a variant's identifier.
    #[serde(default)]
    pub axes: Vec<String>,
    /// Units and ranges of its inputs, one `name: text` each.
    #[serde(default)]
    pub contract: Vec<String>,
    /// Numbers that may be set when a pipeline is made.
    #[serde(default, rename = "override")]
    pub overrides: Vec<Override>,
}

/// A number that may be set when a pipeline is made.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Override {
    /// Its name in the sources.
    pub name: String,
    /// What it is, with its unit.
    pub description: String,
    /// Least value allowed.
    pub minimum: f64,
    /// Greatest value allowed.
    pub maximum: f64,
}

/// A named rule that takes combinations out of the space.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exclusion {
    /// Name of the rule.
    pub name: String,
    /// The pass it holds for; every pass that has all axes of [`Exclusion::when`] if absent.
    pub pass: Option<String>,
    /// Per axis the values that are illegal together.
    pub when: BTreeMap<String, Vec<String>>,
    /// Why.
    pub reason: String,
}

/// A named rule that narrows axes by facts.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Need {
    /// Name of the rule, given as the reason for what it does.
    pub name: String,
    /// Facts and what they must be for the rule to hold.
    pub when: BTreeMap<String, bool>,
    /// Per axis the values that remain allowed.
    pub set: BTreeMap<String, Vec<String>>,
    /// Why.
    pub reason: String,
}

/// The `[package]` table: what is committed of the space.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PackageSelection {
    /// Name of the package.
    pub name: String,
    /// Slices of the space; their union is selected.
    #[serde(default)]
    pub select: Vec<Select>,
    /// Files of functions for hosts that bring their own passes.
    #[serde(default)]
    pub lib: Vec<FunctionLibrary>,
}

/// A slice of the space.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Select {
    /// Name of the pass.
    pub pass: String,
    /// Values per axis; an axis that is not named takes every value.
    #[serde(default)]
    pub axes: BTreeMap<String, Vec<String>>,
}

/// A file of functions without bindings or entry points.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FunctionLibrary {
    /// Stem of the file.
    pub name: String,
    /// Modules whose declarations it offers, relative to [`Header::source`].
    pub modules: Vec<String>,
}

/// Index of `library.toml` in [`Sources`].
const DECLARATION: usize = 0;

impl Library {
    /// Reads `library.toml` at `path` (or in the folder `path`) and every `.wesl` file below its source folder.
    ///
    /// # Errors
    ///
    /// Everything that is wrong with the declaration and with the files as such; what only a variant can show is left
    /// to [`crate::generate`].
    pub fn load(path: &Path) -> Result<Self, Report> {
        let path = if path.is_dir() { path.join("library.toml") } else { path.to_owned() };
        let root = path.parent().unwrap_or(Path::new("")).to_owned();
        let mut sources = Sources::default();
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) => {
                let diagnostic =
                    Diagnostic::new(Code::Read, format!("{}: {error}", path.display()));
                return Err(Report::new(vec![diagnostic], Arc::new(sources)));
            }
        };
        sources.add(relative(&root, &path), text.as_str());
        Self::from_parts(&text, &root, sources)
    }

    fn from_parts(text: &str, root: &Path, mut sources: Sources) -> Result<Self, Report> {
        let mut library: Self = match toml::from_str(text) {
            Ok(library) => library,
            Err(error) => {
                let mut diagnostic = Diagnostic::new(Code::Declaration, error.message());
                if let Some(range) = error.span() {
                    diagnostic = diagnostic.at(DECLARATION, range, "here");
                }
                return Err(Report::new(vec![diagnostic], Arc::new(sources)));
            }
        };
        let mut errors = Vec::new();
        let places = Places::new(text);
        library.check(&places, &mut errors);
        let folder = root.join(&library.library.source);
        let modules = library.read_modules(root, &folder, &places, &mut sources, &mut errors);
        let sources = Arc::new(sources);
        let unread = errors.iter().any(|error| matches!(error.code, Code::Read | Code::Syntax));
        library.check_modules(&modules, &places, &mut errors);
        library.graph = Arc::new(Graph::new(modules, !unread, &mut errors));
        library.check_pass_names(&places, unread, &mut errors);
        library.sources = sources;
        if errors.is_empty() { Ok(library) } else { Err(Report::new(errors, library.sources)) }
    }

    /// The files that were read: `library.toml`, then the modules.
    #[must_use]
    pub fn sources(&self) -> &Arc<Sources> {
        &self.sources
    }

    pub(crate) fn graph(&self) -> &Graph {
        &self.graph
    }

    /// The pass called `name`.
    #[must_use]
    pub fn find_pass(&self, name: &str) -> Option<&Pass> {
        self.pass.iter().find(|pass| pass.name == name)
    }

    /// Every flag that some value sets, sorted.
    #[must_use]
    pub fn flags(&self) -> BTreeSet<&str> {
        let values = self.axis.values().flat_map(|axis| &axis.value);
        values.flat_map(|value| &value.flags).map(String::as_str).collect()
    }

    fn read_modules(
        &self,
        root: &Path,
        folder: &Path,
        places: &Places<'_>,
        sources: &mut Sources,
        errors: &mut Vec<Diagnostic>,
    ) -> Vec<Module> {
        let unreadable = |path: &Path, error: &std::io::Error| {
            places.mark(
                Diagnostic::new(Code::Read, format!("{}: {error}", relative(root, path))),
                &["library", "source"],
                "read from here",
            )
        };
        let files: Vec<PathBuf> = match modules_below(folder) {
            Ok(files) => files,
            Err(error) => {
                errors.push(unreadable(folder, &error));
                return Vec::new();
            }
        };
        let mut modules = Vec::new();
        for file in files {
            match fs::read_to_string(&file) {
                Ok(text) => {
                    let path = relative(folder, &file);
                    let path = path.trim_end_matches(".wesl");
                    let index = sources.add(relative(root, &file), text.as_str());
                    modules.push(parse(index, path, &text, errors));
                }
                Err(error) => errors.push(unreadable(&file, &error)),
            }
        }
        modules
    }

    // ------------------------------------------------------------ what the declaration says of itself

    fn check(&self, places: &Places<'_>, errors: &mut Vec<Diagnostic>) {
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
        for (index, select) in self.package.select.iter().enumerate() {
            let number = index.to_string();
            let path = ["package", "select", &number];
            let axes =
                self.check_pass(&select.pass, &[&path[..], &["pass"]].concat(), places, errors);
            let path = [&path[..], &["axes"]].concat();
            self.check_values(&select.axes, axes, &path, places, errors);
        }
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
                    if !crate::validate::is_feature(feature) {
                        let error = Diagnostic::unknown(
                            "WebGPU feature",
                            feature,
                            crate::validate::features(),
                        );
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
            for (number, axis) in pass.axes.iter().enumerate() {
                let path = ["pass", &index, "axes", &number.to_string()];
                if !self.axis.contains_key(axis) {
                    let error =
                        Diagnostic::unknown("axis", axis, self.axis.keys().map(String::as_str));
                    errors.push(places.mark(error, &path, "here"));
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

    // ------------------------------------------------------------ what the modules hold

    fn check_modules(&self, modules: &[Module], places: &Places<'_>, errors: &mut Vec<Diagnostic>) {
        let flags = self.flags();
        for module in modules {
            let mut check = |condition: &Option<crate::condition::Condition>| {
                if let Some(condition) = condition {
                    condition.flags(&mut |flag, range| {
                        if !flags.contains(flag) {
                            let error = Diagnostic::unknown("flag", flag, flags.iter().copied());
                            let error =
                                error.at(module.file, range.clone(), "no value of an axis sets it");
                            // An `@else` repeats the conditions before it.
                            if !errors.contains(&error) {
                                errors.push(error);
                            }
                        }
                    });
                }
            };
            module.imports.iter().for_each(|import| check(&import.condition));
            let declarations = module.declarations.iter().map(|declaration| &declaration.item);
            for item in module.directives.iter().chain(declarations) {
                check(&item.condition);
                item.edits.iter().for_each(|edit| check(&edit.keep_if));
            }
            for declaration in &module.declarations {
                self.check_name(module.file, declaration, errors);
            }
        }
        let known = || modules.iter().map(|module| module.path.as_str());
        let mut source = |name: &str, path: &[&str]| {
            let found =
                name.strip_suffix(".wesl").is_some_and(|name| known().any(|known| known == name));
            if !found {
                let known: Vec<_> = known().map(|known| format!("{known}.wesl")).collect();
                let error =
                    Diagnostic::unknown("source file", name, known.iter().map(String::as_str));
                errors.push(places.mark(error, path, "here"));
            }
        };
        for (index, pass) in self.pass.iter().enumerate() {
            source(&pass.source, &["pass", &index.to_string(), "source"]);
        }
        for (index, lib) in self.package.lib.iter().enumerate() {
            for (number, module) in lib.modules.iter().enumerate() {
                source(
                    module,
                    &["package", "lib", &index.to_string(), "modules", &number.to_string()],
                );
            }
        }
    }

    fn check_name(
        &self,
        file: usize,
        declaration: &crate::parse::Declaration,
        errors: &mut Vec<Diagnostic>,
    ) {
        let Some((name, range)) = &declaration.name else {
            return;
        };
        let prefix = &self.library.prefix;
        let prefix = match declaration.kind {
            Kind::Struct | Kind::Alias => camel(prefix),
            Kind::Constant => prefix.to_uppercase(),
            _ => prefix.clone(),
        };
        if !name.starts_with(&prefix) || name.len() == prefix.len() {
            let kind = declaration.kind.name();
            errors.push(
                Diagnostic::new(Code::Name, format!("{kind} `{name}` lacks the library's prefix"))
                    .at(file, range.clone(), "declared here")
                    .help(format!(
                        "names are not mangled, so that each {kind} starts with `{prefix}`"
                    )),
            );
        }
    }

    fn check_pass_names(&self, places: &Places<'_>, unread: bool, errors: &mut Vec<Diagnostic>) {
        if unread {
            return;
        }
        for (index, pass) in self.pass.iter().enumerate() {
            let Some(module) = self.graph.module(pass.source.trim_end_matches(".wesl")) else {
                continue;
            };
            let overrides = self.graph.overrides(module);
            for (number, item) in pass.overrides.iter().enumerate() {
                if !overrides.contains(item.name.as_str()) {
                    let kind = format!("override of pass `{}`", pass.name);
                    let error = Diagnostic::unknown(&kind, &item.name, overrides.iter().copied());
                    let path =
                        ["pass", &index.to_string(), "override", &number.to_string(), "name"];
                    errors.push(places.mark(error, &path, "here"));
                }
            }
            for (number, name) in pass.entry_points.iter().enumerate() {
                let known = self.graph.entry_points(module);
                if !known.contains(name.as_str()) {
                    let error = Diagnostic::unknown(
                        &format!("entry point of `{}`", pass.source),
                        name,
                        known,
                    );
                    let path = ["pass", &index.to_string(), "entry_points", &number.to_string()];
                    errors.push(places.mark(error, &path, "here"));
                }
            }
        }
    }
}

fn names<T>(items: &[T], name: impl Fn(&T) -> &String) -> Vec<&str> {
    items.iter().map(|item| name(item).as_str()).collect()
}

fn is_snake(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

fn is_value(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_digit()) && is_snake(&format!("n{name}"))
        || is_snake(name)
}

fn is_kebab(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
}

/// `ab_cd_` as `AbCd`.
fn camel(snake: &str) -> String {
    let capital = |word: &str| {
        let mut letters = word.chars();
        let first = letters.next().map(|c| c.to_ascii_uppercase());
        first.into_iter().chain(letters).collect::<String>()
    };
    snake.split('_').map(capital).collect()
}

/// Where things stand in `library.toml`.
struct Places<'a> {
    root: Option<toml::Spanned<DeValue<'a>>>,
}

impl<'a> Places<'a> {
    fn new(text: &'a str) -> Self {
        let root = DeTable::parse(text).ok().map(|table| {
            let range = table.span();
            toml::Spanned::new(range, DeValue::Table(table.into_inner()))
        });
        Self { root }
    }

    /// Adds the place of `path` to `diagnostic`: the deepest part of it that is there.
    fn mark(&self, diagnostic: Diagnostic, path: &[&str], label: &str) -> Diagnostic {
        let mut range = 0..0;
        let mut value = self.root.as_ref();
        for part in path {
            let Some(found) = value else { break };
            let (place, next) = match found.get_ref() {
                // A table's own range is that of its header or of nothing, and an unknown key is itself at fault.
                DeValue::Table(table) => {
                    match table.iter().find(|(key, _)| key.get_ref() == part) {
                        Some((_, next)) if is_leaf(next.get_ref()) => (next.span(), Some(next)),
                        Some((key, next)) => (key.span(), Some(next)),
                        None => break,
                    }
                }
                DeValue::Array(array) => {
                    match part.parse().ok().and_then(|index: usize| array.get(index)) {
                        Some(next) => (next.span(), Some(next)),
                        None => break,
                    }
                }
                _ => break,
            };
            range = place;
            value = next;
        }
        diagnostic.at(DECLARATION, range, label)
    }
}

/// Whether the value rather than its key is what a label should point at.
fn is_leaf(value: &DeValue<'_>) -> bool {
    matches!(value, DeValue::String(_) | DeValue::Integer(_) | DeValue::Float(_))
}

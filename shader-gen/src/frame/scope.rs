//! What names mean in the frame and in each use of a template: numbers, axes, resources and inputs.

use std::collections::{BTreeMap, BTreeSet};

use sglow_graph::description::{self, Description, Table};
use sglow_graph::{Formula, description as flat};

use super::authored::{Authored, Choice, Step, Template};
use super::formula::{self, Condition as _, Text, apply, both, not, simple};

/// A place in what an author wrote: keys of tables and indices of arrays from the top.
pub(crate) type Path = Vec<String>;

/// A place, and the step that uses the template in which it is.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Origin {
    pub(crate) path: Path,
    pub(crate) used: Option<Path>,
}

impl Origin {
    /// What stands in it at some keys.
    pub(crate) fn at(&self, keys: &[&str]) -> Self {
        let keys = keys.iter().map(|key| (*key).to_owned());
        Self { path: self.path.iter().cloned().chain(keys).collect(), used: self.used.clone() }
    }

    pub(crate) fn item(&self, index: usize) -> Self {
        self.at(&[&index.to_string()])
    }
}

/// What is wrong whatever the configuration.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Fault {
    pub(crate) origin: Origin,
    /// Whether a name is unknown.
    pub(crate) unknown: bool,
    pub(crate) text: String,
}

/// Values, the first of which whose condition holds counts; one without a condition always does, and is the last one.
pub(super) type Cases<T> = Vec<(Option<Formula>, T)>;

/// The frame, or one use of a template.
pub(super) struct Scope<'a> {
    pub(super) template: &'a Template,
    /// Where the template stands.
    pub(super) base: Origin,
    /// What stands before names of resources.
    pub(super) prefix: String,
    /// What stands before names of lets and uniforms.
    pub(super) stem: String,
    pub(super) caller: Option<Caller<'a>>,
    /// The numbers that the use gives.
    pub(super) given: Table<Formula>,
    /// The lets of the template so far; nothing for one that is in progress.
    pub(super) lets: Table<Option<Formula>>,
    /// Axes so far; nothing for one that is in progress.
    pub(super) axes: Table<Option<Cases<String>>>,
}

/// The step that uses a template.
#[derive(Clone)]
pub(super) struct Caller<'a> {
    pub(super) scope: usize,
    pub(super) step: &'a Step,
    pub(super) origin: Origin,
}

impl<'a> Scope<'a> {
    pub(super) fn new(template: &'a Template, base: Origin) -> Self {
        let (prefix, stem, caller, given, lets, axes) = Default::default();
        Self { template, base, prefix, stem, caller, given, lets, axes }
    }
}

/// A repetition that a place stands in.
#[derive(Clone, Copy)]
pub(super) struct Round<'a> {
    /// The number's name in the template, and in the frame.
    pub(super) index: Option<(&'a str, &'a str)>,
    pub(super) lets: Option<&'a Table<Text>>,
    pub(super) origin: &'a Origin,
    pub(super) outer: Option<&'a Round<'a>>,
}

/// Where something stands, which says what its names mean.
#[derive(Clone, Copy)]
pub(super) struct Here<'a> {
    pub(super) scope: usize,
    pub(super) round: Option<&'a Round<'a>>,
}

/// What the name of a resource or an alias stands for.
#[derive(Clone)]
pub(super) enum Known<'a> {
    /// It exists in no configuration.
    Never,
    One,
    /// How often a pair has changed places so far.
    Pair(Formula),
    Alias(usize, &'a Choice),
}

/// What is made of a frame with templates.
pub(super) struct Expansion<'a> {
    pub(super) authored: &'a Authored,
    pub(super) made: Description,
    pub(super) origins: BTreeMap<Path, Origin>,
    pub(super) faults: BTreeSet<Fault>,
    pub(super) scopes: Vec<Scope<'a>>,
    pub(super) known: BTreeMap<String, Known<'a>>,
    /// Names that no let and no number of a round may have.
    pub(super) taken: BTreeSet<String>,
}

impl<'a> Expansion<'a> {
    pub(super) fn wrong(&mut self, origin: Origin, text: impl Into<String>) {
        self.faults.insert(Fault { origin, unknown: false, text: text.into() });
    }

    pub(super) fn unknown<'k>(
        &mut self,
        origin: Origin,
        what: &str,
        name: &str,
        known: impl IntoIterator<Item = &'k String>,
    ) {
        let known: Vec<&str> = known.into_iter().map(String::as_str).collect();
        let list = if known.is_empty() { "" } else { "; expected one of " };
        let text = format!("unknown {what} `{name}`{list}{}", known.join(", "));
        self.faults.insert(Fault { origin, unknown: true, text });
    }

    /// A name that is not taken: this one, or it with a number.
    pub(super) fn free(&mut self, name: &str) -> String {
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let mut names = std::iter::once(name.to_owned()).chain(numbered);
        let free = names.find(|name| !self.taken.contains(name)).unwrap_or_default();
        self.taken.insert(free.clone());
        free
    }

    /// A name of a use's own.
    pub(super) fn own(&self, scope: usize, name: &str) -> String {
        match self.scopes[scope].stem.as_str() {
            "" => name.to_owned(),
            stem => format!("{stem}_{name}"),
        }
    }

    pub(super) fn formula(&mut self, here: Here<'_>, text: &Text, origin: &Origin) -> Formula {
        match text.parse() {
            Ok(tree) => self.tree(here, tree, origin),
            Err(message) => {
                self.wrong(origin.clone(), format!("not a formula: {message}"));
                Formula::Number(1)
            }
        }
    }

    pub(super) fn option(
        &mut self,
        here: Here<'_>,
        text: Option<&Text>,
        origin: &Origin,
    ) -> Option<Formula> {
        text.map(|text| self.formula(here, text, origin))
    }

    pub(super) fn formulas<const N: usize>(
        &mut self,
        here: Here<'_>,
        texts: &[Text; N],
        origin: &Origin,
    ) -> [Formula; N] {
        std::array::from_fn(|index| self.formula(here, &texts[index], &origin.item(index)))
    }

    fn tree(&mut self, here: Here<'_>, tree: Formula, origin: &Origin) -> Formula {
        let operation = match tree {
            Formula::Number(_) => return tree,
            Formula::Name { name } => return self.number(here, &name, origin),
            Formula::Is { is: [axis, value] } => return self.is(here.scope, &axis, &value, origin),
            Formula::Apply(operation) => operation,
        };
        let Some((symbol, arguments)) = operation.into_iter().next() else {
            return Formula::Number(1);
        };
        let arguments = arguments.into_iter().map(|part| self.tree(here, part, origin));
        simple(apply(&symbol, arguments.collect::<Vec<_>>()))
    }

    /// What the name of a number stands for.
    fn number(&mut self, here: Here<'_>, name: &str, origin: &Origin) -> Formula {
        let mut round = here.round;
        while let Some(this) = round {
            if let Some((_, index)) = this.index.filter(|(own, _)| *own == name) {
                return formula::name(index);
            }
            if let Some(text) = this.lets.and_then(|lets| lets.get(name)) {
                let formula =
                    self.formula(Here { round, ..here }, text, &this.origin.at(&["let", name]));
                return self.define(here.scope, name, formula, &this.origin.at(&["let", name]));
            }
            round = this.outer;
        }
        if let Some(given) = self.scopes[here.scope].given.get(name) {
            return given.clone();
        }
        for scope in [here.scope, 0] {
            if self.scopes[scope].template.lets.contains_key(name) {
                return self.defined(scope, name, origin);
            }
        }
        let Description { parameter, facts, .. } = &self.made;
        if parameter.contains_key(name) || facts.contains(name) {
            return formula::name(name);
        }
        self.unknown(origin.clone(), "name", name, []);
        Formula::Number(1)
    }

    /// What a let of a template stands for.
    pub(super) fn defined(&mut self, scope: usize, name: &str, origin: &Origin) -> Formula {
        match self.scopes[scope].lets.get(name) {
            Some(Some(formula)) => return formula.clone(),
            Some(None) => {
                self.wrong(origin.clone(), format!("`{name}` depends on itself"));
                return Formula::Number(1);
            }
            None => {}
        }
        let template = self.scopes[scope].template;
        let Some(text) = template.lets.get(name) else { return Formula::Number(1) };
        self.scopes[scope].lets.insert(name.to_owned(), None);
        let origin = self.scopes[scope].base.at(&["let", name]);
        let formula = self.formula(Here { scope, round: None }, text, &origin);
        let formula = if scope == 0 {
            self.made.lets.insert(name.to_owned(), formula.clone());
            self.origins.insert(vec!["let".to_owned(), name.to_owned()], origin);
            match formula {
                Formula::Number(_) | Formula::Name { .. } => formula,
                _ => formula::name(name),
            }
        } else {
            self.define(scope, name, formula, &origin)
        };
        self.scopes[scope].lets.insert(name.to_owned(), Some(formula.clone()));
        formula
    }

    /// The name of a formula that has one: a let of the frame, unless the formula is as simple itself.
    pub(super) fn define(
        &mut self,
        scope: usize,
        name: &str,
        formula: Formula,
        origin: &Origin,
    ) -> Formula {
        let own = self.own(scope, name);
        if matches!(formula, Formula::Number(_) | Formula::Name { .. }) {
            return formula;
        }
        let same = |(known, of): (&String, &Formula)| known.starts_with(&own) && *of == formula;
        let known = self.made.lets.iter().find(|one| same(*one)).map(|(known, _)| known.clone());
        formula::name(&known.unwrap_or_else(|| {
            let free = self.free(&own);
            self.made.lets.insert(free.clone(), formula);
            self.origins.insert(vec!["let".to_owned(), free.clone()], origin.clone());
            free
        }))
    }

    /// Whether an axis has a value, where other axes and uses of templates decide it.
    fn is(&mut self, scope: usize, axis: &str, value: &str, origin: &Origin) -> Formula {
        let axes = self.made.axes.clone();
        let Some(known) = axes.get(axis) else {
            self.unknown(origin.clone(), "axis", axis, axes.keys());
            return Formula::Number(1);
        };
        if !known.values.iter().any(|known| known == value) {
            self.unknown(origin.clone(), "value", value, &known.values);
            return Formula::Number(1);
        }
        let mut is = formula::is(axis, value);
        for (when, of) in self.axis(scope, axis, origin).into_iter().rev() {
            let when = when.unwrap_or(Formula::Number(1));
            is = match of == value {
                true => simple(apply("||", [when, is])),
                false => simple(apply("&&", [not(when), is])),
            };
        }
        is
    }

    /// The values of an axis by the uses that a place stands in and by other axes; where none applies, it is what the
    /// configuration says.
    pub(super) fn axis(&mut self, scope: usize, axis: &str, origin: &Origin) -> Cases<String> {
        match self.scopes[scope].axes.get(axis) {
            Some(Some(cases)) => return cases.clone(),
            Some(None) => {
                self.wrong(origin.clone(), format!("`{axis}` depends on itself"));
                return Vec::new();
            }
            None => {}
        }
        self.scopes[scope].axes.insert(axis.to_owned(), None);
        let mut cases = Vec::new();
        let mut caller = self.scopes[scope].caller.clone();
        while let Some(Caller { scope, step, origin }) = caller {
            if let Some(choice) = step.axes.get(axis) {
                cases.extend(self.values(
                    Here { scope, round: None },
                    choice,
                    &origin.at(&["axes", axis]),
                ));
            }
            caller = self.scopes[scope].caller.clone();
        }
        let authored = self.authored;
        if let Some(choice) = authored.choose.get(axis) {
            let origin = Origin::default().at(&["choose", axis]);
            cases.extend(self.values(Here { scope, round: None }, choice, &origin));
        }
        let cases = first(cases);
        self.scopes[scope].axes.insert(axis.to_owned(), Some(cases.clone()));
        cases
    }

    /// The values of a choice.
    pub(super) fn values(
        &mut self,
        here: Here<'_>,
        choice: &Choice,
        origin: &Origin,
    ) -> Cases<String> {
        let cases = match choice {
            Choice::Always(value) => return vec![(None, value.clone())],
            Choice::Cases(cases) => cases,
        };
        let cases = cases.iter().enumerate().map(|(index, case)| {
            let origin = origin.item(index).at(&["when"]);
            let when = self.option(here, case.when.as_ref(), &origin);
            (when, case.value.clone())
        });
        first(cases.collect())
    }

    /// The input that a name stands for.
    pub(super) fn input(&mut self, scope: usize, name: &str, origin: &Origin) -> String {
        match self.scopes[scope].caller.clone() {
            Some(Caller { scope, step, origin: of }) => {
                let given = step.names.get(name);
                let origin = given.map_or(origin.clone(), |_| of.at(&["names", name]));
                self.input(scope, given.map_or(name, |given| given), &origin)
            }
            None => {
                if !self.made.input.contains_key(name) {
                    let known: Vec<String> = self.made.input.keys().cloned().collect();
                    self.unknown(origin.clone(), "input", name, &known);
                }
                name.to_owned()
            }
        }
    }

    /// What the name of a resource stands for: its full name, which of a pair, and what is known of it.
    pub(super) fn target(
        &mut self,
        scope: usize,
        name: &str,
        origin: &Origin,
    ) -> Option<(String, Option<String>, Known<'a>)> {
        if let Some(Caller { scope: outer, step, origin: of }) = self.scopes[scope].caller.clone()
            && let Some(given) = step.names.get(name)
        {
            let (given, side) = side(given.trim());
            let found = self.target(outer, given, &of.at(&["names", name]))?;
            return Some((found.0, side.map(str::to_owned).or(found.1), found.2));
        }
        let full = format!("{}{name}", self.scopes[scope].prefix);
        if let Some(known) = self.known.get(&full) {
            return Some((full, None, known.clone()));
        }
        if scope != 0 {
            return self.target(0, name, origin);
        }
        self.unknown(origin.clone(), "resource", name, []);
        None
    }

    /// The resources that a reference stands for; nothing where it stands for one that does not exist.
    pub(super) fn reference(
        &mut self,
        here: Here<'_>,
        text: &str,
        origin: &Origin,
    ) -> Cases<Option<flat::Reference>> {
        let (place, level) = match text.split_once('@') {
            Some((place, level)) => (place, Some(Text(level.to_owned()))),
            None => (text, None),
        };
        let level = self.option(here, level.as_ref(), origin);
        let (name, own) = side(place.trim());
        self.resolved(here.scope, name, own.map(str::to_owned), level, origin, 0)
    }

    fn resolved(
        &mut self,
        scope: usize,
        name: &str,
        own: Option<String>,
        level: Option<Formula>,
        origin: &Origin,
        depth: usize,
    ) -> Cases<Option<flat::Reference>> {
        let Some((name, given, known)) = self.target(scope, name, origin) else {
            return vec![(None, None)];
        };
        let one = |resource, level| vec![(None, Some(flat::Reference { resource, level }))];
        match (known, own.or(given)) {
            (Known::Never, _) => vec![(None, None)],
            (Known::One, None) => one(name, level),
            (Known::One, Some(_)) => {
                self.wrong(origin.clone(), "`.front` and `.back` are of a pair");
                vec![(None, None)]
            }
            (Known::Pair(_), None) => {
                self.wrong(origin.clone(), "of a pair, say `.front` or `.back`");
                vec![(None, None)]
            }
            (Known::Pair(flips), Some(side)) => {
                let (front, back) = match side.as_str() {
                    "front" => ("0", "1"),
                    _ => ("1", "0"),
                };
                let odd = simple(apply("%", [flips, Formula::Number(2)]));
                let even = simple(apply("==", [odd, Formula::Number(0)]));
                let of = |which: &str| flat::Reference {
                    resource: format!("{name}.{which}"),
                    level: level.clone(),
                };
                first(vec![(Some(even), Some(of(front))), (None, Some(of(back)))])
            }
            (Known::Alias(scope, choice), side) => {
                let template = self.scopes[scope].base.clone();
                let prefix = self.scopes[scope].prefix.clone();
                let origin = template.at(&["alias", name.strip_prefix(&prefix).unwrap_or(&name)]);
                if depth > 16 {
                    self.wrong(origin, format!("`{name}` depends on itself"));
                    return vec![(None, None)];
                }
                let mut cases = Vec::new();
                for (when, value) in self.values(Here { scope, round: None }, choice, &origin) {
                    let (target, own) = self::side(value.trim());
                    let side = side.clone().or(own.map(str::to_owned));
                    let inner =
                        self.resolved(scope, target, side, level.clone(), &origin, depth + 1);
                    cases.extend(within(when, inner));
                }
                if cases.last().is_none_or(|(when, _)| when.is_some()) {
                    self.wrong(origin, "the last case of an alias always applies");
                }
                first(cases)
            }
        }
    }

    /// A choice of references; nothing if what it stands for exists in no configuration.
    pub(super) fn references(
        &mut self,
        here: Here<'_>,
        choice: &Choice,
        origin: &Origin,
    ) -> Option<description::Choice<flat::Reference>> {
        let single = matches!(choice, Choice::Always(_));
        let mut cases = Vec::new();
        for (index, (when, value)) in self.values(here, choice, origin).into_iter().enumerate() {
            let origin = if single { origin.clone() } else { origin.item(index).at(&["value"]) };
            cases.extend(within(when, self.reference(here, &value, &origin)));
        }
        // Where what does not exist is chosen, no later case applies.
        let (mut left, mut unless) = (Vec::new(), None);
        for (when, value) in first(cases) {
            match value {
                Some(value) => left.push((both(unless.clone(), when), value)),
                None => unless = both(unless, Some(not(when.unwrap_or(Formula::Number(1))))),
            }
        }
        choice_of(first(left))
    }
}

/// The name of a reference, and which of a pair it means.
fn side(text: &str) -> (&str, Option<&str>) {
    match text.rsplit_once('.') {
        Some((name, side @ ("front" | "back"))) => (name, Some(side)),
        _ => (text, None),
    }
}

/// Cases that count where a condition holds.
fn within<T>(when: Option<Formula>, cases: Cases<T>) -> Cases<T> {
    cases.into_iter().map(|(own, value)| (both(when.clone(), own), value)).collect()
}

/// The cases that may apply.
fn first<T>(cases: Cases<T>) -> Cases<T> {
    let mut left = Vec::new();
    for (when, value) in cases {
        let when = when.and_then(Formula::condition);
        if when.as_ref().is_some_and(Formula::is_never) {
            continue;
        }
        let always = when.is_none();
        left.push((when, value));
        if always {
            break;
        }
    }
    left
}

/// Cases as a description has them; nothing if there is none.
pub(super) fn choice_of<T>(cases: Cases<T>) -> Option<description::Choice<T>> {
    let mut cases: Vec<_> =
        cases.into_iter().map(|(when, value)| flat::Case { when, value }).collect();
    match cases.len() {
        0 => None,
        1 if cases[0].when.is_none() => cases.pop().map(|case| flat::Choice::Always(case.value)),
        _ => Some(flat::Choice::Cases(cases)),
    }
}

/// Whether a formula depends on a name, lets included.
pub(super) fn mentions(of: &Formula, name: &str, lets: &Table<Formula>) -> bool {
    match of {
        Formula::Number(_) | Formula::Is { .. } => false,
        Formula::Name { name: own } => {
            own == name || lets.get(own).is_some_and(|of| mentions(of, name, lets))
        }
        Formula::Apply(operation) => {
            operation.values().flatten().any(|part| mentions(part, name, lets))
        }
    }
}

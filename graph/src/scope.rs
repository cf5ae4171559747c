//! What names mean: axes, numbers and resources, and what formulas and references come to.
//!
//! What is wrong is noted, and something stands in its place: with an error there is no frame, and all that is done is to
//! look for more.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use crate::configuration::Configuration;
use crate::description::{Choice, Description, Field, Number, ParameterType, Reference, Table};
use crate::error::{Error, Errors, Kind, unknown};
use crate::formula::{self, Formula};
use crate::frame::{self, Frame, Value, View};

/// Lets that stand in each other at most.
const MAXIMUM_DEPTH: u32 = 64;

/// What an evaluation has in hand.
pub(crate) struct Evaluation<'d> {
    pub(crate) description: &'d Description,
    pub(crate) configuration: &'d Configuration,
    pub(crate) frame: RefCell<Frame>,
    /// The index of each resource by its name; nothing where it does not exist in the configuration.
    pub(crate) known: BTreeMap<&'d str, Option<usize>>,
    /// How often formulas have read the number of a round.
    pub(crate) rounds_read: Cell<u64>,
    errors: RefCell<BTreeSet<Error>>,
}

/// Where something stands, which says what its names mean.
#[derive(Clone)]
pub(crate) struct Env<'a> {
    pub(crate) of: &'a Evaluation<'a>,
    pub(crate) place: Rc<[String]>,
    /// Values that go before the configured ones: of the host's draws, of a variant, of a rule.
    pub(crate) axes: Option<&'a Table<String>>,
    /// The names and numbers of the rounds it stands in.
    pub(crate) rounds: &'a [(&'a str, u64)],
    pub(crate) depth: u32,
}

impl<'d> Evaluation<'d> {
    pub(crate) fn new(description: &'d Description, configuration: &'d Configuration) -> Self {
        let (frame, known, rounds_read, errors) = Default::default();
        Self { description, configuration, frame, known, rounds_read, errors }
    }

    /// The frame, if nothing is wrong.
    pub(crate) fn finish(self) -> Result<Frame, Errors> {
        let errors: Vec<_> = self.errors.into_inner().into_iter().collect();
        if errors.is_empty() { Ok(self.frame.into_inner()) } else { Err(Errors(errors)) }
    }
}

impl<'a> Env<'a> {
    pub(crate) fn new(of: &'a Evaluation<'a>, place: &[&str]) -> Self {
        Self { of, place: Rc::default(), axes: None, rounds: &[], depth: 0 }.at(place)
    }

    /// The same at another place.
    pub(crate) fn at(&self, place: &[&str]) -> Self {
        Self { place: place.iter().map(|key| (*key).to_owned()).collect(), ..self.clone() }
    }

    /// The same below its place.
    pub(crate) fn below(&self, key: String) -> Self {
        Self { place: self.place.iter().cloned().chain([key]).collect(), ..self.clone() }
    }

    /// What has no error; the error is noted.
    pub(crate) fn noted<T>(&self, result: Result<T, Error>) -> Option<T> {
        result.map_err(|error| self.of.errors.borrow_mut().insert(error)).ok()
    }

    pub(crate) fn error(&self, kind: Kind, text: impl Into<String>) -> Error {
        Error { place: self.place.to_vec(), kind, text: text.into(), formula: None }
    }

    pub(crate) fn wrong(&self, kind: Kind, text: impl Into<String>) {
        self.noted::<()>(Err(self.error(kind, text)));
    }

    /// The entry of a table.
    pub(crate) fn entry<T>(&self, table: &'a Table<T>, what: &str, name: &str) -> Option<&'a T> {
        let missing = || self.error(Kind::Unknown, unknown(what, name, table.keys()));
        self.noted(table.get(name).ok_or_else(missing))
    }

    /// Whether a part of the frame runs; what is of no part always does.
    pub(crate) fn runs(&self, part: &str) -> bool {
        let parts = &self.of.configuration.parts;
        part.is_empty() || parts.as_ref().is_none_or(|parts| parts.contains(part))
    }

    /// The number of a formula; 1 if it has none.
    pub(crate) fn number(&self, formula: &Formula) -> u64 {
        self.noted(self.evaluate(formula)).unwrap_or(1)
    }

    pub(crate) fn option(&self, formula: &Option<Formula>) -> Option<u64> {
        formula.as_ref().map(|formula| self.number(formula))
    }

    pub(crate) fn numbers<const N: usize>(&self, formulas: &[Formula; N]) -> [u64; N] {
        formulas.each_ref().map(|formula| self.number(formula))
    }

    /// Whether a condition is met; without one it is.
    pub(crate) fn holds(&self, when: &Option<Formula>) -> bool {
        self.option(when) != Some(0)
    }

    /// The value of a choice; nothing if no case applies.
    pub(crate) fn choose<'c, T>(&self, choice: &'c Choice<T>) -> Option<&'c T> {
        let cases = match choice {
            Choice::Always(value) => return Some(value),
            Choice::Cases(cases) => cases,
        };
        cases.iter().find(|case| self.holds(&case.when)).map(|case| &case.value)
    }

    /// The value of an axis: of the draw, configured, or the default.
    pub(crate) fn axis(&self, name: &str) -> Option<&'a String> {
        let own = self.axes.and_then(|axes| axes.get(name));
        if own.is_none() && !self.of.frame.borrow().reads.contains(name) {
            self.of.frame.borrow_mut().reads.insert(name.to_owned());
        }
        let given = own.or_else(|| self.of.configuration.axes.get(name));
        given.or_else(|| self.of.description.axes.get(name).map(|axis| &axis.default))
    }

    /// That an axis has a value.
    pub(crate) fn has(&self, axis: &str, value: &str) -> Result<(), Error> {
        let (axes, wrong) = (&self.of.description.axes, |text| self.error(Kind::Unknown, text));
        let values = axes.get(axis).map(|axis| &axis.values);
        let values = values.ok_or_else(|| wrong(unknown("axis", axis, axes.keys())))?;
        let found = values.iter().any(|known| known == value).then_some(());
        found.ok_or_else(|| wrong(unknown("value", value, values)))
    }

    /// The number of a round, of a let, of a parameter, or of a fact.
    fn named(&self, name: &str) -> Result<Number, Error> {
        if let Some((_, number)) = self.rounds.iter().rfind(|(index, _)| *index == name) {
            self.of.rounds_read.update(|count| count + 1);
            return Ok(Number::Whole(*number));
        }
        let Evaluation { description, configuration, .. } = self.of;
        if let Some(formula) = description.lets.get(name) {
            let inner = Env { depth: self.depth + 1, ..self.at(&["let", name]) };
            let circle = || inner.error(Kind::Invalid, format!("`{name}` depends on itself"));
            return if self.depth < MAXIMUM_DEPTH { inner.value(formula) } else { Err(circle()) };
        }
        if let Some(parameter) = description.parameter.get(name) {
            self.of.frame.borrow_mut().reads.insert(name.to_owned());
            // What is out of its range is an error already: the others are found with its default.
            let given = configuration.parameters.get(name);
            let value = *given.filter(|of| parameter.allows(**of)).unwrap_or(&parameter.default);
            let real = parameter.kind == ParameterType::Real;
            return Ok(if real { Number::Real(value.real()) } else { value });
        }
        let holds = || Number::Whole(u64::from(configuration.facts.get(name) == Some(&true)));
        let fact = description.facts.contains(name).then(holds);
        fact.ok_or_else(|| self.error(Kind::Unknown, unknown("name", name, [])))
    }

    /// The number of a formula, or of the real parameter that it names.
    fn value(&self, formula: &Formula) -> Result<Number, Error> {
        match formula {
            Formula::Name { name } => self.named(name),
            _ => self.evaluate(formula).map(Number::Whole),
        }
    }

    fn evaluate(&self, formula: &Formula) -> Result<u64, Error> {
        formula::EVALUATED.set(formula::evaluated() + 1);
        let of = |error: Error| Error { formula: error.formula.or(Some(formula.clone())), ..error };
        self.tree(formula).map_err(of)
    }

    fn tree(&self, formula: &Formula) -> Result<u64, Error> {
        let wrong = |text: String| self.error(Kind::Invalid, text);
        let operation = match formula {
            Formula::Number(number) => return Ok(*number),
            Formula::Is { is: [axis, value] } => {
                self.has(axis, value)?;
                return Ok(u64::from(self.axis(axis) == Some(value)));
            }
            Formula::Name { name } => match self.named(name)? {
                Number::Whole(number) => return Ok(number),
                Number::Real(_) => {
                    return Err(wrong(format!("`{name}` is real; formulas are of whole numbers")));
                }
            },
            Formula::Apply(operation) => operation.first_key_value(),
        };
        let (symbol, arguments) = operation.ok_or_else(|| wrong("an empty formula".to_owned()))?;
        match (symbol.as_str(), &arguments[..]) {
            ("&&", [a, b]) => Ok(u64::from(self.tree(a)? != 0 && self.tree(b)? != 0)),
            ("||", [a, b]) => Ok(u64::from(self.tree(a)? != 0 || self.tree(b)? != 0)),
            ("select", [of, a, b]) => self.tree(if self.tree(of)? != 0 { a } else { b }),
            (symbol, arguments) => {
                let numbers = arguments.iter().map(|argument| self.tree(argument));
                let numbers = numbers.collect::<Result<Vec<_>, _>>()?;
                formula::apply(symbol, &numbers).map_err(|what| {
                    let numbers: Vec<_> = numbers.iter().map(u64::to_string).collect();
                    wrong(format!("{what}: `{symbol}` of {}", numbers.join(", ")))
                })
            }
        }
    }

    /// The value of a member of a uniform.
    pub(crate) fn field(&self, field: &Field) -> Value {
        match field {
            Field::Number(number) => Value::Number(Number::Real(*number)),
            Field::Formula(formula) => {
                Value::Number(self.noted(self.value(formula)).unwrap_or(Number::Whole(1)))
            }
            Field::List(list) => Value::List(list.iter().map(|field| self.field(field)).collect()),
            Field::Age { age } => Value::Age(self.kept(age)),
            Field::Input { input, element } => {
                self.entry(&self.of.description.input, "input", input);
                Value::Input(input.clone(), self.option(element))
            }
        }
    }

    /// The index of a resource; nothing if it does not exist in the configuration.
    fn resource(&self, name: &str) -> Option<usize> {
        let index = self.of.known.get(name).copied();
        let unknown = || self.error(Kind::Unknown, unknown("resource", name, []));
        self.noted(index.ok_or_else(unknown)).unwrap_or(Some(0))
    }

    /// The view of a reference; nothing if no case applies, or its resource does not exist in the configuration.
    pub(crate) fn view(&self, choice: &Choice<Reference>) -> Option<View> {
        let Reference { resource: name, level } = self.choose(choice)?;
        let (resource, level) = (self.resource(name)?, self.option(level));
        let levels = match self.of.frame.borrow().resources.get(resource).map(|one| &one.kind) {
            Some(frame::Kind::Texture { levels, .. }) => *levels,
            _ => 0,
        };
        if let Some(level) = level.filter(|level| *level >= levels) {
            self.wrong(Kind::Invalid, format!("level {level} of `{name}`, which has {levels}"));
        }
        Some(View { resource, level })
    }

    /// The view of what has to exist.
    pub(crate) fn target(&self, choice: &Choice<Reference>) -> View {
        let name = || self.choose(choice).map_or("", |reference| &reference.resource);
        let absent = || View { resource: self.existing(name(), None), level: None };
        self.view(choice).unwrap_or_else(absent)
    }

    /// The index of a resource that has an age.
    pub(crate) fn kept(&self, name: &str) -> usize {
        if self.of.description.resource.get(name).is_some_and(|resource| !resource.kept) {
            self.wrong(Kind::Invalid, format!("`{name}` is not kept, so it is never new"));
        }
        self.existing(name, self.resource(name))
    }

    fn existing(&self, name: &str, index: Option<usize>) -> usize {
        let absent = || format!("`{name}` does not exist in this configuration");
        self.noted(index.ok_or_else(|| self.error(Kind::Invalid, absent()))).unwrap_or(0)
    }
}

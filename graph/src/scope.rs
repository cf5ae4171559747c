//! What names mean: axes, numbers and resources, and what formulas and references come to.
//!
//! What is wrong is noted, and something stands in its place: with an error there is no frame, and all that is done is to
//! look for more.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

use crate::configuration::Configuration;
use crate::description::{Choice, Description, Field, Number, ParameterType, Reference, Table};
use crate::error::{Error, Errors, Kind, Place, unknown};
use crate::formula::{self, Formula, UNKNOWN, binary, unary};
use crate::frame::{self, Resource, Value, View};

/// Lets that stand in each other at most.
const MAXIMUM_DEPTH: u32 = 64;

/// What an evaluation has in hand.
pub(crate) struct Evaluation<'d> {
    pub(crate) description: &'d Description,
    pub(crate) configuration: &'d Configuration,
    /// What exists.
    pub(crate) resources: Vec<Resource>,
    /// The index of each resource by its name; nothing where it does not exist in the configuration.
    pub(crate) known: BTreeMap<&'d str, Option<usize>>,
    pub(crate) errors: RefCell<Vec<Error>>,
}

/// One round of a repetition.
pub(crate) struct Round<'a> {
    pub(crate) index: Option<&'a str>,
    pub(crate) number: u64,
    /// Whether a formula has read the number.
    pub(crate) used: Cell<bool>,
    pub(crate) outer: Option<&'a Round<'a>>,
}

/// Where something stands, which says what its names mean.
#[derive(Clone, Copy)]
pub(crate) struct Env<'a> {
    pub(crate) of: &'a Evaluation<'a>,
    /// The place of the entry.
    pub(crate) place: &'a [String],
    /// The axes of one of the host's draws.
    pub(crate) axes: Option<&'a Table<String>>,
    pub(crate) round: Option<&'a Round<'a>>,
    pub(crate) depth: u32,
}

impl<'d> Evaluation<'d> {
    pub(crate) fn new(description: &'d Description, configuration: &'d Configuration) -> Self {
        let (resources, known, errors) = Default::default();
        Self { description, configuration, resources, known, errors }
    }

    /// What was noted.
    pub(crate) fn finish(&self) -> Result<(), Errors> {
        let mut errors = self.errors.take();
        errors.sort();
        errors.dedup();
        if errors.is_empty() { Ok(()) } else { Err(Errors(errors)) }
    }
}

impl<'a> Env<'a> {
    pub(crate) fn new(of: &'a Evaluation<'a>, place: &'a [String]) -> Self {
        Self { of, place, axes: None, round: None, depth: 0 }
    }

    pub(crate) fn note(&self, error: Error) {
        self.of.errors.borrow_mut().push(error);
    }

    fn error(&self, kind: Kind, text: impl Into<String>) -> Error {
        Error { place: Place(self.place.to_vec()), kind, text: text.into(), formula: None }
    }

    pub(crate) fn wrong(&self, kind: Kind, text: impl Into<String>) {
        self.note(self.error(kind, text));
    }

    /// The entry of a table.
    pub(crate) fn entry<T>(&self, table: &'a Table<T>, what: &str, name: &str) -> Option<&'a T> {
        let entry = table.get(name);
        if entry.is_none() {
            self.wrong(Kind::Unknown, unknown(what, name, table.keys()));
        }
        entry
    }

    /// Whether a part of the frame runs; what is of no part always does.
    pub(crate) fn runs(&self, part: &str) -> bool {
        let parts = &self.of.configuration.parts;
        part.is_empty() || parts.as_ref().is_none_or(|parts| parts.contains(part))
    }

    /// The number of a formula; 1 if it has none.
    pub(crate) fn number(&self, formula: &Formula) -> u64 {
        self.evaluate(formula).map_err(|error| self.note(error)).unwrap_or(1)
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
        match choice {
            Choice::Always(value) => Some(value),
            Choice::Cases(cases) => {
                let case = cases.iter().find(|case| self.holds(&case.when));
                case.map(|case| &case.value)
            }
        }
    }

    /// The value of an axis: of the draw, configured, or the default.
    pub(crate) fn axis(&self, name: &str) -> Option<&'a String> {
        let given = self.axes.and_then(|axes| axes.get(name));
        let given = given.or_else(|| self.of.configuration.axes.get(name));
        given.or_else(|| self.of.description.axes.get(name).map(|axis| &axis.default))
    }

    /// The number of a round, of a let, of a parameter, or of a fact.
    fn named(&self, name: &str) -> Result<Number, Error> {
        let mut round = self.round;
        while let Some(this) = round {
            if this.index == Some(name) {
                this.used.set(true);
                return Ok(Number::Whole(this.number));
            }
            round = this.outer;
        }
        let Evaluation { description, configuration, .. } = self.of;
        if let Some(formula) = description.lets.get(name) {
            let place = ["let".to_owned(), name.to_owned()];
            let inner = Env { place: &place, depth: self.depth + 1, ..*self };
            let circle = || inner.error(Kind::Invalid, format!("`{name}` depends on itself"));
            return if self.depth < MAXIMUM_DEPTH { inner.value(formula) } else { Err(circle()) };
        }
        if let Some(parameter) = description.parameter.get(name) {
            // What is out of its range is an error already: the others are found with its default.
            let given = configuration.parameters.get(name);
            let value = *given.filter(|of| parameter.allows(**of)).unwrap_or(&parameter.default);
            let real = parameter.kind == ParameterType::Real;
            return Ok(if real { Number::Real(value.real()) } else { value });
        }
        if !description.facts.contains(name) {
            return Err(self.error(Kind::Unknown, unknown("name", name, [])));
        }
        Ok(Number::Whole((configuration.facts.get(name) == Some(&true)).into()))
    }

    /// The number of a formula, or of the real parameter that it names.
    fn value(&self, formula: &Formula) -> Result<Number, Error> {
        match formula {
            Formula::Name { name } => self.named(name),
            _ => self.evaluate(formula).map(Number::Whole),
        }
    }

    fn evaluate(&self, formula: &Formula) -> Result<u64, Error> {
        formula::count();
        let of = |error: Error| Error { formula: error.formula.or(Some(formula.clone())), ..error };
        self.tree(formula).map_err(of)
    }

    fn tree(&self, formula: &Formula) -> Result<u64, Error> {
        let wrong = |text: String| self.error(Kind::Invalid, text);
        let operation = match formula {
            Formula::Number(number) => return Ok(*number),
            Formula::Is { is: [axis, value] } => return self.is(axis, value),
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
            ("select", [condition, a, b]) => {
                self.tree(if self.tree(condition)? != 0 { a } else { b })
            }
            (symbol, [a]) => {
                let a = self.tree(a)?;
                unary(symbol, a).map_err(|what| wrong(format!("{what}: `{symbol}` of {a}")))
            }
            (symbol, [a, b]) => {
                let (a, b) = (self.tree(a)?, self.tree(b)?);
                binary(symbol, a, b)
                    .map_err(|what| wrong(format!("{what}: `{symbol}` of {a}, {b}")))
            }
            _ => Err(wrong(format!("{UNKNOWN}: `{symbol}` of {} arguments", arguments.len()))),
        }
    }

    /// 1 if an axis has a value, else 0.
    fn is(&self, axis: &str, value: &str) -> Result<u64, Error> {
        let axes = &self.of.description.axes;
        let text = match axes.get(axis) {
            Some(known) if known.values.iter().any(|known| known == value) => {
                return Ok(u64::from(self.axis(axis).is_some_and(|of| of == value)));
            }
            Some(known) => unknown("value", value, &known.values),
            None => unknown("axis", axis, axes.keys()),
        };
        Err(self.error(Kind::Unknown, text))
    }

    /// The value of a member of a uniform.
    pub(crate) fn field(&self, field: &Field) -> Value {
        match field {
            Field::Number(number) => Value::Number(Number::Real(*number)),
            Field::Formula(formula) => {
                let value = self.value(formula).map_err(|error| self.note(error));
                Value::Number(value.unwrap_or(Number::Whole(1)))
            }
            Field::List(list) => Value::List(list.iter().map(|field| self.field(field)).collect()),
            Field::Age { age } => Value::Age(self.kept(age).unwrap_or_default()),
            Field::Input { input, element } => {
                self.entry(&self.of.description.input, "input", input);
                Value::Input(input.clone(), self.option(element))
            }
        }
    }

    /// The index of a resource; nothing if it does not exist in the configuration.
    pub(crate) fn resource(&self, name: &str) -> Option<usize> {
        let index = self.of.known.get(name).copied();
        index.unwrap_or_else(|| {
            self.wrong(Kind::Unknown, unknown("resource", name, []));
            Some(0)
        })
    }

    /// The view of a reference; nothing if no case applies, or its resource does not exist in the configuration.
    pub(crate) fn view(&self, choice: &Choice<Reference>) -> Option<View> {
        let Reference { resource: name, level } = self.choose(choice)?;
        let (resource, level) = (self.resource(name)?, self.option(level));
        let levels = match self.of.resources.get(resource).map(|one| &one.kind) {
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
        self.view(choice).unwrap_or_else(|| {
            let name = self.choose(choice).map_or("", |reference| &reference.resource);
            self.absent(name);
            View { resource: 0, level: None }
        })
    }

    /// The index of a resource that has an age.
    pub(crate) fn kept(&self, name: &str) -> Option<usize> {
        let index = self.resource(name);
        match index.and_then(|index| self.of.resources.get(index)) {
            None => self.absent(name),
            Some(resource) if resource.kept => {}
            Some(_) => {
                self.wrong(Kind::Invalid, format!("`{name}` is not kept, so it is never new"))
            }
        }
        index
    }

    fn absent(&self, name: &str) {
        self.wrong(Kind::Invalid, format!("`{name}` does not exist in this configuration"));
    }
}

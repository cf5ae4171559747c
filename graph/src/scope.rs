//! What names mean at a step: axes, numbers, resources and inputs, in the frame and in each use of a template.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use crate::configuration::Configuration;
use crate::description::{Choice, Description, Number, ParameterType, Step, Table, Template};
use crate::error::{At, Error, Problem};
use crate::formula::{Formula, Names, Node};
use crate::frame::{Frame, Kind, View};
use crate::reference::{Reference, Side};

/// What an evaluation has in hand.
pub(crate) struct Evaluation<'d> {
    pub(crate) description: &'d Description,
    pub(crate) configuration: &'d Configuration,
    pub(crate) root: Rc<Scope<'d>>,
    pub(crate) frame: RefCell<Frame>,
    pub(crate) errors: RefCell<Vec<Error>>,
    pub(crate) known: RefCell<BTreeMap<String, Known<'d>>>,
    /// Lets, axes and aliases that are being evaluated inside of each other.
    pub(crate) depth: Cell<u32>,
}

/// What the name of a resource or an alias stands for.
#[derive(Clone)]
pub(crate) enum Known<'d> {
    /// It does not exist in the configuration.
    Absent,
    /// Its index.
    One(usize),
    /// The index of the first of a pair, and which of them is the front.
    Pair(usize, usize),
    /// Another name.
    Alias(Rc<Scope<'d>>, &'d Choice<Reference>),
}

/// The frame, or one use of a template.
pub(crate) struct Scope<'d> {
    pub(crate) template: &'d Template,
    /// Where the template is described.
    pub(crate) base: Vec<String>,
    pub(crate) prefix: String,
    pub(crate) caller: Option<Caller<'d>>,
}

/// The step that uses a template.
pub(crate) struct Caller<'d> {
    pub(crate) scope: Rc<Scope<'d>>,
    pub(crate) step: &'d Step,
    pub(crate) path: Vec<String>,
}

impl<'d> Scope<'d> {
    pub(crate) fn of(name: &str, template: &'d Template) -> Self {
        let base = vec!["template".to_owned(), name.to_owned()];
        Self { template, base, prefix: String::new(), caller: None }
    }

    pub(crate) fn at(&self) -> At<'_> {
        At::base(&self.base, self.caller.as_ref().map(|caller| caller.path.as_slice()))
    }
}

/// One round of a repetition.
#[derive(Clone, Copy)]
pub(crate) struct Round<'a> {
    pub(crate) index: Option<&'a str>,
    pub(crate) number: u64,
    /// Whether a formula has read the number.
    pub(crate) used: &'a Cell<bool>,
    pub(crate) lets: Option<&'a Table<Formula>>,
    pub(crate) at: &'a At<'a>,
    pub(crate) outer: Option<&'a Round<'a>>,
}

/// Where something stands, which says what its names mean.
#[derive(Clone, Copy)]
pub(crate) struct Env<'a, 'd> {
    pub(crate) of: &'a Evaluation<'d>,
    pub(crate) scope: &'a Rc<Scope<'d>>,
    /// The axes of one of the host's draws.
    pub(crate) axes: Option<&'a Table<String>>,
    pub(crate) round: Option<&'a Round<'a>>,
}

impl<'a, 'd> Env<'a, 'd> {
    pub(crate) fn new(of: &'a Evaluation<'d>, scope: &'a Rc<Scope<'d>>) -> Self {
        Self { of, scope, axes: None, round: None }
    }

    /// One step deeper into what depends on something else.
    fn deeper<T>(
        &self,
        name: &str,
        at: &At<'_>,
        evaluate: impl FnOnce() -> Result<T, Error>,
    ) -> Result<T, Error> {
        let depth = self.of.depth.get();
        if depth > 64 {
            return Err(at.error(Problem::Circle(name.to_owned())));
        }
        self.of.depth.set(depth + 1);
        let result = evaluate();
        self.of.depth.set(depth);
        result
    }

    pub(crate) fn holds(&self, when: Option<&Formula>, at: &At<'_>) -> Result<bool, Error> {
        when.map_or(Ok(true), |when| Ok(when.evaluate(self, &at.key("when"))? != 0))
    }

    /// The value of a choice; nothing if no case applies.
    pub(crate) fn choose<'c, T>(
        &self,
        choice: &'c Choice<T>,
        at: &At<'_>,
    ) -> Result<Option<&'c T>, Error> {
        let cases = match choice {
            Choice::Always(value) => return Ok(Some(value)),
            Choice::Cases(cases) => cases,
        };
        for (index, case) in cases.iter().enumerate() {
            if self.holds(case.when.as_ref(), &at.item("", index))? {
                return Ok(Some(&case.value));
            }
        }
        Ok(None)
    }

    /// The value of an axis: of the draw, of the use and those around it, derived, configured, or the default.
    pub(crate) fn axis(&self, axis: &str, at: &At<'_>) -> Result<String, Error> {
        if let Some(value) = self.axes.and_then(|axes| axes.get(axis)) {
            return Ok(value.clone());
        }
        let mut scope = self.scope;
        while let Some(Caller { scope: outer, step, path }) = &scope.caller {
            if let Some(choice) = step.axes.get(axis) {
                let top = At::base(path, None);
                let at = top.key("axes");
                if let Some(value) = Self::new(self.of, outer).choose(choice, &at.key(axis))? {
                    return Ok(value.clone());
                }
            }
            scope = outer;
        }
        let Description { choose, axes, .. } = self.of.description;
        if let Some(choice) = choose.get(axis) {
            let top = At::base(&[], None);
            let (at, env) = (top.key("choose"), Self { round: None, ..*self });
            let at = at.key(axis);
            if let Some(value) = self.deeper(axis, &at, || env.choose(choice, &at))? {
                return Ok(value.clone());
            }
        }
        let configured = self.of.configuration.axes.get(axis);
        let value = configured.or_else(|| axes.get(axis).map(|axis| &axis.default));
        value.cloned().ok_or_else(|| at.error(Problem::unknown("axis", axis, axes.keys())))
    }

    /// The number of a name; nothing if the name is unknown.
    fn find(&self, name: &str) -> Result<Option<Number>, Error> {
        let mut round = self.round;
        while let Some(this) = round {
            if this.index == Some(name) {
                this.used.set(true);
                return Ok(Some(Number::Whole(this.number)));
            }
            if let Some(formula) = this.lets.and_then(|lets| lets.get(name)) {
                return Self { round, ..*self }.derive(name, formula, this.at);
            }
            round = this.outer;
        }
        if let Some(Caller { scope, step, path }) = &self.scope.caller
            && let Some(formula) = step.lets.get(name)
        {
            return Self::new(self.of, scope).derive(name, formula, &At::base(path, None));
        }
        if let Some(formula) = self.scope.template.lets.get(name) {
            return Self::new(self.of, self.scope).derive(name, formula, &self.scope.at());
        }
        if self.scope.caller.is_some() {
            return Self::new(self.of, &self.of.root).find(name);
        }
        let (description, configuration) = (self.of.description, self.of.configuration);
        let Some(parameter) = description.parameter.get(name) else {
            let holds = configuration.facts.get(name) == Some(&true);
            let fact = description.facts.contains(name);
            return Ok(fact.then(|| Number::Whole(u64::from(holds))));
        };
        // What is out of its range is an error already: the others are found with its default.
        let given = configuration.parameters.get(name).filter(|given| parameter.allows(**given));
        let value = *given.unwrap_or(&parameter.default);
        let real = parameter.kind == ParameterType::Real;
        Ok(Some(if real { Number::Real(value.real()) } else { value }))
    }

    fn derive(&self, name: &str, of: &Formula, at: &At<'_>) -> Result<Option<Number>, Error> {
        let at = at.key("let");
        let at = at.key(name);
        self.deeper(name, &at, || self.value(of, &at)).map(Some)
    }

    /// The number of a formula, or of the real parameter that it names.
    pub(crate) fn value(&self, formula: &Formula, at: &At<'_>) -> Result<Number, Error> {
        if let Ok(Node::Name(name)) = &formula.tree
            && let Some(number) = self.find(name)?
        {
            return Ok(number);
        }
        formula.evaluate(self, at).map(Number::Whole)
    }

    /// What a reference stands for: the full name, which of a pair, and what is known of it.
    pub(crate) fn target(
        &self,
        reference: &Reference,
        at: &At<'_>,
    ) -> Result<(String, Option<Side>, Known<'d>), Error> {
        let name = &reference.resource;
        let side = |(name, side, known)| (name, reference.side.or(side), known);
        if let Some(Caller { scope, step, path }) = &self.scope.caller
            && let Some(given) = step.names.get(name)
        {
            let top = At::base(path, None);
            let at = top.key("names");
            return Self::new(self.of, scope).target(given, &at.key(name)).map(side);
        }
        let full = format!("{}{name}", self.scope.prefix);
        let known = self.of.known.borrow().get(&full).cloned();
        match known {
            Some(Known::Alias(scope, choice)) => {
                let (top, env) = (scope.at(), Env::new(self.of, &scope));
                let at = top.key("alias");
                let at = at.key(name);
                let Some(chosen) = env.choose(choice, &at)? else {
                    return at.form("no case of the alias applies");
                };
                self.deeper(name, &at, || env.target(chosen, &at)).map(side)
            }
            Some(known) => Ok((full, reference.side, known)),
            None if self.scope.caller.is_some() => {
                Self::new(self.of, &self.of.root).target(reference, at)
            }
            None => at.unknown("resource", name, []),
        }
    }

    /// The view of a reference; nothing if its resource does not exist in the configuration.
    pub(crate) fn view(&self, reference: &Reference, at: &At<'_>) -> Result<Option<View>, Error> {
        let (name, side, known) = self.target(reference, at)?;
        let resource = match (known, side) {
            (Known::One(index), None) => index,
            (Known::Pair(first, front), Some(Side::Front)) => first + front,
            (Known::Pair(first, front), Some(Side::Back)) => first + 1 - front,
            (Known::One(_), Some(_)) => {
                return at.form("`.front` and `.back` are of a pair");
            }
            (Known::Pair(..), None) => {
                return at.form("of a pair, say `.front` or `.back`");
            }
            (Known::Absent | Known::Alias(..), _) => return Ok(None),
        };
        let level = reference.level.as_ref();
        let level = level.map(|level| level.evaluate(self, at)).transpose()?;
        let levels = match self.of.frame.borrow().resources.get(resource).map(|one| &one.kind) {
            Some(Kind::Texture { levels, .. }) => *levels,
            _ => 0,
        };
        if let Some(level) = level.filter(|level| *level >= levels) {
            return at.form(format!("level {level} of `{name}`, which has {levels}"));
        }
        Ok(Some(View { resource, level }))
    }

    /// The input that a name stands for.
    pub(crate) fn input(&self, name: &str, at: &At<'_>) -> Result<String, Error> {
        let known = &self.of.description.input;
        match &self.scope.caller {
            Some(Caller { scope, step, path }) => match step.names.get(name) {
                None => Self::new(self.of, scope).input(name, at),
                Some(given) => {
                    let top = At::base(path, None);
                    let at = top.key("names");
                    Self::new(self.of, scope).input(&given.resource, &at.key(name))
                }
            },
            None if known.contains_key(name) => Ok(name.to_owned()),
            None => at.unknown("input", name, known.keys()),
        }
    }
}

impl Names for Env<'_, '_> {
    fn number(&self, name: &str, at: &At<'_>) -> Result<u64, Error> {
        let problem = match self.find(name)? {
            Some(Number::Whole(number)) => return Ok(number),
            Some(Number::Real(_)) => {
                Problem::Form(format!("`{name}` is real; formulas are of whole numbers"))
            }
            None => Problem::unknown("name", name, []),
        };
        Err(at.error(problem))
    }

    fn is(&self, axis: &str, value: &str, at: &At<'_>) -> Result<bool, Error> {
        let axes = &self.of.description.axes;
        let problem = match axes.get(axis) {
            None => Problem::unknown("axis", axis, axes.keys()),
            Some(known) if !known.values.iter().any(|known| known == value) => {
                Problem::unknown("value", value, &known.values)
            }
            Some(_) => return Ok(self.axis(axis, at)? == value),
        };
        Err(at.error(problem))
    }
}

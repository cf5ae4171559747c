//! From a description and a configuration to a frame.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use crate::configuration::Configuration;
use crate::description::{self, Choice, Description, Field, Indirect, Number, Table, Template};
use crate::error::{At, Error, Errors, Problem};
use crate::formula::Formula;
use crate::frame::{
    Action, Binding, Call, Dispatch, Draw, Frame, Geometry, Kind, Resource, Size, Step, Value,
    Variant, View, texel_bytes,
};
use crate::reference::Reference;
use crate::scope::{Caller, Env, Evaluation, Known, Round, Scope};

/// Rounds of a repetition and calls of a render pass at most.
const MAXIMUM_ROUNDS: u64 = 1 << 16;

impl Description {
    /// The frame of a configuration.
    ///
    /// # Errors
    ///
    /// Everything that is wrong with the configuration, and with the description as far as the configuration shows it.
    pub fn evaluate(&self, configuration: &Configuration) -> Result<Frame, Errors> {
        let empty = Template::default();
        let root = Rc::new(Scope::of("frame", self.template.get("frame").unwrap_or(&empty)));
        let of = Evaluation {
            description: self,
            configuration,
            root: Rc::clone(&root),
            frame: RefCell::default(),
            errors: RefCell::new(configuration.check(self)),
            known: RefCell::new(BTreeMap::new()),
            depth: Cell::new(0),
        };
        let (env, top) = (Env::new(&of, &root), At::base(&[], None));
        for (index, requirement) in self.require.iter().enumerate() {
            let at = top.item("require", index);
            env.note(requirement.that.resolve(&env, &at.key("that")).and_then(|holds| {
                let reason = || Problem::Requirement(requirement.reason.clone());
                if holds != 0 { Ok(()) } else { Err(at.error(reason())) }
            }));
        }
        env.scope(&Context { run: true, ..Context::default() });
        let mut errors = of.errors.take();
        errors.sort();
        errors.dedup();
        if errors.is_empty() { Ok(of.frame.take()) } else { Err(Errors(errors)) }
    }
}

/// What steps have from the groups and uses they stand in.
#[derive(Clone, Default)]
struct Context {
    label: String,
    part: String,
    new: Option<usize>,
    /// Whether they run at all; if not, the names in templates are declared alone.
    run: bool,
}

/// What comes to a value in a configuration.
trait Resolve {
    type To;
    fn resolve(&self, env: &Env<'_, '_>, at: &At<'_>) -> Result<Self::To, Error>;
}

impl Resolve for Formula {
    type To = u64;
    fn resolve(&self, env: &Env<'_, '_>, at: &At<'_>) -> Result<u64, Error> {
        self.evaluate(env, at)
    }
}

impl Resolve for Reference {
    type To = View;
    fn resolve(&self, env: &Env<'_, '_>, at: &At<'_>) -> Result<View, Error> {
        let missing = || at.form(format!("`{self}` does not exist in this configuration"));
        env.view(self, at)?.map_or_else(missing, Ok)
    }
}

impl<T: Resolve> Resolve for Option<T> {
    type To = Option<T::To>;
    fn resolve(&self, env: &Env<'_, '_>, at: &At<'_>) -> Result<Self::To, Error> {
        self.as_ref().map(|value| value.resolve(env, at)).transpose()
    }
}

impl<T: Resolve> Resolve for Vec<T> {
    type To = Vec<T::To>;
    fn resolve(&self, env: &Env<'_, '_>, at: &At<'_>) -> Result<Self::To, Error> {
        self.iter().enumerate().map(|(i, value)| value.resolve(env, &at.item("", i))).collect()
    }
}

impl<const N: usize> Resolve for [Formula; N] {
    type To = [u64; N];
    fn resolve(&self, env: &Env<'_, '_>, at: &At<'_>) -> Result<[u64; N], Error> {
        let mut numbers = [0; N];
        for (index, (number, formula)) in numbers.iter_mut().zip(self).enumerate() {
            *number = env.note(formula.resolve(env, &at.item("", index))).unwrap_or(1);
        }
        Ok(numbers)
    }
}

impl<T: Resolve> Resolve for Table<T> {
    type To = Table<T::To>;
    fn resolve(&self, env: &Env<'_, '_>, at: &At<'_>) -> Result<Self::To, Error> {
        let of = |(name, value): (&String, &T)| {
            Some((name.clone(), env.note(value.resolve(env, &at.key(name)))?))
        };
        Ok(self.iter().filter_map(of).collect())
    }
}

impl Resolve for Choice<String> {
    type To = Option<String>;
    fn resolve(&self, env: &Env<'_, '_>, at: &At<'_>) -> Result<Option<String>, Error> {
        env.choose(self, at).map(Option::<&String>::cloned)
    }
}

/// A binding: nothing if its resource does not exist, or no case applies.
impl Resolve for Choice<Reference> {
    type To = Option<View>;
    fn resolve(&self, env: &Env<'_, '_>, at: &At<'_>) -> Result<Option<View>, Error> {
        env.choose(self, at)?.map_or(Ok(None), |reference| env.view(reference, at))
    }
}

impl Resolve for Field {
    type To = Value;
    fn resolve(&self, env: &Env<'_, '_>, at: &At<'_>) -> Result<Value, Error> {
        Ok(match self {
            Self::Number(number) => Value::Number(Number::Real(*number)),
            Self::Formula(formula) => Value::Number(env.value(formula, at)?),
            Self::List(list) => Value::List(list.resolve(env, at)?),
            Self::Age { age } => Value::Age(age.resolve(env, &at.key("age"))?.resource),
            Self::Input { input, element } => {
                let element = element.resolve(env, &at.key("element"))?;
                Value::Input(env.input(input, at)?, element)
            }
        })
    }
}

impl Resolve for Indirect {
    type To = (usize, u64);
    fn resolve(&self, env: &Env<'_, '_>, at: &At<'_>) -> Result<(usize, u64), Error> {
        let buffer = self.buffer.resolve(env, &at.key("buffer"))?.resource;
        Ok((buffer, self.offset.resolve(env, &at.key("offset"))?))
    }
}

impl<'d> Env<'_, 'd> {
    /// Notes an error: with one, the frame is none, and all that is done is to look for more.
    fn note<T>(&self, result: Result<T, Error>) -> Option<T> {
        result.map_err(|error| self.of.errors.borrow_mut().push(error)).ok()
    }

    /// Whether a part of the frame runs; what is of no part always does.
    fn runs(&self, part: &str) -> bool {
        let parts = &self.of.configuration.parts;
        part.is_empty() || parts.as_ref().is_none_or(|parts| parts.contains(part))
    }

    /// Declares what a scope has and runs its steps.
    fn scope(&self, context: &Context) {
        let (scope, at) = (self.scope, self.scope.at());
        let declare = |table: &'static str, name: &String, known: Result<Known<'d>, Error>| {
            let full = format!("{}{name}", scope.prefix);
            let at = at.key(table);
            let known = self.note(known).unwrap_or(Known::Absent);
            if self.of.known.borrow_mut().insert(full.clone(), known).is_some() {
                self.note(at.key(name).form::<()>(format!("`{full}` is declared twice")));
            }
        };
        for (name, choice) in &scope.template.alias {
            declare("alias", name, Ok(Known::Alias(Rc::clone(scope), choice)));
        }
        for (name, resource) in &scope.template.resource {
            let at = at.key("resource");
            let full = format!("{}{name}", scope.prefix);
            let known = if context.run {
                self.resource(full, resource, &at.key(name), &context.part)
            } else {
                Ok(Known::Absent)
            };
            declare("resource", name, known);
        }
        self.steps("step", &scope.template.step, &at, context);
    }

    fn resource(
        &self,
        name: String,
        resource: &description::Resource,
        at: &At<'_>,
        part: &str,
    ) -> Result<Known<'d>, Error> {
        if !self.holds(resource.when.as_ref(), at)? {
            return Ok(Known::Absent);
        }
        // What is wrong stands for what it should be, so that no error follows from it.
        let (kind, bytes) = self.note(self.kind(resource, at)).unwrap_or_else(|| {
            let (format, size, layers, levels) = (String::new(), [0; 2], 0, u64::MAX);
            (Kind::Texture { format, size, layers, levels }, 0)
        });
        let part = resource.part.as_deref().unwrap_or(part).to_owned();
        let supplied = self.of.configuration.supplied.contains(&name) || !self.runs(&part);
        if resource.kept && (supplied || resource.flip) {
            return at.form("what is kept is neither supplied by the host nor a pair");
        }
        let (external, kept) = (resource.external || supplied, resource.kept);
        let cases = match resource.texture.as_ref().map(|texture| &texture.format) {
            Some(Choice::Cases(cases)) => &cases[..],
            _ => &[],
        };
        let other = |case: &description::Case<String>| {
            let own = matches!(&kind, Kind::Texture { format, .. } if *format == case.value);
            case.when
                .as_ref()
                .filter(|_| !own)
                .map(|when| format!("; {} where {}", case.value, when.text))
        };
        let other_formats: Vec<_> = cases.iter().filter_map(other).collect();
        let resources = &mut self.of.frame.borrow_mut().resources;
        let first = resources.len();
        let suffixes: &[&str] = if resource.flip { &[".0", ".1"] } else { &[""] };
        resources.extend(suffixes.iter().map(|suffix| {
            let (name, part, kind) = (format!("{name}{suffix}"), part.clone(), kind.clone());
            let other_formats = other_formats.clone();
            Resource { name, part, kind, bytes, external, kept, other_formats }
        }));
        Ok(if resource.flip { Known::Pair(first, 0) } else { Known::One(first) })
    }

    /// What a resource is, and its bytes.
    fn kind(&self, resource: &description::Resource, at: &At<'_>) -> Result<(Kind, u64), Error> {
        let size = |factors: &[u64]| {
            let product = factors.iter().try_fold(1_u64, |a, &b| a.checked_mul(b));
            product
                .ok_or_else(|| at.error(Problem::Arithmetic("its bytes exceed 64 bits".to_owned())))
        };
        Ok(match (&resource.buffer, &resource.texture, &resource.sampler) {
            (Some(buffer), None, None) => {
                let at = at.key("buffer");
                let length = buffer.length.resolve(self, &at.key("length"))?;
                let stride = buffer.stride.resolve(self, &at.key("stride"))?;
                let initial = buffer.initial.clone();
                (Kind::Buffer { length, stride, initial }, size(&[length, stride])?)
            }
            (None, Some(texture), None) => {
                let at = at.key("texture");
                let format = texture.format.resolve(self, &at.key("format"))?.unwrap_or_default();
                let Some(texel) = texel_bytes(&format) else {
                    return at.key("format").unknown("format", &format, []);
                };
                let sides = texture.size.resolve(self, &at.key("size"))?;
                let layers = texture.layers.resolve(self, &at.key("layers"))?;
                let levels = texture.levels.resolve(self, &at.key("levels"))?;
                let most = u64::from(u64::BITS - sides[0].max(sides[1]).leading_zeros());
                if levels == 0 || levels > most {
                    let form = format!("{levels} levels; expected 1 to {most}");
                    return Err(at.key("levels").error(Problem::Form(form)));
                }
                let mut bytes = 0_u64;
                for level in 0..levels {
                    let [width, height] = sides.map(|side| (side >> level).max(1));
                    bytes = bytes.saturating_add(size(&[width, height, layers, texel])?);
                }
                (Kind::Texture { format, size: sides, layers, levels }, bytes)
            }
            (None, None, Some(sampler)) => (Kind::Sampler { filter: *sampler }, 0),
            _ => {
                return at.form("a resource is one of a buffer, a texture and a sampler");
            }
        })
    }

    fn steps(&self, key: &str, steps: &'d [description::Step], at: &At<'_>, context: &Context) {
        for (index, step) in steps.iter().enumerate() {
            self.note(self.step(step, &at.item(key, index), context.clone()));
        }
    }

    fn step(
        &self,
        step: &'d description::Step,
        at: &At<'_>,
        mut context: Context,
    ) -> Result<(), Error> {
        context.run = context.run && self.holds(step.when.as_ref(), at)?;
        if let Some(part) = &step.part {
            context.part.clone_from(part);
        }
        if let Some(label) = &step.label {
            context.label = self.scope.prefix.replace('_', " ") + label;
        }
        let runs = context.run && self.runs(&context.part);
        if let Some(new) = step.new.as_ref().filter(|_| runs) {
            let at = at.key("new");
            let index = new.resolve(self, &at)?.resource;
            if self.of.frame.borrow().resources.get(index).is_none_or(|new| !new.kept) {
                return at.form("what may be new is a resource that is kept");
            }
            context.new = Some(index);
        }
        let action = match (&step.pass, &step.clear, &step.template, step.steps.is_empty()) {
            (Some(pass), None, None, true) if runs => self.pass(step, pass, at)?,
            (None, Some(clear), None, true) if runs => Action::Clear(
                clear.resolve(self, &at.key("clear"))?.resource,
                step.bytes.resolve(self, &at.key("bytes"))?,
            ),
            (Some(_), None, None, true) | (None, Some(_), None, true) => return Ok(()),
            (None, None, Some(template), true) => {
                return self.template(step, template, at, &context);
            }
            (None, None, None, false) => return self.group(step, at, &context),
            _ => {
                return at.form("a step is one of `pass`, `clear`, `use` and `steps`");
            }
        };
        let Context { label, part, new, .. } = context;
        let step = Step { place: at.path(), label, part, new, action };
        self.of.frame.borrow_mut().steps.push(step);
        Ok(())
    }

    fn template(
        &self,
        step: &'d description::Step,
        name: &str,
        at: &At<'_>,
        context: &Context,
    ) -> Result<(), Error> {
        let known = &self.of.description.template;
        let Some(template) = known.get(name) else {
            return at.key("use").unknown("template", name, known.keys());
        };
        let mut outer = Some(self.scope);
        for _ in 0..16 {
            outer = outer.and_then(|scope| scope.caller.as_ref()).map(|caller| &caller.scope);
        }
        if outer.is_some() || self.round.is_some() {
            return at.key("use").form("a template is used in no repetition, and not by itself");
        }
        let scope = Rc::new(Scope {
            prefix: format!("{}{}", self.scope.prefix, step.prefix),
            caller: Some(Caller { scope: Rc::clone(self.scope), step, path: at.path() }),
            ..Scope::of(name, template)
        });
        Env::new(self.of, &scope).scope(context);
        Ok(())
    }

    fn group(
        &self,
        step: &'d description::Step,
        at: &At<'_>,
        context: &Context,
    ) -> Result<(), Error> {
        if !context.run || step.repeat.is_none() {
            self.steps("steps", &step.steps, at, context);
            return Ok(());
        }
        let mut pairs = Vec::new();
        for (index, pair) in step.flip.iter().enumerate() {
            let at = at.item("flip", index);
            let (name, _, known) = self.target(&Reference::new(pair), &at)?;
            if !matches!(known, Known::Pair(..)) {
                return at.unknown("pair", pair, []);
            }
            pairs.push(name);
        }
        for number in 0..self.rounds(step.repeat.as_ref(), at)? {
            let (index, lets, used) = (step.index.as_deref(), Some(&step.lets), &Cell::new(false));
            let round = Round { index, number, used, lets, at, outer: self.round };
            Env { round: Some(&round), ..*self }.steps("steps", &step.steps, at, context);
            for pair in &pairs {
                if let Some(Known::Pair(_, front)) = self.of.known.borrow_mut().get_mut(pair) {
                    *front = 1 - *front;
                }
            }
        }
        Ok(())
    }

    fn rounds(&self, repeat: Option<&Formula>, at: &At<'_>) -> Result<u64, Error> {
        let at = at.key("repeat");
        let rounds = repeat.map_or(Ok(1), |repeat| repeat.resolve(self, &at))?;
        let many =
            || at.error(Problem::Arithmetic(format!("{rounds} rounds; at most {MAXIMUM_ROUNDS}")));
        if rounds > MAXIMUM_ROUNDS { Err(many()) } else { Ok(rounds) }
    }

    fn pass(&self, step: &'d description::Step, pass: &str, at: &At<'_>) -> Result<Action, Error> {
        if let (None, Some(draw)) = (&step.dispatch, &step.draw) {
            return self.draw(step, draw, pass, at).map(Box::new).map(Action::Draw);
        }
        let groups = step.dispatch.resolve(self, &at.key("dispatch"))?;
        let size = match (groups, step.indirect.resolve(self, &at.key("indirect"))?, &step.draw) {
            (Some(groups), None, None) => Size::Groups(groups),
            (None, Some((buffer, offset)), None) => Size::Indirect(buffer, offset),
            _ => {
                return at.form("a pass has one of `dispatch`, `indirect` and `draw`");
            }
        };
        let group = self.bindings(step, at)?;
        let constants = step.constants.resolve(self, &at.key("constants"))?;
        let (variant, entry) = (self.variant(step, pass, at)?, step.entry.clone());
        Ok(Action::Dispatch(Dispatch { variant, entry, constants, group, size }))
    }

    fn variant(&self, step: &description::Step, pass: &str, at: &At<'_>) -> Result<Variant, Error> {
        let Description { passes, axes, exclusion, .. } = self.of.description;
        let Some(of_pass) = passes.get(pass) else {
            return at.key("pass").unknown("pass", pass, passes.keys());
        };
        let at = at.key("axes");
        if let Some(axis) = step.axes.keys().find(|axis| !of_pass.contains(axis)) {
            return at.key(axis).unknown("axis", axis, of_pass);
        }
        let (mut variant, id) = (Variant::default(), pass.to_owned());
        (variant.pass, variant.id) = (id.clone(), id);
        for axis in of_pass {
            let at = at.key(axis);
            let own = step.axes.get(axis).map(|choice| choice.resolve(self, &at)).transpose()?;
            let value = own.flatten().map_or_else(|| self.axis(axis, &at), Ok)?;
            let known = axes.get(axis);
            let values = known.map_or(&[][..], |axis| &axis.values);
            if !values.contains(&value) {
                return at.unknown("value", &value, values);
            }
            if !known.is_some_and(|axis| axis.implied && axis.default == value) {
                variant.id += &format!("-{value}");
            }
            variant.axes.push((axis.clone(), value));
        }
        if let Some(rule) =
            exclusion.iter().find(|of| of.excludes(pass, |axis| variant.value(axis)))
        {
            let text = format!("`{variant}` is excluded by `{}`: {}", rule.name, rule.reason);
            return Err(at.error(Problem::Requirement(text)));
        }
        Ok(variant)
    }

    fn draw(
        &self,
        step: &'d description::Step,
        draw: &description::Draw,
        pass: &str,
        at_step: &At<'_>,
    ) -> Result<Draw, Error> {
        let at = at_step.key("draw");
        let kinds = match &draw.list {
            None => BTreeSet::from([Table::new()]),
            Some(list) => {
                let known = &self.of.description.draws;
                if !known.contains_key(list) {
                    return at.key("list").unknown("list of draws", list, known.keys());
                }
                self.of.configuration.draws.get(list).cloned().unwrap_or_default()
            }
        };
        let mut variants = Vec::new();
        for axes in &kinds {
            let env = Env { axes: Some(axes), ..*self };
            let fragment = draw.fragment.as_ref();
            let fragment = fragment.map(|of| of.resolve(&env, &at.key("fragment"))).transpose()?;
            variants.push((env.variant(step, pass, at_step)?, fragment.flatten()));
        }
        let (mut calls, mut shared) = (Vec::new(), None);
        for number in 0..self.rounds(draw.repeat.as_ref(), &at)? {
            let (index, used) = (draw.index.as_deref(), &Cell::new(false));
            let round = Round { index, number, used, lets: None, at: &at, outer: self.round };
            let env = Env { round: Some(&round), ..*self };
            let group = shared.map_or_else(|| env.bindings(step, at_step), Ok)?;
            // What does not depend on the call is the same for all of them.
            shared = (!used.get()).then_some(group);
            let count = draw.count.resolve(&env, &at.key("count"))?;
            let indirect = step.indirect.resolve(&env, &at_step.key("indirect"))?;
            let geometry = match (&draw.list, count, indirect) {
                (Some(_), None, None) => Geometry::List,
                (None, None, Some((buffer, offset))) => Geometry::Indirect(buffer, offset),
                (None, Some(count), None) => {
                    let instances = draw.instances.resolve(&env, &at.key("instances"))?;
                    Geometry::Direct(count, instances.unwrap_or([0, 1]))
                }
                _ => {
                    return at.form("a draw has one of `list`, `count` and the step's `indirect`");
                }
            };
            let viewport = draw.viewport.resolve(&env, &at.key("viewport"))?;
            calls.push(Call { group, viewport, geometry });
        }
        let target = |target: &Reference, key, index: Option<usize>| {
            let at = index.map_or_else(|| at.key(key), |index| at.item(key, index));
            target.resolve(self, &at.key("target"))
        };
        let (color, depth) = (draw.color.iter().enumerate(), draw.depth.as_ref());
        let vertices = draw.vertices.iter().enumerate().map(|(index, vertices)| {
            let at = at.item("vertices", index);
            vertices.buffer.resolve(self, &at.key("buffer"))
        });
        Ok(Draw {
            variants,
            color: color
                .map(|(i, of)| target(&of.target, "color", Some(i)))
                .collect::<Result<_, _>>()?,
            depth: depth.map(|of| target(&of.target, "depth", None)).transpose()?,
            vertices: vertices.collect::<Result<_, _>>()?,
            indices: draw.indices.resolve(self, &at.key("indices"))?,
            description: draw.clone(),
            calls,
        })
    }

    /// The index of what a step binds.
    fn bindings(&self, step: &description::Step, at: &At<'_>) -> Result<usize, Error> {
        let views = step.bind.resolve(self, &at.key("bind"))?;
        let given = |(name, view): (_, Option<View>)| Some((name, Binding::View(view?)));
        let mut group: Table<Binding> = views.into_iter().filter_map(given).collect();
        for (binding, name) in &step.uniforms {
            let scopes = [self.scope, &self.of.root].into_iter();
            let found =
                scopes.filter_map(|of| of.template.uniform.get(name).map(|fields| (of, fields)));
            let Some((of, fields)) = found.into_iter().next() else {
                let at = at.key("uniforms");
                let known = self.scope.template.uniform.keys();
                return at.key(binding).unknown("uniform", name, known);
            };
            let at = of.at();
            let at = at.key("uniform");
            let members = fields.resolve(self, &at.key(name))?;
            let uniform = index_of(&mut self.of.frame.borrow_mut().uniforms, members);
            group.insert(binding.clone(), Binding::Uniform(uniform));
        }
        Ok(index_of(&mut self.of.frame.borrow_mut().groups, group))
    }
}

/// The index of an item of a list, to which it is added if it is not there.
fn index_of<T: PartialEq>(list: &mut Vec<T>, item: T) -> usize {
    // From the end, for what is shared was mostly used a moment ago.
    list.iter().rposition(|known| *known == item).unwrap_or_else(|| {
        list.push(item);
        list.len() - 1
    })
}

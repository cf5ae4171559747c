//! From a description and a configuration to a frame.

use std::collections::BTreeSet;

use crate::configuration::Configuration;
use crate::description::{self, Choice, Description, Table};
use crate::error::Kind::{Illegal, Invalid, Unknown};
use crate::error::{Errors, unknown};
use crate::formula::Formula;
use crate::frame::{
    Action, Binding, Call, Dispatch, Draw, Frame, Geometry, Kind, Resource, Size, Step, Variant,
    texel_bytes,
};
use crate::scope::{Env, Evaluation};

/// Rounds of a repetition and calls of a render pass at most.
const MAXIMUM_ROUNDS: u64 = 1 << 16;

impl Description {
    /// The frame of a configuration.
    ///
    /// # Errors
    ///
    /// Everything that is wrong with the configuration, and with the description as far as the configuration shows it.
    pub fn evaluate(&self, configuration: &Configuration) -> Result<Frame, Errors> {
        let mut of = Evaluation::new(self, configuration);
        of.check();
        of.frame.get_mut().reads.clear();
        for (name, resource) in &self.resource {
            let made = Env::new(&of, &["resource", name]).made(name, resource);
            let resources = &mut of.frame.get_mut().resources;
            of.known.insert(name, made.is_some().then_some(resources.len()));
            resources.extend(made);
        }
        Env::new(&of, &["step"]).steps(&self.step);
        of.finish()
    }
}

impl Evaluation<'_> {
    /// Notes what a configuration names that nothing declares, parameters out of their ranges, and what excludes it.
    fn check(&self) {
        let Evaluation { description, configuration, .. } = self;
        for (name, value) in &configuration.axes {
            let env = Env::new(self, &["axes", name]);
            env.noted(env.has(name, value));
        }
        for name in configuration.facts.keys().filter(|name| !description.facts.contains(*name)) {
            let env = Env::new(self, &["facts", name]);
            env.wrong(Unknown, unknown("fact", name, &description.facts));
        }
        for (name, number) in &configuration.parameters {
            let env = Env::new(self, &["parameters", name]);
            let parameter = env.entry(&description.parameter, "parameter", name);
            if let Some(parameter) = parameter.filter(|one| !one.allows(*number)) {
                let text =
                    format!("parameter `{name}` is {number}; expected {}", parameter.range());
                env.wrong(Invalid, text);
            }
        }
        for (index, rule) in description.exclusion.iter().enumerate() {
            let env = Env::new(self, &["exclusion", &index.to_string()]);
            if rule.passes.is_empty() && env.number(&rule.when) != 0 {
                env.wrong(Illegal, format!("invalid configuration: {}", rule.reason));
            }
        }
    }
}

impl<'a> Env<'a> {
    /// A resource; nothing if it does not exist in the configuration.
    fn made(&self, name: &str, resource: &description::Resource) -> Option<Resource> {
        if !self.holds(&resource.when) {
            return None;
        }
        let (kind, bytes) = self.kind(&resource.kind);
        let (name, part, kept) = (name.to_owned(), resource.part.clone(), resource.kept);
        let supplied = self.of.configuration.supplied.contains(&name) || !self.runs(&part);
        if kept && supplied {
            self.wrong(Invalid, "what is kept is not supplied by the host");
        }
        let external = resource.external || supplied;
        let formats = match &resource.kind {
            description::Kind::Texture { format: Choice::Cases(cases), .. } => cases.clone(),
            _ => Vec::new(),
        };
        Some(Resource { name, part, kind, bytes, external, kept, formats })
    }

    /// What a resource is, and its bytes.
    fn kind(&self, kind: &description::Kind) -> (Kind, u64) {
        let product = |factors: &[u64]| factors.iter().try_fold(1_u64, |a, &b| a.checked_mul(b));
        let (kind, bytes) = match kind {
            description::Kind::Buffer { length, stride, initial } => {
                let (length, stride) = (self.number(length), self.number(stride));
                let bytes = product(&[length, stride]);
                (Kind::Buffer { length, stride, initial: initial.clone() }, bytes)
            }
            description::Kind::Texture { format, size: sides, layers, levels } => {
                let format = self.choose(format).cloned().unwrap_or_default();
                let unknown = || self.error(Unknown, unknown("format", &format, []));
                let texel = self.noted(texel_bytes(&format).ok_or_else(unknown)).unwrap_or(0);
                let sides @ [width, height] = self.numbers(sides);
                let (layers, mut levels) = (self.number(layers), self.number(levels));
                let maximum = u64::from(u64::BITS - width.max(height).leading_zeros());
                if levels == 0 || levels > maximum {
                    self.wrong(Invalid, format!("{levels} levels; expected 1 to {maximum}"));
                    levels = maximum;
                }
                let bytes = (0..levels).try_fold(0_u64, |sum, level| {
                    let [width, height] = sides.map(|side| (side >> level).max(1));
                    sum.checked_add(product(&[width, height, layers, texel])?)
                });
                (Kind::Texture { format, size: sides, layers, levels }, bytes)
            }
            description::Kind::Sampler(filter) => (Kind::Sampler(*filter), Some(0)),
        };
        let overflow = || self.error(Invalid, "its bytes exceed 64 bits");
        (kind, self.noted(bytes.ok_or_else(overflow)).unwrap_or(0))
    }

    /// Runs steps, whose list is at the place.
    fn steps(&self, steps: &'a [description::Step]) {
        for (index, step) in steps.iter().enumerate() {
            let env = self.below(index.to_string());
            if !env.holds(&step.when) {
                continue;
            }
            let action = match (&step.pass, &step.clear, step.steps.is_empty()) {
                (None, None, false) => {
                    let group = env.below("steps".to_owned());
                    group.repeat(&step.repeat, &step.index, |env| env.steps(&step.steps));
                    continue;
                }
                (Some(_), None, true) | (None, Some(_), true) if !env.runs(&step.part) => continue,
                (Some(pass), None, true) => env.pass(step, pass),
                (None, Some(clear), true) => {
                    Some(Action::Clear(env.target(clear).resource, env.option(&step.bytes)))
                }
                _ => {
                    env.wrong(Invalid, "a step is one of `pass`, `clear` and `steps`");
                    None
                }
            };
            let new = step.new.as_ref().map(|name| env.kept(name));
            let (place, label, part) = (env.place.to_vec(), step.label.clone(), step.part.clone());
            let step = action.map(|action| Step { place, label, part, new, action });
            self.of.frame.borrow_mut().steps.extend(step);
        }
    }

    /// Does something in each round of a repetition.
    fn repeat(&self, times: &Option<Formula>, index: &Option<String>, mut run: impl FnMut(Env)) {
        let rounds = self.option(times).unwrap_or(1);
        if rounds > MAXIMUM_ROUNDS {
            self.wrong(Invalid, format!("{rounds} rounds; at most {MAXIMUM_ROUNDS}"));
        }
        for number in 0..rounds.min(MAXIMUM_ROUNDS) {
            let round = index.as_ref().map(|index| (index.as_str(), number));
            let rounds: Vec<_> = self.rounds.iter().copied().chain(round).collect();
            run(Env { rounds: &rounds, ..self.clone() });
        }
    }

    fn pass(&self, step: &description::Step, pass: &str) -> Option<Action> {
        let size = match (&step.dispatch, &step.indirect, &step.draw) {
            (None, _, Some(draw)) => {
                return Some(Action::Draw(Box::new(self.draw(step, draw, pass))));
            }
            (Some(groups), None, None) => Size::Groups(self.numbers(groups)),
            (None, Some(buffer), None) => {
                Size::Indirect(self.target(buffer).resource, self.option(&step.offset).unwrap_or(0))
            }
            _ => {
                self.wrong(Invalid, "a pass has one of `dispatch`, `indirect` and `draw`");
                return None;
            }
        };
        let group = self.bindings(step);
        let constants = step.constants.iter();
        let constants = constants.map(|(name, of)| (name.clone(), self.number(of))).collect();
        let (variant, entry) = (self.variant(step, pass), step.entry.clone());
        Some(Action::Dispatch(Dispatch { variant, entry, constants, group, size }))
    }

    fn variant(&self, step: &description::Step, pass: &str) -> Variant {
        let Description { passes, axes, exclusion, .. } = self.of.description;
        let mut variant = Variant { pass: pass.to_owned(), axes: Vec::new(), id: pass.to_owned() };
        let Some(of_pass) = self.entry(passes, "pass", pass) else { return variant };
        for axis in of_pass {
            let own = step.axes.get(axis).and_then(|choice| self.choose(choice));
            let value = own.or_else(|| self.axis(axis)).cloned().unwrap_or_default();
            self.noted(self.has(axis, &value));
            if !axes.get(axis).is_some_and(|axis| axis.implied && axis.default == value) {
                variant.id += &format!("-{value}");
            }
            variant.axes.push((axis.clone(), value));
        }
        let values = variant.axes.iter().cloned().collect();
        let env = Env { axes: Some(&values), ..self.clone() };
        let mut rules = exclusion.iter().filter(|rule| rule.passes.iter().any(|of| of == pass));
        if let Some(rule) = rules.find(|rule| env.number(&rule.when) != 0) {
            let text = format!("`{}` is excluded by `{}`: {}", variant.id, rule.name, rule.reason);
            self.wrong(Illegal, format!("invalid configuration: {text}"));
        }
        variant
    }

    fn draw(&self, step: &description::Step, draw: &description::Draw, pass: &str) -> Draw {
        let kinds = match &draw.list {
            None => BTreeSet::from([Table::new()]),
            Some(list) => {
                self.entry(&self.of.description.draws, "list of draws", list);
                self.of.configuration.draws.get(list).cloned().unwrap_or_default()
            }
        };
        let variant = |axes| {
            let env = Env { axes: Some(axes), ..self.clone() };
            let fragment = draw.fragment.as_ref().and_then(|of| env.choose(of));
            (env.variant(step, pass), fragment.cloned())
        };
        let (mut calls, mut shared) = (Vec::new(), None);
        self.repeat(&draw.repeat, &draw.index, |env| {
            // What does not depend on the call is the same for all of them.
            let read = self.of.rounds_read.get();
            let group = shared.unwrap_or_else(|| env.bindings(step));
            shared = (self.of.rounds_read.get() == read).then_some(group);
            let geometry = match (&draw.list, &draw.count, &step.indirect) {
                (Some(_), None, None) => Geometry::List,
                (None, None, Some(buffer)) => {
                    let offset = env.option(&step.offset).unwrap_or(0);
                    Geometry::Indirect(env.target(buffer).resource, offset)
                }
                (None, Some(count), None) => {
                    let instances = draw.instances.as_ref().map(|of| env.numbers(of));
                    Geometry::Direct(env.number(count), instances.unwrap_or([0, 1]))
                }
                _ => {
                    env.wrong(Invalid, "a draw has one of `list`, `count` and `indirect`");
                    Geometry::List
                }
            };
            let viewport = draw.viewport.as_ref().map(|of| env.numbers(of));
            calls.push(Call { group, viewport, geometry });
        });
        let target = |of| self.target(of);
        Draw {
            variants: kinds.iter().map(variant).collect(),
            color: draw.color.iter().map(|of| target(&of.target)).collect(),
            depth: draw.depth.as_ref().map(|of| target(&of.target)),
            vertices: draw.vertices.iter().map(|of| of.buffer.as_ref().map(target)).collect(),
            indices: draw.indices.as_ref().map(target),
            description: draw.clone(),
            calls,
        }
    }

    /// The index of what a step binds.
    fn bindings(&self, step: &description::Step) -> usize {
        let view = |(name, of): (&String, _)| Some((name.clone(), Binding::View(self.view(of)?)));
        let mut group: Table<Binding> = step.bind.iter().filter_map(view).collect();
        for (binding, name) in &step.uniforms {
            let env = self.at(&["uniform", name]);
            let members = self.entry(&self.of.description.uniform, "uniform", name);
            let value = |(name, of): (&String, _)| (name.clone(), env.field(of));
            let members = members.into_iter().flatten().map(value).collect();
            let uniform = index_of(&mut self.of.frame.borrow_mut().uniforms, members);
            group.insert(binding.clone(), Binding::Uniform(uniform));
        }
        index_of(&mut self.of.frame.borrow_mut().groups, group)
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

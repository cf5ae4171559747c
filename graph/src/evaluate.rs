//! From a description and a configuration to a frame.

use std::cell::Cell;
use std::collections::BTreeSet;

use crate::configuration::Configuration;
use crate::description::{self, Choice, Description, Filter, Table, Texture};
use crate::error::Kind::{Illegal, Invalid, Unknown};
use crate::error::{Errors, unknown};
use crate::formula::Formula;
use crate::frame::{
    Action, Binding, Call, Dispatch, Draw, Frame, Geometry, Kind, Resource, Size, Step, Variant,
    texel_bytes,
};
use crate::scope::{Env, Evaluation, Round};

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
        of.errors.get_mut().extend(configuration.check(self));
        for (index, rule) in self.exclusion.iter().enumerate() {
            let place = ["exclusion".to_owned(), index.to_string()];
            let env = Env::new(&of, &place);
            if rule.passes.is_empty() && env.number(&rule.when) != 0 {
                env.wrong(Illegal, format!("invalid configuration: {}", rule.reason));
            }
        }
        for (name, resource) in &self.resource {
            let place = ["resource".to_owned(), name.clone()];
            let made = Env::new(&of, &place).made(name, resource);
            of.known.insert(name, made.is_some().then_some(of.resources.len()));
            of.resources.extend(made);
        }
        let mut frame = Frame::default();
        Env::new(&of, &["step".to_owned()]).steps(&self.step, &mut frame);
        of.finish()?;
        Ok(Frame { resources: of.resources, ..frame })
    }
}

impl<'a> Env<'a> {
    /// A resource; nothing if it does not exist in the configuration.
    fn made(&self, name: &str, resource: &description::Resource) -> Option<Resource> {
        if !self.holds(&resource.when) {
            return None;
        }
        let (kind, bytes) = self.kind(resource);
        let (name, part, kept) = (name.to_owned(), resource.part.clone(), resource.kept);
        let supplied = self.of.configuration.supplied.contains(&name) || !self.runs(&part);
        if kept && supplied {
            self.wrong(Invalid, "what is kept is not supplied by the host");
        }
        let external = resource.external || supplied;
        let other_formats = match (&resource.texture, &kind) {
            (Some(Texture { format: Choice::Cases(cases), .. }), Kind::Texture { format, .. }) => {
                let others = cases.iter().filter(|case| case.value != *format);
                let conditions = others.filter_map(|case| Some((&case.value, case.when.as_ref()?)));
                conditions.map(|(format, when)| format!("; {format} where {when}")).collect()
            }
            _ => Vec::new(),
        };
        Some(Resource { name, part, kind, bytes, external, kept, other_formats })
    }

    /// What a resource is, and its bytes.
    fn kind(&self, resource: &description::Resource) -> (Kind, u64) {
        let size = |factors: &[u64]| {
            let product = factors.iter().try_fold(1_u64, |a, &b| a.checked_mul(b));
            product.unwrap_or_else(|| {
                self.wrong(Invalid, "its bytes exceed 64 bits");
                0
            })
        };
        match (&resource.buffer, &resource.texture, resource.sampler) {
            (Some(buffer), None, None) => {
                let (length, stride) = (self.number(&buffer.length), self.number(&buffer.stride));
                let initial = buffer.initial.clone();
                (Kind::Buffer { length, stride, initial }, size(&[length, stride]))
            }
            (None, Some(texture), None) => {
                let format = self.choose(&texture.format).cloned().unwrap_or_default();
                let texel = texel_bytes(&format).unwrap_or_else(|| {
                    self.wrong(Unknown, unknown("format", &format, []));
                    0
                });
                let sides @ [width, height] = self.numbers(&texture.size);
                let layers = self.number(&texture.layers);
                let mut levels = self.number(&texture.levels);
                let maximum = u64::from(u64::BITS - width.max(height).leading_zeros());
                if levels == 0 || levels > maximum {
                    self.wrong(Invalid, format!("{levels} levels; expected 1 to {maximum}"));
                    levels = maximum;
                }
                let bytes = (0..levels).map(|level| {
                    let [width, height] = sides.map(|side| (side >> level).max(1));
                    size(&[width, height, layers, texel])
                });
                let bytes = bytes.fold(0, u64::saturating_add);
                (Kind::Texture { format, size: sides, layers, levels }, bytes)
            }
            (None, None, Some(filter)) => (Kind::Sampler { filter }, 0),
            _ => {
                self.wrong(Invalid, "a resource is one of a buffer, a texture and a sampler");
                (Kind::Sampler { filter: Filter::Nearest }, 0)
            }
        }
    }

    /// Runs steps, whose list is at the place.
    fn steps(&self, steps: &'a [description::Step], frame: &mut Frame) {
        for (index, step) in steps.iter().enumerate() {
            let place = [self.place, &[index.to_string()]].concat();
            let env = Env { place: &place, ..*self };
            if !env.holds(&step.when) {
                continue;
            }
            match (&step.pass, &step.clear, step.steps.is_empty()) {
                (None, None, false) => env.group(step, frame),
                (Some(_), None, true) | (None, Some(_), true) if !env.runs(&step.part) => {}
                (Some(pass), None, true) => {
                    if let Some(action) = env.pass(step, pass, frame) {
                        env.add(step, action, frame);
                    }
                }
                (None, Some(clear), true) => {
                    let action = Action::Clear(env.target(clear).resource, env.option(&step.bytes));
                    env.add(step, action, frame);
                }
                _ => env.wrong(Invalid, "a step is one of `pass`, `clear` and `steps`"),
            }
        }
    }

    fn group(&self, step: &description::Step, frame: &mut Frame) {
        let place = [self.place, &["steps".to_owned()]].concat();
        for number in 0..self.rounds(&step.repeat) {
            let round = self.round(step.index.as_deref(), number);
            Env { place: &place, round: Some(&round), ..*self }.steps(&step.steps, frame);
        }
    }

    fn add(&self, step: &description::Step, action: Action, frame: &mut Frame) {
        let new = step.new.as_ref().and_then(|name| self.kept(name));
        let (label, part) = (step.label.clone(), step.part.clone());
        frame.steps.push(Step { place: self.place.to_vec(), label, part, new, action });
    }

    fn rounds(&self, repeat: &Option<Formula>) -> u64 {
        let rounds = self.option(repeat).unwrap_or(1);
        if rounds > MAXIMUM_ROUNDS {
            self.wrong(Invalid, format!("{rounds} rounds; at most {MAXIMUM_ROUNDS}"));
        }
        rounds.min(MAXIMUM_ROUNDS)
    }

    fn round(&self, index: Option<&'a str>, number: u64) -> Round<'a> {
        Round { index, number, used: Cell::new(false), outer: self.round }
    }

    fn pass(&self, step: &'a description::Step, pass: &str, frame: &mut Frame) -> Option<Action> {
        let size = match (&step.dispatch, &step.indirect, &step.draw) {
            (None, _, Some(draw)) => {
                return Some(Action::Draw(Box::new(self.draw(step, draw, pass, frame))));
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
        let group = self.bindings(step, frame);
        let constants = step.constants.iter();
        let constants = constants.map(|(name, of)| (name.clone(), self.number(of))).collect();
        let (variant, entry) = (self.variant(step, pass), step.entry.clone());
        Some(Action::Dispatch(Dispatch { variant, entry, constants, group, size }))
    }

    fn variant(&self, step: &description::Step, pass: &str) -> Variant {
        let Description { passes, axes, exclusion, .. } = self.of.description;
        let (mut variant, id) = (Variant::default(), pass.to_owned());
        (variant.pass, variant.id) = (id.clone(), id);
        let Some(of_pass) = self.entry(passes, "pass", pass) else { return variant };
        for axis in step.axes.keys().filter(|axis| !of_pass.contains(axis)) {
            self.wrong(Unknown, unknown("axis", axis, of_pass));
        }
        let mut values = Table::new();
        for axis in of_pass {
            let own = step.axes.get(axis).and_then(|choice| self.choose(choice));
            let value = own.or_else(|| self.axis(axis)).cloned().unwrap_or_default();
            let known = axes.get(axis);
            let all = known.map_or(&[][..], |axis| &axis.values);
            if !all.contains(&value) {
                self.wrong(Unknown, unknown("value", &value, all));
            }
            if !known.is_some_and(|axis| axis.implied && axis.default == value) {
                variant.id += &format!("-{value}");
            }
            variant.axes.push((axis.clone(), value.clone()));
            values.insert(axis.clone(), value);
        }
        let env = Env { axes: Some(&values), ..*self };
        let excludes = |rule: &&description::Exclusion| {
            rule.passes.iter().any(|of| of == pass) && env.number(&rule.when) != 0
        };
        if let Some(description::Exclusion { name, reason, .. }) = exclusion.iter().find(excludes) {
            let text = format!("`{variant}` is excluded by `{name}`: {reason}");
            self.wrong(Illegal, format!("invalid configuration: {text}"));
        }
        variant
    }

    fn draw(
        &self,
        step: &'a description::Step,
        draw: &'a description::Draw,
        pass: &str,
        frame: &mut Frame,
    ) -> Draw {
        let kinds = match &draw.list {
            None => BTreeSet::from([Table::new()]),
            Some(list) => {
                self.entry(&self.of.description.draws, "list of draws", list);
                self.of.configuration.draws.get(list).cloned().unwrap_or_default()
            }
        };
        let variant = |axes| {
            let env = Env { axes: Some(axes), ..*self };
            let fragment = draw.fragment.as_ref().and_then(|of| env.choose(of));
            (env.variant(step, pass), fragment.cloned())
        };
        let (mut calls, mut shared) = (Vec::new(), None);
        for number in 0..self.rounds(&draw.repeat) {
            let round = self.round(draw.index.as_deref(), number);
            let env = Env { round: Some(&round), ..*self };
            let group = shared.unwrap_or_else(|| env.bindings(step, frame));
            // What does not depend on the call is the same for all of them.
            shared = (!round.used.get()).then_some(group);
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
                    env.wrong(
                        Invalid,
                        "a draw has one of `list`, `count` and the step's `indirect`",
                    );
                    Geometry::List
                }
            };
            let viewport = draw.viewport.as_ref().map(|of| env.numbers(of));
            calls.push(Call { group, viewport, geometry });
        }
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
    fn bindings(&self, step: &description::Step, frame: &mut Frame) -> usize {
        let view = |(name, of): (&String, _)| Some((name.clone(), Binding::View(self.view(of)?)));
        let mut group: Table<Binding> = step.bind.iter().filter_map(view).collect();
        for (binding, name) in &step.uniforms {
            let members = self.entry(&self.of.description.uniform, "uniform", name);
            let members = members.into_iter().flatten();
            let place = ["uniform".to_owned(), name.clone()];
            let env = Env { place: &place, ..*self };
            let members = members.map(|(name, of)| (name.clone(), env.field(of))).collect();
            let uniform = index_of(&mut frame.uniforms, members);
            group.insert(binding.clone(), Binding::Uniform(uniform));
        }
        index_of(&mut frame.groups, group)
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

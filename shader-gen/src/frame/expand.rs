//! From a frame with templates to one without: every use of a template becomes resources and steps of its own.

use std::collections::BTreeMap;

use sglow_graph::Formula;
use sglow_graph::description::{self as flat, Description, Table};

use super::authored::{self, Authored, Choice, Field};
use super::formula::{self, Condition as _, apply, both, not, simple};
use super::scope::{
    Caller, Expansion, Fault, Here, Known, Origin, Path, Round, Scope, choice_of, mentions,
};

const ONE: Formula = Formula::Number(1);

/// Templates that stand in each other at most.
const MAXIMUM_DEPTH: usize = 16;

/// A frame without templates, and where what it has was written.
#[derive(Clone, Debug, Default)]
pub(crate) struct Expanded {
    pub(crate) description: Description,
    /// By the places of lets, uniforms, resources, steps and exclusions in the description.
    pub(crate) origins: BTreeMap<Path, Origin>,
    pub(crate) faults: Vec<Fault>,
}

/// A step with the steps in it, and where it was written.
struct Made {
    step: flat::Step,
    origin: Origin,
    steps: Vec<Made>,
}

/// What steps have from the groups and uses they stand in.
#[derive(Clone, Default)]
struct Context {
    label: String,
    part: String,
    new: Option<String>,
    /// When they run.
    when: Option<Formula>,
    depth: usize,
}

impl Context {
    /// A step that runs, with what it has from those around it.
    fn runs(&self, step: flat::Step, origin: &Origin) -> Made {
        let (label, part, new) = (self.label.clone(), self.part.clone(), self.new.clone());
        let step = flat::Step { label, part, new, ..step };
        Made { step, origin: origin.clone(), steps: Vec::new() }
    }
}

/// Expands a frame. `library` has what a library declares beside it: axes, passes, facts, presets, defaults, exclusions.
pub(crate) fn expand(authored: &Authored, library: Description) -> Expanded {
    let made = Description {
        parameter: authored.parameter.clone(),
        input: authored.input.clone(),
        draws: authored.draws.clone(),
        ..library
    };
    let taken = made.parameter.keys().chain(&made.facts).cloned().collect();
    let mut of = Expansion {
        authored,
        made,
        origins: BTreeMap::new(),
        faults: Default::default(),
        scopes: Vec::new(),
        known: BTreeMap::new(),
        taken,
    };
    let empty = authored::Template::default();
    let frame = authored.template.get("frame").unwrap_or(&empty);
    of.scopes.push(Scope::new(frame, Origin::default().at(&["template", "frame"])));
    // A host may read them by their names.
    of.taken.extend(frame.lets.keys().cloned());
    let here = Here { scope: 0, round: None };
    for (index, requirement) in authored.require.iter().enumerate() {
        let origin = Origin::default().at(&["require"]).item(index);
        let that = of.formula(here, &requirement.that, &origin.at(&["that"]));
        let place = vec!["exclusion".to_owned(), of.made.exclusion.len().to_string()];
        of.origins.insert(place, origin.at(&["that"]));
        let (name, reason) = (String::new(), requirement.reason.clone());
        of.made.exclusion.push(flat::Exclusion {
            name,
            passes: Vec::new(),
            when: not(that),
            reason,
        });
    }
    let steps = of.template(0, &Context::default());
    for name in frame.lets.keys() {
        let origin = of.scopes[0].base.at(&["let", name]);
        of.defined(0, name, &origin);
    }
    of.made.step = of.numbered(steps, &["step".to_owned()]);
    let Expansion { made: description, origins, faults, .. } = of;
    Expanded { description, origins, faults: faults.into_iter().collect() }
}

impl<'a> Expansion<'a> {
    /// The steps, with their places among the origins.
    fn numbered(&mut self, steps: Vec<Made>, path: &[String]) -> Vec<flat::Step> {
        let mut list = Vec::new();
        for (index, Made { step, origin, steps }) in steps.into_iter().enumerate() {
            let place = [path, &[index.to_string()]].concat();
            self.origins.insert(place.clone(), origin);
            let steps = self.numbered(steps, &[&place[..], &["steps".to_owned()]].concat());
            list.push(flat::Step { steps, ..step });
        }
        list
    }

    /// Declares what a template has, and makes its steps.
    fn template(&mut self, scope: usize, context: &Context) -> Vec<Made> {
        let Scope { template, base, prefix, .. } = &self.scopes[scope];
        let (template, base, prefix) = (*template, base.clone(), prefix.clone());
        for (name, choice) in &template.alias {
            self.declare(
                format!("{prefix}{name}"),
                Known::Alias(scope, choice),
                &base.at(&["alias", name]),
            );
        }
        for (name, resource) in &template.resource {
            let origin = base.at(&["resource", name]);
            let full = format!("{prefix}{name}");
            let known = self.resource(scope, &full, resource, &origin, context);
            self.declare(full, known, &origin);
        }
        let here = Here { scope, round: None };
        self.steps(here, &template.step, &base.at(&["step"]), context)
    }

    fn declare(&mut self, full: String, known: Known<'a>, origin: &Origin) {
        if self.known.insert(full.clone(), known).is_some() {
            self.wrong(origin.clone(), format!("`{full}` is declared twice"));
        }
    }

    fn resource(
        &mut self,
        scope: usize,
        full: &str,
        of: &authored::Resource,
        origin: &Origin,
        context: &Context,
    ) -> Known<'a> {
        let here = Here { scope, round: None };
        let own = self.option(here, of.when.as_ref(), &origin.at(&["when"]));
        let when = both(context.when.clone(), own);
        let kind = match (&of.buffer, &of.texture, of.sampler) {
            (Some(of), None, None) => flat::Kind::Buffer {
                length: self.formula(here, &of.length, &origin.at(&["buffer", "length"])),
                stride: self.formula(here, &of.stride, &origin.at(&["buffer", "stride"])),
                initial: of.initial.clone(),
            },
            (None, Some(of), None) => {
                let at = |key: &str| origin.at(&["texture", key]);
                let format = self.values(here, &of.format, &at("format"));
                flat::Kind::Texture {
                    format: choice_of(format).unwrap_or(flat::Choice::Cases(Vec::new())),
                    size: self.formulas(here, &of.size, &at("size")),
                    layers: self.option(here, of.layers.as_ref(), &at("layers")).unwrap_or(ONE),
                    levels: self.option(here, of.levels.as_ref(), &at("levels")).unwrap_or(ONE),
                }
            }
            (buffer, texture, filter) => {
                if filter.is_none() || buffer.is_some() || texture.is_some() {
                    let text = "a resource is one of a buffer, a texture and a sampler";
                    self.wrong(origin.clone(), text);
                }
                flat::Kind::Sampler(filter.unwrap_or(flat::Filter::Nearest))
            }
        };
        if of.kept && of.flip {
            self.wrong(origin.clone(), "what is kept is no pair");
        }
        if when.as_ref().is_some_and(Formula::is_never) {
            return Known::Never;
        }
        let made = flat::Resource {
            description: of.description.clone(),
            when,
            part: of.part.clone().unwrap_or_else(|| context.part.clone()),
            external: of.external,
            kept: of.kept,
            kind,
        };
        let suffixes: &[&str] = if of.flip { &[".0", ".1"] } else { &[""] };
        for suffix in suffixes {
            let name = format!("{full}{suffix}");
            self.origins.insert(vec!["resource".to_owned(), name.clone()], origin.clone());
            self.made.resource.insert(name, made.clone());
        }
        if of.flip { Known::Pair(Formula::Number(0)) } else { Known::One }
    }

    fn steps(
        &mut self,
        here: Here<'_>,
        steps: &'a [authored::Step],
        origin: &Origin,
        context: &Context,
    ) -> Vec<Made> {
        let mut made = Vec::new();
        for (index, step) in steps.iter().enumerate() {
            made.extend(self.step(here, step, &origin.item(index), context.clone()));
        }
        made
    }

    fn step(
        &mut self,
        here: Here<'_>,
        step: &'a authored::Step,
        origin: &Origin,
        mut context: Context,
    ) -> Vec<Made> {
        let when = self.option(here, step.when.as_ref(), &origin.at(&["when"]));
        let when = when.and_then(Formula::condition);
        context.when = both(context.when, when.clone());
        if let Some(part) = &step.part {
            context.part.clone_from(part);
        }
        if let Some(label) = &step.label {
            context.label = self.scopes[here.scope].prefix.replace('_', " ") + label;
        }
        if let Some(new) = &step.new {
            context.new = self.name(here, new, &origin.at(&["new"]));
        }
        let before = self.known.clone();
        let mut made = match (&step.pass, &step.clear, &step.template, step.steps.is_empty()) {
            (Some(pass), None, None, true) => {
                let work = self.pass(here, step, pass, origin);
                vec![context.runs(work, origin)]
            }
            (None, Some(clear), None, true) => {
                let clear = self.buffer(here, clear, &origin.at(&["clear"]));
                let bytes = self.option(here, step.bytes.as_ref(), &origin.at(&["bytes"]));
                vec![context.runs(flat::Step { clear, bytes, ..flat::Step::default() }, origin)]
            }
            (None, None, Some(name), true) => self.used(here, step, name, origin, &context),
            (None, None, None, false) => self.group(here, step, origin, &context),
            _ => {
                self.wrong(origin.clone(), "a step is one of `pass`, `clear`, `use` and `steps`");
                Vec::new()
            }
        };
        let Some(when) = when else { return made };
        // Pairs that change places in the step do so where it runs.
        for (name, known) in &mut self.known {
            if let (Known::Pair(after), Some(Known::Pair(before))) = (known, before.get(name))
                && after != before
            {
                let flips = [when.clone(), after.clone(), before.clone()];
                *after = simple(apply("select", flips));
            }
        }
        if when.is_never() {
            return Vec::new();
        }
        match &mut made[..] {
            [one] if one.step.when.is_none() => one.step.when = Some(when),
            [] => {}
            _ => {
                let group = flat::Step { when: Some(when), ..flat::Step::default() };
                made = vec![Made { step: group, origin: origin.clone(), steps: made }];
            }
        }
        made
    }

    /// The full name of a resource that is no choice.
    fn name(&mut self, here: Here<'_>, text: &str, origin: &Origin) -> Option<String> {
        let found = self.reference(here, text, origin);
        match &found[..] {
            [(None, Some(flat::Reference { resource, level: None }))] => Some(resource.clone()),
            [(None, None)] => None,
            _ => {
                self.wrong(origin.clone(), "expected the name of one resource");
                None
            }
        }
    }

    fn buffer(
        &mut self,
        here: Here<'_>,
        text: &str,
        origin: &Origin,
    ) -> Option<flat::Choice<flat::Reference>> {
        let choice = self.references(here, &Choice::Always(text.to_owned()), origin);
        // What does not exist is an error where the step runs.
        let absent = || flat::Reference { resource: text.to_owned(), level: None };
        choice.or_else(|| Some(flat::Choice::Always(absent())))
    }

    fn used(
        &mut self,
        here: Here<'_>,
        step: &'a authored::Step,
        name: &str,
        origin: &Origin,
        context: &Context,
    ) -> Vec<Made> {
        let known = &self.authored.template;
        let Some(template) = known.get(name) else {
            self.unknown(origin.at(&["use"]), "template", name, known.keys());
            return Vec::new();
        };
        if context.depth == MAXIMUM_DEPTH || here.round.is_some() {
            let text = "a template is used in no repetition, and not by itself";
            self.wrong(origin.at(&["use"]), text);
            return Vec::new();
        }
        let prefix = format!("{}{}", self.scopes[here.scope].prefix, step.prefix);
        let base = Origin { used: Some(origin.path.clone()), ..Origin::default() };
        let caller = Caller { scope: here.scope, step, origin: origin.clone() };
        let scope = self.scopes.len();
        self.scopes.push(Scope {
            stem: format!("{prefix}{name}"),
            prefix,
            caller: Some(caller),
            ..Scope::new(template, base.at(&["template", name]))
        });
        for (name, text) in &step.lets {
            let origin = origin.at(&["let", name]);
            let formula = self.formula(here, text, &origin);
            let formula = self.define(scope, name, formula, &origin);
            self.scopes[scope].given.insert(name.clone(), formula);
        }
        self.template(scope, &Context { depth: context.depth + 1, ..context.clone() })
    }

    fn group(
        &mut self,
        here: Here<'_>,
        step: &'a authored::Step,
        origin: &Origin,
        context: &Context,
    ) -> Vec<Made> {
        let inner = origin.at(&["steps"]);
        let Some(repeat) = &step.repeat else {
            return self.steps(here, &step.steps, &inner, context);
        };
        let repeat = self.formula(here, repeat, &origin.at(&["repeat"]));
        let own = step.index.as_deref();
        let index = self.own(here.scope, own.unwrap_or("round"));
        let index = self.free(&index);
        let names = own.map(|own| (own, index.as_str()));
        let (lets, outer) = (Some(&step.lets), here.round);
        let round = Round { index: names, lets, origin, outer };
        let within = Here { round: Some(&round), ..here };
        // How often pairs change places in a round, and so before the round and after the last one.
        let pairs: Vec<(String, Formula)> = self.flips(within, step, origin);
        let mut after = Vec::new();
        for (name, flips) in pairs {
            if mentions(&flips, &index, &self.made.lets) {
                self.wrong(
                    origin.at(&["flip"]),
                    format!("`{name}` changes places in some rounds alone"),
                );
            }
            if let Some(Known::Pair(before)) = self.known.get(&name).cloned() {
                let times = |rounds| simple(apply("*", [rounds, flips.clone()]));
                let sum = |rounds| simple(apply("+", [before.clone(), times(rounds)]));
                self.known.insert(name.clone(), Known::Pair(sum(formula::name(&index))));
                after.push((name, Known::Pair(sum(repeat.clone()))));
            }
        }
        let steps =
            self.steps(within, &step.steps, &inner, &Context { when: None, ..context.clone() });
        self.known.extend(after);
        let group = flat::Step { repeat: Some(repeat), index: Some(index), ..Default::default() };
        vec![Made { step: group, origin: origin.clone(), steps }]
    }

    /// How often pairs change places in a round of a group.
    fn flips(
        &mut self,
        here: Here<'_>,
        group: &'a authored::Step,
        origin: &Origin,
    ) -> Vec<(String, Formula)> {
        let mut flips: BTreeMap<String, Formula> = BTreeMap::new();
        let mut add = |name: String, times: Formula| {
            let sum = flips.remove(&name).unwrap_or(Formula::Number(0));
            flips.insert(name, simple(apply("+", [sum, times])));
        };
        for (index, pair) in group.flip.iter().enumerate() {
            let origin = origin.at(&["flip"]).item(index);
            match self.target(here.scope, pair, &origin) {
                Some((name, _, Known::Pair(_))) => add(name, Formula::Number(1)),
                Some(_) => self.unknown(origin, "pair", pair, []),
                None => {}
            }
        }
        for (index, step) in group.steps.iter().enumerate() {
            let origin = origin.at(&["steps"]).item(index);
            let Some(repeat) = step.repeat.as_ref().filter(|_| !step.steps.is_empty()) else {
                continue;
            };
            let repeat = self.formula(here, repeat, &origin.at(&["repeat"]));
            let when = self.option(here, step.when.as_ref(), &origin.at(&["when"]));
            for (name, times) in self.flips(here, step, &origin) {
                let times = simple(apply("*", [repeat.clone(), times]));
                let when = when.clone().unwrap_or(Formula::Number(1));
                add(name, simple(apply("select", [when, times, Formula::Number(0)])));
            }
        }
        flips.into_iter().collect()
    }

    fn pass(
        &mut self,
        here: Here<'_>,
        step: &'a authored::Step,
        pass: &str,
        origin: &Origin,
    ) -> flat::Step {
        let draw = step.draw.as_ref();
        let index = draw.and_then(|draw| draw.index.as_deref());
        let own = index.map(|index| self.own(here.scope, index));
        let own = own.map(|own| self.free(&own));
        let round =
            Round { index: index.zip(own.as_deref()), lets: None, origin, outer: here.round };
        let call = if draw.is_some() { Here { round: Some(&round), ..here } } else { here };
        let at = |key: &str, name: &str| origin.at(&[key, name]);
        let bind = step.bind.iter().filter_map(|(name, choice)| {
            Some((name.clone(), self.references(call, choice, &at("bind", name))?))
        });
        let bind = bind.collect();
        let uniforms = step.uniforms.iter().filter_map(|(name, uniform)| {
            Some((name.clone(), self.uniform(call, uniform, &at("uniforms", name))?))
        });
        let uniforms = uniforms.collect();
        let constants = step
            .constants
            .iter()
            .map(|(name, text)| (name.clone(), self.formula(here, text, &at("constants", name))));
        let constants = constants.collect();
        let dispatch = step.dispatch.as_ref();
        let dispatch = dispatch.map(|of| self.formulas(here, of, &origin.at(&["dispatch"])));
        let offset = step
            .indirect
            .as_ref()
            .map(|of| self.formula(call, &of.offset, &at("indirect", "offset")));
        flat::Step {
            pass: Some(pass.to_owned()),
            axes: self.axes(here, step, pass, origin),
            entry: step.entry.clone(),
            indirect: step
                .indirect
                .as_ref()
                .and_then(|of| self.buffer(call, &of.buffer, &at("indirect", "buffer"))),
            offset: offset.filter(|offset| *offset != Formula::Number(0)),
            draw: draw.map(|draw| self.draw(here, call, draw, own.clone(), &origin.at(&["draw"]))),
            bind,
            uniforms,
            constants,
            dispatch,
            ..flat::Step::default()
        }
    }

    /// The values of a pass's axes where they are not those of the configuration.
    fn axes(
        &mut self,
        here: Here<'_>,
        step: &authored::Step,
        pass: &str,
        origin: &Origin,
    ) -> Table<flat::Choice<String>> {
        let of_pass = self.made.passes.get(pass).cloned().unwrap_or_default();
        let list = step.draw.as_ref().and_then(|draw| draw.list.as_ref());
        let of_list = list.and_then(|list| self.made.draws.get(list)).cloned();
        let mut all = Table::new();
        for axis in of_pass.iter().chain(step.axes.keys()) {
            let origin = origin.at(&["axes", axis]);
            if !of_pass.is_empty() && !of_pass.contains(axis) {
                self.unknown(origin.clone(), "axis", axis, &of_pass);
            }
            let own = step.axes.get(axis);
            let mut cases = own.map_or_else(Vec::new, |own| self.values(here, own, &origin));
            // The host's draws have axes of their own.
            if !of_list.as_ref().is_some_and(|list| list.axes.contains(axis)) {
                cases.extend(self.axis(here.scope, axis, &origin));
            }
            let always = cases.iter().position(|(when, _)| when.is_none());
            cases.truncate(always.map_or(cases.len(), |index| index + 1));
            if let Some(choice) = choice_of(cases) {
                all.insert(axis.clone(), choice);
            }
        }
        all
    }

    /// The name of a uniform with these members; nothing if there is no such uniform.
    fn uniform(&mut self, here: Here<'_>, name: &str, origin: &Origin) -> Option<String> {
        let found = [here.scope, 0]
            .into_iter()
            .find_map(|scope| Some((scope, self.scopes[scope].template.uniform.get(name)?)));
        let Some((scope, fields)) = found else {
            let known = &self.scopes[here.scope].template.uniform;
            self.unknown(origin.clone(), "uniform", name, known.keys());
            return None;
        };
        let base = self.scopes[scope].base.at(&["uniform", name]);
        let members = fields
            .iter()
            .map(|(member, field)| (member.clone(), self.field(here, field, &base.at(&[member]))));
        let members: Table<flat::Field> = members.collect();
        let own = self.own(here.scope, name);
        let same =
            |(known, of): (&String, &Table<flat::Field>)| known.starts_with(&own) && *of == members;
        if let Some((known, _)) = self.made.uniform.iter().find(|one| same(*one)) {
            return Some(known.clone());
        }
        let numbered = (2..).map(|number| format!("{own}_{number}"));
        let mut names = std::iter::once(own.clone()).chain(numbered);
        let free = names.find(|name| !self.made.uniform.contains_key(name))?;
        self.origins.insert(vec!["uniform".to_owned(), free.clone()], base);
        self.made.uniform.insert(free.clone(), members);
        Some(free)
    }

    fn field(&mut self, here: Here<'_>, field: &Field, origin: &Origin) -> flat::Field {
        match field {
            Field::Formula(text) => flat::Field::Formula(self.formula(here, text, origin)),
            Field::Number(number) => flat::Field::Number(*number),
            Field::List(list) => flat::Field::List(
                list.iter()
                    .enumerate()
                    .map(|(index, field)| self.field(here, field, &origin.item(index)))
                    .collect(),
            ),
            Field::Input { input, element } => flat::Field::Input {
                input: self.input(here.scope, input, &origin.at(&["input"])),
                element: self.option(here, element.as_ref(), &origin.at(&["element"])),
            },
            Field::Age { age } => {
                let name = self.name(here, age, &origin.at(&["age"]));
                flat::Field::Age { age: name.unwrap_or_else(|| age.clone()) }
            }
        }
    }

    fn draw(
        &mut self,
        here: Here<'_>,
        call: Here<'_>,
        draw: &authored::Draw,
        index: Option<String>,
        origin: &Origin,
    ) -> flat::Draw {
        let target = |of: &mut Self, text: &str, origin: Origin| {
            let absent = flat::Choice::Cases(Vec::new());
            of.buffer(here, text, &origin).unwrap_or(absent)
        };
        let at = |key: &str| origin.at(&[key]);
        let fragment = draw.fragment.as_ref();
        let fragment = fragment.map(|of| self.values(here, of, &at("fragment")));
        let color = draw.color.iter().enumerate().map(|(index, of)| flat::Color {
            target: target(self, &of.target, at("color").item(index).at(&["target"])),
            clear: of.clear,
        });
        let color = color.collect();
        let depth = draw.depth.as_ref().map(|of| flat::Depth {
            target: target(self, &of.target, at("depth").at(&["target"])),
            clear: of.clear,
            compare: of.compare.clone(),
            write: of.write,
        });
        let vertices = draw.vertices.iter().enumerate().map(|(index, of)| {
            let origin = at("vertices").item(index).at(&["buffer"]);
            let buffer = of.buffer.as_ref().map(|of| target(self, of, origin));
            flat::Vertices { buffer, stride: of.stride, attributes: of.attributes.clone() }
        });
        let vertices = vertices.collect();
        flat::Draw {
            vertex: draw.vertex.clone(),
            fragment: fragment.and_then(choice_of),
            color,
            depth,
            vertices,
            indices: draw.indices.as_ref().map(|of| target(self, of, at("indices"))),
            list: draw.list.clone(),
            count: self.option(call, draw.count.as_ref(), &at("count")),
            instances: draw.instances.as_ref().map(|of| self.formulas(call, of, &at("instances"))),
            repeat: self.option(here, draw.repeat.as_ref(), &at("repeat")),
            index,
            viewport: draw.viewport.as_ref().map(|of| self.formulas(call, of, &at("viewport"))),
        }
    }
}

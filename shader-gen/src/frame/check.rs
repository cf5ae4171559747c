//! Whether the frame of a library fits what its variants bind, and nothing is read before it is written.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value};
use sglow_graph::Description;
use sglow_graph::frame::{Action, Binding, Draw, Frame, Kind, Step, Variant as Runs, View};

use crate::error::{Code, Diagnostic, Report};
use crate::frame::distinct::distinct;
use crate::library::Library;
use crate::manifest::{Access, Described, Dimension, Resource, SampleType};

/// Checks the frame, in every configuration that its conditions tell apart, against `variants`. A variant that is not
/// among them is taken to fit and to write all that it is given.
///
/// # Errors
///
/// Everything that does not fit: a binding that is given nothing, or what its kind, its format or its size does not fit; a
/// member of a uniform without a value; what is read before anything has written it. If all variants of a pass are
/// given, also names that none of them binds.
pub fn check(library: &Library, variants: &[Described]) -> Result<(), Report> {
    let Some(described) = library.frame() else { return Ok(()) };
    let places = described.places(library.sources());
    let mut diagnostics = described.faults(&places, 3);
    let mut checker = Checker {
        variants: variants.iter().map(|variant| (variant.id.as_str(), variant)).collect(),
        found: BTreeSet::new(),
        bound: BTreeMap::new(),
    };
    distinct(&described.description, &described.configurations(3), |_, frame| {
        // What does not evaluate is among the faults, or no legal configuration.
        if let Ok(frame) = frame {
            checker.frame(&frame);
        }
    });
    let legal = library.variants();
    for (pass, (names, places)) in std::mem::take(&mut checker.bound) {
        let of_pass = legal.iter().filter(|variant| variant.pass == pass);
        if of_pass.map(crate::matrix::Variant::id).all(|id| checker.variants.contains_key(&*id)) {
            for (name, place) in places.iter().filter(|((name, _), _)| !names.contains(name)) {
                let text = format!("no variant of pass `{pass}` binds `{}`", name.0);
                checker.found.insert((place.clone(), Code::Unknown, text));
            }
        }
    }
    diagnostics.extend(checker.found.into_iter().map(|(place, code, text)| {
        described.mark(&places, Diagnostic::new(code, text), &described.origin(&place))
    }));
    if diagnostics.is_empty() {
        return Ok(());
    }
    Err(Report::new(diagnostics, library.sources().clone()))
}

/// A description as a manifest holds it: without what is absent, false or empty, which is what a missing key means.
#[must_use]
pub fn json(description: &Description) -> Value {
    fn kept(value: Value) -> Option<Value> {
        match value {
            Value::Null | Value::Bool(false) => None,
            Value::String(text) => (!text.is_empty()).then_some(Value::String(text)),
            Value::Array(list) if list.is_empty() => None,
            Value::Array(list) => {
                let whole = |value| kept(value).unwrap_or(Value::Object(Map::new()));
                Some(Value::Array(list.into_iter().map(whole).collect()))
            }
            Value::Object(map) => {
                let map = map.into_iter().filter_map(|(key, value)| Some((key, kept(value)?)));
                let map: Map<_, _> = map.collect();
                (!map.is_empty()).then_some(Value::Object(map))
            }
            Value::Bool(true) | Value::Number(_) => Some(value),
        }
    }
    let mut value = kept(serde_json::to_value(description).unwrap_or_default()).unwrap_or_default();
    // A pass without axes is known all the same.
    if let (Some(map), Ok(passes)) =
        (value.as_object_mut(), serde_json::to_value(&description.passes))
    {
        map.insert("passes".to_owned(), passes);
    }
    value
}

type Place = Vec<String>;

/// Names that the variants of a pass bind, and names that steps give, with the places of these.
type Bound = (BTreeSet<String>, BTreeMap<(String, Place), Place>);

struct Checker<'a> {
    variants: BTreeMap<&'a str, &'a Described>,
    found: BTreeSet<(Place, Code, String)>,
    bound: BTreeMap<String, Bound>,
}

/// What was written so far: resources and their levels.
struct Written<'a> {
    frame: &'a Frame,
    levels: BTreeSet<(usize, u64)>,
    /// Whether what writes runs in the first frame of a kept resource alone.
    first_alone: bool,
}

impl Written<'_> {
    fn levels(&self, view: View) -> std::ops::Range<u64> {
        match (view.level, self.frame.resources.get(view.resource).map(|of| &of.kind)) {
            (Some(level), _) => level..level + 1,
            (None, Some(Kind::Texture { levels, .. })) => 0..*levels,
            (None, _) => 0..1,
        }
    }

    fn write(&mut self, view: View) {
        let kept = self.frame.resources.get(view.resource).is_some_and(|of| of.kept);
        if self.first_alone && !kept {
            return;
        }
        self.levels.extend(self.levels(view).map(|level| (view.resource, level)));
    }

    fn has(&self, view: View) -> bool {
        let external = self.frame.resources.get(view.resource).is_some_and(|of| of.external);
        external || self.levels(view).all(|level| self.levels.contains(&(view.resource, level)))
    }

    fn name(&self, view: View) -> String {
        let name = self.frame.resources.get(view.resource).map_or("", |of| &of.name);
        view.level.map_or(name.to_owned(), |level| format!("{name}@{level}"))
    }
}

impl Checker<'_> {
    fn wrong(&mut self, step: &Step, path: &[&str], text: String) {
        let path = path.iter().map(|part| (*part).to_owned());
        self.found.insert((
            step.place.iter().cloned().chain(path).collect(),
            Code::Declaration,
            text,
        ));
    }

    fn frame(&mut self, frame: &Frame) {
        let mut written = Written { frame, levels: BTreeSet::new(), first_alone: false };
        for (index, resource) in frame.resources.iter().enumerate() {
            if matches!(&resource.kind, Kind::Buffer { initial, .. } if !initial.is_empty()) {
                written.write(View { resource: index, level: None });
            }
        }
        for step in &frame.steps {
            written.first_alone = step.new.is_some();
            match &step.action {
                Action::Clear(resource, _) => {
                    let view = View { resource: *resource, level: None };
                    if !matches!(
                        frame.resources.get(*resource).map(|of| &of.kind),
                        Some(Kind::Buffer { .. })
                    ) {
                        self.wrong(
                            step,
                            &["clear"],
                            format!("`{}` is no buffer", written.name(view)),
                        );
                    }
                    written.write(view);
                }
                Action::Dispatch(dispatch) => {
                    if let sglow_graph::frame::Size::Indirect(resource, _) = dispatch.size {
                        self.read(step, "indirect", View { resource, level: None }, &written);
                    }
                    self.bindings(step, &dispatch.variant, dispatch.group, &mut written, false);
                }
                Action::Draw(draw) => self.draw(step, draw, &mut written),
            }
        }
    }

    fn draw(&mut self, step: &Step, draw: &Draw, written: &mut Written<'_>) {
        let (color, depth) = (&draw.description.color, draw.description.depth.as_ref());
        let clears = color.iter().map(|of| of.clear.is_some());
        let colors = draw.color.iter().copied().zip(clears);
        let depths = draw.depth.into_iter().zip(depth.map(|of| of.clear.is_some()));
        for (target, cleared) in colors.chain(depths) {
            if !cleared {
                self.read(step, "draw", target, written);
            }
            written.write(target);
        }
        for view in draw.vertices.iter().copied().flatten().chain(draw.indices) {
            self.read(step, "draw", view, written);
        }
        for call in &draw.calls {
            if let sglow_graph::frame::Geometry::Indirect(resource, _) = call.geometry {
                self.read(step, "indirect", View { resource, level: None }, written);
            }
        }
        let groups: BTreeSet<_> = draw.calls.iter().map(|call| call.group).collect();
        for (variant, _) in &draw.variants {
            for group in &groups {
                self.bindings(step, variant, *group, written, draw.description.list.is_some());
            }
        }
    }

    fn read(&mut self, step: &Step, path: &str, view: View, written: &Written<'_>) {
        if !written.has(view) {
            let text = format!("`{}` is read before anything writes it", written.name(view));
            self.wrong(step, &[path], text);
        }
    }

    /// Checks what a variant binds; what is missing is the host's in a draw of a list of its own.
    fn bindings(
        &mut self,
        step: &Step,
        runs: &Runs,
        group: usize,
        written: &mut Written<'_>,
        host: bool,
    ) {
        let Some(given) = written.frame.groups.get(group) else { return };
        let (names, places) = self.bound.entry(runs.pass.clone()).or_default();
        for (name, binding) in given {
            let table = if matches!(binding, Binding::Uniform(_)) { "uniforms" } else { "bind" };
            let place: Place =
                step.place.iter().cloned().chain([table.to_owned(), name.clone()]).collect();
            places.insert((name.clone(), place.clone()), place);
        }
        let Some(variant) = self.variants.get(runs.id.as_str()).copied() else {
            for binding in given.values() {
                if let Binding::View(view) = binding {
                    written.write(*view);
                }
            }
            return;
        };
        names.extend(variant.bindings.iter().map(|binding| binding.name.clone()));
        let mut writes = Vec::new();
        for binding in &variant.bindings {
            let name = binding.name.as_str();
            match given.get(name) {
                None if host => {}
                None => {
                    let text =
                        format!("pass `{}` binds `{name}`, which is given nothing", runs.pass);
                    self.wrong(step, &["bind"], text);
                }
                Some(Binding::Uniform(index)) => {
                    let members = written.frame.uniforms.get(*index);
                    let Resource::Uniform { r#type, .. } = &binding.resource else {
                        self.wrong(step, &["uniforms", name], format!("`{name}` is no uniform"));
                        continue;
                    };
                    let layout = variant.structs.iter().find(|layout| layout.name == *r#type);
                    for field in layout.map_or(&[][..], |layout| &layout.fields) {
                        if !members.is_some_and(|members| members.contains_key(&field.name)) {
                            let text = format!("member `{}` of `{type}` has no value", field.name);
                            self.wrong(step, &["uniforms", name], text);
                        }
                    }
                }
                Some(Binding::View(view)) => {
                    if let Some(text) = misfit(&binding.resource, *view, written) {
                        self.wrong(step, &["bind", name], text);
                    }
                    let access = match &binding.resource {
                        Resource::Storage { access, .. }
                        | Resource::StorageTexture { access, .. } => *access,
                        _ => Access::Read,
                    };
                    let sampler = matches!(binding.resource, Resource::Sampler { .. });
                    // Whether what is bound for both is read before it is written, the binding does not say.
                    if access == Access::Read && !sampler && !written.has(*view) {
                        let text =
                            format!("`{}` is read before anything writes it", written.name(*view));
                        self.wrong(step, &["bind", name], text);
                    }
                    if access != Access::Read {
                        writes.push(*view);
                    }
                }
            }
        }
        writes.into_iter().for_each(|view| written.write(view));
    }
}

/// Why a view does not fit a binding.
fn misfit(binding: &Resource, view: View, written: &Written<'_>) -> Option<String> {
    let name = written.name(view);
    let kind = &written.frame.resources.get(view.resource)?.kind;
    let layered = |dimension: &Dimension, layers: u64| {
        let fits =
            matches!(dimension, Dimension::D2Array) || (*dimension == Dimension::D2 && layers == 1);
        (!fits).then(|| {
            format!("`{name}` has {layers} layers and is bound with one or in another dimension")
        })
    };
    match (binding, kind) {
        (Resource::Storage { r#type, min_size, .. }, Kind::Buffer { length, stride, .. }) => {
            if r#type.starts_with("array<") && stride != min_size {
                return Some(format!(
                    "`{name}` has elements of {stride} bytes; {type} has {min_size}"
                ));
            }
            (length * stride < *min_size)
                .then(|| format!("`{name}` has {} bytes; {type} needs {min_size}", length * stride))
        }
        (
            Resource::Texture { dimension, sample_type, .. },
            Kind::Texture { format, layers, .. },
        ) => {
            let depth = format.starts_with("depth");
            let fits = match sample_type {
                SampleType::Depth => depth,
                SampleType::Uint => format.ends_with("uint"),
                SampleType::Sint => format.ends_with("sint"),
                SampleType::Float | SampleType::UnfilterableFloat => {
                    !depth && !format.ends_with("int")
                }
            };
            if !fits {
                return Some(format!("`{name}` is {format}, which the binding does not take"));
            }
            layered(dimension, *layers)
        }
        (
            Resource::StorageTexture { dimension, format, .. },
            Kind::Texture { format: own, layers, levels, .. },
        ) => {
            if own != format {
                return Some(format!("`{name}` is {own}; the binding is {format}"));
            }
            if view.level.is_none() && *levels > 1 {
                return Some(format!(
                    "`{name}` has {levels} levels; a storage texture is one of them"
                ));
            }
            layered(dimension, *layers)
        }
        (Resource::Sampler { .. }, Kind::Sampler { .. }) => None,
        _ => Some(format!("`{name}` is not of the kind that the binding takes")),
    }
}

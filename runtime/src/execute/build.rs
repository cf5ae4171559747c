//! From a frame to steps with everything resolved.

use std::collections::BTreeMap;

use sglow_graph::description;
use sglow_graph::frame::{self, Binding as Given, Frame, Variant, View};

use super::error::Fault;
use super::groups::{Bound, Groups};
use super::input::{DrawKind, DrawList};
use super::names;
use super::pipelines::{Drawing, Layouts, Pipelines};
use super::resources::Resources;
use super::steps::{Action, Call, Dispatch, Draw, Geometry, Size, Step, Uses};
use super::uniforms::Uniforms;
use crate::interface::{Binding, Interface, Kind};
use crate::package::Package;

/// What steps are made of.
pub(super) struct Builder<'a> {
    pub(super) device: &'a wgpu::Device,
    pub(super) package: &'a Package,
    pub(super) frame: &'a Frame,
    pub(super) lists: &'a BTreeMap<&'a str, &'a dyn DrawList>,
    pub(super) pipelines: &'a mut Pipelines,
    pub(super) resources: Resources,
    pub(super) uniforms: Uniforms,
    pub(super) groups: Groups,
    pub(super) faults: Vec<Fault>,
}

/// A variant with what the package says of it.
type Known<'a> = (&'a Variant, &'a Interface);

/// The groups of a step by their numbers.
type Numbered = Vec<(u32, usize)>;

/// A number as the device takes it.
fn narrow(place: &str, number: u64) -> Result<u32, Fault> {
    u32::try_from(number).map_err(|_| Fault::Step {
        place: place.to_owned(),
        problem: format!("{number} exceeds what a device counts"),
    })
}

impl<'a> Builder<'a> {
    /// Resolves all steps; what is wrong is among the faults.
    pub(super) fn steps(&mut self) -> Vec<Step> {
        let frame = self.frame;
        let mut steps = Vec::new();
        for step in &frame.steps {
            match self.step(step) {
                Ok(step) => steps.push(step),
                Err(fault) => self.faults.push(fault),
            }
        }
        steps
    }

    fn step(&mut self, step: &'a frame::Step) -> Result<Step, Fault> {
        let place = step.place.join(".");
        let (action, pass) = match &step.action {
            frame::Action::Clear(buffer, bytes) => {
                self.resources.use_buffer(*buffer, wgpu::BufferUsages::COPY_DST);
                (Action::Clear(*buffer, *bytes), None)
            }
            frame::Action::Dispatch(dispatch) => {
                (Action::Dispatch(self.dispatch(&place, dispatch)?), Some(&dispatch.variant.pass))
            }
            frame::Action::Draw(draw) => {
                let pass = draw.variants.first().map(|(variant, _)| &variant.pass);
                (Action::Draw(self.draw(&place, draw)?), pass)
            }
        };
        let label = match pass {
            Some(pass) if step.label.is_empty() => pass.clone(),
            _ => step.label.clone(),
        };
        let uses = self.uses(&action);
        Ok(Step { part: step.part.clone(), label, new: step.new, action, uses })
    }

    fn uses(&self, action: &Action) -> Uses {
        let mut uses = Uses::default();
        let mut bound = |groups: &Numbered| {
            for (_, group) in groups {
                self.groups.add_uses(*group, &self.resources, &mut uses);
            }
        };
        match action {
            Action::Clear(buffer, _) => uses.resources.extend([*buffer]),
            Action::Dispatch(dispatch) => {
                bound(&dispatch.groups);
                if let Size::Indirect(buffer, _) = dispatch.size {
                    uses.resources.insert(buffer);
                }
            }
            Action::Draw(draw) => {
                draw.calls.iter().for_each(|call| bound(&call.groups));
                let indirect = draw.calls.iter().filter_map(|call| match call.geometry {
                    Geometry::Indirect(buffer, _) => Some(buffer),
                    Geometry::List | Geometry::Direct(..) => None,
                });
                uses.resources.extend(indirect);
                uses.resources.extend(draw.vertices.iter().flatten().chain(&draw.indices));
                let targets = draw.color.iter().map(|color| color.0);
                let targets = targets.chain(draw.depth.map(|depth| depth.0));
                uses.resources.extend(targets.filter_map(|view| self.resources.of_view(view)));
            }
        }
        uses
    }

    fn interface(&self, variant: &Variant) -> Result<&'a Interface, Fault> {
        let id = variant.to_string();
        self.package.text(&id).map_err(|error| {
            let set = variant.axes.iter().map(|(axis, value)| format!("{axis}={value}"));
            Fault::Variant { error, set: set.collect::<Vec<_>>().join(",") }
        })?;
        self.package.interface(&id).ok_or_else(|| Fault::NoInterface {
            variant: id,
            origin: self.package.origin().to_owned(),
        })
    }

    fn dispatch(&mut self, place: &str, of: &'a frame::Dispatch) -> Result<Dispatch, Fault> {
        let variant = &of.variant;
        let interface = self.interface(variant)?;
        let has = |name: &str| interface.overrides.iter().any(|known| known.name == name);
        #[expect(clippy::cast_precision_loss, reason = "a pipeline's constants are f64")]
        let constants: Vec<_> = of
            .constants
            .iter()
            .filter(|(name, _)| has(name))
            .map(|(name, number)| (name.as_str(), *number as f64))
            .collect();
        let (pipeline, layouts) = self.pipelines.compute(
            self.device,
            self.package,
            variant,
            interface,
            of.entry.as_deref(),
            &constants,
        )?;
        let groups = self.bind(place, &[(variant, interface)], &[], &layouts, of.group);
        let size = match of.size {
            frame::Size::Groups([x, y, z]) => {
                Size::Groups([narrow(place, x)?, narrow(place, y)?, narrow(place, z)?])
            }
            frame::Size::Indirect(buffer, offset) => {
                self.resources.use_buffer(buffer, wgpu::BufferUsages::INDIRECT);
                Size::Indirect(buffer, offset)
            }
        };
        Ok(Dispatch { pipeline, groups, size })
    }

    fn draw(&mut self, place: &str, of: &'a frame::Draw) -> Result<Draw, Fault> {
        let wrong = |problem: String| Fault::Step { place: place.to_owned(), problem };
        let described = &of.description;
        let list = described.list.as_deref();
        let kinds = match list {
            None => Vec::new(),
            Some(name) => match self.lists.get(name) {
                Some(list) => list.kinds(),
                None => return Err(Fault::ListLeftOut { name: name.to_owned() }),
            },
        };
        let mut known: Vec<Known<'a>> = Vec::new();
        for (variant, _) in &of.variants {
            known.push((variant, self.interface(variant)?));
        }
        let shared: Vec<_> = known.iter().map(|(_, interface)| *interface).collect();
        let (targets, depth) = self.targets(place, of)?;
        let mut buffers = Vec::new();
        for vertices in &described.vertices {
            buffers.push((vertices.stride, attributes(vertices).map_err(wrong)?));
        }
        // Without a list there is one kind: both sides of triangles are drawn.
        let own = DrawKind {
            axes: BTreeMap::new(),
            primitive: wgpu::PrimitiveState::default(),
            groups: Vec::new(),
        };
        let kinds = if list.is_some() { kinds } else { vec![own] };
        let (mut pipelines, mut layouts) = (Vec::new(), Layouts::new());
        for kind in &kinds {
            let fits = |variant: &Variant| {
                let has = |(axis, value): (&String, &String)| {
                    variant.axes.iter().any(|(known, of)| known == axis && of == value)
                };
                kind.axes.iter().all(has)
            };
            let Some((variant, fragment)) = of.variants.iter().find(|(variant, _)| fits(variant))
            else {
                return Err(wrong(format!(
                    "the configuration has no draws with {:?} in the list `{}`",
                    kind.axes,
                    list.unwrap_or_default()
                )));
            };
            let drawing = Drawing {
                vertex: &described.vertex,
                fragment: fragment.as_deref(),
                buffers: &buffers,
                targets: &targets,
                depth: depth.clone(),
                primitive: kind.primitive,
                host: &kind.groups,
                shared: &shared,
            };
            let (pipeline, of_pipeline) =
                self.pipelines.render(self.device, self.package, variant, &drawing)?;
            pipelines.push(pipeline);
            layouts.extend(of_pipeline);
        }
        let host: Vec<u32> =
            kinds.iter().flat_map(|kind| kind.groups.iter().map(|group| group.0)).collect();
        let mut calls = Vec::new();
        for call in &of.calls {
            let groups = self.bind(place, &known, &host, &layouts, call.group);
            calls.push(self.call(place, call, groups)?);
        }
        let vertex = wgpu::BufferUsages::VERTEX;
        let vertices = of.vertices.iter().map(|view| view.map(|view| view.resource)).collect();
        for view in of.vertices.iter().flatten() {
            self.resources.use_buffer(view.resource, vertex);
        }
        if let Some(indices) = of.indices {
            self.resources.use_buffer(indices.resource, wgpu::BufferUsages::INDEX);
        }
        Ok(Draw {
            color: self.color(of),
            depth: of.depth.zip(described.depth.as_ref()).map(|(view, described)| {
                #[expect(clippy::cast_possible_truncation, reason = "depth has 32 bits")]
                (self.attachment(view), described.clear.map(|clear| clear as f32))
            }),
            list: described.list.clone(),
            pipelines,
            vertices,
            indices: of.indices.map(|view| view.resource),
            calls,
        })
    }

    fn call(&mut self, place: &str, of: &frame::Call, groups: Numbered) -> Result<Call, Fault> {
        let geometry = match of.geometry {
            frame::Geometry::List => Geometry::List,
            frame::Geometry::Direct(count, [first, number]) => Geometry::Direct(
                narrow(place, count)?,
                [narrow(place, first)?, narrow(place, number)?],
            ),
            frame::Geometry::Indirect(buffer, offset) => {
                self.resources.use_buffer(buffer, wgpu::BufferUsages::INDIRECT);
                Geometry::Indirect(buffer, offset)
            }
        };
        #[expect(clippy::cast_precision_loss, reason = "sides of textures are far below 2^24")]
        let viewport = of.viewport.map(|sides| sides.map(|side| side as f32));
        Ok(Call { groups, viewport, geometry })
    }

    fn attachment(&mut self, view: View) -> usize {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
        self.resources.view(view, wgpu::TextureViewDimension::D2, usage)
    }

    fn color(&mut self, of: &frame::Draw) -> Vec<(usize, Option<wgpu::Color>)> {
        let views = of.color.iter().zip(&of.description.color);
        views
            .map(|(view, described)| {
                let clear = described.clear.map(|[r, g, b, a]| wgpu::Color { r, g, b, a });
                (self.attachment(*view), clear)
            })
            .collect()
    }

    /// The formats of colour targets, and what is done with depth.
    fn targets(
        &self,
        place: &str,
        of: &frame::Draw,
    ) -> Result<(Vec<wgpu::TextureFormat>, Option<wgpu::DepthStencilState>), Fault> {
        let wrong =
            |problem: &str| Fault::Step { place: place.to_owned(), problem: problem.to_owned() };
        let format = |view: &View| match self.resources.kind(view.resource) {
            Some(frame::Kind::Texture { format, .. }) => names::texture(format)
                .ok_or_else(|| wrong("a target has a format that no texture can be made of")),
            _ => Err(wrong("a target has to be a texture")),
        };
        let colors = of.color.iter().map(format).collect::<Result<_, _>>()?;
        let (Some(view), Some(depth)) = (&of.depth, &of.description.depth) else {
            return Ok((colors, None));
        };
        let compare = names::comparison(&depth.compare);
        let state = wgpu::DepthStencilState {
            format: format(view)?,
            depth_write_enabled: Some(depth.write),
            depth_compare: Some(compare.ok_or_else(|| wrong("unknown comparison of depths"))?),
            stencil: Default::default(),
            bias: Default::default(),
        };
        Ok((colors, Some(state)))
    }

    /// What a step binds, by the numbers of groups; those of the host are left to it.
    fn bind(
        &mut self,
        place: &str,
        variants: &[Known<'a>],
        host: &[u32],
        layouts: &Layouts,
        group: usize,
    ) -> Numbered {
        let frame = self.frame;
        let mut entries: BTreeMap<u32, BTreeMap<u32, Bound>> = BTreeMap::new();
        for (variant, interface) in variants {
            for binding in &interface.bindings {
                let known = entries.entry(binding.group).or_default();
                if host.contains(&binding.group) || known.contains_key(&binding.binding) {
                    continue;
                }
                let given = frame.groups.get(group).and_then(|group| group.get(&binding.name));
                match self.bound(place, variant, interface, binding, given) {
                    Ok(bound) => {
                        known.insert(binding.binding, bound);
                    }
                    Err(faults) => self.faults.extend(faults),
                }
            }
        }
        let groups = entries.into_iter().filter(|(number, _)| !host.contains(number));
        groups
            .filter_map(|(number, entries)| {
                let layout = layouts.get(&number)?;
                let entries = entries.into_iter().collect();
                Some((number, self.groups.group(layout, entries, &self.resources)))
            })
            .collect()
    }

    fn bound(
        &mut self,
        place: &str,
        variant: &Variant,
        interface: &Interface,
        binding: &Binding,
        given: Option<&Given>,
    ) -> Result<Bound, Vec<Fault>> {
        let wrong = |problem: &str| {
            vec![Fault::Binding {
                place: place.to_owned(),
                variant: variant.to_string(),
                binding: binding.name.clone(),
                problem: problem.to_owned(),
            }]
        };
        let Some(given) = given else { return Err(wrong("and nothing is given for it")) };
        let view = match (&binding.kind, given) {
            (Kind::Uniform { r#type, .. }, Given::Uniform(uniform)) => {
                let Some(members) = self.frame.uniforms.get(*uniform) else {
                    return Err(wrong("and nothing is given for it"));
                };
                let slot = self.uniforms.slot(*uniform, members, interface, r#type);
                return slot.map(Bound::Uniform).map_err(|faults| {
                    let fault = |(member, problem)| Fault::Member {
                        place: place.to_owned(),
                        variant: variant.to_string(),
                        binding: binding.name.clone(),
                        member,
                        problem,
                    };
                    faults.into_iter().map(fault).collect()
                });
            }
            (_, Given::View(view)) => *view,
            (_, Given::Uniform(_)) => {
                return Err(wrong("which is no uniform, and a uniform is given for it"));
            }
        };
        let textured = |dimension: &str, usage| {
            names::dimension(dimension).map(|dimension| (dimension, usage))
        };
        let (dimension, usage) = match (&binding.kind, self.resources.kind(view.resource)) {
            (Kind::Storage { .. }, Some(frame::Kind::Buffer { .. })) => {
                self.resources.use_buffer(view.resource, wgpu::BufferUsages::STORAGE);
                return Ok(Bound::Buffer(view.resource));
            }
            (Kind::Sampler { .. }, Some(frame::Kind::Sampler { .. })) => {
                return Ok(Bound::Sampler(view.resource));
            }
            (Kind::Texture { dimension, .. }, Some(frame::Kind::Texture { .. })) => {
                textured(dimension, wgpu::TextureUsages::TEXTURE_BINDING)
            }
            (Kind::StorageTexture { dimension, .. }, Some(frame::Kind::Texture { .. })) => {
                textured(dimension, wgpu::TextureUsages::STORAGE_BINDING)
            }
            _ => return Err(wrong("and what is given for it is of another kind")),
        }
        .ok_or_else(|| wrong("whose dimension is unknown"))?;
        Ok(Bound::View(self.resources.view(view, dimension, usage)))
    }
}

fn attributes(of: &description::Vertices) -> Result<Vec<wgpu::VertexAttribute>, String> {
    let one = |attribute: &description::Attribute| {
        let format = names::vertex(&attribute.format)
            .ok_or_else(|| format!("unknown vertex format `{}`", attribute.format))?;
        let (offset, shader_location) = (attribute.offset, attribute.location);
        Ok(wgpu::VertexAttribute { format, offset, shader_location })
    };
    of.attributes.iter().map(one).collect()
}

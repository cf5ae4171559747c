//! From a frame to steps with everything resolved.

use std::collections::BTreeMap;

use sglow_graph::description;
use sglow_graph::frame::{self, Binding as Given, Frame, Geometry, Kind, Size, Variant, View};
use wgpu::BindingType as Type;

use super::error::Fault;
use super::groups::Groups;
use super::input::{DrawKind, Lists};
use super::pipelines::{Drawing, Layouts, Pipelines};
use super::resources::{Bound, Resources};
use super::steps::{Action, Dispatch, Draw, Numbered, Step, Uses};
use super::uniforms::Uniforms;
use crate::interface::{Binding, Interface};
use crate::names;
use crate::package::Package;
use crate::pipeline::PipelineError;

/// What steps are made of.
pub(super) struct Builder<'a> {
    pub(super) device: &'a wgpu::Device,
    pub(super) package: &'a Package,
    pub(super) frame: &'a Frame,
    pub(super) lists: &'a Lists<'a>,
    pub(super) pipelines: &'a mut Pipelines,
    pub(super) resources: Resources,
    pub(super) uniforms: Uniforms,
    pub(super) groups: Groups,
    pub(super) faults: Vec<Fault>,
    /// What the step at hand uses.
    pub(super) uses: Uses,
}

/// A variant with what the package says of it.
type Known<'a> = (&'a Variant, &'a Interface);

fn wrong(place: &str, problem: impl Into<String>) -> Fault {
    Fault::Step { place: place.to_owned(), problem: problem.into() }
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
        self.uses = Uses::default();
        let (action, variant) = match &step.action {
            frame::Action::Clear(buffer, bytes) => {
                self.buffer(*buffer, wgpu::BufferUsages::COPY_DST);
                (Action::Clear(*buffer, *bytes), None)
            }
            frame::Action::Dispatch(dispatch) => {
                (Action::Dispatch(self.dispatch(&place, dispatch)?), Some(&dispatch.variant))
            }
            frame::Action::Draw(draw) => {
                let variant = draw.variants.first().map(|(variant, _)| variant);
                (Action::Draw(Box::new(self.draw(&place, draw)?)), variant)
            }
        };
        let label = match variant {
            Some(variant) if step.label.is_empty() => variant.pass.clone(),
            _ => step.label.clone(),
        };
        let uses = std::mem::take(&mut self.uses);
        Ok(Step { part: step.part.clone(), label, new: step.new, action, uses })
    }

    /// Notes the use of a buffer.
    fn buffer(&mut self, buffer: usize, usage: wgpu::BufferUsages) {
        self.resources.use_buffer(buffer, usage);
        self.uses.resources.insert(buffer);
    }

    /// Notes the use of a texture; the number of the view.
    fn view(
        &mut self,
        view: View,
        dimension: wgpu::TextureViewDimension,
        usage: wgpu::TextureUsages,
    ) -> usize {
        self.uses.resources.insert(view.resource);
        self.resources.view(view, dimension, usage)
    }

    fn target(&mut self, view: &View) -> usize {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
        self.view(*view, wgpu::TextureViewDimension::D2, usage)
    }

    fn interface(&self, variant: &Variant) -> Result<&'a Interface, Fault> {
        let id = &variant.id;
        self.package.text(id).map_err(|error| {
            let set = variant.axes.iter().map(|(axis, value)| format!("{axis}={value}"));
            Fault::Variant { error, set: set.collect::<Vec<_>>().join(",") }
        })?;
        Ok(self.package.interface(id).map_err(PipelineError::Package)?)
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
        match of.size {
            Size::Groups(groups) => {
                let most = self.device.limits().max_compute_workgroups_per_dimension;
                if let Some(count) = groups.into_iter().find(|count| *count > u64::from(most)) {
                    let problem = format!("{count} workgroups; this device allows {most} each way");
                    return Err(wrong(place, problem));
                }
            }
            Size::Indirect(buffer, _) => self.buffer(buffer, wgpu::BufferUsages::INDIRECT),
        }
        Ok(Dispatch { pipeline, groups, size: of.size })
    }

    fn draw(&mut self, place: &str, of: &'a frame::Draw) -> Result<Draw, Fault> {
        let described = &of.description;
        let list = described.list.as_deref();
        // Without a list there is one kind: both sides of triangles are drawn.
        let kinds = match list {
            None => vec![DrawKind::default()],
            Some(name) => self.lists.get(name).ok_or_else(|| Fault::list_left_out(name))?.kinds(),
        };
        let mut known: Vec<Known<'a>> = Vec::new();
        for (variant, _) in &of.variants {
            known.push((variant, self.interface(variant)?));
        }
        let shared: Vec<_> = known.iter().map(|(_, interface)| *interface).collect();
        let (targets, depth) = self.formats(of).map_err(|problem| wrong(place, problem))?;
        let buffers: Result<Vec<_>, _> = described.vertices.iter().map(attributes).collect();
        let buffers = buffers.map_err(|problem| wrong(place, problem))?;
        let (mut pipelines, mut layouts) = (Vec::new(), Layouts::new());
        for kind in &kinds {
            let fits = |variant: &Variant| {
                kind.axes.iter().all(|(axis, of)| variant.value(axis) == Some(of))
            };
            let fitting = of.variants.iter().find(|(variant, _)| fits(variant));
            let (variant, fragment) = fitting.ok_or_else(|| {
                let (axes, list) = (&kind.axes, list.unwrap_or_default());
                let problem =
                    format!("the configuration has no draws with {axes:?} in the list `{list}`");
                wrong(place, problem)
            })?;
            let drawing = Drawing {
                vertex: &described.vertex,
                fragment: fragment.as_deref(),
                buffers: &buffers,
                targets: &targets,
                depth: depth.clone(),
                kind,
                shared: &shared,
            };
            let (pipeline, of_pipeline) =
                self.pipelines.render(self.device, self.package, variant, &drawing)?;
            pipelines.push(pipeline);
            layouts.extend(of_pipeline);
        }
        let host: Vec<u32> =
            kinds.iter().flat_map(|kind| kind.groups.iter().map(|group| group.0)).collect();
        let mut groups = Vec::new();
        for call in &of.calls {
            groups.push(self.bind(place, &known, &host, &layouts, call.group));
            match call.geometry {
                Geometry::List => {}
                Geometry::Direct(count, [first, number]) => {
                    let most = count.max(first.saturating_add(number));
                    if u32::try_from(most).is_err() {
                        return Err(wrong(place, format!("{most} exceeds what a device counts")));
                    }
                }
                Geometry::Indirect(buffer, _) => self.buffer(buffer, wgpu::BufferUsages::INDIRECT),
            }
        }
        for view in of.vertices.iter().flatten() {
            self.buffer(view.resource, wgpu::BufferUsages::VERTEX);
        }
        if let Some(indices) = of.indices {
            self.buffer(indices.resource, wgpu::BufferUsages::INDEX);
        }
        let color = of.color.iter().map(|view| self.target(view)).collect();
        let depth = of.depth.as_ref().map(|view| self.target(view));
        Ok(Draw { of: of.clone(), color, depth, pipelines, groups })
    }

    /// The formats of colour targets, and what is done with depth.
    fn formats(
        &self,
        of: &frame::Draw,
    ) -> Result<(Vec<wgpu::TextureFormat>, Option<wgpu::DepthStencilState>), String> {
        let format = |view: &View| match self.resources.kind(view.resource) {
            Some(Kind::Texture { format, .. }) => names::texture(format),
            _ => Err("a target has to be a texture".to_owned()),
        };
        let colors = of.color.iter().map(format).collect::<Result<_, _>>()?;
        let (Some(view), Some(depth)) = (&of.depth, &of.description.depth) else {
            return Ok((colors, None));
        };
        let state = wgpu::DepthStencilState {
            format: format(view)?,
            depth_write_enabled: Some(depth.write),
            depth_compare: Some(names::comparison(&depth.compare)?),
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
        let given = self.frame.groups.get(group);
        let mut entries: BTreeMap<u32, BTreeMap<u32, _>> = BTreeMap::new();
        for (variant, interface) in variants {
            for binding in &interface.bindings {
                let Binding { group, name, entry, .. } = binding;
                let known = entries.entry(*group).or_default();
                if host.contains(group) || known.contains_key(&entry.binding) {
                    continue;
                }
                match self.bound(interface, binding, given.and_then(|given| given.get(name))) {
                    Ok(bound) => drop(known.insert(entry.binding, (*entry, bound))),
                    Err(problems) => self.faults.extend(problems.into_iter().map(|problem| {
                        wrong(place, format!("variant '{}' binds `{name}`, {problem}", variant.id))
                    })),
                }
            }
        }
        let groups = entries.into_iter().filter(|(number, _)| !host.contains(number));
        groups
            .filter_map(|(number, entries)| {
                let layout = layouts.get(&number)?;
                Some((number, self.groups.group(layout, entries.into_values().collect())))
            })
            .collect()
    }

    fn bound(
        &mut self,
        interface: &Interface,
        binding: &Binding,
        given: Option<&Given>,
    ) -> Result<Bound, Vec<String>> {
        let wrong = |problem: &str| Err(vec![problem.to_owned()]);
        let view = match given {
            None => return wrong("and nothing is given for it"),
            Some(Given::View(view)) => *view,
            Some(Given::Uniform(uniform)) => {
                let members = self.frame.uniforms.get(*uniform);
                let (Some(members), Some(of)) = (members, &binding.r#struct) else {
                    return wrong("which is no uniform, and a uniform is given for it");
                };
                let slot = self.uniforms.slot(self.device, *uniform, members, interface, of)?;
                self.uses.uniforms.insert(slot);
                return Ok(Bound::Uniform(slot));
            }
        };
        Ok(match (binding.entry.ty, self.resources.kind(view.resource)) {
            (Type::Buffer { .. }, Some(Kind::Buffer { .. })) if binding.r#struct.is_none() => {
                self.buffer(view.resource, wgpu::BufferUsages::STORAGE);
                Bound::Resource(view.resource)
            }
            (Type::Sampler(_), Some(Kind::Sampler { .. })) => Bound::Resource(view.resource),
            (Type::Texture { view_dimension, .. }, Some(Kind::Texture { .. })) => {
                let usage = wgpu::TextureUsages::TEXTURE_BINDING;
                Bound::View(self.view(view, view_dimension, usage))
            }
            (Type::StorageTexture { view_dimension, .. }, Some(Kind::Texture { .. })) => {
                let usage = wgpu::TextureUsages::STORAGE_BINDING;
                Bound::View(self.view(view, view_dimension, usage))
            }
            _ => return wrong("and what is given for it is of another kind"),
        })
    }
}

/// The stride and the attributes of a vertex buffer.
fn attributes(of: &description::Vertices) -> Result<(u64, Vec<wgpu::VertexAttribute>), String> {
    let one = |attribute: &description::Attribute| {
        let format = names::vertex(&attribute.format)?;
        let (offset, shader_location) = (attribute.offset, attribute.location);
        Ok(wgpu::VertexAttribute { format, offset, shader_location })
    };
    Ok((of.stride, of.attributes.iter().map(one).collect::<Result<_, String>>()?))
}

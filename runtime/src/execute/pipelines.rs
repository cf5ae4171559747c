//! Pipelines, each made once, with the layouts that the package has for them.

use std::collections::BTreeMap;

use sglow_graph::frame::Variant;

use super::error::Fault;
use super::input::DrawKind;
use crate::interface::Interface;
use crate::package::Package;
use crate::pipeline::{guarded, module};

/// Layouts of groups by their numbers.
pub(super) type Layouts = BTreeMap<u32, wgpu::BindGroupLayout>;

/// What was compiled, for all frames of a host.
#[derive(Debug, Default)]
pub(super) struct Pipelines {
    compute: BTreeMap<String, (wgpu::ComputePipeline, Layouts)>,
    render: BTreeMap<String, (wgpu::RenderPipeline, Layouts)>,
}

/// What a render pipeline is made of beside its variant.
pub(super) struct Drawing<'a> {
    pub(super) vertex: &'a str,
    pub(super) fragment: Option<&'a str>,
    pub(super) buffers: &'a [(u64, Vec<wgpu::VertexAttribute>)],
    pub(super) targets: &'a [wgpu::TextureFormat],
    pub(super) depth: Option<wgpu::DepthStencilState>,
    pub(super) kind: &'a DrawKind,
    /// The interfaces of all variants that share the groups of the frame.
    pub(super) shared: &'a [&'a Interface],
}

impl Pipelines {
    /// How many pipelines were made.
    pub(super) fn made(&self) -> u64 {
        (self.compute.len() + self.render.len()) as u64
    }

    /// A compute pipeline, with the layouts of its groups.
    pub(super) fn compute(
        &mut self,
        device: &wgpu::Device,
        package: &Package,
        variant: &Variant,
        interface: &Interface,
        entry: Option<&str>,
        constants: &[(&str, f64)],
    ) -> Result<(wgpu::ComputePipeline, Layouts), Fault> {
        let id = &variant.id;
        let key = format!("{id} {entry:?} {constants:?}");
        if let Some(known) = self.compute.get(&key) {
            return Ok(known.clone());
        }
        let module = module(device, package, id)?;
        let made = guarded(device, id, || {
            let groups = layouts(device, id, &[interface]);
            let layout = pipeline_layout(device, id, &groups);
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(id),
                layout: Some(&layout),
                module: &module,
                entry_point: entry,
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants,
                    ..Default::default()
                },
                cache: None,
            });
            (pipeline, groups)
        })?;
        self.compute.insert(key, made.clone());
        Ok(made)
    }

    /// A render pipeline, with the layouts of its groups.
    pub(super) fn render(
        &mut self,
        device: &wgpu::Device,
        package: &Package,
        variant: &Variant,
        drawing: &Drawing<'_>,
    ) -> Result<(wgpu::RenderPipeline, Layouts), Fault> {
        let id = &variant.id;
        let Drawing { vertex, fragment, buffers, targets, depth, kind, shared } = drawing;
        let DrawKind { primitive, groups: host, .. } = kind;
        let key = format!(
            "{id} {vertex} {fragment:?} {buffers:?} {targets:?} {depth:?} {primitive:?} {host:?} {:?}",
            merged(shared)
        );
        if let Some(known) = self.render.get(&key) {
            return Ok(known.clone());
        }
        let module = module(device, package, id)?;
        let targets: Vec<_> = targets.iter().map(|&format| Some(format.into())).collect();
        let buffers: Vec<_> = buffers
            .iter()
            .map(|(array_stride, attributes)| {
                Some(wgpu::VertexBufferLayout {
                    array_stride: *array_stride,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes,
                })
            })
            .collect();
        let made = guarded(device, id, || {
            let mut groups = layouts(device, id, shared);
            groups.extend(host.iter().cloned());
            let layout = pipeline_layout(device, id, &groups);
            let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(id),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(vertex),
                    compilation_options: Default::default(),
                    buffers: &buffers,
                },
                primitive: *primitive,
                depth_stencil: depth.clone(),
                multisample: Default::default(),
                fragment: fragment.map(|entry| wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(entry),
                    compilation_options: Default::default(),
                    targets: &targets,
                }),
                multiview_mask: None,
                cache: None,
            });
            (pipeline, groups)
        })?;
        self.render.insert(key, made.clone());
        Ok(made)
    }
}

/// What variants bind, by group and number, for every stage that any of them binds it in.
fn merged(interfaces: &[&Interface]) -> BTreeMap<u32, BTreeMap<u32, wgpu::BindGroupLayoutEntry>> {
    let mut groups: BTreeMap<_, BTreeMap<_, _>> = BTreeMap::new();
    for binding in interfaces.iter().flat_map(|interface| &interface.bindings) {
        let group = groups.entry(binding.group).or_default();
        let known: &mut wgpu::BindGroupLayoutEntry =
            group.entry(binding.entry.binding).or_insert(binding.entry);
        known.visibility |= binding.entry.visibility;
    }
    groups
}

fn layouts(device: &wgpu::Device, id: &str, interfaces: &[&Interface]) -> Layouts {
    let of = |(group, entries): (u32, BTreeMap<u32, wgpu::BindGroupLayoutEntry>)| {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(id),
            entries: &entries.into_values().collect::<Vec<_>>(),
        });
        (group, layout)
    };
    merged(interfaces).into_iter().map(of).collect()
}

fn pipeline_layout(device: &wgpu::Device, id: &str, groups: &Layouts) -> wgpu::PipelineLayout {
    let count = groups.keys().next_back().map_or(0, |last| last + 1);
    let groups: Vec<_> = (0..count).map(|group| groups.get(&group)).collect();
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(id),
        bind_group_layouts: &groups,
        immediate_size: 0,
    })
}

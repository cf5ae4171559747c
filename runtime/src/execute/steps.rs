//! The steps of a frame with everything resolved: what remains is to encode them.

use std::collections::BTreeSet;

use super::groups::Groups;
use super::input::Inputs;
use super::resources::Resources;
use crate::pipeline::timed;
use crate::timing::PassTimer;

/// A step.
#[derive(Debug)]
pub(super) struct Step {
    pub(super) part: String,
    pub(super) label: String,
    /// The kept resource in whose first frame alone it runs.
    pub(super) new: Option<usize>,
    pub(super) action: Action,
    /// What it reads and writes.
    pub(super) uses: Uses,
}

/// Resources and uniforms.
#[derive(Clone, Debug, Default)]
pub(super) struct Uses {
    pub(super) resources: BTreeSet<usize>,
    pub(super) uniforms: BTreeSet<usize>,
}

impl Uses {
    pub(super) fn add(&mut self, other: &Self) {
        self.resources.extend(&other.resources);
        self.uniforms.extend(&other.uniforms);
    }
}

#[derive(Debug)]
pub(super) enum Action {
    Clear(usize, Option<u64>),
    Dispatch(Dispatch),
    Draw(Draw),
}

#[derive(Debug)]
pub(super) struct Dispatch {
    pub(super) pipeline: wgpu::ComputePipeline,
    /// Groups by their numbers.
    pub(super) groups: Vec<(u32, usize)>,
    pub(super) size: Size,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Size {
    Groups([u32; 3]),
    Indirect(usize, u64),
}

#[derive(Debug)]
pub(super) struct Draw {
    /// Views, with what they are cleared to.
    pub(super) color: Vec<(usize, Option<wgpu::Color>)>,
    pub(super) depth: Option<(usize, Option<f32>)>,
    /// The host's list; else the frame's own geometry.
    pub(super) list: Option<String>,
    pub(super) pipelines: Vec<wgpu::RenderPipeline>,
    pub(super) vertices: Vec<Option<usize>>,
    pub(super) indices: Option<usize>,
    pub(super) calls: Vec<Call>,
}

#[derive(Debug)]
pub(super) struct Call {
    pub(super) groups: Vec<(u32, usize)>,
    pub(super) viewport: Option<[f32; 4]>,
    pub(super) geometry: Geometry,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Geometry {
    List,
    Direct(u32, [u32; 2]),
    Indirect(usize, u64),
}

/// What steps find when they are encoded.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub(super) resources: &'a Resources,
    pub(super) groups: &'a Groups,
    pub(super) inputs: &'a Inputs<'a>,
}

/// Encodes steps. Dispatches of one label that follow upon each other share a compute pass, timed as one.
pub(super) fn encode(
    steps: &[&Step],
    scene: Scene<'_>,
    encoder: &mut wgpu::CommandEncoder,
    mut timer: Option<&mut (dyn PassTimer + '_)>,
) {
    let mut steps = steps.iter().peekable();
    while let Some(step) = steps.next() {
        match &step.action {
            Action::Clear(buffer, bytes) => {
                if let Some(buffer) = scene.resources.buffer(*buffer) {
                    encoder.clear_buffer(buffer, 0, *bytes);
                }
            }
            Action::Draw(draw) => draw.encode(&step.label, scene, encoder, timer.as_deref_mut()),
            Action::Dispatch(first) => {
                let mut dispatches = vec![first];
                while let Some(Step { action: Action::Dispatch(next), .. }) =
                    steps.next_if(|next| {
                        next.label == step.label && matches!(next.action, Action::Dispatch(_))
                    })
                {
                    dispatches.push(next);
                }
                compute(&step.label, &dispatches, scene, encoder, timer.as_deref_mut());
            }
        }
    }
}

fn compute(
    label: &str,
    dispatches: &[&Dispatch],
    scene: Scene<'_>,
    encoder: &mut wgpu::CommandEncoder,
    mut timer: Option<&mut (dyn PassTimer + '_)>,
) {
    timed(encoder, timer.as_deref_mut(), label, |encoder, stamps| {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(label),
            timestamp_writes: stamps.map(|stamps| stamps.compute()),
        });
        for dispatch in dispatches {
            pass.set_pipeline(&dispatch.pipeline);
            for (number, group) in &dispatch.groups {
                pass.set_bind_group(*number, scene.groups.get(*group), &[]);
            }
            match dispatch.size {
                Size::Groups([x, y, z]) => pass.dispatch_workgroups(x, y, z),
                Size::Indirect(buffer, offset) => {
                    if let Some(buffer) = scene.resources.buffer(buffer) {
                        pass.dispatch_workgroups_indirect(buffer, offset);
                    }
                }
            }
        }
    });
    if let Some(timer) = timer {
        timer.dispatched(dispatches.len());
    }
}

impl Draw {
    fn encode(
        &self,
        label: &str,
        scene: Scene<'_>,
        encoder: &mut wgpu::CommandEncoder,
        timer: Option<&mut (dyn PassTimer + '_)>,
    ) {
        let view = |view: usize| scene.resources.texture_view(view);
        let color: Vec<_> = self
            .color
            .iter()
            .map(|(target, clear)| {
                Some(wgpu::RenderPassColorAttachment {
                    view: view(*target)?,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: clear.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear),
                        store: wgpu::StoreOp::Store,
                    },
                })
            })
            .collect();
        let depth = self.depth.and_then(|(target, clear)| {
            Some(wgpu::RenderPassDepthStencilAttachment {
                view: view(target)?,
                depth_ops: Some(wgpu::Operations {
                    load: clear.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            })
        });
        timed(encoder, timer, label, |encoder, stamps| {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(label),
                color_attachments: &color,
                depth_stencil_attachment: depth,
                timestamp_writes: stamps.map(|stamps| stamps.render()),
                ..Default::default()
            });
            for (slot, buffer) in (0..).zip(&self.vertices) {
                if let Some(buffer) = buffer.and_then(|buffer| scene.resources.buffer(buffer)) {
                    pass.set_vertex_buffer(slot, buffer.slice(..));
                }
            }
            let indices = self.indices.and_then(|indices| scene.resources.buffer(indices));
            if let Some(indices) = indices {
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
            }
            if let (None, Some(pipeline)) = (&self.list, self.pipelines.first()) {
                pass.set_pipeline(pipeline);
            }
            let mut bound: &[_] = &[];
            for call in &self.calls {
                if call.groups != bound {
                    for (number, group) in &call.groups {
                        pass.set_bind_group(*number, scene.groups.get(*group), &[]);
                    }
                    bound = &call.groups;
                }
                self.call(call, indices.is_some(), scene, &mut pass);
            }
        });
    }

    fn call(&self, call: &Call, indexed: bool, scene: Scene<'_>, pass: &mut wgpu::RenderPass<'_>) {
        if let Some([x, y, width, height]) = call.viewport {
            pass.set_viewport(x, y, width, height, 0.0, 1.0);
        }
        match call.geometry {
            Geometry::List => {
                let list = self.list.as_deref().and_then(|list| scene.inputs.lists.get(list));
                if let Some(list) = list {
                    list.draw(pass, &self.pipelines);
                }
            }
            Geometry::Direct(count, [first, number]) => {
                let instances = first..first.saturating_add(number);
                if indexed {
                    pass.draw_indexed(0..count, 0, instances);
                } else {
                    pass.draw(0..count, instances);
                }
            }
            Geometry::Indirect(buffer, offset) => match scene.resources.buffer(buffer) {
                Some(buffer) if indexed => pass.draw_indexed_indirect(buffer, offset),
                Some(buffer) => pass.draw_indirect(buffer, offset),
                None => {}
            },
        }
    }
}

impl Step {
    /// The host's list that it draws.
    pub(super) fn list(&self) -> Option<&str> {
        match &self.action {
            Action::Draw(draw) => draw.list.as_deref(),
            Action::Clear(..) | Action::Dispatch(_) => None,
        }
    }
}

//! The steps of a frame with everything resolved: what remains is to encode them.

use std::collections::BTreeSet;

use sglow_graph::frame::{self, Geometry, Size};

use super::groups::Groups;
use super::input::Inputs;
use super::resources::{Resources, narrow};
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
#[derive(Debug, Default)]
pub(super) struct Uses {
    pub(super) resources: BTreeSet<usize>,
    pub(super) uniforms: BTreeSet<usize>,
}

impl Uses {
    /// What any of the steps uses.
    pub(super) fn of<'a>(steps: impl IntoIterator<Item = &'a Step>) -> Self {
        let mut all = Self::default();
        for Step { uses, .. } in steps {
            all.resources.extend(&uses.resources);
            all.uniforms.extend(&uses.uniforms);
        }
        all
    }
}

/// The groups of a dispatch or a call by their numbers.
pub(super) type Numbered = Vec<(u32, usize)>;

#[derive(Debug)]
pub(super) enum Action {
    Clear(usize, Option<u64>),
    Dispatch(Dispatch),
    Draw(Box<Draw>),
}

#[derive(Debug)]
pub(super) struct Dispatch {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) groups: Numbered,
    pub(super) size: Size,
}

#[derive(Debug)]
pub(super) struct Draw {
    pub(super) of: frame::Draw,
    /// Views of the targets.
    pub(super) color: Vec<usize>,
    pub(super) depth: Option<usize>,
    /// One for each kind of the host's list; else one.
    pub(super) pipelines: Vec<wgpu::RenderPipeline>,
    /// What each call binds.
    pub(super) groups: Vec<Numbered>,
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
    let together = |one: &&Step, next: &&Step| {
        matches!((&one.action, &next.action), (Action::Dispatch(_), Action::Dispatch(_)))
            && one.label == next.label
    };
    for steps in steps.chunk_by(together) {
        let label = &steps[0].label;
        match &steps[0].action {
            Action::Clear(buffer, bytes) => {
                if let Some(buffer) = scene.resources.buffer(*buffer) {
                    encoder.clear_buffer(buffer, 0, *bytes);
                }
            }
            Action::Draw(draw) => draw.encode(label, scene, encoder, timer.as_deref_mut()),
            Action::Dispatch(_) => compute(label, steps, scene, encoder, timer.as_deref_mut()),
        }
    }
}

fn compute(
    label: &str,
    steps: &[&Step],
    scene: Scene<'_>,
    encoder: &mut wgpu::CommandEncoder,
    mut timer: Option<&mut (dyn PassTimer + '_)>,
) {
    timed(encoder, timer.as_deref_mut(), label, |encoder, stamps| {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(label),
            timestamp_writes: stamps.map(|stamps| stamps.compute()),
        });
        for step in steps {
            let Action::Dispatch(dispatch) = &step.action else { continue };
            pass.set_pipeline(&dispatch.pipeline);
            for (number, group) in &dispatch.groups {
                pass.set_bind_group(*number, scene.groups.get(*group), &[]);
            }
            match dispatch.size {
                Size::Groups(groups) => {
                    let [x, y, z] = groups.map(narrow);
                    pass.dispatch_workgroups(x, y, z);
                }
                Size::Indirect(buffer, offset) => {
                    if let Some(buffer) = scene.resources.buffer(buffer) {
                        pass.dispatch_workgroups_indirect(buffer, offset);
                    }
                }
            }
        }
    });
    if let Some(timer) = timer {
        timer.dispatched(steps.len());
    }
}

/// What a target is cleared to, or that it stays.
fn operations<T>(clear: Option<T>) -> wgpu::Operations<T> {
    let load = clear.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear);
    wgpu::Operations { load, store: wgpu::StoreOp::Store }
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
        let buffer = |of: &frame::View| scene.resources.buffer(of.resource);
        let described = &self.of.description;
        let color = self.color.iter().zip(&described.color).map(|(target, described)| {
            let clear = described.clear.map(|[r, g, b, a]| wgpu::Color { r, g, b, a });
            Some(wgpu::RenderPassColorAttachment {
                view: view(*target)?,
                depth_slice: None,
                resolve_target: None,
                ops: operations(clear),
            })
        });
        let color: Vec<_> = color.collect();
        let depth = self.depth.zip(described.depth.as_ref()).and_then(|(target, described)| {
            #[expect(clippy::cast_possible_truncation, reason = "depth has 32 bits")]
            let clear = described.clear.map(|clear| clear as f32);
            Some(wgpu::RenderPassDepthStencilAttachment {
                view: view(target)?,
                depth_ops: Some(operations(clear)),
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
            for (slot, of) in (0..).zip(&self.of.vertices) {
                if let Some(buffer) = of.as_ref().and_then(buffer) {
                    pass.set_vertex_buffer(slot, buffer.slice(..));
                }
            }
            if let Some(indices) = self.of.indices.as_ref().and_then(buffer) {
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
            }
            if let (None, Some(pipeline)) = (&described.list, self.pipelines.first()) {
                pass.set_pipeline(pipeline);
            }
            let mut bound: &[_] = &[];
            for (call, groups) in self.of.calls.iter().zip(&self.groups) {
                if groups != bound {
                    for (number, group) in groups {
                        pass.set_bind_group(*number, scene.groups.get(*group), &[]);
                    }
                    bound = groups;
                }
                self.call(call, scene, &mut pass);
            }
        });
    }

    fn call(&self, call: &frame::Call, scene: Scene<'_>, pass: &mut wgpu::RenderPass<'_>) {
        #[expect(clippy::cast_precision_loss, reason = "sides of textures are far below 2^24")]
        if let Some([x, y, width, height]) = call.viewport.map(|sides| sides.map(|one| one as f32))
        {
            pass.set_viewport(x, y, width, height, 0.0, 1.0);
        }
        let indexed = self.of.indices.is_some();
        match call.geometry {
            Geometry::List => {
                let list = self.of.description.list.as_deref();
                if let Some(list) = list.and_then(|list| scene.inputs.lists.get(list)) {
                    list.draw(pass, &self.pipelines);
                }
            }
            Geometry::Direct(count, [first, number]) => {
                let (count, first) = (narrow(count), narrow(first));
                let instances = first..first.saturating_add(narrow(number));
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
            Action::Draw(draw) => draw.of.description.list.as_deref(),
            Action::Clear(..) | Action::Dispatch(_) => None,
        }
    }
}

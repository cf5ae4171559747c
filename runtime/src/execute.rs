//! Executes a frame that is data: resources, pipelines, uniforms and steps of a [`sglow_graph::Frame`].
//!
//! Everything that follows from the frame is made once. What is left for each frame is to take what the host gives, to copy
//! it into the uniforms, and to encode the steps: no formula is evaluated and no pipeline is made.

mod build;
mod error;
mod groups;
mod input;
mod pipelines;
mod resources;
mod steps;
mod uniforms;

use sglow_graph::Frame;

pub use error::{Fault, Faults};
pub use input::{DrawKind, DrawList, Input, Inputs, Lists};

use crate::package::Package;
use crate::pipeline::checked;
use crate::timing::PassTimer;
use build::Builder;
use groups::Groups;
use pipelines::Pipelines;
use resources::Resources;
use steps::{Scene, Step, Uses};
use uniforms::Uniforms;

/// What a step belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage<'a> {
    /// The part of the frame.
    pub part: &'a str,
    /// What its time is called.
    pub label: &'a str,
}

/// What was made so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Made {
    /// Pipelines; none of them in a frame.
    pub pipelines: u64,
    /// Bind groups; in a frame those alone that bind what the host supplies, if that is not what it was.
    pub groups: u64,
}

/// A frame on a device.
pub struct Executor {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipelines: Pipelines,
    ready: Ready,
}

/// What follows from a frame.
struct Ready {
    resources: Resources,
    uniforms: Uniforms,
    groups: Groups,
    steps: Vec<Step>,
    /// What all steps use.
    all: Uses,
}

impl Ready {
    fn new(
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        package: &Package,
        frame: &Frame,
        lists: &Lists<'_>,
        pipelines: &mut Pipelines,
    ) -> Result<Self, Faults> {
        let mut builder = Builder {
            device,
            package,
            frame,
            lists,
            pipelines,
            resources: Resources::new(frame),
            uniforms: Uniforms::default(),
            groups: Groups::default(),
            faults: Vec::new(),
            uses: Uses::default(),
        };
        let steps = builder.steps();
        let Builder { mut resources, mut uniforms, mut groups, faults, .. } = builder;
        Faults::none_of(faults)?;
        let mut faults = Vec::new();
        let made = checked(device, || {
            resources.make(device, queue, &mut faults);
            uniforms.make(device, queue);
            groups.make(device, &mut resources, &uniforms, true, &mut faults);
        });
        let what = "what the frame binds".to_owned();
        faults.extend(made.err().map(|message| Fault::Device { what, message }));
        Faults::none_of(faults)?;
        Ok(Self { resources, uniforms, groups, all: Uses::of(&steps), steps })
    }
}

impl Executor {
    /// Makes everything that a frame needs, but for what the host supplies.
    ///
    /// `lists`: the host's draws; the pipelines that they need are made here.
    ///
    /// # Errors
    ///
    /// Everything that is missing or does not fit, at once.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        package: &Package,
        frame: &Frame,
        lists: &Lists<'_>,
    ) -> Result<Self, Faults> {
        let mut pipelines = Pipelines::default();
        let ready = Ready::new((device, queue), package, frame, lists, &mut pipelines)?;
        Ok(Self { device: device.clone(), queue: queue.clone(), pipelines, ready })
    }

    /// Takes another frame, of another size or another configuration. Pipelines that serve it stay; what resources held is
    /// lost.
    ///
    /// # Errors
    ///
    /// As [`Self::new`]; what there was before stays.
    pub fn resize(
        &mut self,
        package: &Package,
        frame: &Frame,
        lists: &Lists<'_>,
    ) -> Result<(), Faults> {
        let on = (&self.device, &self.queue);
        self.ready = Ready::new(on, package, frame, lists, &mut self.pipelines)?;
        Ok(())
    }

    /// Lets what is kept from frame to frame begin again with the next one.
    pub fn restart(&mut self) {
        self.ready.resources.restart(&self.queue);
    }

    /// Encodes one frame.
    ///
    /// # Errors
    ///
    /// Everything that the host has left out or that does not fit, at once. Nothing is encoded then.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut (dyn PassTimer + '_)>,
    ) -> Result<(), Faults> {
        self.run(None, encoder, inputs, timer)
    }

    /// Encodes some stages alone. What is kept from frame to frame grows older by it if it is used.
    ///
    /// # Errors
    ///
    /// As [`Self::encode`], of these steps.
    pub fn encode_where(
        &mut self,
        selected: impl Fn(Stage<'_>) -> bool,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut (dyn PassTimer + '_)>,
    ) -> Result<(), Faults> {
        self.run(Some(&selected), encoder, inputs, timer)
    }

    fn run(
        &mut self,
        selected: Option<&dyn Fn(Stage<'_>) -> bool>,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        timer: Option<&mut (dyn PassTimer + '_)>,
    ) -> Result<(), Faults> {
        let Ready { resources, uniforms, groups, steps, all } = &mut self.ready;
        let runs = |step: &&Step| {
            selected.is_none_or(|selected| selected(Stage { part: &step.part, label: &step.label }))
                && step.new.is_none_or(|new| resources.is_new(new))
        };
        let steps: Vec<_> = steps.iter().filter(runs).collect();
        let some = selected.map(|_| Uses::of(steps.iter().copied()));
        let uses = some.as_ref().unwrap_or(all);
        let mut faults = Vec::new();
        let changed = resources.take(&uses.resources, inputs, &mut faults);
        uniforms.take(&uses.uniforms, inputs, &resources.ages(), &mut faults);
        let lists = steps.iter().filter_map(|step| step.list());
        let missing = lists.filter(|name| !inputs.lists.contains_key(name));
        faults.extend(missing.map(Fault::list_left_out));
        groups.make(&self.device, resources, uniforms, changed, &mut faults);
        Faults::none_of(faults)?;
        uniforms.encode(&self.device, &self.queue, encoder);
        steps::encode(&steps, Scene { resources, groups, inputs }, encoder, timer);
        resources.grow_older(&uses.resources);
        Ok(())
    }

    /// A buffer of the frame; nothing if it has none of this name.
    pub fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        self.ready.resources.buffer(self.ready.resources.find(name)?)
    }

    /// A texture of the frame; nothing if it has none of this name.
    pub fn texture(&self, name: &str) -> Option<&wgpu::Texture> {
        self.ready.resources.texture(self.ready.resources.find(name)?)
    }

    /// The names of the buffers, textures and samplers that were made here.
    pub fn own(&self) -> impl Iterator<Item = &str> {
        self.ready.resources.own()
    }

    /// What was made so far.
    pub fn made(&self) -> Made {
        Made { pipelines: self.pipelines.made(), groups: self.ready.groups.made() }
    }
}

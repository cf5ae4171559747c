//! What a frame keeps and runs, with names in place of indices.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use sglow_graph::Configuration;
use sglow_graph::description::Filter;
use sglow_graph::frame::{self, Action, Binding, Frame, Geometry, Kind, Size, Variant, View};

/// What a variant does with one of its bindings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// It reads.
    pub reads: bool,
    /// It writes.
    pub writes: bool,
}

/// The bindings of each variant by its identifier and their names.
pub type Bindings = BTreeMap<String, BTreeMap<String, Access>>;

/// A frame as a list.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Content {
    /// What it is the frame of, in a few words.
    pub title: String,
    /// The values of axes and parameters that are not the defaults, as `--set` takes them.
    pub changed: Vec<String>,
    /// All values.
    pub configuration: Configuration,
    /// Bytes of all resources.
    pub bytes: u64,
    /// Bytes of those that the host supplies.
    pub external_bytes: u64,
    /// The parts of the frame, in the order in which they first occur.
    pub parts: Vec<Part>,
    /// What exists, part by part, the largest first.
    pub resources: Vec<Resource>,
    /// What runs, in order.
    pub steps: Vec<Step>,
}

/// A part of a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Bytes of its resources.
    pub bytes: u64,
    /// How many resources it has.
    pub resources: usize,
    /// How many steps it has.
    pub steps: usize,
}

/// A resource.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Resource {
    /// Its name.
    pub name: String,
    /// Its part of the frame.
    pub part: String,
    /// What it is.
    #[serde(flatten)]
    pub kind: Kept,
    /// All layers and levels.
    pub bytes: u64,
    /// Whether the host supplies it.
    pub external: bool,
    /// Whether its contents last from frame to frame.
    pub kept: bool,
}

/// What a resource is.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Kept {
    /// A buffer of so many elements of so many bytes.
    Buffer {
        /// Elements.
        length: u64,
        /// Bytes of each.
        stride: u64,
    },
    /// A texture.
    Texture {
        /// Its format.
        format: String,
        /// Width and height.
        size: [u64; 2],
        /// Layers.
        layers: u64,
        /// Mip levels.
        levels: u64,
    },
    /// A sampler.
    Sampler {
        /// How it filters.
        filter: Filter,
    },
}

impl Kept {
    /// Its format and size as a person reads them.
    pub fn text(&self) -> String {
        match self {
            Self::Buffer { length, stride } => format!("{length} x {stride} B"),
            Self::Texture { format, size: [width, height], layers, levels } => {
                let more = |count: u64, what: &str| {
                    if count > 1 { format!(", {count} {what}") } else { String::new() }
                };
                format!(
                    "{format} {width} x {height}{}{}",
                    more(*layers, "layers"),
                    more(*levels, "mips")
                )
            }
            Self::Sampler { filter: Filter::Linear } => "sampler, linear".to_owned(),
            Self::Sampler { filter: Filter::Nearest } => "sampler, nearest".to_owned(),
        }
    }
}

/// A step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// Where the description has it.
    pub place: String,
    /// Its part of the frame.
    pub part: String,
    /// What its time is called.
    pub label: String,
    /// The pass; nothing where a buffer is cleared.
    pub pass: Option<String>,
    /// The variants: one, or as many as the host's draws have.
    pub variants: Vec<String>,
    /// The entry point, where the step names one.
    pub entry: Option<String>,
    /// How much runs.
    pub work: Work,
    /// Numbers of the pipeline.
    pub constants: BTreeMap<String, u64>,
    /// The kept resource in whose first frame alone it runs.
    pub first_frame_of: Option<String>,
    /// What it reads.
    pub reads: Vec<Use>,
    /// What it writes.
    pub writes: Vec<Use>,
}

/// How much a step does.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Work {
    /// Clears the first bytes of a buffer, or all of them.
    Clear {
        /// How many; all of them if there is no number.
        bytes: Option<u64>,
    },
    /// Dispatches workgroups.
    Dispatch {
        /// Along x, y and z.
        workgroups: [u64; 3],
    },
    /// Dispatches or draws what a buffer says.
    Indirect {
        /// The buffer.
        buffer: String,
        /// Where in it, in bytes.
        offset: u64,
        /// How many times.
        calls: u64,
    },
    /// Draws so many vertices or indices in each call.
    Draw {
        /// Vertices or indices.
        vertices: u64,
        /// Instances.
        instances: u64,
        /// Calls.
        calls: u64,
    },
    /// Draws a list of the host's.
    List {
        /// The list.
        list: String,
        /// Calls.
        calls: u64,
    },
}

impl Work {
    /// The same as a person reads it.
    pub fn text(&self) -> String {
        let times =
            |calls: u64| if calls == 1 { String::new() } else { format!(", {calls} times") };
        match self {
            Self::Clear { bytes: None } => "clear".to_owned(),
            Self::Clear { bytes: Some(bytes) } => format!("clear {bytes} B"),
            Self::Dispatch { workgroups: [x, y, z] } => format!("{x}x{y}x{z}"),
            Self::Indirect { buffer, calls, .. } => format!("from {buffer}{}", times(*calls)),
            Self::Draw { vertices, instances: 1, calls } => {
                format!("draw {vertices}{}", times(*calls))
            }
            Self::Draw { vertices, instances, calls } => {
                format!("draw {vertices} x {instances}{}", times(*calls))
            }
            Self::List { list, calls } => format!("draw {list}{}", times(*calls)),
        }
    }
}

/// A resource that a step uses.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Use {
    /// The resource.
    pub resource: String,
    /// Its one level; all of them without it.
    pub level: Option<u64>,
    /// The binding, or `target`, `vertices`, `indices`, `arguments`, `clear`.
    pub by: String,
}

impl Content {
    /// The list of a frame. `bindings` knows every variant that it runs.
    pub fn new(
        title: String,
        changed: Vec<String>,
        configuration: Configuration,
        frame: &Frame,
        bindings: &Bindings,
    ) -> Self {
        let mut there = BTreeSet::new();
        for resource in &frame.resources {
            let initial =
                matches!(&resource.kind, Kind::Buffer { initial, .. } if !initial.is_empty());
            if resource.external || resource.kept || initial {
                there.insert(resource.name.clone());
            }
        }
        let mut steps: Vec<Step> = frame.steps.iter().map(|of| step(frame, of, bindings)).collect();
        for step in &mut steps {
            // A binding for both reads nothing where nothing has been written yet.
            let Step { reads, writes, .. } = step;
            reads.retain(|one| there.contains(&one.resource) || !writes.contains(one));
            there.extend(writes.iter().map(|one| one.resource.clone()));
        }
        let mut parts: Vec<Part> = Vec::new();
        let of_steps = steps.iter().map(|step| &step.part);
        for name in of_steps.chain(frame.resources.iter().map(|resource| &resource.part)) {
            if !parts.iter().any(|part| part.name == *name) {
                let own = || frame.resources.iter().filter(|resource| resource.part == *name);
                parts.push(Part {
                    name: name.clone(),
                    bytes: own().map(|resource| resource.bytes).sum(),
                    resources: own().count(),
                    steps: steps.iter().filter(|step| step.part == *name).count(),
                });
            }
        }
        let mut resources: Vec<Resource> = Vec::new();
        for part in &parts {
            let own = frame.resources.iter().filter(|resource| resource.part == part.name);
            let mut own: Vec<Resource> = own.map(resource).collect();
            // Stable: what is as large stays in the order of the frame.
            own.sort_by_key(|resource| std::cmp::Reverse(resource.bytes));
            resources.extend(own);
        }
        let external = resources.iter().filter(|resource| resource.external);
        Self {
            title,
            changed,
            configuration,
            bytes: resources.iter().map(|resource| resource.bytes).sum(),
            external_bytes: external.map(|resource| resource.bytes).sum(),
            parts,
            resources,
            steps,
        }
    }
}

fn resource(of: &frame::Resource) -> Resource {
    let kind = match &of.kind {
        Kind::Buffer { length, stride, .. } => Kept::Buffer { length: *length, stride: *stride },
        Kind::Texture { format, size, layers, levels } => {
            Kept::Texture { format: format.clone(), size: *size, layers: *layers, levels: *levels }
        }
        Kind::Sampler(filter) => Kept::Sampler { filter: *filter },
    };
    let frame::Resource { name, part, bytes, external, kept, .. } = of.clone();
    Resource { name, part, kind, bytes, external, kept }
}

/// What a step uses, each once.
struct Uses<'a> {
    frame: &'a Frame,
    bindings: &'a Bindings,
    reads: Vec<Use>,
    writes: Vec<Use>,
}

impl Uses<'_> {
    fn add(&mut self, view: View, by: &str, access: Access) {
        let Some(resource) = self.frame.resources.get(view.resource) else { return };
        let one = Use { resource: resource.name.clone(), level: view.level, by: by.to_owned() };
        let lists = [(access.reads, &mut self.reads), (access.writes, &mut self.writes)];
        for (_, list) in lists.into_iter().filter(|(does, _)| *does) {
            if !list.contains(&one) {
                list.push(one.clone());
            }
        }
    }

    fn read(&mut self, resource: usize, by: &str) {
        self.add(View { resource, level: None }, by, Access { reads: true, writes: false });
    }

    /// What is bound, without what the variant lacks.
    fn group(&mut self, variant: &Variant, group: usize) {
        let (Some(given), Some(known)) =
            (self.frame.groups.get(group), self.bindings.get(&variant.id))
        else {
            return;
        };
        for (name, binding) in given {
            if let (Binding::View(view), Some(access)) = (binding, known.get(name)) {
                self.add(*view, name, *access);
            }
        }
    }

    fn draw(&mut self, draw: &frame::Draw) {
        let (reads, writes) = (false, true);
        for (target, of) in draw.color.iter().zip(&draw.description.color) {
            self.add(*target, "target", Access { reads: of.clear.is_none(), writes });
        }
        if let (Some(target), Some(of)) = (draw.depth, &draw.description.depth) {
            let writes = of.write || of.clear.is_some();
            self.add(target, "target", Access { reads: of.clear.is_none(), writes });
        }
        let access = Access { reads: !reads, writes: !writes };
        for view in draw.vertices.iter().flatten() {
            self.add(*view, "vertices", access);
        }
        if let Some(view) = draw.indices {
            self.add(view, "indices", access);
        }
        for call in &draw.calls {
            if let Geometry::Indirect(buffer, _) = call.geometry {
                self.read(buffer, "arguments");
            }
            for (variant, _) in &draw.variants {
                self.group(variant, call.group);
            }
        }
    }
}

fn step(frame: &Frame, of: &frame::Step, bindings: &Bindings) -> Step {
    let name = |resource: usize| {
        frame.resources.get(resource).map_or_else(String::new, |resource| resource.name.clone())
    };
    let mut uses = Uses { frame, bindings, reads: Vec::new(), writes: Vec::new() };
    let mut step = Step {
        place: of.place.join("."),
        part: of.part.clone(),
        label: of.label.clone(),
        pass: None,
        variants: Vec::new(),
        entry: None,
        work: Work::Clear { bytes: None },
        constants: BTreeMap::new(),
        first_frame_of: of.new.map(name),
        reads: Vec::new(),
        writes: Vec::new(),
    };
    match &of.action {
        Action::Clear(resource, bytes) => {
            step.work = Work::Clear { bytes: *bytes };
            let access = Access { reads: false, writes: true };
            uses.add(View { resource: *resource, level: None }, "clear", access);
        }
        Action::Dispatch(dispatch) => {
            step.pass = Some(dispatch.variant.pass.clone());
            step.variants = vec![dispatch.variant.id.clone()];
            step.entry.clone_from(&dispatch.entry);
            step.constants.clone_from(&dispatch.constants);
            step.work = match dispatch.size {
                Size::Groups(workgroups) => Work::Dispatch { workgroups },
                Size::Indirect(buffer, offset) => {
                    uses.read(buffer, "arguments");
                    Work::Indirect { buffer: name(buffer), offset, calls: 1 }
                }
            };
            uses.group(&dispatch.variant, dispatch.group);
        }
        Action::Draw(draw) => {
            let passes = draw.variants.first().map(|(variant, _)| variant.pass.clone());
            step.pass = passes.or_else(|| draw.description.list.clone());
            step.variants = draw.variants.iter().map(|(variant, _)| variant.id.clone()).collect();
            step.work = work(draw, &name);
            uses.draw(draw);
        }
    }
    let Uses { reads, writes, .. } = uses;
    Step { reads, writes, ..step }
}

/// What a draw comes to; calls differ in where they draw, and what they bind.
fn work(draw: &frame::Draw, name: &dyn Fn(usize) -> String) -> Work {
    let calls = draw.calls.len() as u64;
    if let Some(list) = &draw.description.list {
        return Work::List { list: list.clone(), calls };
    }
    match draw.calls.first().map(|call| &call.geometry) {
        Some(Geometry::Indirect(buffer, offset)) => {
            Work::Indirect { buffer: name(*buffer), offset: *offset, calls }
        }
        Some(Geometry::Direct(vertices, [_, instances])) => {
            Work::Draw { vertices: *vertices, instances: *instances, calls }
        }
        Some(Geometry::List) | None => Work::Draw { vertices: 0, instances: 0, calls },
    }
}

/// Bytes with a binary unit.
pub fn bytes(bytes: u64) -> String {
    let (mut value, mut unit) = (bytes as f64, "B");
    for next in ["KiB", "MiB", "GiB", "TiB"] {
        if value < 1024.0 {
            break;
        }
        (value, unit) = (value / 1024.0, next);
    }
    let decimals = usize::from(unit != "B" && value < 100.0);
    format!("{value:.decimals$} {unit}")
}

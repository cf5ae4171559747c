//! What a description comes to in one configuration: resources and steps in order, all numbers known.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::description::{self, Case, Number, Table};

macro_rules! evaluated {
    ($($item:item)*) => { $(
        #[derive(Clone, Debug, PartialEq, Serialize)]
        #[serde(rename_all = "snake_case")]
        $item
    )* };
}

evaluated!(
    /// The frame of one configuration. Resources, uniforms and groups are referred to by their indices.
    #[derive(Default)]
    pub struct Frame {
        /// What exists.
        pub resources: Vec<Resource>,
        /// Members of uniforms by name, each uniform once. Their places follow from the layout of the variant's structure.
        pub uniforms: Vec<Table<Value>>,
        /// Sets of bindings by name, each once. A step drops those that its variant lacks.
        pub groups: Vec<Table<Binding>>,
        /// What runs, in order.
        pub steps: Vec<Step>,
        /// The axes and parameters that it depends on: another value of any other axis or parameter gives the same frame.
        #[serde(skip)]
        pub reads: BTreeSet<String>,
    }

    /// A resource that exists.
    pub struct Resource {
        /// Its name; of a pair with `.0` or `.1` behind it.
        pub name: String,
        /// The part of the frame that it is counted under.
        pub part: String,
        /// What it is.
        pub kind: Kind,
        /// Its size in bytes, all layers and levels; 0 for a sampler.
        pub bytes: u64,
        /// Whether the host supplies it.
        pub external: bool,
        /// Whether its contents last from frame to frame.
        pub kept: bool,
        /// The formats that a texture has in this and in other configurations, unless it is the same in all.
        #[serde(skip)]
        pub formats: Vec<Case<String>>,
    }

    /// A pass with a value on each of its axes.
    #[derive(Default, Eq, PartialOrd, Ord)]
    pub struct Variant {
        /// The pass.
        pub pass: String,
        /// Axes and values, in the order of the pass.
        pub axes: Vec<(String, String)>,
        /// Its identifier: the pass and its values joined by `-`, without the default of an axis that is implied.
        pub id: String,
    }

    /// The value of a member of a uniform.
    pub enum Value {
        /// A number, converted to the member's type.
        Number(Number),
        /// An input of the host; one element of it, if the input is an array of what the member is.
        Input(String, Option<u64>),
        /// How many frames ago a kept resource was new.
        Age(usize),
        /// Components of a vector or elements of an array.
        List(Vec<Value>),
    }

    /// What a binding is given: a uniform or a resource.
    #[derive(Eq)]
    pub enum Binding {
        /// The index of a uniform.
        Uniform(usize),
        /// A resource.
        View(View),
    }

    /// A step that runs.
    pub struct Step {
        /// Where the description has it: keys and indices from the top.
        pub place: Vec<String>,
        /// What its time is called.
        pub label: String,
        /// The part of the frame that it belongs to.
        pub part: String,
        /// The kept resource in whose first frame alone it runs.
        pub new: Option<usize>,
        /// What it does.
        pub action: Action,
    }

    /// What a step does.
    pub enum Action {
        /// Clears a buffer to 0: its first bytes, or all of them.
        Clear(usize, Option<u64>),
        /// Dispatches workgroups.
        Dispatch(Dispatch),
        /// Draws in one render pass.
        Draw(Box<Draw>),
    }

    /// A dispatch.
    pub struct Dispatch {
        /// What runs.
        pub variant: Variant,
        /// The entry point, where there are several.
        pub entry: Option<String>,
        /// Numbers of the pipeline. Those that the variant lacks are dropped.
        pub constants: Table<u64>,
        /// Its bindings.
        pub group: usize,
        /// How many workgroups.
        pub size: Size,
    }

    /// Workgroups of a dispatch.
    #[derive(Copy, Eq)]
    pub enum Size {
        /// So many.
        Groups([u64; 3]),
        /// What a buffer says, from a byte on.
        Indirect(usize, u64),
    }

    /// A render pass.
    pub struct Draw {
        /// What the description says of it: entry point, clears, comparison, attributes.
        pub description: description::Draw,
        /// What runs, each with its fragment entry point: as many as the host's list has, one without a list.
        pub variants: Vec<(Variant, Option<String>)>,
        /// Colour targets, in the order of their locations.
        pub color: Vec<View>,
        /// The depth target.
        pub depth: Option<View>,
        /// Vertex buffers, in the order of their slots; the host's own where there is none.
        pub vertices: Vec<Option<View>>,
        /// The buffer of 32-bit indices.
        pub indices: Option<View>,
        /// Calls.
        pub calls: Vec<Call>,
    }

    /// A call of a render pass.
    pub struct Call {
        /// Its bindings.
        pub group: usize,
        /// Left, top, width and height in pixels; the whole target without it.
        pub viewport: Option<[u64; 4]>,
        /// What is drawn.
        pub geometry: Geometry,
    }

    /// What a call draws.
    pub enum Geometry {
        /// The host's list.
        List,
        /// Vertices or indices, the first instance, and the number of instances.
        Direct(u64, [u64; 2]),
        /// What a buffer says, from a byte on.
        Indirect(usize, u64),
    }
);

/// What a resource is, all numbers known.
pub type Kind = description::Kind<u64, String>;
/// A resource, or one level of it.
pub type View = description::Reference<usize, u64>;

impl Variant {
    /// The value on an axis, if the pass has it.
    pub fn value(&self, axis: &str) -> Option<&str> {
        self.axes.iter().find(|(name, _)| name == axis).map(|(_, value)| value.as_str())
    }
}

impl Frame {
    /// The index of the resource called `name`.
    pub fn resource(&self, name: &str) -> Option<usize> {
        self.resources.iter().position(|resource| resource.name == name)
    }

    /// The variants that run.
    pub fn variants(&self) -> BTreeSet<&Variant> {
        let mut variants = BTreeSet::new();
        for step in &self.steps {
            match &step.action {
                Action::Clear(..) => {}
                Action::Dispatch(dispatch) => variants.extend([&dispatch.variant]),
                Action::Draw(draw) => variants.extend(draw.variants.iter().map(|(of, _)| of)),
            }
        }
        variants
    }
}

/// Bytes of a texel of a format, as WebGPU names it; nothing for formats that have no such size.
pub fn texel_bytes(format: &str) -> Option<u64> {
    Some(match format {
        "r8unorm" | "r8uint" => 1,
        "r16float" | "r16uint" | "rg8unorm" | "depth16unorm" => 2,
        "r32float" | "r32uint" | "r32sint" | "rg16float" | "rgba8unorm" | "rgba8unorm-srgb"
        | "bgra8unorm" | "rgb10a2unorm" | "rg11b10ufloat" | "rgba8uint" | "depth32float" => 4,
        "rg32float" | "rg32uint" | "rgba16float" | "rgba16uint" => 8,
        "rgba32float" | "rgba32uint" => 16,
        _ => return None,
    })
}

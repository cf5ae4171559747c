//! The types of what an author writes: `frame.toml`.
//!
//! What they mean, [`crate::frame`] says. Types without templates, of which a frame is evaluated, are those of
//! [`sglow_graph::description`].

use serde::{Deserialize, Serialize};
use sglow_graph::description::{Attribute, DrawList, Filter, Input, Parameter, Table};

use super::formula::Text;

/// A frame with its templates.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Authored {
    /// Numbers that a person or an engine sets.
    pub parameter: Table<Parameter>,
    /// What the host writes into uniforms.
    pub input: Table<Input>,
    /// Draws of the host's own.
    pub draws: Table<DrawList>,
    /// What a configuration has to meet, beside the ranges of its parameters.
    pub require: Vec<Requirement>,
    /// Axes that follow from others, in the frame and in every use of a template; without a case that applies, what the
    /// configuration says.
    pub choose: Table<Choice>,
    /// Parts of frames. The one called `frame` is the frame; its lets, resources and uniforms are known everywhere.
    pub template: Table<Template>,
}

/// The frame, or a part of it that steps use with arguments of their own. Each use has resources of its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Template {
    /// What it does and what it takes.
    pub description: String,
    /// Derived numbers.
    #[serde(rename = "let")]
    pub lets: Table<Text>,
    /// Resources under other names. The last case always applies.
    pub alias: Table<Choice>,
    /// The members of uniforms; names in them are those of the step that binds the uniform.
    pub uniform: Table<Table<Field>>,
    /// What is kept in memory.
    pub resource: Table<Resource>,
    /// What runs, in order.
    pub step: Vec<Step>,
}

/// What a configuration has to meet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Requirement {
    /// What holds.
    pub that: Text,
    /// The same in words.
    pub reason: String,
}

/// A value or a reference to a resource, or the first of several cases that applies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a value, or a list of cases `{ when, value }`")]
pub enum Choice {
    /// The same in every configuration.
    Always(String),
    /// The value of the first case whose condition holds.
    Cases(Vec<Case>),
}

/// A case of a [`Choice`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Its condition; without one it applies whenever no case before it does.
    pub when: Option<Text>,
    /// Its value.
    pub value: String,
}

/// What is kept in memory: one of a buffer, a texture and a sampler.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Resource {
    /// What it holds.
    pub description: String,
    /// When it exists; always without it.
    pub when: Option<Text>,
    /// The part of the frame it is counted under; that of the step which uses the template without it.
    pub part: Option<String>,
    /// Whether the host supplies it. It may supply others, too, but none that is kept.
    pub external: bool,
    /// Whether its contents last from frame to frame.
    pub kept: bool,
    /// Whether there are two of it, which change places in a repetition.
    pub flip: bool,
    /// A buffer.
    pub buffer: Option<Buffer>,
    /// A texture.
    pub texture: Option<Texture>,
    /// A sampler that clamps to the edge.
    pub sampler: Option<Filter>,
}

/// A buffer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Buffer {
    /// Number of elements.
    pub length: Text,
    /// Bytes of an element.
    pub stride: Text,
    /// Words that it holds from its creation, from its beginning on; the rest is 0.
    #[serde(default)]
    pub initial: Vec<u32>,
}

/// A two-dimensional texture. What nothing writes is 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Texture {
    /// Its format, as WebGPU names it.
    pub format: Choice,
    /// Width and height of level 0.
    pub size: [Text; 2],
    /// Number of layers; 1 without it.
    pub layers: Option<Text>,
    /// Number of mip levels; 1 without it.
    pub levels: Option<Text>,
}

/// A member of a uniform.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "a formula, a number, `{ input = … }`, `{ age = … }`, or a list of these"
)]
pub enum Field {
    /// A formula, or the name of a real parameter.
    Formula(Text),
    /// A constant.
    Number(f64),
    /// One after the other: components of a vector, or elements of an array.
    List(Vec<Field>),
    /// What the host writes, or one element of it if the input is an array of what the member is.
    #[expect(missing_docs, reason = "said above")]
    Input { input: String, element: Option<Text> },
    /// How many frames ago a kept resource was new: 0 in the first one.
    #[expect(missing_docs, reason = "said above")]
    Age { age: String },
}

/// One step: a pass, a clear, the use of a template, or a group of steps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Step {
    /// What its time is called; consecutive dispatches of one label are timed as one. Of a group and a use: the label of its
    /// steps without one. Before the labels in a template stands the use's prefix, with spaces for underscores.
    pub label: Option<String>,
    /// The part of the frame that it belongs to; without one that of the group or the use it stands in.
    pub part: Option<String>,
    /// When it runs; always without it.
    pub when: Option<Text>,
    /// The kept resource in whose first frame after creation, resize or restart alone it runs.
    pub new: Option<String>,

    /// The pass that it runs.
    pub pass: Option<String>,
    /// Values of axes of the pass or of the template; of the others what the configuration says.
    pub axes: Table<Choice>,
    /// The compute entry point, where the pass has several.
    pub entry: Option<String>,
    /// Resources by the names of bindings. Those that a variant lacks are dropped.
    pub bind: Table<Choice>,
    /// Uniforms by the names of bindings.
    pub uniforms: Table<String>,
    /// Numbers of the pipeline by the names of overrides. Those that a variant lacks are dropped.
    pub constants: Table<Text>,
    /// Workgroups of a dispatch.
    pub dispatch: Option<[Text; 3]>,
    /// The buffer that holds the workgroups of a dispatch or the arguments of a draw.
    pub indirect: Option<Indirect>,
    /// What is drawn.
    pub draw: Option<Draw>,

    /// The buffer that is cleared to 0.
    pub clear: Option<String>,
    /// How many of its bytes; all of them without it.
    pub bytes: Option<Text>,

    /// The template that it uses.
    #[serde(rename = "use")]
    pub template: Option<String>,
    /// What stands before the names of the template's resources and aliases.
    pub prefix: String,
    /// What names of resources and inputs stand for in the template.
    pub names: Table<String>,
    /// Of a use, the template's numbers. Of a repetition, derived numbers of each round.
    #[serde(rename = "let")]
    pub lets: Table<Text>,

    /// The steps of a group.
    pub steps: Vec<Step>,
    /// How many times the group runs; once without it.
    pub repeat: Option<Text>,
    /// The name of the round's number, from 0 on.
    pub index: Option<String>,
    /// The pairs that change places at the end of each round.
    pub flip: Vec<String>,
}

/// Where the arguments of an indirect dispatch or draw are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Indirect {
    /// The buffer.
    pub buffer: String,
    /// The first byte, a multiple of 4.
    pub offset: Text,
}

/// What a step draws in one render pass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Draw {
    /// The vertex entry point.
    pub vertex: String,
    /// The fragment entry point; without one, or without a case that applies, there is no fragment stage.
    pub fragment: Option<Choice>,
    /// Colour targets, in the order of their locations.
    pub color: Vec<Color>,
    /// The depth target.
    pub depth: Option<Depth>,
    /// Vertex buffers, in the order of their slots.
    pub vertices: Vec<Vertices>,
    /// The buffer of 32-bit indices; vertices are drawn in their order without it.
    pub indices: Option<String>,
    /// The host's draws, which take the place of `indices`, `count` and instances.
    pub list: Option<String>,
    /// How many vertices or indices are drawn.
    pub count: Option<Text>,
    /// First instance and number of instances; 0 and 1 without it.
    pub instances: Option<[Text; 2]>,
    /// How many times it draws; once without it.
    pub repeat: Option<Text>,
    /// The name of the number of each time, from 0 on.
    pub index: Option<String>,
    /// Left, top, width and height in pixels; the whole target without it.
    pub viewport: Option<[Text; 4]>,
}

/// A colour target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Color {
    /// The texture.
    pub target: String,
    /// What it is cleared to before; what it holds stays without it.
    pub clear: Option<[f64; 4]>,
}

/// A depth target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Depth {
    /// The texture.
    pub target: String,
    /// What it is cleared to before; what it holds stays without it.
    pub clear: Option<f64>,
    /// The comparison, as WebGPU names it.
    pub compare: String,
    /// Whether what is drawn changes it.
    #[serde(default)]
    pub write: bool,
}

/// A vertex buffer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vertices {
    /// The buffer; the host's own without it.
    pub buffer: Option<String>,
    /// Bytes of a vertex.
    pub stride: u64,
    /// Its attributes.
    #[serde(default)]
    pub attributes: Vec<Attribute>,
}

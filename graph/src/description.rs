//! The types of a description: what a package's manifest holds under `graph`.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::formula::Formula;

/// A table by name.
pub type Table<T> = BTreeMap<String, T>;

/// Types that a manifest holds and a schema describes.
macro_rules! described {
    ($($item:item)*) => { $(
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
        $item
    )* };
}

described!(
    /// A frame as data: everything that may run, and under which conditions.
    #[derive(Default)]
    #[serde(default)]
    pub struct Description {
        /// The library's axes.
        pub axes: Table<Axis>,
        /// The axes of each of the library's passes, in the order of a variant's identifier.
        pub passes: Table<Vec<String>>,
        /// Facts of an input that formulas may name, 0 or 1.
        pub facts: BTreeSet<String>,
        /// Numbers that a person or an engine sets.
        pub parameter: Table<Parameter>,
        /// What the host writes into uniforms.
        pub input: Table<Input>,
        /// Draws of the host's own.
        pub draws: Table<DrawList>,
        /// Named configurations.
        pub preset: Table<Preset>,
        /// What facts change of the defaults.
        pub default: Vec<ClassDefault>,
        /// Configurations and variants that there are not.
        pub exclusion: Vec<Exclusion>,
        /// Names for formulas, which are evaluated where the name stands.
        #[serde(rename = "let")]
        pub lets: Table<Formula>,
        /// The members of uniforms; formulas in them are evaluated at the step that binds the uniform.
        pub uniform: Table<Table<Field>>,
        /// What is kept in memory.
        pub resource: Table<Resource>,
        /// What runs, in order.
        pub step: Vec<Step>,
    }

    /// An axis of the library.
    pub struct Axis {
        /// The value without a choice.
        pub default: String,
        /// All values.
        pub values: Vec<String>,
        /// Whether a variant's identifier leaves the default out; then it is the last axis of its passes.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        pub implied: bool,
    }

    /// A value, or the first of several cases that applies.
    #[serde(untagged, expecting = "a value, or a list of cases `{ when, value }`")]
    pub enum Choice<T> {
        /// The same in every configuration.
        Always(T),
        /// The value of the first case whose condition holds.
        Cases(Vec<Case<T>>),
    }

    /// A case of a [`Choice`].
    pub struct Case<T> {
        /// Its condition; without one it applies whenever no case before it does.
        pub when: Option<Formula>,
        /// Its value.
        pub value: T,
    }

    /// A whole or a real number.
    #[derive(Copy)]
    #[serde(untagged, expecting = "a number of at least 0")]
    pub enum Number {
        /// A whole number.
        Whole(u64),
        /// A real number.
        Real(f64),
    }

    /// Whether a parameter is whole or real.
    #[derive(Copy, Eq)]
    #[serde(rename_all = "snake_case")]
    pub enum ParameterType {
        /// Whole; formulas may name it.
        Whole,
        /// Real; uniforms alone may name it.
        Real,
    }

    /// How often a number may change.
    #[derive(Copy, Eq)]
    #[serde(rename_all = "snake_case")]
    pub enum Per {
        /// With the size of something: the frame is evaluated again.
        Resize,
        /// With the scene: the frame is evaluated again if it is a parameter.
        Scene,
        /// In every frame: it is an input.
        Frame,
    }

    /// A number that a person or an engine sets.
    #[serde(deny_unknown_fields)]
    pub struct Parameter {
        /// What it is, with its unit.
        pub description: String,
        /// Whole or real.
        #[serde(rename = "type")]
        pub kind: ParameterType,
        /// Its value unless it is set.
        pub default: Number,
        /// The smallest value that is allowed.
        pub minimum: Option<f64>,
        /// What it has to exceed.
        pub above: Option<f64>,
        /// The largest value that is allowed.
        pub maximum: Option<f64>,
        /// How often it may change.
        pub per: Per,
        /// Whether it is a size of what the host has, and no setting.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        pub host: bool,
    }

    /// What the host writes into uniforms.
    #[serde(deny_unknown_fields)]
    pub struct Input {
        /// What it is and how it is computed, with its unit.
        pub description: String,
        /// Its type in WGSL: a scalar, a vector, a matrix, or a structure of the uniform's variant.
        #[serde(rename = "type")]
        pub kind: String,
        /// How often it may change.
        pub per: Per,
        /// What the members of a structure are.
        #[serde(default)]
        pub member: Table<String>,
    }

    /// Draws of the host's own: it chooses their variants, binds what the frame does not, and issues them.
    #[serde(deny_unknown_fields)]
    pub struct DrawList {
        /// What is drawn, and what the host binds for it.
        pub description: String,
        /// The axes by which the host chooses variants.
        #[serde(default)]
        pub axes: Vec<String>,
    }

    /// A named configuration.
    pub struct Preset {
        /// What it is.
        pub description: String,
        /// Values of axes and parameters; the others keep their defaults.
        pub set: Table<Setting>,
    }

    /// The name of a value on an axis, or the number of a parameter.
    #[serde(untagged, expecting = "the name of a value, or a number of at least 0")]
    #[expect(missing_docs, reason = "said above")]
    pub enum Setting {
        Number(Number),
        Name(String),
    }

    /// A rule that changes defaults for a class of input.
    pub struct ClassDefault {
        /// Its name.
        pub name: String,
        /// When it holds, by the facts of the input and by axes as the preset, what is set and the rules before it leave them.
        pub when: Option<Formula>,
        /// Values of axes and parameters.
        pub set: Table<Setting>,
        /// Axes and parameters that these values make meaningless: the rule does not hold where one of them is set.
        #[serde(default)]
        pub unless: Vec<String>,
        /// Why.
        pub reason: String,
    }

    /// A rule that takes configurations out, or variants of some passes.
    pub struct Exclusion {
        /// Its name, if it has one.
        #[serde(default)]
        pub name: String,
        /// The passes of whose variants it takes some out; none if it is about whole configurations.
        #[serde(default)]
        pub passes: Vec<String>,
        /// What is taken out: a condition of the configuration, or of the axes of a variant.
        pub when: Formula,
        /// Why.
        pub reason: String,
    }

    /// What is kept in memory.
    #[serde(deny_unknown_fields)]
    pub struct Resource {
        /// What it holds.
        #[serde(default)]
        pub description: String,
        /// When it exists; always without it.
        pub when: Option<Formula>,
        /// The part of the frame it is counted under.
        #[serde(default)]
        pub part: String,
        /// Whether the host supplies it. It may supply others, too, but none that is kept.
        #[serde(default)]
        pub external: bool,
        /// Whether its contents last from frame to frame.
        #[serde(default)]
        pub kept: bool,
        /// What it is.
        #[serde(flatten)]
        pub kind: Kind,
    }

    /// What a resource is. Its numbers are formulas, or known in a frame.
    #[serde(rename_all = "snake_case")]
    #[expect(missing_docs, reason = "said of each kind")]
    pub enum Kind<N = Formula, F = Choice<String>> {
        /// So many elements of so many bytes. From its creation it begins with the words `initial`; the rest is 0.
        Buffer {
            length: N,
            stride: N,
            #[serde(default)]
            initial: Vec<u32>,
        },
        /// A two-dimensional texture of a format, as WebGPU names it, and of the width and height of level 0. What nothing
        /// writes is 0.
        Texture { format: F, size: [N; 2], layers: N, levels: N },
        /// A sampler that clamps to the edge.
        Sampler(Filter),
    }

    /// How a sampler filters, within a level and between levels.
    #[derive(Copy, Eq)]
    #[serde(rename_all = "snake_case")]
    pub enum Filter {
        /// It does not.
        Nearest,
        /// Linearly.
        Linear,
    }

    /// A resource by its name, or, in a frame, by its index.
    #[derive(Copy, Eq)]
    pub struct Reference<R = String, N = Formula> {
        /// The resource.
        pub resource: R,
        /// The one level of a texture that is meant; all levels without it.
        pub level: Option<N>,
    }

    /// A member of a uniform.
    #[serde(untagged, expecting = "a formula, a number, an input, an age, or a list of these")]
    #[expect(missing_docs, reason = "said of each kind")]
    pub enum Field {
        /// A formula, or the name of a real parameter.
        Formula(Formula),
        /// A constant.
        Number(f64),
        /// One after the other: components of a vector, or elements of an array.
        List(Vec<Field>),
        /// What the host writes, or one element of it if the input is an array of what the member is.
        Input { input: String, element: Option<Formula> },
        /// How many frames ago a kept resource was new: 0 in the first one.
        Age { age: String },
    }

    /// One step: a pass, a clear, or a group of steps.
    #[derive(Default)]
    #[serde(default)]
    pub struct Step {
        /// What its time is called; consecutive dispatches of one label are timed as one.
        pub label: String,
        /// The part of the frame that it belongs to.
        pub part: String,
        /// When it runs; always without it.
        pub when: Option<Formula>,
        /// The kept resource in whose first frame after creation, resize or restart alone it runs.
        pub new: Option<String>,

        /// The pass that it runs.
        pub pass: Option<String>,
        /// Values of axes of the pass; of the others, and where no case applies, what the configuration says.
        pub axes: Table<Choice<String>>,
        /// The compute entry point, where the pass has several.
        pub entry: Option<String>,
        /// Resources by the names of bindings. Those that a variant lacks are dropped.
        pub bind: Table<Choice<Reference>>,
        /// Uniforms by the names of bindings.
        pub uniforms: Table<String>,
        /// Numbers of the pipeline by the names of overrides. Those that a variant lacks are dropped.
        pub constants: Table<Formula>,
        /// Workgroups of a dispatch.
        pub dispatch: Option<[Formula; 3]>,
        /// The buffer that holds the workgroups of a dispatch or the arguments of a draw.
        pub indirect: Option<Choice<Reference>>,
        /// The first byte of these in it, a multiple of 4; 0 without it.
        pub offset: Option<Formula>,
        /// What is drawn.
        pub draw: Option<Draw>,

        /// The buffer that is cleared to 0.
        pub clear: Option<Choice<Reference>>,
        /// How many of its bytes; all of them without it.
        pub bytes: Option<Formula>,

        /// The steps of a group.
        pub steps: Vec<Step>,
        /// How many times the group runs; once without it.
        pub repeat: Option<Formula>,
        /// The name of the round's number, from 0 on.
        pub index: Option<String>,
    }

    /// What a step draws in one render pass.
    #[derive(Default)]
    #[serde(default)]
    pub struct Draw {
        /// The vertex entry point.
        pub vertex: String,
        /// The fragment entry point; without one, or without a case that applies, there is no fragment stage.
        pub fragment: Option<Choice<String>>,
        /// Colour targets, in the order of their locations.
        pub color: Vec<Color>,
        /// The depth target.
        pub depth: Option<Depth>,
        /// Vertex buffers, in the order of their slots.
        pub vertices: Vec<Vertices>,
        /// The buffer of 32-bit indices; vertices are drawn in their order without it.
        pub indices: Option<Choice<Reference>>,
        /// The host's draws, which take the place of `indices`, `count` and instances.
        pub list: Option<String>,
        /// How many vertices or indices are drawn.
        pub count: Option<Formula>,
        /// First instance and number of instances; 0 and 1 without it.
        pub instances: Option<[Formula; 2]>,
        /// How many times it draws; once without it.
        pub repeat: Option<Formula>,
        /// The name of the number of each time, from 0 on.
        pub index: Option<String>,
        /// Left, top, width and height in pixels; the whole target without it.
        pub viewport: Option<[Formula; 4]>,
    }

    /// A colour target.
    pub struct Color {
        /// The texture.
        pub target: Choice<Reference>,
        /// What it is cleared to before; what it holds stays without it.
        pub clear: Option<[f64; 4]>,
    }

    /// A depth target.
    pub struct Depth {
        /// The texture.
        pub target: Choice<Reference>,
        /// What it is cleared to before; what it holds stays without it.
        pub clear: Option<f64>,
        /// The comparison, as WebGPU names it.
        pub compare: String,
        /// Whether what is drawn changes it.
        #[serde(default)]
        pub write: bool,
    }

    /// A vertex buffer.
    pub struct Vertices {
        /// The buffer; the host's own without it.
        pub buffer: Option<Choice<Reference>>,
        /// Bytes of a vertex.
        pub stride: u64,
        /// Its attributes.
        #[serde(default)]
        pub attributes: Vec<Attribute>,
    }

    /// An attribute of a vertex.
    #[derive(Eq)]
    #[serde(deny_unknown_fields)]
    pub struct Attribute {
        /// Its location in the shader.
        pub location: u32,
        /// Its format, as WebGPU names it.
        pub format: String,
        /// Its first byte.
        pub offset: u64,
    }
);

//! The manifest of a package: what each variant is, needs and promises.

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

mod comments;
mod cost;
mod layout;
mod omitted;
mod purpose;
pub mod reflect;
mod shared;
mod variant;

pub use cost::{Cost, LoopCost, Operations};
pub use layout::{FieldType, Layout, LayoutField};
pub use omitted::Omissions;
pub use purpose::{Assumed, LeftOut, MadeFor, Saved, Weight};
pub use reflect::{Error, Reflection, reflect};
pub use shared::Shared;
pub use variant::{Described, variant};

/// The version of what [`Manifest`] says; it grows when a reader of the version before would misread it.
pub const SCHEMA_VERSION: u32 = 7;

/// A package of shaders: what it contains, by what it was made, and of what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The version of this format.
    pub schema_version: u32,
    /// Name of the package.
    pub package: String,
    /// Version of the package.
    pub version: String,
    /// One sentence.
    pub description: String,
    /// SPDX licence expression.
    pub license: String,
    /// What wrote it.
    pub generator: Tool,
    /// The version of naga that has validated every variant.
    pub naga: String,
    /// SHA-256 of all that the package was made of: sources, `library.toml`, the selection and the targets.
    pub source_hash: String,
    /// The works that descriptions and comments refer to.
    pub citations: Vec<Citation>,
    /// What every name at module scope starts with.
    pub prefix: String,
    /// The input that the package was made for; any, if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub made_for: Option<MadeFor>,
    /// What was left out because that input does not need it, rule by rule.
    pub left_out: Vec<LeftOut>,
    /// The languages that the variants are written in, sorted.
    pub targets: Vec<String>,
    /// The choices that passes offer, in alphabetical order.
    pub axes: Vec<Axis>,
    /// The passes, in the order in which they run.
    pub passes: Vec<Pass>,
    /// The frame: parameters, presets, exclusions, inputs, resources and steps, in the language of the crate `sglow-graph`. What
    /// is absent is empty or false.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<sglow_graph::Description>")]
    pub graph: Option<serde_json::Value>,
    /// Functions for hosts that bring their own passes: first the file of all of them, then modules. Each function stands once
    /// in that file and once in the modules.
    pub libraries: Vec<FunctionLibrary>,
    /// What variants refer to by key.
    pub shared: Shared,
    /// The variants, sorted by identifier.
    pub variants: Vec<Variant>,
}

/// A program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tool {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
}

/// A work that is referred to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Citation {
    /// How it is called, as in `[Key, Eq. (1)]`.
    pub key: String,
    /// The full reference.
    pub text: String,
}

/// A choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// What is chosen.
    pub description: String,
    /// The value that is taken when none is given.
    pub default: String,
    /// What can be chosen.
    pub values: Vec<AxisValue>,
}

/// A value of an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisValue {
    /// Its name.
    pub name: String,
    /// What choosing it means.
    pub description: String,
}

/// One or more entry points with their bindings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pass {
    /// Its name.
    pub name: String,
    /// What it does.
    pub description: String,
    /// Its axes, in the order of the values in a variant's identifier.
    pub axes: Vec<String>,
}

/// Functions for hosts that bring their own passes: a file that has all of them as WGSL, which has the library's name, or a
/// module of WESL that imports its neighbours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FunctionLibrary {
    /// Its name.
    pub name: String,
    /// Where it is written.
    pub files: Vec<File>,
}

/// A pass with a value on each of its axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    /// Pass and values joined by `-`.
    pub id: String,
    /// Name of its pass.
    pub pass: String,
    /// The value on each axis.
    pub axes: BTreeMap<String, String>,
    /// Keys of its entry points.
    pub entry_points: Vec<String>,
    /// The static operations that each of them reaches, outside loops and for each turn of its loops, by its name.
    pub cost: BTreeMap<String, Cost>,
    /// Keys of what it binds, by group and number.
    pub bindings: Vec<String>,
    /// Keys of the structs in its buffers, each after those within it.
    pub structs: Vec<String>,
    /// Numbers that may be set when a pipeline is made.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub overrides: Vec<Override>,
    /// Key of what a device must have.
    pub requires: String,
    /// Key of the units and ranges of its inputs.
    pub contract: String,
    /// Where it is written.
    pub files: Vec<File>,
    /// Its error, once measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<serde_json::Value>,
    /// How long it takes, once measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<serde_json::Value>,
}

/// A function that a pipeline starts in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EntryPoint {
    /// Its name.
    pub name: String,
    /// Its stage.
    pub stage: Stage,
    /// Invocations of a workgroup in x, y and z; compute only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub workgroup_size: Option<[u32; 3]>,
}

/// A stage of a pipeline.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Once per vertex.
    Vertex,
    /// Once per fragment.
    Fragment,
    /// Once per invocation of a grid.
    Compute,
    /// A stage that WebGPU does not have.
    Other,
}

/// A resource that a host binds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Binding {
    /// Number of its bind group.
    pub group: u32,
    /// Its number within the group.
    pub binding: u32,
    /// Its name in the text.
    pub name: String,
    /// What it is.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// The stages that use it.
    pub visibility: Vec<Stage>,
    /// What is bound.
    #[serde(flatten)]
    pub resource: Resource,
}

/// What is bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Resource {
    /// A uniform buffer.
    Uniform {
        /// Its type in WGSL.
        r#type: String,
        /// The least number of bytes to bind.
        min_size: u64,
    },
    /// A storage buffer.
    Storage {
        /// What is done with it.
        access: Access,
        /// Its type in WGSL.
        r#type: String,
        /// The least number of bytes to bind: with one element of a runtime-sized array.
        min_size: u64,
        /// Bytes from one element of an array to the next.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stride: Option<u32>,
    },
    /// A texture that is loaded from or sampled.
    Texture {
        /// The dimension of the view.
        dimension: Dimension,
        /// What its texels give.
        sample_type: SampleType,
        /// Whether it has several samples per texel.
        multisampled: bool,
    },
    /// A texture that is written, or read without a sampler.
    StorageTexture {
        /// The dimension of the view.
        dimension: Dimension,
        /// Its format, as WebGPU spells it.
        format: String,
        /// What is done with it.
        access: Access,
    },
    /// A sampler.
    Sampler {
        /// What it does.
        sampler_type: SamplerType,
    },
}

impl Resource {
    /// The WebGPU limit per stage that it counts against.
    fn limit(&self) -> &'static str {
        match self {
            Self::Uniform { .. } => "maxUniformBuffersPerShaderStage",
            Self::Storage { .. } => "maxStorageBuffersPerShaderStage",
            Self::Texture { .. } => "maxSampledTexturesPerShaderStage",
            Self::StorageTexture { .. } => "maxStorageTexturesPerShaderStage",
            Self::Sampler { .. } => "maxSamplersPerShaderStage",
        }
    }
}

/// What is done with a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Access {
    /// It is read.
    Read,
    /// It is written.
    Write,
    /// It is read and written.
    ReadWrite,
}

/// The dimension of a texture view, as WebGPU spells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Dimension {
    /// One.
    #[serde(rename = "1d")]
    D1,
    /// Two.
    #[serde(rename = "2d")]
    D2,
    /// Layers of two.
    #[serde(rename = "2d-array")]
    D2Array,
    /// Six faces.
    #[serde(rename = "cube")]
    Cube,
    /// Layers of six faces.
    #[serde(rename = "cube-array")]
    CubeArray,
    /// Three.
    #[serde(rename = "3d")]
    D3,
}

/// What the texels of a texture give, as WebGPU spells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SampleType {
    /// Floats that a sampler filters.
    Float,
    /// Floats that are only loaded, so that no format has to be filterable.
    UnfilterableFloat,
    /// Depth.
    Depth,
    /// Signed integers.
    Sint,
    /// Unsigned integers.
    Uint,
}

/// What a sampler does, as WebGPU spells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SamplerType {
    /// It may filter.
    Filtering,
    /// It compares with a reference.
    Comparison,
}

/// A struct in a buffer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Struct {
    /// Its name.
    pub name: String,
    /// What it is.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Bytes, its padding included; with one element of a runtime-sized array.
    pub size: u32,
    /// Alignment in bytes.
    pub align: u32,
    /// Its fields, in order.
    pub fields: Vec<Field>,
}

/// A field of a struct.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// What it is, with unit and range.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Its type in WGSL.
    pub r#type: String,
    /// Bytes from the start of the struct.
    pub offset: u32,
    /// Bytes; those of one element for a runtime-sized array.
    pub size: u32,
    /// Bytes from one element of an array to the next.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stride: Option<u32>,
}

/// A number that may be set when a pipeline is made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Override {
    /// Its key among a pipeline's constants.
    pub name: String,
    /// Its type in WGSL.
    pub r#type: String,
    /// The value it has when none is set; one has to be set if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub default: Option<serde_json::Number>,
    /// The least value allowed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub minimum: Option<serde_json::Number>,
    /// The greatest value allowed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub maximum: Option<serde_json::Number>,
    /// What it is, with its unit.
    pub description: String,
}

/// What a device must have.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Requires {
    /// WebGPU features, sorted.
    pub features: BTreeSet<String>,
    /// What is needed of WebGPU's limits; a limit that is not named is not touched.
    pub limits: BTreeMap<String, u64>,
    /// Those of the limits for which WebGPU's default is not enough.
    pub limits_beyond_default: BTreeSet<String>,
}

/// A file of the package.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct File {
    /// Its language.
    pub target: String,
    /// Where it lies in the package.
    pub path: String,
    /// SHA-256 of its bytes in hexadecimal.
    pub sha256: String,
    /// What wrote it.
    pub tool: String,
}

/// The JSON schema of [`Manifest`], as it lies in `manifest.schema.json`.
#[must_use]
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(Manifest).to_value()
}

//! `library.toml`: what a library offers, in the author's own words.

mod calls;
mod check;
mod document;
mod frame;
mod inputs;
mod load;
mod modules;
mod overlay;
pub(crate) mod place;
mod preset;
mod rule;
mod steps;
mod value;

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Deserialize;

pub use self::calls::Calls;
pub use self::frame::Frame;
pub use self::inputs::Example;
pub use self::overlay::Overlay;
pub use self::preset::{Measurement, Preset, PresetFile};
pub use self::rule::{ClassDefault, Condition, Exclusion};
use crate::link::Graph;
use crate::source::Sources;
pub use sglow_graph::description::{Parameter, Setting};

/// A library of shaders as its `library.toml` declares it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Library {
    /// Name, version and rules of the whole.
    pub library: Header,
    /// Works that comments and descriptions refer to.
    #[serde(default)]
    pub citation: Vec<Citation>,
    /// Facts of a user's input that [`Need`]s may depend on.
    #[serde(default)]
    pub fact: Vec<Fact>,
    /// Choices that passes offer, by name.
    #[serde(default)]
    pub axis: BTreeMap<String, Axis>,
    /// Named configurations: those of the declaration, then those of [`Header::presets`].
    #[serde(default)]
    pub preset: Vec<Preset>,
    /// What facts change of the defaults.
    #[serde(default, rename = "default")]
    pub class_default: Vec<ClassDefault>,
    /// Passes, in the order in which they run.
    #[serde(default)]
    pub pass: Vec<Pass>,
    /// Combinations of values that are illegal.
    #[serde(default)]
    pub exclusion: Vec<Exclusion>,
    /// What facts require of axes.
    #[serde(default)]
    pub need: Vec<Need>,
    /// What exists only where something else does.
    #[serde(default)]
    pub presence: Vec<Presence>,
    /// Functions that are evaluated over a buffer.
    #[serde(default)]
    pub calls: Option<Calls>,
    /// The committed selection.
    pub package: PackageSelection,
    /// What host inputs are for some arguments, by input or `input.member`.
    #[serde(skip)]
    pub examples: BTreeMap<String, Vec<Example>>,
    #[serde(skip)]
    overlays: Vec<Overlay>,
    #[serde(skip)]
    frame: Option<Frame>,
    #[serde(skip)]
    sources: Arc<Sources>,
    #[serde(skip)]
    graph: Arc<Graph>,
}

/// The `[library]` table.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    /// Name of the library.
    pub name: String,
    /// Version of the library, as in `1.2.3`.
    pub version: String,
    /// One sentence.
    pub description: String,
    /// SPDX licence expression.
    pub license: String,
    /// What every name at module scope starts with, in snake case with its underscore: `abc_`. Types start with the
    /// same in camel case (`Abc`), constants in capitals (`ABC_`).
    pub prefix: String,
    /// Folder of the sources, relative to `library.toml`.
    pub source: String,
    /// A file of more presets, which a program has measured and written, relative to `library.toml`. It need not exist.
    #[serde(default)]
    pub presets: Option<String>,
    /// The file that describes the frame in the language of [`crate::frame`], relative to `library.toml`.
    #[serde(default)]
    pub frame: Option<String>,
    /// The file that says what the frame's host inputs are for some arguments, relative to `library.toml`.
    #[serde(default)]
    pub inputs: Option<String>,
}

/// A work that the sources cite.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Citation {
    /// How the sources call it, as in `[Key, Eq. (1)]`.
    pub key: String,
    /// The full reference.
    pub text: String,
}

/// Something that is true or false of a user's input.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fact {
    /// Name of the fact.
    pub name: String,
    /// What it means that the fact holds.
    pub description: String,
}

/// A typed choice.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// What is chosen.
    pub description: String,
    /// Name of the value that is taken when none is given.
    pub default: String,
    /// Whether a person or an engine sets it; else it follows from other axes, from what is drawn, or from the step.
    #[serde(default = "yes")]
    pub setting: bool,
    /// Whether methods are compared by it; else it is what the scene or the host has.
    #[serde(default = "yes")]
    pub compared: bool,
    /// Whether its default is left out of identifiers and of the heads of texts: variants keep their names when their pass
    /// gains such an axis. Of each pass the last axis alone may be one, so that an identifier still says all.
    #[serde(default)]
    pub implied: bool,
    /// The values, in the author's order.
    pub value: Vec<AxisValue>,
}

fn yes() -> bool {
    true
}

/// One value of an [`Axis`].
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisValue {
    /// Name of the value.
    pub name: String,
    /// What choosing it means.
    pub description: String,
    /// Flags that hold in the sources when it is chosen.
    #[serde(default)]
    pub flags: Vec<String>,
    /// WebGPU features that a device must have.
    #[serde(default)]
    pub requires: Vec<String>,
    /// On the axis of [`Calls`]: the call that is evaluated when it is chosen.
    #[serde(default)]
    pub call: Option<String>,
    /// What is stored of a struct that the call returns: members, with a swizzle or without, of at most 4 numbers.
    #[serde(default)]
    pub results: Vec<String>,
}

/// One or more entry points with their bindings.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pass {
    /// Name of the pass.
    pub name: String,
    /// What it does.
    pub description: String,
    /// The module that holds its entry points, relative to [`Header::source`].
    pub source: String,
    /// Names of its entry points.
    pub entry_points: Vec<String>,
    /// Names of its axes; their order is the order of values in a variant's identifier.
    #[serde(default)]
    pub axes: Vec<String>,
    /// Units and ranges of its inputs.
    #[serde(default)]
    pub contract: Vec<ContractLine>,
    /// Numbers that may be set when a pipeline is made.
    #[serde(default, rename = "override")]
    pub overrides: Vec<Override>,
}

/// What a pass expects of an input, or promises of an output.
#[derive(Clone, Debug, Deserialize)]
#[serde(from = "WrittenLine")]
pub struct ContractLine {
    /// `name: text`
    pub text: String,
    /// Per axis of the pass the values for which the line is part of the contract; every value of an axis that is not
    /// named.
    pub when: BTreeMap<String, Vec<String>>,
}

/// How a [`ContractLine`] is written.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a text, or a table of `text` and `when`")]
enum WrittenLine {
    Text(String),
    Table(ConditionalLine),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ConditionalLine {
    text: String,
    when: BTreeMap<String, Vec<String>>,
}

impl From<WrittenLine> for ContractLine {
    fn from(line: WrittenLine) -> Self {
        match line {
            WrittenLine::Text(text) => Self { text, when: BTreeMap::new() },
            WrittenLine::Table(ConditionalLine { text, when }) => Self { text, when },
        }
    }
}

/// A number that may be set when a pipeline is made.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Override {
    /// Its name in the sources.
    pub name: String,
    /// What it is, with its unit.
    pub description: String,
    /// Least value allowed.
    pub minimum: f64,
    /// Greatest value allowed.
    pub maximum: f64,
}

/// A named rule that narrows axes by facts.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Need {
    /// Name of the rule, given as the reason for what it does.
    pub name: String,
    /// Facts and what they must be for the rule to hold.
    pub when: BTreeMap<String, bool>,
    /// Per axis the values that remain allowed.
    pub set: BTreeMap<String, Vec<String>>,
    /// Why.
    pub reason: String,
}

/// A named rule that lets variants exist only where choices on other axes are still possible.
///
/// A pass may be of use to another one alone, which has an axis that it lacks itself. Such a rule says so.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Presence {
    /// Name of the rule, given as the reason for what it leaves out.
    pub name: String,
    /// The passes it holds for.
    pub passes: Vec<String>,
    /// Per axis of these passes the values that it holds for; every value of an axis that is not named.
    #[serde(default)]
    pub when: BTreeMap<String, Vec<String>>,
    /// Alternatives, of which one has to hold: per axis, of these passes or not, the values of which at least one still
    /// has to be allowed.
    pub only_with: Vec<BTreeMap<String, Vec<String>>>,
    /// Why.
    pub reason: String,
}

/// The `[package]` table: what is committed of the space.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PackageSelection {
    /// Name of the package.
    pub name: String,
    /// Slices of the space; their union is selected.
    #[serde(default)]
    pub select: Vec<Select>,
    /// Files of functions for hosts that bring their own passes.
    #[serde(default)]
    pub lib: Vec<FunctionLibrary>,
}

/// A slice of the space.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Select {
    /// Name of the pass.
    pub pass: String,
    /// Values per axis; an axis that is not named takes every value.
    #[serde(default)]
    pub axes: BTreeMap<String, Vec<String>>,
}

/// A file of functions without bindings or entry points.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FunctionLibrary {
    /// Stem of the file.
    pub name: String,
    /// Modules whose declarations it offers, relative to [`Header::source`].
    pub modules: Vec<String>,
}

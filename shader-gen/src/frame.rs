//! The frame as an author writes it, without templates, and checked.
//!
//! `frame.toml` is written in the language that this page describes ([`authored`] has its types). `expand` makes of it the
//! [`Description`] that a manifest carries and of which a frame is evaluated: [`sglow_graph`] describes what both have in
//! common, resources, steps and numbers. [`check()`] compares it with what shaders bind.
//!
//! ```
//! use sglow_graph::{Configuration, Description};
//! use sglow_shader_gen::frame::authored::Authored;
//! let authored: Authored = toml::from_str(r#"
//! [parameter.side]
//! description = "width and height of the image in texels"
//! type = "whole"
//! default = 256
//! per = "resize"
//! [template.frame.let]
//! levels = "log2(side) + 1"
//! [template.frame.resource.image]
//! texture = { format = [{ when = "texel == 'r32float'", value = "r32float" }, { value = "rgba16float" }],
//!             size = ["side", "side"], levels = "levels" }
//! [[template.frame.step]]
//! use = "mips"
//! names = { pyramid = "image" }
//! let = { width = "side" }
//! [[template.mips.step]]
//! repeat = "levels - 1"
//! index = "level"
//! [[template.mips.step.steps]]
//! label = "mips"
//! pass = "halve"
//! bind = { finer = "pyramid@level", coarser = "pyramid@level + 1" }
//! dispatch = ["div_ceil(width >> level + 1, 8)", "div_ceil(width >> level + 1, 8)", 1]
//! "#)?;
//! // What a library declares beside its frame.
//! let library: Description = serde_json::from_str(r#"{
//!     "passes": { "halve": ["texel"] },
//!     "axes": { "texel": { "default": "r32float", "values": ["r32float", "rgba16float"] } }
//! }"#)?;
//! let description = authored.description(library)?;
//! let frame = description.evaluate(&Configuration::default())?;
//! assert_eq!((frame.steps.len(), frame.resources[0].bytes), (8, 4 * (4_u64.pow(9) - 1) / 3));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Formulas
//! A text of whole numbers of 64 bits: `|| && == != <= >= < > << >> + - * / % !` (tighter from left to right as in Rust,
//! comparisons before shifts), brackets, the functions of [`sglow_graph`], and `axis == 'value'` or `axis != 'value'`. A
//! *condition* is a formula; a *choice* is a value or the first of `[{ when, value }, …]` that applies.
//!
//! # Templates
//! `template.frame` is the frame. A step with `use` runs another template with numbers (`let`), axes, and names of resources
//! and inputs (`names`) of its own; `prefix` stands before the names of what the template declares. A name in a template is
//! an argument, a let of the template, or known to the whole frame: a let of `template.frame`, a parameter, a fact. What it
//! declares is known from the step on that uses it, and absent where that does not run. `choose` derives axes from others,
//! in each use by the axes of the use.
//!
//! # Resources
//! A reference is `name`, or `name@level` for one level of a texture. A `flip` is a pair: `name.front` is the newest,
//! `name.back` what is written next; they change places at the end of each round of a repetition that says so, as often in
//! each round, and begin each frame in their order. The description has two resources, `name.0` and `name.1`, and chooses
//! one of them by how often they have changed places. An alias is another name.

pub mod authored;
mod check;
pub(crate) mod distinct;
mod expand;
pub(crate) mod formula;
mod scope;

pub use check::{check, json};
pub(crate) use expand::{Expanded, expand};
pub use formula::Text;
pub(crate) use scope::Origin;
use sglow_graph::Description;
use thiserror::Error;

use self::authored::Authored;

/// A frame that is none in any configuration: what is wrong, each with its place.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{}", .0.join("\n"))]
pub struct Faults(pub Vec<String>);

impl Authored {
    /// The frame without templates. `library` has what a library declares beside it: axes, passes, facts, presets, defaults,
    /// exclusions.
    ///
    /// # Errors
    ///
    /// What is wrong whatever the configuration: names that nothing declares, texts that are no formulas.
    pub fn description(&self, library: Description) -> Result<Description, Faults> {
        let Expanded { description, faults, .. } = expand(self, library);
        let text = |fault: &scope::Fault| {
            let used = fault.origin.used.as_ref();
            let used =
                used.map_or_else(String::new, |used| format!(", used by {}", used.join(".")));
            format!("{}: {}{used}", fault.origin.path.join("."), fault.text)
        };
        let faults: Vec<String> = faults.iter().map(text).collect();
        if faults.is_empty() { Ok(description) } else { Err(Faults(faults)) }
    }
}

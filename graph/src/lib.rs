//! A frame as data: which resources a renderer keeps and which passes it runs on them, for every configuration.
//!
//! A [`Description`] is written by the author of a shader library, in TOML or in JSON; [`Description::evaluate`] turns it into
//! the [`Frame`] of one [`Configuration`]. That happens at creation and on a resize: per frame a host writes its inputs
//! alone. Nothing here opens a device or reads a shader. What shaders bind, and whether a view of a texture is sampled,
//! stored to or drawn to, follows from their reflection; whoever executes a frame drops the bindings that a variant lacks.
//!
//! ```
//! use sglow_graph::{Configuration, Description};
//! let text = r#"
//! passes = { halve = ["texel"] } # a generator fills in what the library declares, as here and in the next line
//! axes = { texel = { default = "r32float", values = ["r32float", "rgba16float"] } }
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
//! repeat = "levels - 1"
//! index = "level"
//! [[template.frame.step.steps]]
//! label = "mips"
//! pass = "halve"
//! bind = { finer = "image@level", coarser = "image@level + 1" }
//! dispatch = ["div_ceil(side >> level + 1, 8)", "div_ceil(side >> level + 1, 8)", 1]
//! "#;
//! let description: Description = toml::from_str(text)?;
//! let frame = description.evaluate(&Configuration::default())?;
//! assert_eq!((frame.steps.len(), frame.resources[0].bytes), (8, 4 * (4_u64.pow(9) - 1) / 3));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Numbers
//! A *parameter* is set by a person or an engine, an *axis* chooses text; the library declares its axes, presets, defaults and
//! exclusions. A *let* is derived.
//! A [`Formula`] is of whole numbers of 64 bits: `|| && == != <= >= < > << >> + - * / % !` (tighter from left to right as in
//! Rust, comparisons before shifts), brackets, `min(a, b)`, `max(a, b)`, `div_ceil(a, b)`, `log2(a)` (rounded down),
//! `pow2_ceil(a)`, `bits(a)` (how many hold a), `select(condition, a, b)`, and `axis == 'value'` or `axis != 'value'`. What is
//! not 0 is true. An overflow, a division by 0, a negative difference and `log2(0)` are errors; `&&`, `||` and `select` evaluate
//! what decides alone. A *condition* is a formula; a *choice* is a value or the first of `[{ when, value }, …]` that applies.
//!
//! # Configurations
//! [`Description::configure`] makes one of the class of an input (`default`), a `preset` and what is set by hand. It is illegal
//! if it misses a `require`, or a pass that runs has values that an `exclusion` names together: an error with the rule.
//!
//! # Templates
//! `template.frame` is the frame. A step with `use` runs another template with numbers (`let`), axes, and names of resources
//! and inputs (`names`) of its own; `prefix` stands before the names of what the template declares. A name in a template is
//! an argument, a let of the template, or known to the whole frame: a let of `template.frame`, a parameter, a fact. What it
//! declares is known from the step on that uses it, and absent where that does not run.
//!
//! # Resources
//! A buffer is `length` times `stride` bytes, a texture two-dimensional, of one sample. Nothing has contents at creation but
//! zeros and the `initial` words of a buffer. What is neither `external` nor `kept` need not outlive a frame. A `flip` is a pair:
//! `name.front` is the newest, `name.back` what is written next; they change places at the end of each round of a repetition
//! that says so, and begin each frame in their order. `name@level` is one level of a texture. An alias is another name.
//! A binding whose resource does not exist, or of which no case applies, is absent.
//!
//! # Steps
//! Steps run in their order. `pass` with `dispatch` (workgroups), `indirect` or `draw`; `clear` of a buffer, wholly or its first
//! `bytes`; `use`; or a group of `steps`, which `repeat` runs any number of times, none as well. `new` names a kept resource:
//! the step runs in its first frame alone, after creation, a resize or a restart. Consecutive dispatches of one `label` are
//! timed as one. A `draw` is one render pass of one or several calls; a `list` is drawn by the host, which chooses variants
//! by the axes of the list and binds what the frame does not.
//!
//! A member of a uniform is a formula, a constant, an input of the host, the age of a kept resource in frames, or a list of
//! these, one after the other. An input fills the member that it is given to, or, with `element`, that element of it does.
//!
//! # Hosts
//! A configuration may leave out parts of the frame and supply resources itself: those are `external` in the result.

pub mod configuration;
pub mod description;
pub mod error;
mod evaluate;
pub mod formula;
pub mod frame;
mod parse;
pub mod reference;
mod scope;

pub use configuration::Configuration;
pub use description::Description;
pub use error::{Error, Errors, Place, Problem};
pub use formula::Formula;
pub use frame::Frame;

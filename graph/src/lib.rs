//! A frame as data: which resources a renderer keeps and which passes it runs on them, for every configuration.
//!
//! A [`Description`] is what a package's manifest has under `graph`; [`Description::evaluate`] turns it into the [`Frame`] of
//! one [`Configuration`]. That happens at creation and on a resize: per frame a host writes its inputs alone. Nothing here
//! opens a device or reads a shader. What shaders bind, and whether a view of a texture is sampled, stored to or drawn to,
//! follows from their reflection; whoever executes a frame drops the bindings that a variant lacks. The author of a shader
//! library writes another form, with templates and formulas as texts, of which the generator makes this one.
//!
//! ```
//! use sglow_graph::{Configuration, Description};
//! let description: Description = serde_json::from_str(r#"{
//!     "axes": { "texel": { "default": "r32float", "values": ["r32float", "rgba16float"] } },
//!     "passes": { "halve": ["texel"] },
//!     "parameter": { "side": { "description": "of the image, in texels", "type": "whole", "default": 256, "per": "resize" } },
//!     "let": { "levels": { "+": [{ "log2": [{ "name": "side" }] }, 1] } },
//!     "resource": { "image": { "texture": {
//!         "format": [{ "when": { "is": ["texel", "r32float"] }, "value": "r32float" }, { "value": "rgba16float" }],
//!         "size": [{ "name": "side" }, { "name": "side" }], "layers": 1, "levels": { "name": "levels" }
//!     } } },
//!     "step": [{ "repeat": { "-": [{ "name": "levels" }, 1] }, "index": "level", "steps": [{
//!         "label": "mips", "pass": "halve",
//!         "bind": { "finer": { "resource": "image", "level": { "name": "level" } } },
//!         "dispatch": [{ "div_ceil": [{ ">>": [{ "name": "side" }, { "name": "level" }] }, 16] }, 1, 1]
//!     }] }]
//! }"#)?;
//! let frame = description.evaluate(&Configuration::default())?;
//! assert_eq!((frame.steps.len(), frame.resources[0].bytes), (8, 4 * (4_u64.pow(9) - 1) / 3));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Numbers
//! A *parameter* is set by a person or an engine, an *axis* chooses text, a *let* is another name for a formula, evaluated where
//! the name stands. A [`Formula`] is of whole numbers of 64 bits: `|| && == != <= >= < > << >> + - * / % !`, `min(a, b)`,
//! `max(a, b)`, `div_ceil(a, b)`, `log2(a)` (rounded down), `pow2_ceil(a)`, `bits(a)` (number of bits of a),
//! `select(condition, a, b)`. What is not 0 is true. An overflow, a division by 0, a negative difference and `log2(0)` are
//! errors; `&&`, `||` and `select` short-circuit. A *choice* is a value or the first of
//! `[{ when, value }, …]` that applies.
//!
//! # Configurations
//! [`Description::configure`] makes one of the class of an input (`default`), a `preset` and what is set by hand. It is illegal
//! if an `exclusion` holds for it, or for a pass that runs with its axes: an error with the rule.
//!
//! # Resources and steps
//! What is neither `external` nor `kept` need not outlive a frame. A binding whose resource does not exist, or of which no case
//! applies, is absent. Steps run in their order: a `pass` with `dispatch` (workgroups), `indirect` or `draw`; a `clear` of a
//! buffer; or a group of `steps`, which `repeat` runs zero or more times. A `draw` is one render pass.

pub mod configuration;
mod configure;
pub mod description;
pub mod error;
mod evaluate;
pub mod formula;
pub mod frame;
mod scope;

pub use configuration::Configuration;
pub use description::Description;
pub use error::{Error, Errors};
pub use formula::Formula;
pub use frame::Frame;

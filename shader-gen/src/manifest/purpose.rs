//! What a package was made for, and what was left out of it for that.

use std::collections::BTreeMap;
use std::ops::Sub;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The input that a package was made for. A package without one is for any input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MadeFor {
    /// Its name.
    pub input: String,
    /// What was taken to be so of it, and lets rules leave things out. With an input of which it is not so the package
    /// must not be used.
    pub assumed: Vec<Assumed>,
    /// The value that was chosen on each axis that has one.
    pub chosen: BTreeMap<String, String>,
    /// All that was left out, against a package for an input of which every fact holds.
    pub saved: Saved,
}

/// Something that was taken to be so.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Assumed {
    /// The fact.
    pub fact: String,
    /// Whether it holds.
    pub holds: bool,
    /// What shows it.
    pub evidence: String,
    /// The rule that left something out because of it.
    pub rule: String,
}

/// Something that was left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// The rule that left it out.
    pub rule: String,
    /// Its reason.
    pub reason: String,
    /// The values that were left out of each axis.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, Vec<String>>,
    /// The variants that were left out because they are of no use with what was chosen.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub variants: Vec<String>,
    /// What `saved` compares with.
    pub against: String,
    /// What this rule alone has saved.
    pub saved: Saved,
}

impl LeftOut {
    /// What was left out, in a line: values of axes, or variants.
    #[must_use]
    pub fn what(&self) -> String {
        let values =
            self.values.iter().map(|(axis, values)| format!("{axis} {}", values.join(", ")));
        let variants = match self.variants.as_slice() {
            [] => None,
            [only] => Some(only.clone()),
            [first, rest @ ..] => Some(format!("{first} and {} more", rest.len())),
        };
        values.chain(variants).collect::<Vec<_>>().join("; ")
    }
}

/// What was saved. Less than nothing where what is left costs more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Saved {
    /// Scalar operations in the texts of what runs.
    pub static_operations: i64,
    /// Bindings of what runs.
    pub bindings: i64,
    /// Bytes of textures that are kept for a frame.
    pub texture_bytes: i64,
    /// Bytes of buffers that are kept for a frame.
    pub buffer_bytes: i64,
    /// Bytes of shader texts.
    pub shader_bytes: i64,
    /// Milliseconds per frame, where they were measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub milliseconds: Option<f64>,
}

/// What something takes, in the same units as [`Saved`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Weight {
    /// Scalar operations.
    pub static_operations: u64,
    /// Bindings.
    pub bindings: u64,
    /// Bytes of textures.
    pub texture_bytes: u64,
    /// Bytes of buffers.
    pub buffer_bytes: u64,
    /// Bytes of texts.
    pub shader_bytes: u64,
}

impl Sub for Weight {
    type Output = Saved;

    fn sub(self, other: Self) -> Saved {
        let difference = |of: fn(&Self) -> u64| of(&self) as i64 - of(&other) as i64;
        Saved {
            static_operations: difference(|weight| weight.static_operations),
            bindings: difference(|weight| weight.bindings),
            texture_bytes: difference(|weight| weight.texture_bytes),
            buffer_bytes: difference(|weight| weight.buffer_bytes),
            shader_bytes: difference(|weight| weight.shader_bytes),
            milliseconds: None,
        }
    }
}

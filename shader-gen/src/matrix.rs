//! The space of variants: which there are, which are illegal, and which an input needs.

use std::fmt;

/// A pass with a value on each of its axes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Variant {
    /// Name of the pass.
    pub pass: String,
    /// `(axis, value)` in the pass's order of axes.
    pub values: Vec<(String, String)>,
}

impl Variant {
    /// Pass and values joined by `-`, as in `scan-exact-wide`.
    #[must_use]
    pub fn id(&self) -> String {
        self.to_string()
    }

    /// The value on `axis`, if the pass has that axis.
    #[must_use]
    pub fn value(&self, axis: &str) -> Option<&str> {
        self.values
            .iter()
            .find(|(name, _)| name == axis)
            .map(|(_, value)| value.as_str())
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.pass)?;
        self.values
            .iter()
            .try_for_each(|(_, value)| write!(f, "-{value}"))
    }
}

//! A number that was measured, with its bound.

use schemars::JsonSchema;
use serde::Serialize;

/// How a value has to lie to its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Relation {
    /// The value must not exceed the bound.
    AtMost,
    /// The value must not fall below the bound.
    AtLeast,
    /// The value must be the bound.
    Equal,
}

impl Relation {
    /// Whether a value lies so.
    pub fn holds(self, value: f64, bound: f64) -> bool {
        match self {
            Self::AtMost => value <= bound,
            Self::AtLeast => value >= bound,
            Self::Equal => value == bound,
        }
    }

    /// As it is written.
    pub fn sign(self) -> &'static str {
        match self {
            Self::AtMost => "<=",
            Self::AtLeast => ">=",
            Self::Equal => "=",
        }
    }
}

/// A number that was measured, and what was promised of it.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Check {
    /// What was measured.
    pub name: String,
    /// The number; null in the file if it is not finite.
    #[schemars(with = "Option<f64>")]
    pub value: f64,
    /// Its unit; a count names what is counted.
    pub unit: String,
    /// How `value` has to lie to `bound`.
    pub relation: Relation,
    /// What was promised.
    pub bound: f64,
    /// Whether the promise is kept; never for a value that is not a number.
    pub holds: bool,
    /// The line that measures it again.
    pub command: String,
    /// On what it was measured, and what not to conclude.
    pub note: String,
}

impl Check {
    /// A check of `value` against `bound`.
    pub fn new(
        name: impl Into<String>,
        value: f64,
        unit: impl Into<String>,
        relation: Relation,
        bound: f64,
    ) -> Self {
        Self {
            name: name.into(),
            value,
            unit: unit.into(),
            relation,
            bound,
            holds: relation.holds(value, bound),
            command: String::new(),
            note: String::new(),
        }
    }

    /// Adds what a reader has to know.
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }
}

//! What is wrong, and where.

use std::fmt;

use thiserror::Error;

use crate::formula::Formula;

/// A place in a description or a configuration: keys of tables and indices of arrays from the top. It is that of an entry (a
/// let, a uniform, a resource, a step, a requirement; an axis, a parameter, a fact).
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place(pub Vec<String>);

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.0.join("."))
    }
}

/// Of what kind an [`Error`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A name that nothing declares.
    Unknown,
    /// A configuration that a requirement or an exclusion of the description rules out.
    Illegal,
    /// Anything else.
    Invalid,
}

/// One thing that is wrong, and where.
#[derive(Clone, Debug, Error, PartialEq, Eq, PartialOrd, Ord)]
#[error("{place}: {text}")]
pub struct Error {
    /// Where.
    pub place: Place,
    /// Of what kind it is.
    pub kind: Kind,
    /// What.
    pub text: String,
    /// The formula that has no value, if one has none.
    pub formula: Option<Formula>,
}

/// That a name is none of those that are known, which are listed unless there are none.
pub(crate) fn unknown<'a>(
    what: &str,
    name: &str,
    known: impl IntoIterator<Item = &'a String>,
) -> String {
    let known: Vec<&str> = known.into_iter().map(String::as_str).collect();
    let list = if known.is_empty() { "" } else { "; expected one of " };
    format!("unknown {what} `{name}`{list}{}", known.join(", "))
}

/// Everything that is wrong, sorted by place; never empty.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct Errors(pub Vec<Error>);

impl Errors {
    /// Whether the configuration is ruled out: what else is wrong then says nothing about the description.
    pub fn is_illegal(&self) -> bool {
        self.0.iter().any(|error| error.kind == Kind::Illegal)
    }
}

//! What is wrong, and where.

use thiserror::Error;

use crate::formula::Formula;

/// The kind of an [`Error`].
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
#[error("{}: {text}", place.join("."))]
pub struct Error {
    /// Keys of tables and indices of arrays from the top of the description or the configuration, down to an entry: a let, a
    /// uniform, a resource, a step, an exclusion; an axis, a parameter, a fact.
    pub place: Vec<String>,
    /// Of what kind it is.
    pub kind: Kind,
    /// The message.
    pub text: String,
    /// The formula that has no value, if one has none.
    pub formula: Option<Formula>,
}

/// The message for an unknown name; lists the known names, if any.
pub(crate) fn unknown<'a, I>(what: &str, name: &str, known: I) -> String
where
    I: IntoIterator<Item = &'a String>,
{
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

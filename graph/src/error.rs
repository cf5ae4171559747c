//! Errors, and the places in a description that they name.

use std::fmt;

use thiserror::Error;

/// A place in a description: keys of tables and indices of arrays from the top, the same in TOML and in JSON.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place(pub Vec<String>);

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.0.join("."))
    }
}

/// What is wrong.
#[derive(Clone, Debug, Error, PartialEq, Eq, PartialOrd, Ord)]
pub enum Problem {
    /// A text is no formula.
    #[error("not a formula: {0}")]
    Syntax(String),
    /// A formula that has no result: an overflow, a division by zero, a negative difference, the logarithm of 0.
    #[error("{0}")]
    Arithmetic(String),
    /// A name that nothing declares.
    #[error("unknown {kind} `{name}`{}", expected(.known))]
    #[expect(missing_docs, reason = "the message says it")]
    Unknown { kind: &'static str, name: String, known: Vec<String> },
    /// A value that depends on itself.
    #[error("`{0}` depends on itself")]
    Circle(String),
    /// A declaration that is not what it has to be.
    #[error("{0}")]
    Form(String),
    /// A parameter out of its range.
    #[error("parameter `{name}` is {value}; expected {range}")]
    #[expect(missing_docs, reason = "the message says it")]
    Range { name: String, value: String, range: String },
    /// A requirement that the configuration does not meet, or a rule that excludes one of its variants.
    #[error("invalid configuration: {0}")]
    Requirement(String),
}

fn expected(names: &[String]) -> String {
    if names.is_empty() { String::new() } else { format!("; expected one of {}", names.join(", ")) }
}

impl Problem {
    pub(crate) fn unknown<'a>(
        kind: &'static str,
        name: &str,
        known: impl IntoIterator<Item = &'a String>,
    ) -> Self {
        Self::Unknown { kind, name: name.to_owned(), known: known.into_iter().cloned().collect() }
    }
}

/// One thing that is wrong, and where.
#[derive(Clone, Debug, Error, PartialEq, Eq, PartialOrd, Ord)]
#[error("{place}: {problem}{}", .used.iter().map(|at| format!(", used by {at}")).collect::<String>())]
pub struct Error {
    /// Where.
    pub place: Place,
    /// What.
    pub problem: Problem,
    /// The step that uses the template in which the place is.
    pub used: Option<Place>,
}

/// Everything that is wrong, sorted by place; never empty.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct Errors(pub Vec<Error>);

/// A path that is built on the stack while a description is walked; a [`Place`] is made of it for an error alone.
#[derive(Clone, Copy)]
pub(crate) struct At<'a> {
    parent: Option<&'a At<'a>>,
    base: &'a [String],
    key: &'a str,
    index: Option<usize>,
    used: Option<&'a [String]>,
}

impl<'a> At<'a> {
    pub(crate) fn base(base: &'a [String], used: Option<&'a [String]>) -> Self {
        Self { parent: None, base, key: "", index: None, used }
    }

    pub(crate) fn key(&'a self, key: &'a str) -> Self {
        Self { parent: Some(self), base: &[], key, index: None, used: self.used }
    }

    /// An element of the array `key`, or of what is here if there is no key.
    pub(crate) fn item(&'a self, key: &'a str, index: usize) -> Self {
        Self { index: Some(index), ..self.key(key) }
    }

    pub(crate) fn path(&self) -> Vec<String> {
        let mut path = self.parent.map_or_else(Vec::new, At::path);
        path.extend_from_slice(self.base);
        path.extend((!self.key.is_empty()).then(|| self.key.to_owned()));
        path.extend(self.index.map(|index| index.to_string()));
        path
    }

    pub(crate) fn error(&self, problem: Problem) -> Error {
        let used = self.used.map(|path| Place(path.to_vec()));
        Error { place: Place(self.path()), problem, used }
    }

    pub(crate) fn form<T>(&self, text: impl Into<String>) -> Result<T, Error> {
        Err(self.error(Problem::Form(text.into())))
    }

    pub(crate) fn unknown<'b, T>(
        &self,
        kind: &'static str,
        name: &str,
        known: impl IntoIterator<Item = &'b String>,
    ) -> Result<T, Error> {
        Err(self.error(Problem::unknown(kind, name, known)))
    }
}

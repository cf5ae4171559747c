//! References to resources: `name`, `name.front`, `name.back`, `name@level`.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::formula::Formula;

/// A resource, or a part of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(from = "Form")]
pub struct Reference {
    /// Name of the resource, an alias, or what a use of a template calls so.
    pub resource: String,
    /// Which of a pair.
    pub side: Option<Side>,
    /// The one level of a texture that is meant; all levels without it.
    pub level: Option<Formula>,
}

/// One of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The newest; the first of the pair before any round.
    Front,
    /// The other one, which the next round writes.
    Back,
}

#[derive(Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "a reference to a resource, as in `name` or `name@level`")]
enum Form {
    Text(String),
    Parts { resource: String, side: Option<Side>, level: Option<Formula> },
}

impl From<Form> for Reference {
    fn from(form: Form) -> Self {
        match form {
            Form::Text(text) => Self::new(&text),
            Form::Parts { resource, side, level } => Self { resource, side, level },
        }
    }
}

impl Reference {
    /// The reference of a text.
    pub fn new(text: &str) -> Self {
        let (place, level) = match text.split_once('@') {
            Some((place, level)) => (place, Some(Formula::new(level))),
            None => (text, None),
        };
        let (resource, side) = match (place.strip_suffix(".front"), place.strip_suffix(".back")) {
            (Some(resource), _) => (resource, Some(Side::Front)),
            (_, Some(resource)) => (resource, Some(Side::Back)),
            _ => (place, None),
        };
        Self { resource: resource.trim().to_owned(), side, level }
    }
}

impl fmt::Display for Reference {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.resource)?;
        match self.side {
            None => {}
            Some(Side::Front) => out.write_str(".front")?,
            Some(Side::Back) => out.write_str(".back")?,
        }
        self.level.as_ref().map_or(Ok(()), |level| write!(out, "@{}", level.text))
    }
}

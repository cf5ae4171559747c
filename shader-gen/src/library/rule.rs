//! Rules about values of axes: what is illegal together, and what facts change of the defaults.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sglow_graph::description::Setting;

use super::Pass;

/// A rule that changes defaults for a class of input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassDefault {
    /// Its name.
    pub name: String,
    /// What facts must be, and values that axes may have, for the rule to hold; it holds for every input if there are none.
    /// An axis has the value that is set by hand, or else that of the preset, or else that of the rules before this one.
    #[serde(default)]
    pub when: BTreeMap<String, Condition>,
    /// Values of axes and parameters.
    pub set: BTreeMap<String, Setting>,
    /// Axes and parameters that these values make meaningless: the rule does not hold where one of them is set.
    #[serde(default)]
    pub unless: Vec<String>,
    /// Why.
    pub reason: String,
}

/// What a fact or an axis must be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "true or false of a fact, or a list of values of an axis")]
pub enum Condition {
    /// Whether a fact holds.
    Fact(bool),
    /// One of these values.
    Values(Vec<String>),
}

impl ClassDefault {
    /// Whether the rule holds: these facts are known, of axes and parameters these are set by hand, and an axis has this
    /// value.
    pub fn holds<'a>(
        &self,
        facts: &BTreeMap<String, bool>,
        set: impl IntoIterator<Item = &'a str>,
        axis: impl Fn(&str) -> Option<String>,
    ) -> bool {
        let holds = |(name, condition): (&String, &Condition)| match condition {
            Condition::Fact(holds) => facts.get(name) == Some(holds),
            Condition::Values(values) => axis(name).is_some_and(|value| values.contains(&value)),
        };
        self.when.iter().all(holds)
            && !set.into_iter().any(|name| self.unless.iter().any(|unless| unless == name))
    }
}

/// A rule that takes combinations of values out of the space of variants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exclusion {
    /// Its name.
    pub name: String,
    /// The pass it holds for; without it every pass that has all axes of `when`.
    pub pass: Option<String>,
    /// For each axis the values that are illegal together.
    pub when: BTreeMap<String, Vec<String>>,
    /// Why.
    pub reason: String,
}

impl Exclusion {
    /// Whether it holds for a pass with these values on its axes.
    pub fn excludes<'a>(&self, pass: &str, value: impl Fn(&str) -> Option<&'a str>) -> bool {
        self.pass.as_ref().is_none_or(|own| own == pass)
            && self.when.iter().all(|(axis, illegal)| {
                value(axis).is_some_and(|value| illegal.iter().any(|one| one == value))
            })
    }

    /// The passes of whose variants it takes some out.
    pub fn of_passes<'a>(&self, passes: &'a [Pass]) -> impl Iterator<Item = &'a Pass> {
        passes.iter().filter(|pass| {
            self.pass.as_ref().is_none_or(|own| *own == pass.name)
                && self.when.keys().all(|axis| pass.axes.contains(axis))
        })
    }
}

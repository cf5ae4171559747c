//! Conditions over flags: what `@if(…)` holds.

use std::collections::BTreeSet;
use std::fmt;
use std::ops::Range;

/// A condition over flags.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Condition {
    /// `true` or `false`.
    Literal(bool),
    /// A flag, with its place in its file.
    Flag(String, Range<usize>),
    /// `!a`
    Not(Box<Self>),
    /// `a && b`
    And(Box<Self>, Box<Self>),
    /// `a || b`
    Or(Box<Self>, Box<Self>),
}

impl Condition {
    pub(crate) fn not(self) -> Self {
        Self::Not(Box::new(self))
    }

    pub(crate) fn and(self, other: Self) -> Self {
        Self::And(Box::new(self), Box::new(other))
    }

    pub(crate) fn or(self, other: Self) -> Self {
        Self::Or(Box::new(self), Box::new(other))
    }

    /// Whether the condition holds when `flags` are all that is set.
    #[must_use]
    pub fn holds(&self, flags: &BTreeSet<&str>) -> bool {
        match self {
            Self::Literal(value) => *value,
            Self::Flag(name, _) => flags.contains(name.as_str()),
            Self::Not(a) => !a.holds(flags),
            Self::And(a, b) => a.holds(flags) && b.holds(flags),
            Self::Or(a, b) => a.holds(flags) || b.holds(flags),
        }
    }

    /// Calls `visit` with every flag and its place.
    pub fn flags(&self, visit: &mut impl FnMut(&str, &Range<usize>)) {
        match self {
            Self::Literal(_) => {}
            Self::Flag(name, range) => visit(name, range),
            Self::Not(a) => a.flags(visit),
            Self::And(a, b) | Self::Or(a, b) => {
                a.flags(visit);
                b.flags(visit);
            }
        }
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Literal(value) => write!(f, "{value}"),
            Self::Flag(name, _) => f.write_str(name),
            Self::Not(a) => match **a {
                Self::And(..) | Self::Or(..) => write!(f, "!({a})"),
                _ => write!(f, "!{a}"),
            },
            Self::And(a, b) => {
                for (operator, side) in [("", a), (" && ", b)] {
                    match **side {
                        Self::Or(..) => write!(f, "{operator}({side})")?,
                        _ => write!(f, "{operator}{side}")?,
                    }
                }
                Ok(())
            }
            Self::Or(a, b) => {
                for (operator, side) in [("", a), (" || ", b)] {
                    match **side {
                        Self::And(..) => write!(f, "{operator}({side})")?,
                        _ => write!(f, "{operator}{side}")?,
                    }
                }
                Ok(())
            }
        }
    }
}

//! The space of variants: which there are, which are illegal, and which an input needs.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use crate::error::{Code, Diagnostic, Report};
use crate::library::{Exclusion, Library, Need, Pass, Presence};

/// A pass with a value on each of its axes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Variant {
    /// Name of the pass.
    pub pass: String,
    /// `(axis, value)` in the pass's order of axes.
    pub values: Vec<(String, String)>,
    /// Which of them an identifier names: all but the defaults of axes that are implied.
    named: Vec<bool>,
}

impl Variant {
    /// A variant of a library.
    fn of(library: &Library, pass: &Pass, values: Vec<(String, String)>) -> Self {
        let is_named = |(axis, value): &(String, String)| {
            let known = library.axis.get(axis).filter(|axis| axis.implied);
            known.is_none_or(|axis| axis.default != *value)
        };
        let named = values.iter().map(is_named).collect();
        Self { pass: pass.name.clone(), values, named }
    }

    /// The values that its identifier names.
    pub fn named(&self) -> impl Iterator<Item = &(String, String)> {
        self.values.iter().zip(&self.named).filter(|(_, named)| **named).map(|(value, _)| value)
    }

    /// Pass and values joined by `-`, as in `scan-exact-wide`.
    #[must_use]
    pub fn id(&self) -> String {
        self.to_string()
    }

    /// The value on `axis`, if the pass has that axis.
    #[must_use]
    pub fn value(&self, axis: &str) -> Option<&str> {
        self.values.iter().find(|(name, _)| name == axis).map(|(_, value)| value.as_str())
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.pass)?;
        self.named().try_for_each(|(_, value)| write!(f, "-{value}"))
    }
}

/// Which facts of an input are known, and what they are.
pub type Facts = BTreeMap<String, bool>;

/// What an input needs of one axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Allowed {
    /// The values that remain, in the axis's order; empty if rules contradict each other.
    pub values: Vec<String>,
    /// The rules that took values away.
    pub because: Vec<Because>,
}

/// What remains allowed on each axis, by name of the axis.
pub type AllowedValues = BTreeMap<String, Allowed>;

/// A rule that took values of an axis away.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Because {
    /// Name of the [`crate::library::Need`].
    pub need: String,
    /// Its reason.
    pub reason: String,
    /// The values that it took away and no rule before it had.
    pub removed: Vec<String>,
}

/// A combination that is not in the space, and the rule that says so.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excluded {
    /// What it would be.
    pub variant: Variant,
    /// Name of the [`Exclusion`].
    pub exclusion: String,
    /// Its reason.
    pub reason: String,
}

/// A variant that would be of no use, and the rule that says so.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Absent {
    /// The variant.
    pub variant: Variant,
    /// Name of the [`Presence`] rule.
    pub presence: String,
    /// Its reason.
    pub reason: String,
}

impl Library {
    /// Every legal variant, pass by pass, in the order of the axes and of their values.
    #[must_use]
    pub fn variants(&self) -> Vec<Variant> {
        self.legal(&|_, _| true)
    }

    /// Those of [`Self::variants`] whose value on each axis `allowed` has.
    fn legal(&self, allowed: &dyn Fn(&str, &str) -> bool) -> Vec<Variant> {
        let legal = |variant: &Variant| self.exclusion_of(variant).is_none();
        self.pass.iter().flat_map(|pass| self.combinations(pass, allowed)).filter(legal).collect()
    }

    /// Every combination that a rule excludes, with that rule.
    #[must_use]
    pub fn excluded(&self) -> Vec<Excluded> {
        let excluded = |variant: Variant| {
            let rule = self.exclusion_of(&variant)?;
            Some(Excluded { variant, exclusion: rule.name.clone(), reason: rule.reason.clone() })
        };
        self.pass
            .iter()
            .flat_map(|pass| self.combinations(pass, &|_, _| true))
            .filter_map(excluded)
            .collect()
    }

    /// The variant of `pass` with `values` on its axes and the default on every other axis.
    ///
    /// # Errors
    ///
    /// A pass, axis or value that is not known (with those that are), an axis given twice, or a combination that a rule
    /// excludes (with the rule).
    pub fn variant(&self, pass: &str, values: &[(&str, &str)]) -> Result<Variant, Report> {
        let mut errors = Vec::new();
        let Some(pass) = self.find_pass(pass) else {
            let known = self.pass.iter().map(|pass| pass.name.as_str());
            let error = Diagnostic::unknown("pass", pass, known);
            return Err(Report::new(vec![error], self.sources().clone()));
        };
        for (index, (axis, value)) in values.iter().enumerate() {
            if !pass.axes.iter().any(|known| known == axis) {
                let kind = format!("axis of pass `{}`", pass.name);
                errors.push(Diagnostic::unknown(&kind, axis, pass.axes.iter().map(String::as_str)));
            } else if let Some(known) = self.axis.get(*axis)
                && !known.value.iter().any(|known| known.name == *value)
            {
                let known = known.value.iter().map(|value| value.name.as_str());
                errors.push(Diagnostic::unknown(&format!("value of axis `{axis}`"), value, known));
            }
            if values[..index].iter().any(|(other, _)| other == axis) {
                errors.push(Diagnostic::new(
                    Code::Duplicate,
                    format!("axis `{axis}` is given twice"),
                ));
            }
        }
        let value = |axis: &String| {
            let given = values.iter().find(|(name, _)| name == axis).map(|(_, value)| *value);
            let value = given.or_else(|| self.axis.get(axis).map(|axis| axis.default.as_str()));
            (axis.clone(), value.unwrap_or_default().to_owned())
        };
        let variant = Variant::of(self, pass, pass.axes.iter().map(value).collect());
        if errors.is_empty()
            && let Some(rule) = self.exclusion_of(&variant)
        {
            errors.push(
                Diagnostic::new(
                    Code::Excluded,
                    format!("`{variant}` is excluded by `{}`", rule.name),
                )
                .help(rule.reason.as_str()),
            );
        }
        if errors.is_empty() {
            Ok(variant)
        } else {
            Err(Report::new(errors, self.sources().clone()))
        }
    }

    /// What an input of which `facts` are known needs of each axis, by name of the axis.
    ///
    /// # Errors
    ///
    /// A fact that is not known, with those that are.
    pub fn needed(&self, facts: &Facts) -> Result<AllowedValues, Report> {
        self.needed_by(facts, |_| true)
    }

    /// As [`Library::needed`], as if the rule called `left_out` did not exist: what the rule is worth.
    ///
    /// # Errors
    ///
    /// As [`Library::needed`].
    pub fn needed_without(&self, facts: &Facts, left_out: &str) -> Result<AllowedValues, Report> {
        self.needed_by(facts, |rule| rule.name != left_out)
    }

    fn needed_by(
        &self,
        facts: &Facts,
        counts: impl Fn(&Need) -> bool,
    ) -> Result<AllowedValues, Report> {
        let known = || self.fact.iter().map(|fact| fact.name.as_str());
        let unknown: Vec<_> = facts
            .keys()
            .filter(|fact| !known().any(|known| known == *fact))
            .map(|fact| Diagnostic::unknown("fact", fact, known()))
            .collect();
        if !unknown.is_empty() {
            return Err(Report::new(unknown, self.sources().clone()));
        }
        let all = |axis: &crate::library::Axis| Allowed {
            values: axis.value.iter().map(|value| value.name.clone()).collect(),
            because: Vec::new(),
        };
        let mut allowed: AllowedValues =
            self.axis.iter().map(|(name, axis)| (name.clone(), all(axis))).collect();
        for need in self.need.iter().filter(|need| counts(need)) {
            if need.when.iter().any(|(fact, value)| facts.get(fact) != Some(value)) {
                continue;
            }
            for (axis, keep) in &need.set {
                let Some(allowed) = allowed.get_mut(axis) else {
                    continue;
                };
                let (kept, removed) =
                    allowed.values.drain(..).partition(|value| keep.contains(value));
                allowed.values = kept;
                if !removed.is_empty() {
                    allowed.because.push(Because {
                        need: need.name.clone(),
                        reason: need.reason.clone(),
                        removed,
                    });
                }
            }
        }
        Ok(allowed)
    }

    /// The legal variants whose values `allowed` all has and that are of use where it is all there is; and those that
    /// are of none. Both in the order of [`Library::variants`].
    #[must_use]
    pub fn remaining(&self, allowed: &AllowedValues) -> (Vec<Variant>, Vec<Absent>) {
        let mut absent = Vec::new();
        let fits = |axis: &str, value: &str| {
            let of_axis = allowed.get(axis);
            of_axis.is_none_or(|allowed| allowed.values.iter().any(|known| known == value))
        };
        let mut variants = self.legal(&fits);
        variants.retain(|variant| {
            let rule = self.absence_of(variant, allowed);
            absent.extend(rule.map(|rule| Absent {
                variant: variant.clone(),
                presence: rule.name.clone(),
                reason: rule.reason.clone(),
            }));
            rule.is_none()
        });
        (variants, absent)
    }

    /// The rule by which a variant is of no use where `allowed` is all there is; an axis that is not in it has all of
    /// its values.
    #[must_use]
    pub fn absence_of(&self, variant: &Variant, allowed: &AllowedValues) -> Option<&Presence> {
        let possible = |(axis, values): (&String, &Vec<String>)| {
            allowed
                .get(axis)
                .is_none_or(|allowed| values.iter().any(|value| allowed.values.contains(value)))
        };
        self.presence.iter().find(|rule| {
            let holds = |(axis, values): (&String, &Vec<String>)| {
                variant.value(axis).is_some_and(|value| values.iter().any(|own| own == value))
            };
            rule.passes.contains(&variant.pass)
                && rule.when.iter().all(holds)
                && !rule.only_with.iter().any(|together| together.iter().all(possible))
        })
    }

    /// The variants that the `[package]` table selects, in the order of [`Library::variants`].
    #[must_use]
    pub fn selected(&self) -> Vec<Variant> {
        let is_selected = |variant: &Variant| {
            self.package.select.iter().any(|select| {
                let holds = |(axis, values): (&String, &Vec<String>)| {
                    variant
                        .value(axis)
                        .is_some_and(|value| values.iter().any(|allowed| allowed == value))
                };
                select.pass == variant.pass && select.axes.iter().all(holds)
            })
        };
        let mut variants = self.variants();
        variants.retain(is_selected);
        variants
    }

    /// What a variant expects of its inputs: the lines of its pass that are about it, one `name: text` each.
    #[must_use]
    pub fn contract_of(&self, variant: &Variant) -> Vec<String> {
        let holds = |(axis, values): (&String, &Vec<String>)| {
            variant.value(axis).is_some_and(|value| values.iter().any(|own| own == value))
        };
        let lines = self.find_pass(&variant.pass).into_iter().flat_map(|pass| &pass.contract);
        lines.filter(|line| line.when.iter().all(holds)).map(|line| line.text.clone()).collect()
    }

    /// The flags that hold in a variant.
    #[must_use]
    pub fn flags_of(&self, variant: &Variant) -> BTreeSet<&str> {
        self.values_of(variant).flat_map(|value| &value.flags).map(String::as_str).collect()
    }

    /// The WebGPU features that a variant requires, sorted.
    #[must_use]
    pub fn requires(&self, variant: &Variant) -> BTreeSet<&str> {
        self.values_of(variant).flat_map(|value| &value.requires).map(String::as_str).collect()
    }

    fn values_of(&self, variant: &Variant) -> impl Iterator<Item = &crate::library::AxisValue> {
        variant.values.iter().filter_map(|(axis, value)| {
            let axis = self.axis.get(axis)?;
            axis.value.iter().find(|known| known.name == *value)
        })
    }

    fn combinations(&self, pass: &Pass, allowed: &dyn Fn(&str, &str) -> bool) -> Vec<Variant> {
        let mut variants = vec![Vec::new()];
        for name in &pass.axes {
            let Some(axis) = self.axis.get(name) else {
                continue;
            };
            let extend = |values: &Vec<(String, String)>| {
                let with = |value: &crate::library::AxisValue| {
                    let mut values = values.clone();
                    values.push((name.clone(), value.name.clone()));
                    values
                };
                let values = axis.value.iter().filter(|value| allowed(name, &value.name));
                values.map(with).collect::<Vec<_>>()
            };
            variants = variants.iter().flat_map(extend).collect();
        }
        variants.into_iter().map(|values| Variant::of(self, pass, values)).collect()
    }

    fn exclusion_of(&self, variant: &Variant) -> Option<&Exclusion> {
        let value = |axis: &str| variant.value(axis);
        self.exclusion.iter().find(|rule| rule.excludes(&variant.pass, value))
    }
}

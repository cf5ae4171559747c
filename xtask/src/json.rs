//! What a command found out, for machines: the same shape for every command.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::SystemTime;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::failure::{Failure, Result};
use crate::{table, write};

/// How a value has to lie to its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Relation {
    /// The value must not exceed the bound.
    AtMost,
    /// The value must not fall below the bound.
    AtLeast,
    /// The value must be the bound.
    Equal,
}

impl Relation {
    /// Whether a value lies so.
    pub(crate) fn holds(self, value: f64, bound: f64) -> bool {
        match self {
            Self::AtMost => value <= bound,
            Self::AtLeast => value >= bound,
            Self::Equal => value == bound,
        }
    }

    /// As it is written.
    pub(crate) fn sign(self) -> &'static str {
        match self {
            Self::AtMost => "<=",
            Self::AtLeast => ">=",
            Self::Equal => "=",
        }
    }
}

/// A number that was measured, and what was promised of it.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct Check {
    /// What was measured.
    pub(crate) name: String,
    /// The number; null in the file if it is not finite.
    #[schemars(with = "Option<f64>")]
    pub(crate) value: f64,
    /// Its unit; a count names what is counted.
    pub(crate) unit: String,
    /// How `value` has to lie to `bound`.
    pub(crate) relation: Relation,
    /// What was promised.
    pub(crate) bound: f64,
    /// Whether the promise is kept; never for a value that is not a number.
    pub(crate) holds: bool,
    /// The line that measures it again.
    pub(crate) command: String,
    /// On what it was measured, and what not to conclude.
    pub(crate) note: String,
}

impl Check {
    /// A check of `value` against `bound`.
    pub(crate) fn new(
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
    pub(crate) fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }
}

/// The file that a command writes beside what it shows.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct Report {
    /// Every number that the command can hold against a promise.
    pub(crate) checks: Vec<Check>,
    /// The GPU, or what took its place; empty if none was used.
    pub(crate) adapter: String,
    /// Its driver.
    pub(crate) driver: String,
    /// Versions of the tools that took part.
    pub(crate) versions: BTreeMap<String, String>,
    /// When the command ran, RFC 3339 in UTC.
    pub(crate) date: String,
    /// The line that makes this file again.
    pub(crate) command: String,
    /// What is particular to the command.
    #[serde(flatten)]
    pub(crate) details: Map<String, Value>,
}

impl Report {
    /// An empty report of the command that is running.
    pub(crate) fn new() -> Self {
        let versions = [("sglow", env!("CARGO_PKG_VERSION"))];
        Self {
            checks: Vec::new(),
            adapter: String::new(),
            driver: String::new(),
            versions: versions
                .into_iter()
                .map(|(name, version)| (name.to_owned(), version.to_owned()))
                .collect(),
            date: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
            command: command_line(std::env::args().skip(1)),
            details: Map::new(),
        }
    }

    /// Adds a check; unless it names a line of its own, the running command measures it again.
    pub(crate) fn check(&mut self, mut check: Check) {
        if check.command.is_empty() {
            check.command.clone_from(&self.command);
        }
        self.checks.push(check);
    }

    /// Adds what is particular to the command.
    ///
    /// # Errors
    ///
    /// When `value` has no JSON, such as a map whose keys are no strings.
    pub(crate) fn detail(&mut self, name: &str, value: impl Serialize) -> Result {
        self.details.insert(name.to_owned(), serde_json::to_value(value)?);
        Ok(())
    }

    /// Writes the report as JSON.
    pub(crate) fn write(&self, path: &Path) -> Result {
        write::text(path, &(serde_json::to_string_pretty(self)? + "\n"))
    }

    /// The checks as a table for a person.
    pub(crate) fn table(&self) -> comfy_table::Table {
        let mut table = table::new(["", "check", "value", "promise", "note"]);
        for check in &self.checks {
            table.add_row([
                if check.holds { "ok" } else { "FAILS" },
                &check.name,
                &format!("{} {}", number(check.value), check.unit),
                &format!("{} {}", check.relation.sign(), number(check.bound)),
                &check.note,
            ]);
        }
        table
    }

    /// Whether every check holds and there is one at all.
    ///
    /// # Errors
    ///
    /// Names the checks that fail.
    pub(crate) fn verdict(&self) -> Result {
        if self.checks.is_empty() {
            return Err(Failure::new("nothing was checked"));
        }
        let failing: Vec<&str> = self
            .checks
            .iter()
            .filter(|check| !check.holds)
            .map(|check| check.name.as_str())
            .collect();
        if failing.is_empty() {
            return Ok(());
        }
        Err(Failure::new(format!(
            "{} of {} checks fail: {}",
            failing.len(),
            self.checks.len(),
            failing.join(", ")
        )))
    }
}

/// The line a person types for these arguments.
pub(crate) fn command_line(arguments: impl Iterator<Item = String>) -> String {
    let mut line = String::from("cargo xtask");
    for argument in arguments {
        line.push(' ');
        let plain = |c: char| c.is_alphanumeric() || "-_=,./:+@".contains(c);
        if !argument.is_empty() && argument.chars().all(plain) {
            line.push_str(&argument);
        } else {
            line.push_str(&format!("'{}'", argument.replace('\'', r"'\''")));
        }
    }
    line
}

/// A number as a person reads it: counts in full, the rest with four digits.
fn number(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e9 {
        format!("{value}")
    } else if (1e-3..1e6).contains(&value.abs()) {
        format!("{value:.4}")
    } else {
        format!("{value:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checks_hold_or_fail_and_none_at_all_fails() {
        let mut report = Report::new();
        assert!(report.verdict().is_err(), "no checks is a failure");
        report.check(Check::new("small", 1.0, "ULP", Relation::AtMost, 2.0));
        report.check(Check::new("large", 3.0, "modules", Relation::AtLeast, 3.0));
        report.check(Check::new("same", 0.0, "errors", Relation::Equal, 0.0));
        report.verdict().unwrap();
        report.check(Check::new("odd", f64::NAN, "ULP", Relation::AtMost, 2.0));
        report.check(Check::new("off", 1.0, "errors", Relation::Equal, 0.0));
        let text = report.verdict().unwrap_err().to_string();
        assert_eq!(text, "error: 2 of 5 checks fail: odd, off");
    }

    #[test]
    fn the_file_has_the_promised_shape() {
        let mut report = Report::new();
        report.check(Check::new("nothing", f64::NAN, "ULP", Relation::AtMost, 2.0).note("why"));
        report.detail("extra", ["a"]).unwrap();
        let value = serde_json::to_value(&report).unwrap();
        for key in ["adapter", "driver", "versions", "date", "extra"] {
            assert!(value.get(key).is_some(), "{key} is missing");
        }
        let check = &value["checks"][0];
        let keys = ["name", "value", "unit", "bound", "holds", "command", "note"];
        assert!(keys.iter().all(|key| check.get(key).is_some()), "{check}");
        assert!(check["value"].is_null() && check["holds"] == false);
    }

    #[test]
    fn a_command_line_can_be_typed_again() {
        let arguments = ["render", "--set", "kernel=modified,lobes=both", "it's here"];
        assert_eq!(
            command_line(arguments.into_iter().map(str::to_owned)),
            r"cargo xtask render --set kernel=modified,lobes=both 'it'\''s here'"
        );
    }
}

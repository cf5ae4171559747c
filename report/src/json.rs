//! What a command found out, for machines: the same shape for every command.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::SystemTime;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};
use sglow_results::check::Check;

use crate::failure::{Failure, Result};
use crate::{table, write};

/// The file that a command writes beside what it shows.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Report {
    /// Every number that the command can hold against a promise.
    pub checks: Vec<Check>,
    /// The GPU, or what took its place; empty if none was used.
    pub adapter: String,
    /// Its driver.
    pub driver: String,
    /// Versions of the tools that took part.
    pub versions: BTreeMap<String, String>,
    /// When the command ran, RFC 3339 in UTC.
    pub date: String,
    /// The line that makes this file again.
    pub command: String,
    /// What is particular to the command.
    #[serde(flatten)]
    pub details: Map<String, Value>,
}

impl Default for Report {
    fn default() -> Self {
        Self::new()
    }
}

impl Report {
    /// An empty report of the command that is running.
    pub fn new() -> Self {
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
            command: command_line(arguments()),
            details: Map::new(),
        }
    }

    /// The same of a command that uses a GPU.
    #[must_use]
    pub fn on(adapter: &str, driver: &str) -> Self {
        Self { adapter: adapter.to_owned(), driver: driver.to_owned(), ..Self::new() }
    }

    /// Adds all checks.
    pub fn checks(&mut self, checks: impl IntoIterator<Item = Check>) {
        checks.into_iter().for_each(|check| self.check(check));
    }

    /// Adds a check; unless it names a line of its own, the running command measures it again.
    pub fn check(&mut self, mut check: Check) {
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
    pub fn detail(&mut self, name: &str, value: impl Serialize) -> Result {
        self.details.insert(name.to_owned(), serde_json::to_value(value)?);
        Ok(())
    }

    /// Writes the report as JSON.
    pub fn write(&self, path: &Path) -> Result {
        write::text(path, &(serde_json::to_string_pretty(self)? + "\n"))
    }

    /// The checks as a table for a person.
    pub fn table(&self) -> comfy_table::Table {
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
    pub fn verdict(&self) -> Result {
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

/// The arguments of this process, as far as they are text.
fn arguments() -> impl Iterator<Item = String> {
    std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned())
}

/// The line a person types for these arguments.
pub fn command_line(arguments: impl Iterator<Item = String>) -> String {
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
    use sglow_results::check::Relation;

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

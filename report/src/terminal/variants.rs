//! Which variants there are, and why each is in or out, for a terminal and as JSON.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};
use sglow_shader_gen::library::Library;
use sglow_shader_gen::manifest::Saved;
use sglow_shader_gen::matrix::{Absent, AllowedValues, Excluded, Variant};
use sglow_shader_gen::package::Purpose;

use crate::failure::Result;
use crate::json::Report;
use crate::scene::{Decision, Derived, Fact, Memory};
use crate::table;

/// What is shown.
#[derive(Clone, Copy)]
pub struct Listing<'a> {
    /// The library.
    pub library: &'a Library,
    /// Every legal variant.
    pub space: &'a [Variant],
    /// Every illegal one.
    pub excluded: &'a [Excluded],
    /// The committed ones.
    pub committed: &'a [Variant],
    /// The chosen ones.
    pub variants: &'a [Variant],
    /// Per axis the values that remain, and what took the others away.
    pub allowed: &'a AllowedValues,
    /// Legal variants that are of no use with what remains, and the rules that say so.
    pub absent: &'a [Absent],
    /// Passes none of whose legal variants remains.
    pub left_out: &'a [String],
    /// What follows from the scene, if there is one.
    pub derived: Option<&'a Derived<'a>>,
    /// What passes without a variant have none of.
    pub none: &'a str,
}

impl Listing<'_> {
    /// The variants.
    #[must_use]
    pub fn show(&self) -> String {
        let mut lines = vec![passes(self).to_string()];
        lines.extend(self.variants.iter().map(ToString::to_string));
        if !self.left_out.is_empty() {
            lines.push(format!("none {}: {}", self.none, self.left_out.join(", ")));
        }
        lines.join("\n")
    }

    /// Why each value of each axis is in or out, and which rules exclude what.
    #[must_use]
    pub fn explain(&self) -> String {
        let mut lines = Vec::new();
        if let Some(derived) = self.derived {
            lines.push(format!("\n{}", facts(derived)));
            lines.push(format!("\n{}", decisions(derived)));
            lines.push(format!("\n{}\n", left_out(derived.purpose)));
            for left in &derived.purpose.left_out {
                lines.push(format!(
                    "{}: {}; leaves out {}, which is measured against {}",
                    left.rule,
                    left.reason,
                    left.what(),
                    left.against
                ));
            }
            lines.push(format!("\n{}", milliseconds(derived)));
            lines.push(format!("\n{}", memory(derived)));
        }
        lines.push(format!("\n{}", axes(self)));
        lines.push(format!("\n{}", exclusions(self.library, self.excluded)));
        lines.join("\n")
    }

    /// All of it, for JSON.
    ///
    /// # Errors
    ///
    /// When something has no JSON.
    pub fn details(&self, report: &mut Report) -> Result {
        let ids = |variants: &[Variant]| variants.iter().map(Variant::id).collect::<Vec<_>>();
        report.detail("chosen", ids(self.variants))?;
        report.detail("committed", ids(self.committed))?;
        let (legal, excluded) = (self.space.len(), self.excluded.len());
        report.detail("space", json!({"legal": legal, "excluded": excluded}))?;
        report.detail("absent", absent(self))?;
        if let Some(derived) = self.derived {
            report.detail("memory", memory_as_json(derived))?;
            report.detail("facts", facts_as_json(derived))?;
            report.detail("decisions", decisions_as_json(derived))?;
            report.detail("made_for", &derived.purpose.made_for)?;
            report.detail("omitted", &derived.purpose.left_out)?;
            report.detail("milliseconds_measured", &derived.milliseconds)?;
        }
        report.detail("axes", explained(self))?;
        report.detail("exclusions", excluded_by_rule(self.library, self.excluded))?;
        report.detail("left_out", self.left_out)
    }
}

fn passes(shown: &Listing<'_>) -> comfy_table::Table {
    let Listing { library, space, excluded, committed, .. } = *shown;
    let mut table = table::new(["pass", "axes", "legal", "excluded", "committed", "chosen"]);
    let mut row = |name: &str, axes: String, of_pass: &dyn Fn(&Variant) -> bool| {
        let count = |variants: &[Variant]| variants.iter().filter(|one| of_pass(one)).count();
        let excluded = excluded.iter().filter(|one| of_pass(&one.variant)).count();
        table.add_row([
            name.to_owned(),
            axes,
            count(space).to_string(),
            excluded.to_string(),
            count(committed).to_string(),
            count(shown.variants).to_string(),
        ]);
    };
    for pass in &library.pass {
        row(&pass.name, pass.axes.join(", "), &|variant| variant.pass == pass.name);
    }
    row("all", String::new(), &|_| true);
    table
}

fn facts(derived: &Derived<'_>) -> comfy_table::Table {
    let mut table = table::new(["fact", "", "what shows it"]);
    for fact in derived.facts.iter() {
        table.add_row([fact.name.as_str(), if fact.holds { "yes" } else { "no" }, &fact.evidence]);
    }
    table
}

fn facts_as_json(derived: &Derived<'_>) -> Value {
    let fact = |fact: &Fact| {
        let value = json!({"holds": fact.holds, "evidence": fact.evidence});
        (fact.name.clone(), value)
    };
    Value::Object(derived.facts.iter().map(fact).collect())
}

fn decisions(derived: &Derived<'_>) -> comfy_table::Table {
    let mut table = table::new(["decision", "value", "why"]);
    for decision in &derived.decisions {
        table.add_row([&decision.what, &decision.value, &decision.reason]);
    }
    table
}

fn decisions_as_json(derived: &Derived<'_>) -> Vec<Value> {
    let decision = |of: &Decision| json!({"name": of.what, "value": of.value, "reason": of.reason, "changed": of.changed});
    derived.decisions.iter().map(decision).collect()
}

/// What the rules that leave something out save.
fn left_out(purpose: &Purpose) -> comfy_table::Table {
    let mut table = table::new([
        "what a rule saves",
        "operations",
        "bindings",
        "textures",
        "buffers",
        "texts",
        "ms",
    ]);
    let mut row = |rule: &str, saved: &Saved| {
        table.add_row([
            rule.to_owned(),
            saved.static_operations.to_string(),
            saved.bindings.to_string(),
            bytes(saved.texture_bytes),
            bytes(saved.buffer_bytes),
            bytes(saved.shader_bytes),
            saved.milliseconds.map_or_else(|| "-".to_owned(), |time| format!("{time:.2}")),
        ]);
    };
    for left in &purpose.left_out {
        row(&left.rule, &left.saved);
    }
    row("all of them", &purpose.made_for.saved);
    table
}

/// Where the milliseconds come from.
fn milliseconds(derived: &Derived<'_>) -> String {
    match &derived.measured {
        Some(([width, height], adapter, driver)) => {
            format!("Milliseconds are those of {width} x {height} pixels on {adapter}, {driver}.")
        }
        None => {
            let name = &derived.purpose.made_for.input;
            format!(
                "Milliseconds are known once `cargo xtask report --scene {name}` has measured them."
            )
        }
    }
}

/// The memory of a frame: what is kept, and what would be if every fact held.
fn memory(derived: &Derived<'_>) -> comfy_table::Table {
    let mut table =
        table::new(["a frame keeps", "as", "for this scene", "if every fact held", "less"]);
    for Memory { part, storage, bytes: own, bytes_if_every_fact_held: all } in &derived.memory {
        let less = 100.0 * (1.0 - *own as f64 / *all as f64);
        table.add_row([
            (*part).to_owned(),
            (*storage).to_owned(),
            bytes(*own as i64),
            bytes(*all as i64),
            format!("{less:.0} %"),
        ]);
    }
    table
}

fn memory_as_json(derived: &Derived<'_>) -> Vec<Value> {
    let row = |of: &Memory| json!({"part": of.part, "storage": of.storage, "bytes": of.bytes, "bytes_if_every_fact_held": of.bytes_if_every_fact_held});
    derived.memory.iter().map(row).collect()
}

/// Bytes in a unit that a person reads.
fn bytes(bytes: i64) -> String {
    let size = bytes.unsigned_abs();
    let sign = if bytes < 0 { "-" } else { "" };
    match size {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{sign}{:.1} kB", size as f64 / 1e3),
        _ => format!("{sign}{:.2} MB", size as f64 / 1e6),
    }
}

/// Variants that are of no use, by rule.
fn absent(shown: &Listing<'_>) -> Value {
    let mut rules: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for absent in shown.absent {
        rules.entry(&absent.presence).or_default().push(absent.variant.id());
    }
    json!(rules)
}

fn axes(shown: &Listing<'_>) -> comfy_table::Table {
    let mut table = table::new(["axis", "value", "", "why"]);
    // What none of the chosen variants has a value of says nothing of them.
    let has = |name: &str| shown.variants.iter().any(|variant| variant.value(name).is_some());
    for (name, axis) in shown.library.axis.iter().filter(|(name, _)| has(name)) {
        let Some(allowed) = shown.allowed.get(name) else {
            continue;
        };
        for value in &axis.value {
            let rule = allowed.because.iter().find(|rule| rule.removed.contains(&value.name));
            let (mark, why) = match rule {
                Some(rule) => ("out", format!("{}: {}", rule.need, rule.reason)),
                None if axis.default == value.name => {
                    ("in", format!("{} (default)", value.description))
                }
                None => ("in", value.description.clone()),
            };
            table.add_row([name, &value.name, mark, &why]);
        }
    }
    table
}

fn exclusions(library: &Library, excluded: &[Excluded]) -> comfy_table::Table {
    let mut table = table::new(["exclusion", "combinations", "passes", "why"]);
    for rule in &library.exclusion {
        let of_rule = || excluded.iter().filter(|one| one.exclusion == rule.name);
        let passes: BTreeSet<&str> = of_rule().map(|one| one.variant.pass.as_str()).collect();
        let passes = passes.into_iter().collect::<Vec<_>>().join(", ");
        table.add_row([&rule.name, &of_rule().count().to_string(), &passes, &rule.reason]);
    }
    table
}

fn explained(shown: &Listing<'_>) -> Value {
    let axis = |(name, allowed): (&String, &sglow_shader_gen::matrix::Allowed)| {
        let rule = |rule: &sglow_shader_gen::matrix::Because| json!({"rule": rule.need, "reason": rule.reason, "removed": rule.removed});
        let because: Vec<Value> = allowed.because.iter().map(rule).collect();
        (name.clone(), json!({"values": allowed.values, "because": because}))
    };
    Value::Object(shown.allowed.iter().map(axis).collect())
}

fn excluded_by_rule(library: &Library, excluded: &[Excluded]) -> Vec<Value> {
    let rule = |rule: &sglow_shader_gen::library::Exclusion| {
        let count = excluded.iter().filter(|one| one.exclusion == rule.name).count();
        json!({"rule": rule.name, "reason": rule.reason, "combinations": count})
    };
    library.exclusion.iter().map(rule).collect()
}

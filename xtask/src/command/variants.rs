//! `variants`: which variants there are, and why each is in or out.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};
use sglow_renderer::needs::Decision;
use sglow_renderer::plan::Storage;
use sglow_report::failure::Result;
use sglow_report::json::Report;
use sglow_report::table;
use sglow_results::check::{Check, Relation};
use sglow_scene::Fact;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::manifest::Saved;
use sglow_shader_gen::matrix::{Excluded, Variant};
use sglow_shader_gen::package::Purpose;

use crate::derivation::Derivation;
use crate::measured::Measured;
use crate::say;
use crate::selection::{Choice, Derived, Selection};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask variants
  cargo xtask variants --scene cornell --explain
  cargo xtask variants --all --json out/variants.json

Without --scene, --set or --all this shows what is committed; with --scene what a frame of it runs, with --all or --set
alone every legal variant that needs and settings leave. With --scene, --explain shows what is true of the scene and by
what, which numbers follow, and what was left out, why, and what that saves: in the texts and the memory of a frame of
640x360.";

/// Options of `variants`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    choice: Choice,
    /// Say for each value of each axis why it is in or out, and which rules exclude what
    #[arg(long)]
    explain: bool,
    /// Also write all of it as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Lists.
///
/// # Errors
///
/// When the library or the choice is wrong, or the committed selection is empty.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let library = arguments.choice.over.library()?;
    let selection = arguments.choice.select(&library)?;
    let (space, excluded, committed) = (library.variants(), library.excluded(), library.selected());

    say::line(passes(&library, &selection, &space, &excluded, &committed));
    for variant in &selection.variants {
        say::line(variant);
    }
    if !selection.left_out.is_empty() {
        let why = if arguments.choice.is_committed() {
            "committed of these passes; `--all` lists them"
        } else if selection.derived.is_some() && !arguments.choice.all {
            "of these passes in a frame of the scene; `--all` lists what its needs leave"
        } else {
            "legal of these passes"
        };
        say::line(format!("none {why}: {}", selection.left_out.join(", ")));
    }
    if arguments.explain {
        if let Some(derived) = &selection.derived {
            let Derived { derivation, purpose, .. } = derived;
            say::line(format!("\n{}", facts(derivation)));
            say::line(format!("\n{}", decisions(derivation)));
            say::line(format!("\n{}\n", left_out(purpose)));
            for left in &purpose.left_out {
                say::line(format!(
                    "{}: {}; leaves out {}, which is measured against {}",
                    left.rule,
                    left.reason,
                    left.what(),
                    left.against
                ));
            }
            say::line(format!("\n{}", milliseconds(derived)));
            say::line(format!("\n{}", memory(derived)));
        }
        say::line(format!("\n{}", axes(&library, &selection)));
        say::line(format!("\n{}", exclusions(&library, &excluded)));
    }

    let mut report = Report::new();
    let number = |name: &str, count: usize| {
        Check::new(name, count as f64, "variants", Relation::AtLeast, 1.0)
    };
    report.check(number("legal variants", space.len()));
    report.check(number("committed variants", committed.len()));
    report.check(number("variants chosen", selection.variants.len()));
    if let Some(path) = &arguments.json {
        let ids = |variants: &[Variant]| variants.iter().map(Variant::id).collect::<Vec<_>>();
        report.detail("chosen", ids(&selection.variants))?;
        report.detail("committed", ids(&committed))?;
        report.detail("space", json!({"legal": space.len(), "excluded": excluded.len()}))?;
        report.detail("absent", absent(&selection))?;
        if let Some(derived) = &selection.derived {
            let Derived { derivation, purpose, .. } = derived;
            report.detail("memory", memory_as_json(derived))?;
            report.detail("facts", facts_as_json(derivation))?;
            report.detail("decisions", decisions_as_json(derivation))?;
            report.detail("made_for", &purpose.made_for)?;
            report.detail("omitted", &purpose.left_out)?;
            report.detail("milliseconds_measured", &derived.measured)?;
        }
        report.detail("axes", explained(&selection))?;
        report.detail("exclusions", excluded_by_rule(&library, &excluded))?;
        report.detail("left_out", &selection.left_out)?;
        report.write(path)?;
    }
    report.verdict()
}

fn passes(
    library: &Library,
    selection: &Selection,
    space: &[Variant],
    excluded: &[Excluded],
    committed: &[Variant],
) -> comfy_table::Table {
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
            count(&selection.variants).to_string(),
        ]);
    };
    for pass in &library.pass {
        row(&pass.name, pass.axes.join(", "), &|variant| variant.pass == pass.name);
    }
    row("all", String::new(), &|_| true);
    table
}

fn facts(derivation: &Derivation) -> comfy_table::Table {
    let mut table = table::new(["fact", "", "what shows it"]);
    for fact in derivation.needs.facts.iter() {
        table.add_row([fact.name, if fact.holds { "yes" } else { "no" }, &fact.evidence]);
    }
    table
}

fn facts_as_json(derivation: &Derivation) -> Value {
    let fact = |fact: &Fact| {
        let value = json!({"holds": fact.holds, "evidence": fact.evidence});
        (fact.name.to_owned(), value)
    };
    Value::Object(derivation.needs.facts.iter().map(fact).collect())
}

fn decisions(derivation: &Derivation) -> comfy_table::Table {
    let mut table = table::new(["decision", "value", "why"]);
    for decision in &derivation.needs.decisions {
        table.add_row([decision.name, &decision.value, &decision.reason]);
    }
    table
}

fn decisions_as_json(derivation: &Derivation) -> Vec<Value> {
    let decision = |of: &Decision| json!({"name": of.name, "value": of.value, "reason": of.reason, "changed": of.changed});
    derivation.needs.decisions.iter().map(decision).collect()
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
fn milliseconds(derived: &Derived) -> String {
    match &derived.measured {
        Some(Measured { adapter, driver, size: [width, height], .. }) => {
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
fn memory(derived: &Derived) -> comfy_table::Table {
    let mut table =
        table::new(["a frame keeps", "as", "for this scene", "if every fact held", "less"]);
    for (part, storage, [own, all]) in memory_by_part(derived) {
        let less = 100.0 * (1.0 - own as f64 / all as f64);
        table.add_row([
            part.to_owned(),
            storage.to_owned(),
            bytes(own as i64),
            bytes(all as i64),
            format!("{less:.0} %"),
        ]);
    }
    table
}

fn memory_as_json(derived: &Derived) -> Vec<Value> {
    let row = |(part, storage, [own, all]): (&str, &str, [u64; 2])| json!({"part": part, "storage": storage, "bytes": own, "bytes_if_every_fact_held": all});
    memory_by_part(derived).into_iter().map(row).collect()
}

/// Bytes by part and by kind of memory, of this scene and of everything; what neither has is left out.
fn memory_by_part(derived: &Derived) -> Vec<(&'static str, &'static str, [u64; 2])> {
    let parts: [(_, &[_]); 4] = [
        ("surfaces", &["surfaces"]),
        ("indirect light", &["lights", "shading"]),
        ("visibility", &["visibility"]),
        ("picture", &["picture"]),
    ];
    let mut rows = Vec::new();
    for (name, parts) in parts {
        for (kind, storage) in [("textures", Storage::Texture), ("buffers", Storage::Buffer)] {
            let sizes = [&derived.derivation.plan, &derived.everything]
                .map(|plan| plan.bytes(storage, parts));
            if sizes != [0; 2] {
                rows.push((name, kind, sizes));
            }
        }
    }
    rows
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
fn absent(selection: &Selection) -> Value {
    let mut rules: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for absent in &selection.absent {
        rules.entry(&absent.presence).or_default().push(absent.variant.id());
    }
    json!(rules)
}

fn axes(library: &Library, selection: &Selection) -> comfy_table::Table {
    let mut table = table::new(["axis", "value", "", "why"]);
    // What none of the chosen variants has a value of says nothing of them.
    let has = |name: &str| selection.variants.iter().any(|variant| variant.value(name).is_some());
    for (name, axis) in library.axis.iter().filter(|(name, _)| has(name)) {
        let Some(allowed) = selection.allowed.get(name) else {
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

fn explained(selection: &Selection) -> Value {
    let axis = |(name, allowed): (&String, &sglow_shader_gen::matrix::Allowed)| {
        let rule = |rule: &sglow_shader_gen::matrix::Because| json!({"rule": rule.need, "reason": rule.reason, "removed": rule.removed});
        let because: Vec<Value> = allowed.because.iter().map(rule).collect();
        (name.clone(), json!({"values": allowed.values, "because": because}))
    };
    Value::Object(selection.allowed.iter().map(axis).collect())
}

fn excluded_by_rule(library: &Library, excluded: &[Excluded]) -> Vec<Value> {
    let rule = |rule: &sglow_shader_gen::library::Exclusion| {
        let count = excluded.iter().filter(|one| one.exclusion == rule.name).count();
        json!({"rule": rule.name, "reason": rule.reason, "combinations": count})
    };
    library.exclusion.iter().map(rule).collect()
}

//! `variants`: which variants there are, and why each is in or out.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};
use sglow_shader_gen::library::Library;
use sglow_shader_gen::matrix::{Excluded, Variant};

use crate::failure::Result;
use crate::json::{Check, Relation, Report};
use crate::say;
use crate::selection::{Choice, Selection, library};
use crate::table;

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask variants
  cargo xtask variants --scene cornell --explain
  cargo xtask variants --all --json out/variants.json

Without --scene, --set or --all this shows what is committed; with them every legal variant that the scene's needs and
the settings leave.";

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
    let library = library()?;
    let selection = arguments.choice.select(&library)?;
    let (space, excluded, committed) = (library.variants(), library.excluded(), library.selected());

    say::line(passes(&library, &selection, &space, &excluded, &committed));
    for variant in &selection.variants {
        say::line(variant);
    }
    for pass in &selection.left_out {
        let why = if arguments.choice.is_committed() {
            "none is committed; `--all` lists them"
        } else {
            "no legal variant remains"
        };
        say::line(format!("pass {pass}: {why}"));
    }
    if arguments.explain {
        if !selection.facts.is_empty() {
            say::line("\nFacts of the scene");
            for (fact, holds) in &selection.facts {
                say::line(format!("  {fact}: {}", if *holds { "yes" } else { "no" }));
            }
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
        report.detail("facts", &selection.facts)?;
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

fn axes(library: &Library, selection: &Selection) -> comfy_table::Table {
    let mut table = table::new(["axis", "value", "", "why"]);
    for (name, axis) in &library.axis {
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

//! What a GPU compiler makes of every variant, on a machine without that GPU, beside the figures that are committed.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::time::Duration;

use comfy_table::Table;
use sglow_cost::{Cost, Costs, Program, RADEON_ICD, Relation, Request, compare, compile};
use sglow_report::failure::{Context as _, Failure, Result};
use sglow_report::json::Report;
use sglow_report::{table, write};
use sglow_results::check::{Check, Relation as Bound};
use sglow_results::progress::Progress;
use sglow_shader_gen::package::{self, Options, Target};

use crate::machine::{apt, library_folder, repository, vulkan};

/// The families of GPUs that are compiled for unless others are named: RDNA 2 and GCN 5.
pub const FAMILIES: [&str; 2] = ["navi21", "vega10"];
/// The longest that one variant may take.
const LIMIT: Duration = Duration::from_secs(300);

/// What makes this program compile for another one: see [`sglow_cost::serve`].
const SERVE: [&str; 2] = ["cost", "--serve"];

/// Compiles the committed selection, or `only` these variants of it, for each family; compares the figures with those in
/// `docs/costs`, or replaces them; puts them into `report`, and returns a table of each family.
///
/// # Errors
///
/// When there is no such driver, family or variant, or the driver fails on a variant.
pub fn run(
    families: &[String],
    only: &[String],
    replace: bool,
    progress: &dyn Progress,
    report: &mut Report,
) -> Result<Vec<(String, Table)>> {
    let folder = tempfile::tempdir().context("no temporary folder")?;
    let package = folder.path().join("package");
    let mut options = Options::new(&package);
    options.targets = BTreeSet::from([Target::Spirv]);
    progress.start("generating SPIR-V", 0);
    package::generate(&library_folder(), &options, &mut |_| ())?;
    progress.end();
    let program = Program {
        path: std::env::current_exe().context("this program has no path")?,
        arguments: SERVE.map(str::to_owned).to_vec(),
        icd: RADEON_ICD.into(),
        jobs: std::thread::available_parallelism().map_or(1, usize::from),
        limit: LIMIT,
    };
    let mut tables = Vec::new();
    for family in families {
        progress.start(&format!("{family}: compiling (minutes)"), 0);
        let package = package.clone();
        let of = Request { package, family: family.clone(), only: only.to_vec() };
        let costs = compile(&program, &of);
        progress.end();
        let costs = costs.map_err(|error| {
            let help = format!("RADV is of Mesa; type: {}", apt::line(&vulkan::PACKAGES));
            Failure::new(error.to_string()).help(help)
        })?;
        check(family, &costs, only, replace, report)?;
        report.detail(family, &costs)?;
        let title = format!("{}, {}", costs.compiler.driver, costs.compiler.device);
        tables.push((title, shown(&costs)));
    }
    Ok(tables)
}

/// Where the figures of a family are kept.
fn kept(family: &str) -> PathBuf {
    repository().join("docs/costs").join(format!("{family}.json"))
}

/// Compares figures with the committed ones, or replaces these.
fn check(
    family: &str,
    costs: &Costs,
    only: &[String],
    replace: bool,
    report: &mut Report,
) -> Result {
    let path = kept(family);
    let old = match std::fs::read_to_string(&path) {
        Ok(text) => Some(serde_json::from_str::<Costs>(&text).context(path.display())?),
        Err(_) => None,
    };
    let mut old = old.unwrap_or_else(|| Costs { costs: Vec::new(), ..costs.clone() });
    if !only.is_empty() {
        old.costs.retain(|cost| only.contains(&cost.id));
        old.skipped.clone_from(&costs.skipped);
    }
    let comparison = compare(&old, costs);
    let faults = comparison.faults.iter().map(|fault| {
        format!("{} {}: {} {}", fault.id, fault.entry_point, fault.figure, fault.value)
    });
    let zero = |what: &str, count: usize, note: String| {
        let check = Check::new(format!("{family}: {what}"), count as f64, "", Bound::AtMost, 0.0);
        check.note(note)
    };
    let note = format!("of {} entry points", costs.costs.len());
    let faults: Vec<String> = std::iter::once(note).chain(faults).collect();
    let count = comparison.faults.len();
    report.check(zero("registers that spill, private memory", count, faults.join("; ")));
    if replace {
        let text = serde_json::to_string_pretty(costs)? + "\n";
        return write::text(&path, &text);
    }
    let note = match &comparison.relation {
        Relation::SameCompiler => format!("{}; `--write` replaces them", path.display()),
        Relation::OtherCompiler { old, new } => {
            format!("not compared: {} made them, this is {}", old.driver, new.driver)
        }
    };
    report.check(zero("figures other than the committed ones", comparison.differences.len(), note));
    report.detail(&format!("{family} differences"), &comparison.differences)
}

/// The range of each figure by pass.
fn shown(costs: &Costs) -> Table {
    let mut passes: BTreeMap<&str, Vec<&Cost>> = BTreeMap::new();
    for cost in &costs.costs {
        passes.entry(cost.id.split('-').next().unwrap_or_default()).or_default().push(cost);
    }
    let mut table = table::new([
        "pass",
        "entry points",
        "instructions",
        "VGPRs",
        "subgroups per SIMD",
        "issue cycles of the loop",
    ]);
    for (pass, costs) in passes {
        let range = |figure: &dyn Fn(&Cost) -> Option<u64>| {
            let all = || costs.iter().filter_map(|cost| figure(cost));
            match (all().min(), all().max()) {
                (Some(minimum), Some(maximum)) if minimum < maximum => {
                    format!("{minimum}-{maximum}")
                }
                (Some(same), _) => same.to_string(),
                _ => "-".to_owned(),
            }
        };
        table.add_row([
            pass.to_owned(),
            costs.len().to_string(),
            range(&|cost| Some(cost.instructions)),
            range(&|cost| Some(cost.vgprs)),
            range(&|cost| Some(cost.subgroups_per_simd)),
            range(&|cost| cost.loop_issue_cycles),
        ]);
    }
    table
}

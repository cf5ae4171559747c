//! What a GPU compiler makes of every variant, on a machine without that GPU, beside the figures that are committed.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::time::Duration;

use comfy_table::Table;
use sglow_cost::{
    Cost, Costs, Program, RADEON_ICD, Relation, Request, Shader, Skipped, compare, compile,
};
use sglow_report::failure::{Context as _, Failure, Result};
use sglow_report::json::Report;
use sglow_report::{table, write};
use sglow_results::check::{Check, Relation as Bound};
use sglow_results::frontier::document::SceneReport;
use sglow_results::progress::Progress;
use sglow_results::static_cost::StaticCost;

use crate::machine::{apt, repository, vulkan};
use crate::subject::{EntryPoint, Subject, read_package};
use crate::turns;

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
    progress.start("writing SPIR-V", 0);
    let subjects = read_package(&repository().join("shaders/packages/sglow"), folder.path());
    progress.end();
    let (shaders, skipped) = shaders(&subjects?, only)?;
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
        let costs =
            compile(&program, &Request { family: family.clone(), shaders: shaders.clone() });
        progress.end();
        let mut costs = costs.map_err(failure)?;
        costs.skipped.extend(skipped.clone());
        costs.skipped.sort_by(|a, b| a.id.cmp(&b.id));
        check(family, &costs, only, replace, report)?;
        if only.is_empty() {
            let (agreement, count) = turns::agreement(&costs)?;
            let name = format!("{family}: rank correlation of the manifest's turns");
            let check = Check::new(name, agreement, "", Bound::AtLeast, turns::AGREEMENT);
            report.check(
                check.note(format!("with the longest innermost loops of {count} entry points")),
            );
        }
        report.detail(family, &costs)?;
        let title = format!("{}, {}", costs.compiler.driver, costs.compiler.device);
        tables.push((title, shown(&costs)));
    }
    Ok(tables)
}

/// The committed figures of what configurations of scenes run, of the families that are compiled for unless others are
/// named.
///
/// # Errors
///
/// When a file of them is not what this program writes.
pub fn committed(scenes: &[SceneReport]) -> Result<Vec<StaticCost>> {
    let configurations = scenes.iter().flat_map(|scene| &scene.configurations);
    let run: BTreeSet<&String> = configurations.flat_map(|one| &one.variants).collect();
    let mut all = Vec::new();
    for family in FAMILIES {
        let Some(Costs { compiler, costs, .. }) = of_family(family)? else { continue };
        let costs = costs.into_iter().filter(|cost| run.contains(&cost.id));
        all.extend(costs.map(|cost| StaticCost {
            variant: cost.id,
            family: compiler.family.clone(),
            driver: compiler.driver.clone(),
            instructions: cost.instructions,
            loop_issue_cycles: cost.loop_issue_cycles,
            vgprs: cost.vgprs,
            subgroups_per_simd: cost.subgroups_per_simd,
        }));
    }
    Ok(all)
}

/// The committed figures of a family, if there are any.
pub(crate) fn of_family(family: &str) -> Result<Option<Costs>> {
    let name = format!("docs/costs/{family}.json");
    match std::fs::read_to_string(repository().join(&name)) {
        Ok(text) => Ok(Some(serde_json::from_str(&text).context(&name)?)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error).context(&name),
    }
}

/// The compute shaders of subjects, or of `only` these, and what is none.
fn shaders(subjects: &[Subject], only: &[String]) -> Result<(Vec<Shader>, Vec<Skipped>)> {
    if let Some(id) = only.iter().find(|id| !subjects.iter().any(|one| one.name == **id)) {
        return Err(Failure::new(format!("unknown variant `{id}`"))
            .help("`cargo xtask variants` lists the identifiers"));
    }
    let (mut shaders, mut skipped) = (Vec::new(), Vec::new());
    for subject in subjects.iter().filter(|one| only.is_empty() || only.contains(&one.name)) {
        let Some(path) = &subject.spirv else { continue };
        let id = &subject.name;
        for EntryPoint { name, stage } in &subject.entry_points {
            if stage == "compute" {
                let (id, entry_point, path) = (id.clone(), name.clone(), path.clone());
                shaders.push(Shader { id, entry_point, path });
            } else {
                // A stage of graphics depends on formats that only a host knows.
                let why = format!("`{name}` is a {stage} entry point; only compute is");
                skipped.push(Skipped { id: id.clone(), why });
            }
        }
    }
    Ok((shaders, skipped))
}

fn failure(error: sglow_cost::Error) -> Failure {
    use sglow_cost::Error::{Icd, Loader};
    let failure = Failure::new(error.to_string());
    if !matches!(error, Icd(_) | Loader(_)) {
        return failure;
    }
    failure.help(format!("type: {}", apt::line(&vulkan::PACKAGES)))
}

/// Compares figures with the committed ones, or replaces these.
fn check(
    family: &str,
    costs: &Costs,
    only: &[String],
    replace: bool,
    report: &mut Report,
) -> Result {
    let name = format!("docs/costs/{family}.json");
    let path = repository().join(&name);
    let old = of_family(family)?;
    let committed = old.is_some();
    let mut old = old.unwrap_or_else(|| costs.clone());
    if !only.is_empty() {
        old.costs.retain(|cost| only.contains(&cost.id));
        old.skipped.retain(|skipped| only.contains(&skipped.id));
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
        _ if !committed => format!("not compared: there is no {name}; `--write` makes it"),
        Relation::SameCompiler => format!("{name}; `--write` replaces them"),
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

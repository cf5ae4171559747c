//! Hosts in other languages (`tests/hosts`) run frames from a package's folder alone; the runtime repeats them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::{Deserialize, Serialize};
use sglow_report::failure::{Context as _, Failure, Result};
use sglow_report::json::Report;
use sglow_results::check::{Check, Relation};
use sglow_results::progress::Progress;

use crate::machine::{apt, cargo, program, repository, target_folder};
use crate::tint::{SWIFTSHADER_PACKAGES, succeed, swiftshader};

/// The frames: `tests/hosts/check.py` says what each is.
const CASES: [&str; 7] =
    ["default", "f16", "rgba16float", "visibility", "clusters", "chains", "occluders"];

/// What may lie between the results of two programs, relative to the largest component of each vector; between halves beside one
/// step of theirs.
const TOLERANCE: f64 = 1e-5;

/// A comparison of two programs' results for one frame, as the script writes it.
#[derive(Debug, Deserialize, Serialize)]
pub struct Comparison {
    case: String,
    size: String,
    results: [String; 2],
    /// 1e30 where whole numbers differ, or one is not finite.
    apart: f64,
    control: f64,
}

/// What runs the hosts, with its libraries.
#[derive(Debug)]
pub struct Hosts {
    work: PathBuf,
}

impl Hosts {
    /// Fetches the libraries, once.
    ///
    /// # Errors
    ///
    /// When Python, Node, a driver that Dawn accepts or a library is missing.
    pub fn find(progress: &dyn Progress) -> Result<Self> {
        for (tool, package) in [("python3", "python3-venv"), ("node", "nodejs"), ("npm", "npm")] {
            if program(tool).is_none() {
                return Err(Failure::new(format!("{tool} is not installed"))
                    .help(format!("type: {}", apt::line(&[package]))));
            }
        }
        if swiftshader().is_none() {
            return Err(Failure::new("there is no driver that Dawn accepts, such as SwiftShader")
                .help(format!("type: {}", apt::line(&SWIFTSHADER_PACKAGES))));
        }
        let found = Self { work: target_folder().join("verify/hosts") };
        progress.start("fetching the libraries of hosts", 0);
        let installed = succeed(found.script().arg("--install"));
        progress.end();
        installed.map(|()| found)
    }

    fn script(&self) -> Command {
        let mut command = Command::new("python3");
        command.arg(repository().join("tests/hosts/check.py")).arg("--work").arg(&self.work);
        command
    }

    /// Runs the hosts and the runtime on the same surfaces.
    ///
    /// # Errors
    ///
    /// When one of them fails.
    pub fn compare(&self, folder: &Path, progress: &dyn Progress) -> Result<Vec<Comparison>> {
        progress.start("building what repeats the frames of hosts", 0);
        let build = ["build", "--quiet", "--workspace", "--example", "host_frame"];
        let built = succeed(cargo().args(build));
        progress.end();
        built?;
        let result = folder.join("hosts.json");
        let mut command = self.script();
        command
            .arg("--runtime")
            .arg(target_folder().join("debug/examples/host_frame"))
            .arg("--xtask")
            .arg(std::env::current_exe().context("the path of this program")?)
            .arg("--json")
            .arg(&result)
            .args(CASES.iter().flat_map(|case| ["--case", case]));
        progress.start("hosts in other languages and the runtime run frames", 0);
        let ran = succeed(&mut command);
        progress.end();
        // Where results are apart the script fails, and has written by how much.
        let text = match (fs::read_to_string(&result), ran) {
            (Ok(text), _) => text,
            (Err(_), Err(failure)) => return Err(failure),
            (Err(error), Ok(())) => return Err(error).context("the script wrote no result"),
        };
        serde_json::from_str(&text).context("the script's result is not what is expected")
    }
}

/// Turns comparisons into checks: for each frame and pair of programs the worst of its sizes.
pub fn record(report: &mut Report, comparisons: &[Comparison]) -> Result {
    let mut worst = BTreeMap::<_, (f64, f64, Vec<&str>)>::new();
    for one in comparisons {
        let (apart, control, sizes) =
            worst.entry((&one.case, &one.results)).or_insert((0.0, f64::INFINITY, Vec::new()));
        *apart = apart.max(one.apart);
        *control = control.min(one.control);
        sizes.push(&one.size);
    }
    for ((case, [one, other]), (apart, control, sizes)) in worst {
        let name = |what: &str| format!("hosts: {one} and {other}, {case}: {what}");
        let unit = "relative";
        let sizes = sizes.join(" and ");
        report.check(
            Check::new(name("difference"), apart, unit, Relation::AtMost, TOLERANCE)
                .note(format!("of the largest component of each vector, at {sizes} pixels")),
        );
        let changed = if other == "runtime" { "a light 0.1 % brighter" } else { "a wrong number" };
        report.check(
            Check::new(name("control"), control, unit, Relation::AtLeast, 2.0 * TOLERANCE)
                .note(format!("{changed}, which has to be seen")),
        );
    }
    report.detail("hosts", comparisons)
}

//! `verify`: compilers that share no code with the generator read every variant of a package.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use sglow_shader_gen::package::{self, Options, Target};

use crate::command::verify::spirv_val::Validator;
use crate::command::verify::subject::Subject;
use crate::command::verify::tint::{Verdict, Verdicts};
use crate::failure::{Context as _, Failure, Result};
use crate::json::{Check, Relation, Report};
use crate::machine::{apt, program, repository};
use crate::progress;
use crate::say;
use crate::selection::{library, library_folder};

mod spirv_val;
mod subject;
mod tint;

pub(crate) use tint::{SWIFTSHADER_PACKAGES, swiftshader};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask verify
  cargo xtask verify --package out/package --allow-missing
  cargo xtask verify --all
  cargo xtask verify --install --json out/verify.json

Consumers:
  spirv-val    SPIRV-Tools, built from source once (minutes), or the system's; reads the SPIR-V of each variant
  tint         Dawn in Node (npm webgpu); reads each WGSL file, makes a pipeline of each compute entry point
  tint-spirv   Dawn in Python (dawn-python); reads the SPIR-V of each variant, makes pipelines likewise

Each consumer must also refuse modules that are broken on purpose. What is fetched or built lies in target/verify.";

/// Options of `verify`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The package to read [default: shaders/packages/sglow]
    #[arg(long, value_name = "DIR")]
    package: Option<PathBuf>,
    /// Read every variant of the space instead, generated for this
    #[arg(long, conflicts_with = "package")]
    all: bool,
    /// The file that receives the result [default: out/verify.json]
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Succeed even if a consumer is not available
    #[arg(long)]
    allow_missing: bool,
    /// Install missing system packages with apt-get
    #[arg(long)]
    install: bool,
}

/// A consumer that could not be asked.
#[derive(Debug, Serialize)]
struct Missing {
    consumer: &'static str,
    why: String,
}

/// Asks every consumer.
///
/// # Errors
///
/// When the package cannot be read, a consumer refuses a variant or accepts a broken one, or a consumer is missing and
/// that is not allowed.
pub(crate) fn run(arguments: &Arguments) -> Result {
    if arguments.install {
        install()?;
    }
    let folder = tempfile::tempdir().context("no temporary folder")?;
    let package = match &arguments.package {
        _ if arguments.all => generate_space(&folder.path().join("space"))?,
        Some(package) => package.clone(),
        None => repository().join("shaders/packages/sglow"),
    };
    let subjects = subject::read_package(&package, folder.path())?;
    let controls = subject::controls(folder.path())?;

    let mut report = Report::new();
    let differences = package::verify_hashes(&package)?;
    for difference in &differences {
        eprintln!("{difference}");
    }
    report.check(
        Check::new(
            "package: files that are not what SHA256SUMS says",
            differences.len() as f64,
            "files",
            Relation::Equal,
            0.0,
        )
        .note(format!("{} modules in the package", subjects.len())),
    );
    let mut missing = Vec::new();
    match Validator::find() {
        Ok(validator) => {
            let old = validator.is_old() && arguments.allow_missing;
            let verdicts = validator.read(&subjects, &controls)?;
            record(&mut report, "spirv-val", &subjects, &controls, &verdicts, old)?;
        }
        Err(failure) => missing.push(Missing { consumer: "spirv-val", why: failure.to_string() }),
    }
    for (consumer, read) in
        [("tint", tint::read_wgsl as tint::Read), ("tint-spirv", tint::read_spirv)]
    {
        match read(&subjects, &controls, folder.path()) {
            Ok(verdicts) => record(&mut report, consumer, &subjects, &controls, &verdicts, true)?,
            Err(failure) => missing.push(Missing { consumer, why: failure.to_string() }),
        }
    }

    say::line(report.table());
    for absent in &missing {
        eprintln!("{} is missing: {}", absent.consumer, absent.why);
    }
    let read = if arguments.all { "every variant of the space" } else { "a package" };
    report.detail("read", read)?;
    report.detail("missing", &missing)?;
    let json = arguments.json.clone().unwrap_or_else(|| repository().join("out/verify.json"));
    report.write(&json)?;
    say::line(format!("written: {}", json.display()));
    if !missing.is_empty() && !arguments.allow_missing {
        let names: Vec<&str> = missing.iter().map(|missing| missing.consumer).collect();
        return Err(Failure::new(format!("consumers are missing: {}", names.join(", "))).help(
            "`--install` installs what apt-get has; `--allow-missing` goes on without them",
        ));
    }
    report.verdict()
}

/// Writes every legal variant of the library as a package to `out`.
fn generate_space(out: &Path) -> Result<PathBuf> {
    let mut options = Options::new(out);
    options.targets = BTreeSet::from([Target::Wgsl]);
    options.variants = Some(library()?.variants());
    let spinner = progress::spinner("generating every variant of the space");
    package::generate(&library_folder(), &options, &mut |_| ())?;
    spinner.finish_and_clear();
    Ok(out.to_owned())
}

/// Installs what the consumers need of the system.
fn install() -> Result {
    let mut packages = Vec::new();
    for (tool, package) in
        [("c++", "g++"), ("node", "nodejs"), ("npm", "npm"), ("python3", "python3-venv")]
    {
        if program(tool).is_none() {
            packages.push(package);
        }
    }
    if swiftshader().is_none() {
        packages.extend(SWIFTSHADER_PACKAGES);
    }
    if packages.is_empty() { Ok(()) } else { apt::install(&packages) }
}

/// Turns what a consumer says into checks.
fn record(
    report: &mut Report,
    consumer: &'static str,
    subjects: &[Subject],
    controls: &[Subject],
    verdicts: &Verdicts,
    portable_controls_only: bool,
) -> Result {
    let of = |wanted: &[Subject]| -> Vec<&Verdict> {
        let named = |verdict: &&Verdict| wanted.iter().any(|subject| subject.name == verdict.name);
        verdicts.results.iter().filter(named).collect()
    };
    let verdict_on_subjects = of(subjects);
    let count =
        |state: &str| verdict_on_subjects.iter().filter(|verdict| verdict.state == state).count();
    let (valid, invalid, skipped) = (count("valid"), count("invalid"), count("skipped"));
    let pipelines: usize = verdict_on_subjects.iter().map(|verdict| verdict.pipelines).sum();

    for verdict in verdict_on_subjects.iter().filter(|verdict| verdict.state == "invalid") {
        eprintln!("{consumer} refuses {}:\n  {}", verdict.name, verdict.messages.join("\n  "));
    }
    let tools: Vec<String> =
        verdicts.versions.iter().map(|(tool, version)| format!("{tool} {version}")).collect();
    let mut note = format!("{valid} valid, {skipped} skipped; {}", tools.join(", "));
    if pipelines > 0 {
        note = format!("{note}; {pipelines} compute pipelines made");
    }
    let offered =
        subjects.iter().filter(|subject| consumer == "tint" || subject.spirv.is_some()).count();
    report.check(
        Check::new(
            format!("{consumer}: modules refused"),
            invalid as f64,
            "modules",
            Relation::AtMost,
            0.0,
        )
        .note(note),
    );
    report.check(
        Check::new(
            format!("{consumer}: modules read"),
            (valid + invalid) as f64,
            "modules",
            Relation::AtLeast,
            (offered - skipped.min(offered)).max(1) as f64,
        )
        .note("all that the adapter has the features for, and at least one"),
    );
    let broken = of(controls);
    for control in controls.iter().filter(|control| control.portable || !portable_controls_only) {
        let refused =
            broken.iter().any(|verdict| verdict.name == control.name && verdict.state == "invalid");
        if consumer == "tint" || control.spirv.is_some() {
            report.check(
                Check::new(
                    format!("{consumer}: {} refused", control.name),
                    f64::from(u8::from(refused)),
                    "modules",
                    Relation::Equal,
                    1.0,
                )
                .note(if control.portable {
                    "broken on purpose"
                } else {
                    "broken on purpose in a way that validators before 2025 do not see"
                }),
            );
        }
    }
    if !verdicts.adapter.is_empty() {
        report.adapter.clone_from(&verdicts.adapter);
        report.driver.clone_from(&verdicts.driver);
    }
    report.versions.extend(verdicts.versions.clone());
    report.detail(consumer, &verdicts.results)
}

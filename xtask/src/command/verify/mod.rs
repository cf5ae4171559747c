//! `verify`: compilers that share no code with the generator read every variant of a package, hosts in other languages run its
//! frame, and a browser opens pages.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;
use sglow_shader_gen::package::{self, Options, Target};

use crate::command::verify::chromium::Browser;
use crate::command::verify::hosts::Hosts;
use crate::command::verify::spirv_val::Validator;
use crate::command::verify::subject::Subject;
use crate::command::verify::tint::{Verdict, Verdicts};
use crate::failure::{Context as _, Failure, Result};
use crate::json::{Check, Relation, Report};
use crate::machine::{apt, program, repository};
use crate::selection::{library, library_folder};
use crate::{progress, say};

mod chromium;
mod hosts;
mod spirv_val;
mod subject;
mod tint;

pub(crate) use chromium::PACKAGES as CHROMIUM_PACKAGES;
pub(crate) use tint::{SWIFTSHADER_PACKAGES, swiftshader};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask verify
  cargo xtask verify --package out/package --allow-missing
  cargo xtask verify --all
  cargo xtask verify --install --json out/verify.json
  cargo xtask verify --consumer chromium --page out/report/index.html

Consumers:
  spirv-val    SPIRV-Tools, built from source once (minutes), or the system's; reads the SPIR-V of each variant
  tint         Dawn in Node (npm webgpu); reads each WGSL file, makes a pipeline of each compute entry point
  tint-spirv   Dawn in Python (dawn-python); reads the SPIR-V of each variant, makes pipelines likewise
  hosts        programs in Python (wgpu) and JavaScript (npm webgpu) run frames of the committed package; the runtime
               repeats each, and results may differ by 1e-5
  chromium     opens a page of made-up numbers, and those of --page: 400 and 1600 pixels wide, light and dark

Each consumer must also refuse what is broken on purpose. What is fetched or built lies in target/verify; pictures of
pages lie beside the result, in verify.";

/// Options of `verify`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The package to read [default: shaders/packages/sglow]
    #[arg(long, value_name = "DIR")]
    package: Option<PathBuf>,
    /// Read every variant of the space instead, generated for this
    #[arg(long, conflicts_with = "package")]
    all: bool,
    /// Ask these consumers alone
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    consumer: Vec<Consumer>,
    /// Also open this page in the browser; may be given more than once
    #[arg(long, value_name = "FILE")]
    page: Vec<PathBuf>,
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

/// Who reads what this project makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Consumer {
    /// SPIRV-Tools.
    SpirvVal,
    /// Dawn in Node.
    Tint,
    /// Dawn in Python.
    TintSpirv,
    /// Programs in Python and JavaScript, which run frames.
    Hosts,
    /// A browser, which reads pages.
    Chromium,
}

impl Arguments {
    fn asks(&self, consumer: Consumer) -> bool {
        self.consumer.is_empty() || self.consumer.contains(&consumer)
    }

    fn asks_for_shaders(&self) -> bool {
        [Consumer::SpirvVal, Consumer::Tint, Consumer::TintSpirv].iter().any(|one| self.asks(*one))
    }
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
    if !arguments.page.is_empty() && !arguments.asks(Consumer::Chromium) {
        return Err(Failure::new("`--page` is for the consumer chromium, which is not asked")
            .help("add it: --consumer chromium"));
    }
    if arguments.install {
        install(arguments)?;
    }
    let mut report = Report::new();
    let mut missing = Vec::new();
    let json = arguments.json.clone().unwrap_or_else(|| repository().join("out/verify.json"));
    if arguments.asks_for_shaders() {
        shaders(arguments, &mut report, &mut missing)?;
    }
    if arguments.asks(Consumer::Hosts) {
        match Hosts::find() {
            Ok(found) => {
                let folder = tempfile::tempdir().context("no temporary folder")?;
                hosts::record(&mut report, &found.compare(folder.path())?)?;
            }
            Err(failure) => missing.push(Missing { consumer: "hosts", why: failure.to_string() }),
        }
    }
    if arguments.asks(Consumer::Chromium) {
        match Browser::find() {
            Ok(browser) => {
                let pictures = json.parent().unwrap_or(Path::new("")).join("verify");
                browser.read(&arguments.page, &pictures, &mut report)?;
            }
            Err(failure) => {
                missing.push(Missing { consumer: "chromium", why: failure.to_string() });
            }
        }
    }

    say::line(report.table());
    for absent in &missing {
        eprintln!("{} is missing: {}", absent.consumer, absent.why);
    }
    report.detail("missing", &missing)?;
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

/// Asks those who read shaders.
fn shaders(arguments: &Arguments, report: &mut Report, missing: &mut Vec<Missing>) -> Result {
    let folder = tempfile::tempdir().context("no temporary folder")?;
    let package = match &arguments.package {
        _ if arguments.all => generate_space(&folder.path().join("space"))?,
        Some(package) => package.clone(),
        None => repository().join("shaders/packages/sglow"),
    };
    let subjects = subject::read_package(&package, folder.path())?;
    let controls = subject::controls(folder.path())?;
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
    if arguments.asks(Consumer::SpirvVal) {
        match Validator::find() {
            Ok(validator) => {
                let old = validator.is_old() && arguments.allow_missing;
                let verdicts = validator.read(&subjects, &controls)?;
                record(report, "spirv-val", &subjects, &controls, &verdicts, old)?;
            }
            Err(failure) => {
                missing.push(Missing { consumer: "spirv-val", why: failure.to_string() });
            }
        }
    }
    for (asked, consumer, read) in [
        (Consumer::Tint, "tint", tint::read_wgsl as tint::Read),
        (Consumer::TintSpirv, "tint-spirv", tint::read_spirv),
    ] {
        if !arguments.asks(asked) {
            continue;
        }
        match read(&subjects, &controls, folder.path()) {
            Ok(verdicts) => record(report, consumer, &subjects, &controls, &verdicts, true)?,
            Err(failure) => missing.push(Missing { consumer, why: failure.to_string() }),
        }
    }
    let read = if arguments.all { "every variant of the space" } else { "a package" };
    report.detail("read", read)
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
fn install(arguments: &Arguments) -> Result {
    let mut packages = Vec::new();
    for (consumer, tool, package) in [
        (Consumer::SpirvVal, "c++", "g++"),
        (Consumer::Tint, "node", "nodejs"),
        (Consumer::Tint, "npm", "npm"),
        (Consumer::TintSpirv, "python3", "python3-venv"),
        (Consumer::Hosts, "node", "nodejs"),
        (Consumer::Hosts, "npm", "npm"),
        (Consumer::Hosts, "python3", "python3-venv"),
    ] {
        if arguments.asks(consumer) && program(tool).is_none() {
            packages.push(package);
        }
    }
    packages.sort_unstable();
    packages.dedup();
    let dawn = [Consumer::Tint, Consumer::TintSpirv, Consumer::Hosts];
    if dawn.iter().any(|one| arguments.asks(*one)) && swiftshader().is_none() {
        packages.extend(SWIFTSHADER_PACKAGES);
    }
    if arguments.asks(Consumer::Chromium) && Browser::find().is_err() {
        packages.extend(CHROMIUM_PACKAGES);
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

//! Every consumer in turn: compilers that share no code with the generator read a package, hosts in other languages run its
//! frame, a browser opens pages. Each must also refuse what is broken on purpose.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::Serialize;
use sglow_report::failure::{Context as _, Failure, Result};
use sglow_report::json::Report;
use sglow_results::check::{Check, Relation};
use sglow_results::progress::Progress;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::package::{self, Options, Target};
use sglow_shader_gen::prune::Whole;

use crate::chromium::{self, Browser};
use crate::hosts::{self, Hosts};
use crate::known;
use crate::machine::vulkan::{self, Vulkan};
use crate::machine::{apt, library_folder, program, repository};
use crate::spirv_val::Validator;
use crate::subject::{self, Subject};
use crate::tint::{self, SWIFTSHADER_PACKAGES, Verdict, Verdicts, swiftshader};

/// Who reads what this project makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Consumer {
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

impl Consumer {
    /// All of them, by name.
    pub const ALL: [(&'static str, Self); 5] = [
        ("spirv-val", Self::SpirvVal),
        ("tint", Self::Tint),
        ("tint-spirv", Self::TintSpirv),
        ("hosts", Self::Hosts),
        ("chromium", Self::Chromium),
    ];
}

/// What is verified, by whom.
pub struct Request<'a> {
    /// The package that is read; the committed one if there is none.
    pub package: Option<PathBuf>,
    /// Whether every variant of the space is read instead, generated for this.
    pub all: bool,
    /// The consumers; all of them if it is empty.
    pub consumers: Vec<Consumer>,
    /// Pages that the browser opens beside made-up ones.
    pub pages: Vec<PathBuf>,
    /// The folder for pictures of pages.
    pub pictures: PathBuf,
    /// Whether a consumer may be missing.
    pub allow_missing: bool,
    /// What is reported while it lasts.
    pub progress: &'a dyn Progress,
}

impl Request<'_> {
    /// Whether a consumer takes part.
    #[must_use]
    pub fn includes(&self, consumer: Consumer) -> bool {
        self.consumers.is_empty() || self.consumers.contains(&consumer)
    }
}

/// Lets every requested consumer read, writes what each says into `report`, and returns those that are missing.
///
/// # Errors
///
/// When the package cannot be read or a consumer cannot be run.
pub fn verify(request: &Request<'_>, report: &mut Report) -> Result<Vec<Missing>> {
    let mut missing = Vec::new();
    let shaders_too = [Consumer::SpirvVal, Consumer::Tint, Consumer::TintSpirv];
    if shaders_too.iter().any(|one| request.includes(*one)) {
        shaders(request, report, &mut missing)?;
    }
    if request.includes(Consumer::Hosts) {
        match Hosts::find(request.progress) {
            Ok(found) => {
                let folder = tempfile::tempdir().context("no temporary folder")?;
                hosts::record(report, &found.compare(folder.path(), request.progress)?)?;
            }
            Err(failure) => missing.push(Missing { consumer: "hosts", why: failure.to_string() }),
        }
    }
    if request.includes(Consumer::Chromium) {
        match Browser::find() {
            Ok(browser) => {
                browser.read(&request.pages, &request.pictures, report, request.progress)?;
            }
            Err(failure) => {
                missing.push(Missing { consumer: "chromium", why: failure.to_string() });
            }
        }
    }
    Ok(missing)
}

/// A consumer that could not be run.
#[derive(Debug, Serialize)]
pub struct Missing {
    /// The consumer.
    pub consumer: &'static str,
    /// Why.
    pub why: String,
}

/// Names the consumers that could not be run.
///
/// # Errors
///
/// When there is one and none `may_lack`.
pub fn absent(missing: &[Missing], may_lack: bool) -> Result {
    for absent in missing {
        eprintln!("{} is missing: {}", absent.consumer, absent.why);
    }
    if missing.is_empty() || may_lack {
        return Ok(());
    }
    let names: Vec<&str> = missing.iter().map(|missing| missing.consumer).collect();
    let failure = Failure::new(format!("consumers are missing: {}", names.join(", ")));
    Err(failure
        .help("`--install` installs what apt-get has; `--allow-missing` goes on without them"))
}

/// Runs the consumers that read shaders.
fn shaders(request: &Request<'_>, report: &mut Report, missing: &mut Vec<Missing>) -> Result {
    let folder = tempfile::tempdir().context("no temporary folder")?;
    let package = match &request.package {
        _ if request.all => generate_space(&folder.path().join("space"), request.progress)?,
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
    if request.includes(Consumer::SpirvVal) {
        match Validator::find(request.progress) {
            Ok(validator) => {
                let old = validator.is_old() && request.allow_missing;
                let verdicts = validator.read(&subjects, &controls, request.progress)?;
                record(report, "spirv-val", &subjects, &controls, &verdicts, old)?;
            }
            Err(failure) => {
                missing.push(Missing { consumer: "spirv-val", why: failure.to_string() });
            }
        }
    }
    for (requested, consumer, read) in [
        (Consumer::Tint, "tint", tint::read_wgsl as tint::Read),
        (Consumer::TintSpirv, "tint-spirv", tint::read_spirv),
    ] {
        if !request.includes(requested) {
            continue;
        }
        match read(&subjects, &controls, folder.path(), request.progress) {
            Ok(verdicts) => record(report, consumer, &subjects, &controls, &verdicts, true)?,
            Err(failure) => missing.push(Missing { consumer, why: failure.to_string() }),
        }
    }
    let read = if request.all { "every variant of the space" } else { "a package" };
    report.detail("read", read)
}

/// Writes every legal variant of the library as a package to `out`, each proved against the whole of its modules.
fn generate_space(out: &Path, progress: &dyn Progress) -> Result<PathBuf> {
    let mut options = Options::new(out);
    options.targets = BTreeSet::from([Target::Wgsl]);
    options.variants = Some(Library::load(&library_folder())?.variants());
    options.whole = Whole::Modules;
    progress.start("generating every variant of the space", 0);
    package::generate(&library_folder(), &options, &mut |_| ())?;
    progress.end();
    Ok(out.to_owned())
}

/// Installs what the consumers need of the system.
///
/// # Errors
///
/// When that is not allowed or does not work.
pub fn install(request: &Request<'_>) -> Result {
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
        if request.includes(consumer) && program(tool).is_none() {
            packages.push(package);
        }
    }
    packages.sort_unstable();
    packages.dedup();
    let dawn = [Consumer::Tint, Consumer::TintSpirv, Consumer::Hosts];
    // Dawn in Node loads the system's loader; the runtime repeats the frames of hosts.
    if dawn.iter().any(|one| request.includes(*one)) && !Vulkan::find().usable() {
        packages.extend(vulkan::PACKAGES);
    }
    if dawn.iter().any(|one| request.includes(*one)) && swiftshader().is_none() {
        packages.extend(SWIFTSHADER_PACKAGES);
    }
    if request.includes(Consumer::Chromium) && Browser::find().is_err() {
        packages.extend(chromium::PACKAGES);
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

    let known = known::counted(consumer, &verdict_on_subjects);
    let is_new =
        |verdict: &&&Verdict| verdict.state == "invalid" && !known::is_known(consumer, verdict);
    for verdict in verdict_on_subjects.iter().filter(is_new) {
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
            (invalid - known.refused) as f64,
            "modules",
            Relation::AtMost,
            0.0,
        )
        .note(note),
    );
    if !known.why.is_empty() {
        let refused = known.refused;
        report.check(
            Check::new(
                format!("{consumer}: modules whose refusal was known, taken by now"),
                known.taken as f64,
                "modules",
                Relation::AtMost,
                0.0,
            )
            .note(format!("{refused} modules refused as known: {}", known.why.join("; "))),
        );
    }
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

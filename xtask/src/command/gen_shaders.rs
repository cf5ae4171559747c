//! `gen-shaders`: packages from the library.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use sglow_consumers::machine::{library_folder, repository, target_folder};
use sglow_report::failure::{Failure, Result};
use sglow_report::json::Report;
use sglow_report::{failure, write};
use sglow_results::check::{Check, Relation};
use sglow_shader_gen::package::{self, Options, Progress, Target};

use crate::options::{Choice, Over};
use crate::{progress, say};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask gen-shaders
  cargo xtask gen-shaders --check
  cargo xtask gen-shaders --scene cornell --target wgsl,spirv --out out/cornell
  cargo xtask gen-shaders --scene cornell --all --out out/cornell-all
  cargo xtask gen-shaders --set kernel=previous,lobes=both --out out/previous
  cargo xtask gen-shaders --all --target wgsl --out out/everything

Without --scene, --set or --all this writes the selection in shaders/library.toml, which is committed. With --scene it
writes what a frame of the scene runs, each axis by --set, by the scene's needs or by its default: what `render --scene
--package` takes, no more and no less. With --all, or --set alone, it writes every legal variant that needs and settings
leave. The manifest says what was left out, by which rule, and what that saves.";

/// Options of `gen-shaders`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) choice: Choice,
    /// The folder of the package [default: shaders/packages/NAME]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Languages beside WGSL: spirv, rust
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub(crate) target: Vec<Target>,
    /// Write nothing; fail if the folder is not what would be written
    #[arg(long)]
    pub(crate) check: bool,
    /// Also write what was done as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
}

/// Generates, or checks.
pub(crate) fn run(arguments: &Arguments) -> Result {
    let start = Instant::now();
    let over = &arguments.choice.over.library;
    let committed =
        arguments.choice.is_committed() && arguments.target.is_empty() && over.is_empty();
    let out = match &arguments.out {
        Some(out) => std::path::absolute(out)?,
        None if committed => {
            repository().join("shaders/packages").join(Over::default().library()?.package.name)
        }
        None => {
            let failure = Failure::new("this would replace the committed package by another one");
            return Err(failure.help("name a folder: `--out out/package`"));
        }
    };
    if !arguments.check {
        write::probe(&out)?;
    }
    let mut options = Options::new(out);
    options.check = arguments.check;
    options.over.clone_from(over);
    options.cache = Some(target_folder().join("generated"));
    if !arguments.target.is_empty() {
        options.targets = BTreeSet::from_iter(arguments.target.iter().copied());
    }
    if !arguments.choice.is_committed() {
        let (selection, _) = arguments.choice.select(&arguments.choice.over.library()?)?;
        if selection.derived.is_none() {
            for pass in &selection.left_out {
                eprintln!("pass {pass}: no legal variant remains; left out");
            }
        }
        options.variants = Some(selection.variants);
        options.purpose = selection.derived.map(|derived| derived.purpose);
    }

    let spinner = progress::spinner("reading the library");
    let mut variants = 0;
    let outcome = package::generate(&library_folder(), &options, &mut |step| {
        spinner.set_message(match step {
            Progress::Unchanged => "nothing has changed".to_owned(),
            Progress::Variants(count) => {
                variants = count;
                format!("{count} variants: assembling, pruning, proving, validating")
            }
            Progress::Targets(count) => format!("{count} variants: writing"),
            Progress::Files(count) => format!("{count} files: comparing"),
        });
    });
    spinner.finish_and_clear();
    let differing = package::differing(&outcome);
    let seconds = start.elapsed().as_secs_f64();
    if let Some(path) = &arguments.json {
        let mut report = Report::new();
        if arguments.check {
            let (what, number) = ("generated files that differ", differing as f64);
            report.check(Check::new(what, number, "files", Relation::Equal, 0.0));
        }
        let files =
            outcome.as_ref().map_or(0, |outcome| outcome.written.len() + outcome.unchanged.len());
        report.check(Check::new("generated files", files as f64, "files", Relation::AtLeast, 1.0));
        report.detail("seconds", seconds)?;
        report.detail("variants", variants)?;
        report.detail("differing", differing)?;
        report.write(path)?;
    }
    let outcome = outcome.map_err(|error| match error {
        package::Error::Library(report) => failure::rendered(report),
        other => other.into(),
    })?;
    let place = options.out.strip_prefix(repository()).unwrap_or(&options.out).display();
    say::line(format!("{place}: {outcome} ({seconds:.2} s)"));
    Ok(())
}

//! `variants`: which variants there are, and why each is in or out.

use std::path::PathBuf;

use clap::Args;
use sglow_report::failure::Result;
use sglow_report::json::Report;
use sglow_report::terminal::variants::Listing;
use sglow_results::check::{Check, Relation};

use crate::options::Choice;
use crate::{say, scene};

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
pub(crate) fn run(arguments: &Arguments) -> Result {
    let choice = &arguments.choice;
    let library = choice.over.library()?;
    let (selection, measured) = choice.select(&library)?;
    let (space, excluded, committed) = (library.variants(), library.excluded(), library.selected());
    let derived = selection.derived.as_ref();
    let derived = derived.map(|derived| scene::derived(derived, measured.as_ref())).transpose()?;
    let listing = Listing {
        library: &library,
        space: &space,
        excluded: &excluded,
        committed: &committed,
        variants: &selection.variants,
        allowed: &selection.allowed,
        absent: &selection.absent,
        left_out: &selection.left_out,
        derived: derived.as_ref(),
        none: if choice.is_committed() {
            "committed of these passes; `--all` lists them"
        } else if derived.is_some() && !choice.all {
            "of these passes in a frame of the scene; `--all` lists what its needs leave"
        } else {
            "legal of these passes"
        },
    };
    say::line(listing.show());
    if arguments.explain {
        say::line(listing.explain());
    }
    let mut report = Report::new();
    for (name, variants) in [
        ("legal variants", &space),
        ("committed variants", &committed),
        ("variants chosen", &selection.variants),
    ] {
        let count = variants.len() as f64;
        report.check(Check::new(name, count, "variants", Relation::AtLeast, 1.0));
    }
    if let Some(path) = &arguments.json {
        listing.details(&mut report)?;
        report.write(path)?;
    }
    report.verdict()
}

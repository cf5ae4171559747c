//! What can be typed.

use std::fmt::Write as _;

use clap::{CommandFactory as _, Parser, Subcommand};
use sglow_report::failure::Result;

use crate::command::{
    choose, compare, cost, docs, doctor, fuzz, gen_shaders, graph, kernels, render, report,
    reproduce, stability, test, variants, verify,
};

/// Generates, verifies and runs shaders for real-time indirect light with spherical Gaussians.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version, disable_help_subcommand = true)]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

/// What can be done.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Write shader packages from the library
    #[command(after_help = gen_shaders::EXAMPLES)]
    GenShaders(gen_shaders::Arguments),
    /// Show which variants there are, which are illegal, and what a scene needs
    #[command(after_help = variants::EXAMPLES)]
    Variants(variants::Arguments),
    /// Show what a frame keeps and runs, as tables, a drawing or JSON
    #[command(after_help = graph::EXAMPLES)]
    Graph(graph::Arguments),
    /// Render a scene to a picture
    #[command(after_help = render::EXAMPLES)]
    Render(render::Arguments),
    /// Compare two pictures by every metric
    #[command(after_help = compare::EXAMPLES)]
    Compare(compare::Arguments),
    /// Show where filtering kernels lie on an image, and what lies within them
    #[command(after_help = kernels::EXAMPLES)]
    Kernels(kernels::Arguments),
    /// Measure error against run time
    #[command(after_help = report::EXAMPLES)]
    Report(report::Arguments),
    /// Find the configuration that meets a budget of error or time, and write the package of just that
    #[command(after_help = choose::EXAMPLES)]
    Choose(choose::Arguments),
    /// Show the papers' tables and figures, ours beside theirs
    #[command(after_help = reproduce::EXAMPLES)]
    Reproduce(reproduce::Arguments),
    /// Check every function and the whole pipeline against their bounds, over every regime
    #[command(after_help = stability::EXAMPLES)]
    Stability(stability::Arguments),
    /// Measure the tables of docs/ that no other command writes
    #[command(after_help = docs::EXAMPLES)]
    Docs(docs::Arguments),
    /// Validate a package with independent compilers
    #[command(after_help = verify::EXAMPLES)]
    Verify(verify::Arguments),
    /// Show what a GPU compiler makes of every variant, without that GPU
    #[command(after_help = cost::EXAMPLES)]
    Cost(cost::Arguments),
    /// Run all tests, after making sure that a Vulkan driver exists
    #[command(after_help = test::EXAMPLES)]
    Test(test::Arguments),
    /// Show what this machine has and lacks
    #[command(after_help = doctor::EXAMPLES)]
    Doctor(doctor::Arguments),
    /// Try mutated inputs of every kind: nothing may panic, run long or take much memory
    #[command(after_help = fuzz::EXAMPLES)]
    Fuzz(fuzz::Arguments),
}

impl Command {
    /// Does it.
    pub(crate) fn run(self) -> Result {
        match self {
            Self::GenShaders(arguments) => gen_shaders::run(&arguments),
            Self::Variants(arguments) => variants::run(&arguments),
            Self::Graph(arguments) => graph::run(&arguments),
            Self::Render(arguments) => render::run(&arguments),
            Self::Compare(arguments) => compare::run(&arguments),
            Self::Kernels(arguments) => kernels::run(&arguments),
            Self::Report(arguments) => report::run(&arguments),
            Self::Choose(arguments) => choose::run(&arguments),
            Self::Reproduce(arguments) => reproduce::run(&arguments),
            Self::Stability(arguments) => stability::run(&arguments),
            Self::Docs(arguments) => docs::run(&arguments),
            Self::Verify(arguments) => verify::run(&arguments),
            Self::Cost(arguments) => cost::run(&arguments),
            Self::Test(arguments) => test::run(&arguments),
            Self::Doctor(arguments) => doctor::run(&arguments),
            Self::Fuzz(arguments) => fuzz::run(&arguments),
        }
    }
}

/// Printed when no command is given.
pub(crate) fn introduction() -> String {
    let cli = Cli::command();
    let mut text = String::from(
        "sglow turns one readable library of shaders (shaders/src) into specialised, validated variants for real-time \
         \nindirect light with spherical Gaussians, runs them, and measures the error and the time of each.\n\n\
         Commands:\n",
    );
    for command in cli.get_subcommands() {
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        // Writing to a string does not fail.
        let _ = writeln!(text, "  {:<12} {about}", command.get_name());
    }
    text.push_str(
        "\nFirst, try:\n  \
         cargo xtask gen-shaders     write the package that is committed; `git diff` shows nothing\n  \
         cargo xtask test            run all tests, on a software GPU if there is no other\n\n\
         `cargo xtask COMMAND --help` explains a command and gives examples.",
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_sound_and_every_command_has_an_example() {
        let cli = Cli::command();
        cli.clone().debug_assert();
        let introduction = introduction();
        for command in cli.get_subcommands() {
            let name = command.get_name();
            let help = command.get_after_help().map(ToString::to_string);
            let example = format!("cargo xtask {name}");
            assert!(help.is_some_and(|help| help.contains(&example)), "{name} lacks an example");
            assert!(introduction.contains(name), "{name} is not introduced");
        }
    }

    /// How many lines of a text are commands, which parse.
    fn parsed(text: &str) -> usize {
        let lines = text.lines().map(str::trim).filter(|line| line.starts_with("cargo xtask "));
        let parse = |line: &str| {
            let words = line.split_whitespace().skip(2);
            let parsed = Cli::try_parse_from(std::iter::once("cargo xtask").chain(words));
            assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
        };
        lines.map(parse).count()
    }

    #[test]
    fn every_example_and_every_line_of_the_documents_parses() {
        assert!(parsed(include_str!("../../docs/overlays.md")) >= 5);
        for command in Cli::command().get_subcommands() {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            assert!(parsed(&help) > 0);
        }
    }

    #[test]
    fn no_mutated_line_panics() {
        let help = |command: &clap::Command| command.get_after_help().map(ToString::to_string);
        let helps: String = Cli::command().get_subcommands().filter_map(help).collect();
        let tried = sglow_fuzz::Target::new("command-line", 30)
            .lines(&helps, |line| Cli::try_parse_from(line.split_whitespace().skip(1)).is_ok());
        assert!(tried.refused > 10 && tried.taken > 10, "{tried:?}");
    }
}

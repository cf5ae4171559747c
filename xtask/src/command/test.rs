//! `test`: all tests, on a machine that may have no GPU.

use clap::Args;
use sglow_consumers::machine::cargo;
use sglow_consumers::machine::driver::ensure_vulkan;
use sglow_report::failure::{Context as _, Failure, Result};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask test
  cargo xtask test --no-install
  cargo xtask test -- --package sglow-oracle --release

What follows `--` goes to `cargo test --workspace` as it is.";

/// Options of `test`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Install nothing; print the command instead
    #[arg(long)]
    no_install: bool,
    /// For `cargo test`
    #[arg(last = true, value_name = "ARGUMENT")]
    cargo: Vec<String>,
}

/// Makes sure that a Vulkan driver exists and runs the tests.
pub(crate) fn run(arguments: &Arguments) -> Result {
    // Elsewhere the driver belongs to the system, and the tests say whether there is one.
    if cfg!(target_os = "linux") {
        ensure_vulkan(!arguments.no_install)?;
    }
    let mut command = cargo();
    command.args(["test", "--workspace"]).args(&arguments.cargo);
    eprintln!(
        "+ {}",
        ["cargo test --workspace"]
            .into_iter()
            .chain(arguments.cargo.iter().map(String::as_str))
            .collect::<Vec<_>>()
            .join(" ")
    );
    let status = command.status().context("cargo test cannot be started")?;
    if status.success() {
        return Ok(());
    }
    Err(Failure::new(format!("`cargo test` ended with {status}")))
}

//! `test`: all tests, on a machine that may have no GPU.

use clap::Args;

use crate::failure::{Context as _, Failure, Result};
use crate::machine::vulkan::{self, Vulkan};
use crate::machine::{apt, cargo};

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
    /// Install nothing; say what to type instead
    #[arg(long)]
    no_install: bool,
    /// For `cargo test`
    #[arg(last = true, value_name = "ARGUMENT")]
    cargo: Vec<String>,
}

/// Makes sure that a Vulkan driver exists and runs the tests.
///
/// # Errors
///
/// When there is no driver and none can be installed, or a test fails.
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

/// Installs a software driver if there is none.
fn ensure_vulkan(may_install: bool) -> Result {
    let before = Vulkan::find();
    if before.usable() {
        return Ok(());
    }
    eprintln!("No usable Vulkan driver: {}.", lack(&before));
    if let Some(variable) = &before.variable {
        return Err(Failure::new(format!("{variable} names no driver that can be loaded"))
            .help(format!("unset {variable}, or let it name a driver's JSON file")));
    }
    if !may_install {
        return Err(Failure::new("the tests need a Vulkan driver")
            .help(format!("type: {}", apt::line(&vulkan::PACKAGES))));
    }
    eprintln!("Installing Mesa's software driver (lavapipe).");
    apt::install(&vulkan::PACKAGES)?;
    let after = Vulkan::find();
    if after.usable() {
        return Ok(());
    }
    Err(Failure::new(format!(
        "no usable Vulkan driver even after installing {}: {}",
        vulkan::PACKAGES.join(" and "),
        lack(&after)
    )))
}

/// What a machine without a usable driver lacks.
fn lack(vulkan: &Vulkan) -> String {
    let mut lacks = Vec::new();
    if vulkan.loader.is_none() {
        lacks.push("there is no loader (libvulkan.so.1)".to_owned());
    }
    if vulkan.drivers.is_empty() {
        lacks.push("no driver is registered".to_owned());
    }
    lacks.extend(vulkan.drivers.iter().filter_map(|driver| {
        let fault = driver.fault.as_ref()?;
        Some(format!("{}: {fault}", driver.manifest.display()))
    }));
    lacks.join("; ")
}

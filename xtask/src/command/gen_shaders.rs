//! `gen-shaders`: packages from the library.

use std::path::PathBuf;

use clap::Args;

use crate::failure::{Failure, Result};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask gen-shaders";

/// Options of `gen-shaders`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder that receives the package
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Generates.
pub(crate) fn run(arguments: &Arguments) -> Result {
    Err(Failure::new(format!("{arguments:?}")))
}

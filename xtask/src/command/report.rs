//! `report`: error against run time.

use std::path::PathBuf;

use clap::Args;

use crate::failure::{Failure, Result};

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask report --out out/report
  cargo xtask report --scene cornell --scene caustic --out out/report";

/// Options of `report`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A built-in scene, or a file: .gltf, .glb, .obj; may be given more than once
    #[arg(long, value_name = "FILE|NAME")]
    scene: Vec<String>,
    /// The folder that receives report.json and index.html
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Measures.
///
/// # Errors
///
/// When a scene, a variant or the device does not allow it, or a promise is not kept.
pub(crate) fn run(arguments: &Arguments) -> Result {
    Err(Failure::new(format!("the report is not wired to the runtime: {arguments:?}")))
}

//! `render`: a scene as a picture.

use std::path::PathBuf;

use clap::Args;

use crate::failure::{Failure, Result};
use crate::picture::Layer;

/// What `--help` shows below the options.
pub(crate) const EXAMPLES: &str = "\
Examples:
  cargo xtask render --scene cornell --out out/cornell.png
  cargo xtask render --scene cornell --set kernel=previous --size 640x360 --out out/previous.exr
  cargo xtask render --scene cornell --layer normal --out out/normal.png";

/// Options of `render`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A built-in scene, or a file: .gltf, .glb, .obj
    #[arg(long, value_name = "FILE|NAME")]
    scene: String,
    /// Values of axes; the others follow the scene's needs and the defaults
    #[arg(long, value_name = "AXIS=VALUE", value_delimiter = ',')]
    set: Vec<String>,
    /// Pixels of the picture
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    size: String,
    /// The file to write: .png for the eye, .exr with all layers in linear units
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Show one layer alone (.png)
    #[arg(long, value_name = "LAYER")]
    layer: Option<Layer>,
    /// Exposure in stops; without it the picture's mean becomes mid-grey (.png)
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true)]
    exposure: Option<f32>,
}

/// Renders.
///
/// # Errors
///
/// When the scene, the variant or the device does not allow it.
pub(crate) fn run(arguments: &Arguments) -> Result {
    Err(Failure::new(format!("rendering is not wired to the runtime: {arguments:?}")))
}

//! What the parameters of lights' maps do to a picture.

use serde::Serialize;

use crate::picture_error::PictureError;

/// Paths for each pixel of the measured references.
pub const PATHS: u32 = 1024;

/// A setting's error on one scene.
#[derive(Clone, Debug, Serialize)]
pub struct OnScene {
    /// The setting.
    pub name: String,
    /// Whether it is the default of all parameters.
    pub default: bool,
    /// Its picture against paths.
    pub error: PictureError,
}

//! From what a user requests of a library and a scene to settings, variants and what they save.

use sglow_graph::Errors;
use sglow_runtime::light::LightsError;
use sglow_runtime::package::PackageError;
use sglow_runtime::settings::SettingsError;
use sglow_scene::SceneError;
use sglow_shader_gen::error::Report;
use thiserror::Error;

pub mod derivation;
pub mod frame;
pub mod saving;
pub mod selection;
pub mod shot;

/// Errors of requests.
#[derive(Debug, Error)]
pub enum RequestError {
    /// The library is wrong.
    #[error(transparent)]
    Library(#[from] Report),
    /// Variants cannot be generated.
    #[error(transparent)]
    Generate(#[from] sglow_shader_gen::package::Error),
    /// A variant binds what no manifest describes.
    #[error(transparent)]
    Manifest(#[from] sglow_shader_gen::manifest::Error),
    /// A package is not what its manifest says.
    #[error(transparent)]
    Package(#[from] PackageError),
    /// The scene cannot be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene has fewer lights.
    #[error("the scene has no light {wanted}; it has {count}, counted from 0")]
    NoLight {
        /// The requested light.
        wanted: usize,
        /// The lights that there are.
        count: usize,
    },
    /// The scene's lights cannot share a map.
    #[error(transparent)]
    Lights(#[from] LightsError),
    /// An axis or a parameter cannot be set so.
    #[error(transparent)]
    Setting(#[from] SettingsError),
    /// Several settings are wrong.
    #[error("{}", .0.join("\n"))]
    Settings(Vec<String>),
    /// What is set leaves no value on an axis.
    #[error("no value remains on axis `{axis}`{}", rules.iter().map(|rule| format!("\nhelp: {rule}")).collect::<String>())]
    NoValue {
        /// The axis.
        axis: String,
        /// What took its values away.
        rules: Vec<String>,
    },
    /// No combination of values is requested.
    #[error("nothing is requested")]
    Nothing,
    /// The library has no frame.
    #[error("the library describes no frame: it has no frame.toml")]
    NoFrame,
    /// A package does not describe its frame.
    #[error("{0}: describes no frame")]
    NoDescription(String),
    /// The frame does not allow the settings.
    #[error(transparent)]
    Frame(#[from] Errors),
}

#[cfg(test)]
pub(crate) fn library() -> sglow_shader_gen::library::Library {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    sglow_shader_gen::library::Library::load(&folder).unwrap()
}

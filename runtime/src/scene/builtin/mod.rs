//! Scenes made by code.

use super::{Draft, SceneError};

/// The names of the built-in scenes.
pub const NAMES: [&str; 5] = ["atrium", "caustic", "columns", "cornell", "cornell-glossy"];

/// Whether a name is that of a built-in scene, with or without a number behind it.
pub(super) fn is_builtin(name: &str) -> bool {
    NAMES.contains(&name.split(':').next().unwrap_or_default())
}

/// The error for a name that is not built in.
pub(super) fn unknown(name: &str) -> SceneError {
    let known = format!("{} (atrium:75k, atrium:262k, atrium:331k)", NAMES.join(", "));
    SceneError::UnknownBuiltin { name: name.to_owned(), known }
}

/// Makes the scene of a name.
pub(super) fn make(name: &str) -> Result<Draft, SceneError> {
    Err(unknown(name))
}

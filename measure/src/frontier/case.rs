//! A scene that is to be measured, and what is found of it.

use sglow_renderer::request::RequestError;
use sglow_renderer::request::derivation::{Derivation, Request};
use sglow_scene::Scene;
use sglow_shader_gen::library::Library;
use thiserror::Error;

use super::subject::FrontierError;
use crate::cache::CacheError;

/// Errors of what is to be measured.
#[derive(Debug, Error)]
pub enum SelectError {
    /// Values that there are not.
    #[error("{}", .0.join("\n"))]
    Values(Vec<String>),
    /// No configuration remains.
    #[error("{scene}: nothing remains to be measured{}", help.iter().map(|line| format!("\nhelp: {line}")).collect::<String>())]
    Nothing {
        /// The scene.
        scene: String,
        /// The values that exclude the last ones.
        help: Vec<String>,
    },
    /// The default with the requested values is not legal.
    #[error(
        "{scene}: screening has no configuration to start from\nhelp: --all measures every legal one that has these values"
    )]
    Start {
        /// The scene.
        scene: String,
    },
    /// A scene or a setting is not possible.
    #[error(transparent)]
    Request(#[from] RequestError),
    /// A configuration cannot be measured.
    #[error(transparent)]
    Frontier(#[from] FrontierError),
    /// A result cannot be kept.
    #[error(transparent)]
    Cache(#[from] CacheError),
}

/// A scene that is to be measured.
#[derive(Debug)]
pub struct Case {
    /// The scene, with one light.
    pub scene: Scene,
    /// What it needs.
    pub derivation: Derivation,
    /// The library that it was derived by.
    pub library: Library,
}

impl Case {
    /// Derives what a scene with one light needs.
    ///
    /// # Errors
    ///
    /// When what is requested is not possible.
    pub fn new(scene: Scene, library: Library, request: &Request) -> Result<Self, RequestError> {
        let derivation = Derivation::new(&library, &scene, &[], request)?;
        Ok(Self { scene, derivation, library })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::path::{Path, PathBuf};

    use sglow_renderer::request::shot::load;

    use super::*;

    pub(crate) fn case(scene: &str, over: &[PathBuf]) -> Case {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
        let library = Library::load_with(&folder, over).unwrap();
        let scene = load(scene, None, &sglow_scene::Options::default()).unwrap().0;
        Case::new(scene, library, &Request::of([16, 9])).unwrap()
    }
}

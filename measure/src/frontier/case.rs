//! A scene that is to be measured, and what is found of it.

use std::collections::BTreeMap;

use sglow_renderer::device::Gpu;
use sglow_renderer::request::derivation::{Derivation, Request};
use sglow_renderer::request::{RequestError, saving};
use sglow_results::frontier::document::{Pictures, SceneReport};
use sglow_results::picture_error::{Display, flip_map};
use sglow_results::progress::Progress;
use sglow_results::saved::saved;
use sglow_scene::Scene;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::package::Purpose;
use thiserror::Error;

use super::offer::Offer;
use super::scene;
use super::screening::Planned;
use super::subject::{FrontierError, Subject};
use crate::cache::{Cache, CacheError};
use crate::saved::keep;

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
        /// What took the last ones away.
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

/// What was measured of a scene, with all that belongs to it.
#[derive(Debug)]
pub struct Found {
    /// The numbers.
    pub measured: SceneReport,
    /// The pictures.
    pub pictures: Pictures,
    /// FLIP maps by the name of the configuration, row by row from the top.
    pub flip: BTreeMap<String, Vec<f32>>,
    /// What its package was made without.
    pub purpose: Purpose,
}

/// Measures a scene.
///
/// # Errors
///
/// When it does not render, a variant is missing or a result cannot be kept.
pub fn measure(
    gpu: &Gpu,
    offer: &Offer<'_>,
    case: &Case,
    planned: Planned,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<Found, SelectError> {
    let Case { scene, derivation, library } = case;
    let subject = Subject::new(gpu, offer.package, scene, derivation.settings.clone());
    let measured = scene::scene(&subject, &planned.ways, &planned.close(), cache, progress);
    progress.end();
    let (mut measured, pictures) = measured?;
    measured.screening = planned.screening;
    let rules = measured.pruned.as_ref().map(saved);
    if let Some(pruned) = &measured.pruned {
        keep(cache, scene, pruned, &gpu.adapter)?;
    }
    let (purpose, _) = saving::purpose(library, derivation, &scene.name, &[], rules.as_ref())?;
    let map = |picture| flip_map(&pictures.reference, picture, measured.size, Display::Automatic);
    let flip = pictures.ways.iter().map(|(name, picture)| (name.clone(), map(picture))).collect();
    Ok(Found { flip, purpose, measured, pictures })
}

#[cfg(test)]
pub(crate) mod tests {
    use std::path::{Path, PathBuf};

    use sglow_renderer::request::shot::load;

    use super::*;

    pub(crate) fn case(scene: &str, over: &[PathBuf]) -> Case {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
        let library = Library::load_with(&folder, over).unwrap();
        let scene = load(scene, None).unwrap().0;
        Case::new(scene, library, &Request::of([16, 9])).unwrap()
    }
}

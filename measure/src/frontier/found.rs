//! What is found of a scene, with all that belongs to it.

use std::collections::BTreeMap;

use sglow_renderer::device::Gpu;
use sglow_renderer::request::saving;
use sglow_results::frontier::document::{Pictures, SceneReport};
use sglow_results::picture_error::{Display, flip_map};
use sglow_results::progress::Progress;
use sglow_results::saved::saved;
use sglow_shader_gen::package::Purpose;

use super::case::{Case, SelectError};
use super::offer::Offer;
use super::scene;
use super::screening::Planned;
use super::subject::Subject;
use crate::cache::Cache;
use crate::saved::keep;

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
    let Case { scene, derivation, library, .. } = case;
    let subject = Subject::new(gpu, offer.package, scene, derivation.settings.clone());
    let measured =
        scene::scene(&subject, &planned.configurations, &planned.close(), cache, progress);
    progress.end();
    let (mut measured, pictures) = measured?;
    measured.screening = planned.screening;
    let needs = library.need.iter();
    let rules = needs.map(|rule| (rule.name.clone(), rule.set.keys().cloned().collect())).collect();
    if let Some(pruned) = &measured.pruned {
        keep(cache, scene, pruned, &rules, &gpu.adapter)?;
    }
    let saved = measured.pruned.as_ref().map(|pruned| saved(pruned, &rules));
    let (purpose, _) = saving::purpose(library, derivation, &scene.name, &[], saved.as_ref())?;
    let map = |picture| flip_map(&pictures.reference, picture, measured.size, Display::Automatic);
    let flip = pictures
        .configurations
        .iter()
        .map(|(name, picture)| (name.clone(), map(picture)))
        .collect();
    Ok(Found { flip, purpose, measured, pictures })
}

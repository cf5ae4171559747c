//! A scene measured: every configuration's time and error, the frontier once more as whole frames.

use std::collections::{BTreeMap, BTreeSet};

use sglow_renderer::light::kind_of_all;
use sglow_results::frontier::document::{Configuration, Pictures, Radiance, SceneReport};
use sglow_results::frontier::rank;
use sglow_results::progress::Progress;
use sglow_runtime::settings::Settings;

use super::bench::RUNS;
use super::evaluate::Evaluator;
use super::references::{References, references};
use super::subject::{Drawn, FrontierError, Subject};
use super::together::{self, Named};
use super::{configuration, lists, measure, prune, straddling, sweep};
use crate::cache::Cache;

/// Measures a scene by each of `configurations`, those called as in `close` as closely as the frontier; what was
/// measured before under the same circumstances is taken from `cache`.
///
/// # Errors
///
/// When there is no configuration, the scene does not render, or a result cannot be kept.
pub fn scene(
    subject: &Subject<'_>,
    configurations: &[Settings],
    close: &BTreeSet<String>,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<(SceneReport, Pictures), FrontierError> {
    if configurations.is_empty() {
        let why = "none of the variants has the requested values".to_owned();
        return Err(FrontierError::Nothing { scene: subject.scene.name.clone(), why });
    }
    let references = references(subject, cache, progress)?;
    let mut measured = measure::every(subject, configurations, &references, cache, progress)?;
    rank::mark(&mut measured.configurations);
    let chosen = chosen(&measured.configurations, configurations, close, &subject.base);
    let (lists, nodes) = lists::lists(subject, cache)?.unzip();
    let pictures = Pictures {
        nodes: nodes.unwrap_or_default(),
        ..pictures(subject, &chosen, &references, cache)?
    };
    again(subject, &chosen, close, &mut measured.configurations, cache, progress)?;
    let base = &subject.base;
    Ok((
        SceneReport {
            scene: subject.scene.name.clone(),
            triangles: subject.scene.triangle_count(),
            light: kind_of_all(&subject.scene.lights).to_string(),
            size: base.size,
            rsm_size: base.map,
            lights: base.lights,
            iterations: base.iterations,
            size_factor: f64::from(base.size_factor),
            clock: measured.clock,
            runs: RUNS,
            reference: references.reference.clone(),
            configurations: measured.configurations,
            sweeps: sweep::sweeps(subject, &references, cache, progress)?,
            lists,
            straddling: straddling::straddling(subject, &references, cache)?,
            screening: None,
            pruned: prune::pruned(subject, cache, progress)?,
            not_finite: measured.not_finite,
        },
        pictures,
    ))
}

/// The configurations that are looked at closely: those on a frontier, the default and those in `close`, by name.
fn chosen<'w>(
    measured: &[Configuration],
    configurations: &'w [Settings],
    also: &BTreeSet<String>,
    base: &Settings,
) -> Vec<(String, &'w Settings)> {
    let close = |name: &str| {
        also.contains(name)
            || measured
                .iter()
                .any(|configuration| configuration.name == name && configuration.is_shown())
    };
    let named =
        configurations.iter().map(|settings| (configuration::name(settings, base), settings));
    named.filter(|(name, _)| close(name)).collect()
}

/// Whole pictures of configurations, and of the reference.
fn pictures(
    subject: &Subject<'_>,
    chosen: &Named<'_>,
    references: &References,
    cache: &Cache,
) -> Result<Pictures, FrontierError> {
    let whole = |indirect: &Radiance| -> Result<Radiance, FrontierError> {
        let Drawn { renderer, frame, .. } = subject.drawn()?;
        Ok(Evaluator::new(subject, references, frame, renderer.eye()).whole(indirect))
    };
    let mut found = Pictures {
        reference: cache
            .get(&subject.scene_key("reference picture")?, || whole(&references.indirect))?,
        configurations: BTreeMap::new(),
        nodes: Vec::new(),
    };
    for (name, settings) in chosen {
        let picture = cache.get(&subject.key("picture", name, settings)?, || {
            let (maps, _) = subject.maps(settings, 0)?;
            let (lights, _) = subject.lights(settings, &maps, 0)?;
            let visibility = subject.visibility(settings)?;
            if let Some(visibility) = &visibility {
                subject.shadow(visibility, &lights)?;
            }
            whole(&subject.reflect(&lights, visibility.as_ref(), &subject.shading(settings)?)?)
        })?;
        found.configurations.insert(name.clone(), picture);
    }
    Ok(found)
}

/// The longest frame that is timed as a whole again, in milliseconds: what lies between passes takes some milliseconds
/// at most, so that the sum of longer ones is good enough.
const WHOLE_AT_MOST: f64 = 1e3;
/// The longest frame whose flicker is followed, in milliseconds, but for configurations that promises are about.
const FLICKER_AT_MOST: f64 = 4e3;

/// The frontier and the default once more: whole frames in turns, and their flicker.
fn again(
    subject: &Subject<'_>,
    chosen: &Named<'_>,
    close: &BTreeSet<String>,
    measured: &mut [Configuration],
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<(), FrontierError> {
    let within = |limit: f64, always: &BTreeSet<String>| -> Vec<(String, &Settings)> {
        let short = |name: &str| {
            measured.iter().any(|configuration| {
                configuration.name == *name && configuration.time.median <= limit
            })
        };
        let chosen = chosen.iter().filter(|(name, _)| always.contains(name) || short(name));
        chosen.map(|(name, settings)| (name.clone(), *settings)).collect()
    };
    let timed = within(WHOLE_AT_MOST, &BTreeSet::new());
    let followed = within(FLICKER_AT_MOST, close);
    let scene = &subject.scene.name;
    progress.start(&format!("{scene}: {} whole frames in turns", timed.len()), 0);
    let times = together::whole_frames(subject, &timed, cache)?;
    progress.start(&format!("{scene}: flicker of {} configurations", followed.len()), 0);
    let flickers = together::flicker(subject, &followed, cache)?;
    for configuration in measured {
        let at = |named: &Named<'_>| named.iter().position(|(name, _)| *name == configuration.name);
        configuration.whole = at(&timed).and_then(|at| times.get(at).copied());
        configuration.flicker = at(&followed).and_then(|at| flickers.get(at).copied());
    }
    Ok(())
}

//! Times of what reflects lights, in turns, so that what disturbs the one disturbs the others too.

use std::collections::BTreeMap;
use std::rc::Rc;

use sglow_results::progress::Progress;
use sglow_runtime::indirect::Indirect;
use sglow_runtime::settings::Settings;

use super::bench::{PassTimes, RUNS, Runs, Timed};
use super::configuration;
use super::shared::Shared;
use super::subject::{FrontierError, Subject};
use crate::cache::{Cache, Key};

/// A shading variant that is to be timed.
struct Lacking {
    settings: Settings,
    key: Key,
    runs: Runs,
}

/// Times of shadowing and reflecting the lights that are made by default, by [`super::depends::Depends::shading_id`]: of all that were not
/// measured before, in turns.
pub(super) fn time_shadings(
    shared: &Shared<'_, '_>,
    configurations: &[Settings],
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<BTreeMap<String, Timed>, FrontierError> {
    let subject = shared.subject;
    let mut found = BTreeMap::new();
    let mut lacking: BTreeMap<String, Lacking> = BTreeMap::new();
    for settings in configurations.iter().map(|one| subject.depends.of_shading(one)) {
        let id = subject.depends.shading_id(&settings);
        if found.contains_key(&id) || lacking.contains_key(&id) {
            continue;
        }
        let key =
            subject.key("shading", &configuration::name(&settings, &subject.base), &settings)?;
        match cache.find::<Timed>(&key) {
            Some(timed) => drop(found.insert(id, timed)),
            None => drop(lacking.insert(id, Lacking { settings, key, runs: Runs::default() })),
        }
    }
    in_turns(shared, &mut lacking, progress)?;
    for (id, Lacking { key, runs, .. }) in lacking {
        found.insert(id, cache.get(&key, || Ok::<_, FrontierError>(Timed::of(&runs)))?);
    }
    Ok(found)
}

fn in_turns(
    shared: &Shared<'_, '_>,
    lacking: &mut BTreeMap<String, Lacking>,
    progress: &dyn Progress,
) -> Result<(), FrontierError> {
    let subject = shared.subject;
    if lacking.is_empty() {
        return Ok(());
    }
    let what = format!("{}: {} shading variants in turns", subject.scene.name, lacking.len());
    progress.start(&what, lacking.len() * (RUNS + 1));
    let mut lights = DefaultLights::default();
    let mut done = 0;
    for run in 0..=RUNS {
        // Maps are drawn once a run for all that read them: of some scenes that takes far longer than what reads them.
        let mut drawn: Vec<(Rc<Indirect>, PassTimes)> = Vec::new();
        for Lacking { settings, runs, .. } in lacking.values_mut() {
            let visibility = shared.visibility(settings)?;
            let shading = shared.shading(settings)?;
            // The first run compiles.
            let mut discarded = Runs::default();
            let runs = if run == 0 { &mut discarded } else { runs };
            let lights = lights.held(subject, settings)?;
            let maps = match &visibility {
                None => Vec::new(),
                Some(visibility) => match drawn.iter().find(|(own, _)| Rc::ptr_eq(own, visibility))
                {
                    Some((_, times)) => times.clone(),
                    None => {
                        let times = subject.time_visibility(lights, visibility)?;
                        drawn.push((visibility.clone(), times.clone()));
                        times
                    }
                },
            };
            subject.time_shading(lights, visibility.as_deref(), &shading, &maps, runs)?;
            done += 1;
            progress.done(done);
        }
    }
    Ok(())
}

/// Lights that are made by default, once for each layout.
#[derive(Default)]
struct DefaultLights(Vec<(Settings, Indirect)>);

impl DefaultLights {
    fn held(
        &mut self,
        subject: &Subject<'_>,
        settings: &Settings,
    ) -> Result<&Indirect, FrontierError> {
        let alike = |made: &Settings| subject.depends.same_layout(settings, made);
        let at = match self.0.iter().position(|(made, _)| alike(made)) {
            Some(at) => at,
            None => {
                let (maps, _) = subject.maps(settings, 0)?;
                let (lights, _) = subject.lights(settings, &maps, 0)?;
                self.0.push((settings.clone(), lights));
                self.0.len() - 1
            }
        };
        Ok(&self.0[at].1)
    }
}

//! A scene measured: every way's time and error, the frontier once more as whole frames.

use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sglow_runtime::frame::{Renderer, kind, light_maps};
use sglow_runtime::indirect::{Indirect, Inputs};
use sglow_runtime::plan::Part;
use sglow_runtime::settings::Settings;
use sglow_runtime::shading::Shading;
use sglow_runtime::timing::{Clock, Timer};
use sglow_runtime::visibility::Visibility;
use sglow_shaders::{Diffuse, Lobes, Specular, Visibility as VisibilityAxis};

use super::bench::{Runs, held_alike, of_lights, of_maps, of_shading};
use super::choose::{self, Bought, Budget, Metric};
use super::document::{Pass, Pictures, Radiance, Reference, SceneReport, Time, Way};
use super::judge::{Judge, Verdict};
use super::rank;
use super::subject::{Drawn, FrontierError, Subject};
use super::truth::{Truth, truth};
use super::{prune, sweep, way};
use crate::cache::{Cache, Key};
use crate::rivals::flicker::{self, Contender, Walk};

/// Timed runs of each pass, after one that compiles.
pub const RUNS: usize = 5;

/// What is told while it lasts.
pub trait Progress: Sync {
    /// What comes next, and of how many steps.
    fn start(&self, what: &str, steps: usize);
    /// How many steps are done.
    fn done(&self, steps: usize);
}

/// Passes that were timed.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Timed {
    pub(super) passes: Vec<Pass>,
    pub(super) whole: Time,
    clock: String,
}

impl Timed {
    pub(super) fn of(runs: &Runs) -> Self {
        let clock = runs.clock.unwrap_or(Clock::Wall).to_string();
        Self { passes: runs.passes(), whole: runs.whole(), clock }
    }
}

/// What is made once for several ways.
struct Workshop<'a, 's> {
    subject: &'a Subject<'s>,
    shadings: RefCell<BTreeMap<String, std::rc::Rc<Shading>>>,
    hidings: RefCell<BTreeMap<String, std::rc::Rc<Visibility>>>,
}

impl<'a, 's> Workshop<'a, 's> {
    fn new(subject: &'a Subject<'s>) -> Self {
        Self { subject, shadings: RefCell::default(), hidings: RefCell::default() }
    }

    fn shading(&self, settings: &Settings) -> Result<std::rc::Rc<Shading>, FrontierError> {
        let id = settings.shade().id().to_string();
        if let Some(made) = self.shadings.borrow().get(&id) {
            return Ok(made.clone());
        }
        let made = std::rc::Rc::new(self.subject.shading(settings)?);
        self.shadings.borrow_mut().insert(id, made.clone());
        Ok(made)
    }

    fn hiding(
        &self,
        settings: &Settings,
    ) -> Result<Option<std::rc::Rc<Visibility>>, FrontierError> {
        let Settings { visibility, lobes, precision, .. } = settings;
        let id = format!("{visibility} {lobes} {precision}");
        if let Some(made) = self.hidings.borrow().get(&id) {
            return Ok(Some(made.clone()));
        }
        let made = self.subject.hiding(settings)?.map(std::rc::Rc::new);
        if let Some(made) = &made {
            self.hidings.borrow_mut().insert(id, made.clone());
        }
        Ok(made)
    }
}

/// Measures a scene by each of `ways`; what was measured before under the same circumstances is taken from `cache`.
///
/// # Errors
///
/// When there is no way, the scene does not render, or a result cannot be kept.
pub fn scene(
    subject: &Subject<'_>,
    ways: &[Settings],
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<(SceneReport, Pictures), FrontierError> {
    if ways.is_empty() {
        let why = "none of the variants has the values asked for".to_owned();
        return Err(FrontierError::NoWay { scene: subject.scene.name.clone(), why });
    }
    progress.start(&format!("{}: reference", subject.scene.name), 0);
    let truth = truth(subject, cache, &|_, _| {})?;
    let mut clock = String::new();
    let (mut measured, not_finite) = every_way(subject, ways, &truth, cache, progress, &mut clock)?;
    rank::mark(&mut measured, truth.reference.floor_over_mean);
    let chosen = chosen(&measured, ways, &subject.base);
    let pictures = pictures(subject, &chosen, &truth, cache)?;
    again(subject, &chosen, &mut measured, cache, progress)?;
    let base = &subject.base;
    Ok((
        SceneReport {
            scene: subject.scene.name.clone(),
            triangles: subject.scene.triangle_count(),
            light: kind(&subject.scene.lights[0]).to_string(),
            size: base.size,
            rsm_size: base.rsm_size,
            lights: base.count,
            iterations: base.iterations,
            size_factor: f64::from(base.size_factor),
            clock,
            runs: RUNS,
            reference: truth.reference.clone(),
            ways: measured,
            sweeps: sweep::sweeps(subject, &truth, cache, progress)?,
            pruned: prune::pruned(subject, cache, progress)?,
            not_finite,
        },
        pictures,
    ))
}

/// What a budget buys, as [`choose`](super::choose) has it.
#[derive(Clone, Debug)]
pub struct Purchase {
    /// Every way; those that were compared closely have times of whole frames.
    pub ways: Vec<Way>,
    /// The names of those that win and come next, best first; nothing if the budget buys nothing.
    pub order: Vec<String>,
    /// What errors are against.
    pub reference: Reference,
    /// How times were taken.
    pub clock: String,
}

/// Finds what a budget buys among `ways`. Whatever comes first has been measured again as whole frames, in turns with
/// what comes close to it.
///
/// # Errors
///
/// When there is no way, the scene does not render, or a result cannot be kept.
pub fn buy(
    subject: &Subject<'_>,
    ways: &[Settings],
    metric: Metric,
    budget: Budget,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<Purchase, FrontierError> {
    progress.start(&format!("{}: reference", subject.scene.name), 0);
    let truth = truth(subject, cache, &|_, _| {})?;
    let mut clock = String::new();
    let (mut measured, _) = every_way(subject, ways, &truth, cache, progress, &mut clock)?;
    rank::mark(&mut measured, truth.reference.floor_over_mean);
    let settings: BTreeMap<String, &Settings> =
        ways.iter().map(|settings| (way::name(settings, &subject.base), settings)).collect();
    loop {
        let order: Vec<String> = match choose::choose(&measured, metric, budget) {
            Some(Bought::Ways(ways)) => ways.iter().map(|way| way.name.clone()).collect(),
            Some(Bought::Nothing { .. }) | None => Vec::new(),
        };
        let first = measured.iter().find(|way| order.first() == Some(&way.name));
        if first.is_none_or(|way| way.whole.is_some()) {
            return Ok(Purchase { ways: measured, order, reference: truth.reference, clock });
        }
        let chosen: Vec<(String, &Settings)> =
            order.iter().filter_map(|name| Some((name.clone(), *settings.get(name)?))).collect();
        progress.start(&format!("{}: {} ways in turns", subject.scene.name, chosen.len()), 0);
        let times = turns(subject, &chosen, cache)?;
        for ((name, _), time) in chosen.iter().zip(times) {
            if let Some(way) = measured.iter_mut().find(|way| way.name == *name) {
                way.whole = Some(time);
            }
        }
    }
}

/// The ways that are looked at closely: the frontier's and the default, by name.
fn chosen<'w>(
    measured: &[Way],
    ways: &'w [Settings],
    base: &Settings,
) -> Vec<(String, &'w Settings)> {
    let close =
        |name: &str| measured.iter().any(|way| way.name == name && (way.frontier || way.default));
    let named = ways.iter().map(|settings| (way::name(settings, base), settings));
    named.filter(|(name, _)| close(name)).collect()
}

/// Times and errors of every way.
fn every_way(
    subject: &Subject<'_>,
    ways: &[Settings],
    truth: &Truth,
    cache: &Cache,
    progress: &dyn Progress,
    clock: &mut String,
) -> Result<(Vec<Way>, usize), FrontierError> {
    let base = &subject.base;
    let named = |what: &str, settings: &Settings| {
        let name = way::name(settings, base);
        subject.key(what, &name, settings)
    };
    let of_makers = |what: &str, settings: &Settings| {
        subject.key_of_lights(what, &way::name(settings, base), settings)
    };
    let workshop = Workshop::new(subject);
    let judge: OnceCell<Judge<'_>> = OnceCell::new();
    let judged = || -> Result<&Judge<'_>, FrontierError> {
        if judge.get().is_none() {
            let Drawn { renderer, frame, .. } = subject.drawn()?;
            let _ = judge.set(Judge::new(subject, truth, frame, renderer.eye()));
        }
        judge.get().ok_or_else(|| FrontierError::NoSurface { scene: subject.scene.name.clone() })
    };

    let shaded = time_shadings(&workshop, ways, cache, progress)?;
    progress.start(&format!("{}: {} ways", subject.scene.name, ways.len()), ways.len());
    let mut found = Vec::new();
    let mut not_finite = 0;
    let mut maps: Option<(Settings, OnceCell<Indirect>, Timed)> = None;
    let mut lights: Option<(Settings, OnceCell<Indirect>, Timed)> = None;
    let mut hidden: Option<(Settings, VisibilityAxis)> = None;
    for (index, settings) in ways.iter().enumerate() {
        let (map_settings, light_settings) = (of_maps(settings), of_lights(settings));
        if maps.as_ref().is_none_or(|maps| maps.0 != map_settings) {
            let made = OnceCell::new();
            let timed = cache.get(&of_makers("maps", &map_settings)?, || {
                let (indirect, runs) = subject.maps(&map_settings, RUNS)?;
                let _ = made.set(indirect);
                Ok::<_, FrontierError>(Timed::of(&runs))
            })?;
            maps = Some((map_settings, made, timed));
        }
        let Some((map_settings, map_cell, map_times)) = &maps else { continue };
        let map = || made(map_cell, || Ok(subject.maps(map_settings, 0)?.0));
        if lights.as_ref().is_none_or(|lights| lights.0 != light_settings) {
            let made = OnceCell::new();
            let timed = cache.get(&of_makers("lights", &light_settings)?, || {
                let (indirect, runs) = subject.lights(&light_settings, map()?, RUNS)?;
                let _ = made.set(indirect);
                Ok::<_, FrontierError>(Timed::of(&runs))
            })?;
            lights = Some((light_settings, made, timed));
        }
        let Some((light_settings, light_cell, light_times)) = &lights else { continue };
        let light = || made(light_cell, || Ok(subject.lights(light_settings, map()?, 0)?.0));

        let id = settings.shade().id().to_string();
        let verdict: Verdict = cache.get(&named("verdict", settings)?, || {
            let lights = light()?;
            let hiding = workshop.hiding(settings)?;
            if let Some(hiding) = &hiding {
                let these = (light_settings.clone(), settings.visibility);
                if hidden.as_ref() != Some(&these) {
                    subject.hide(hiding, lights)?;
                    hidden = Some(these);
                }
            }
            let shading = workshop.shading(settings)?;
            let indirect = subject.reflect(lights, hiding.as_deref(), &shading)?;
            let oracle = subject.read_lights(lights)?;
            Ok::<_, FrontierError>(judged()?.verdict(settings, &indirect, &oracle))
        })?;
        not_finite += verdict.not_finite;
        let shading_times = &shaded[&id];
        let parts = [map_times, light_times, shading_times];
        clock.clone_from(&map_times.clock);
        found.push(Way {
            name: way::name(settings, base),
            axes: way::axes(settings)
                .into_iter()
                .map(|(axis, value)| (axis.to_owned(), value.to_owned()))
                .collect(),
            variants: way::variants(settings),
            default: way::name(settings, base) == "default",
            complete: complete(settings, base),
            passes: parts.iter().flat_map(|timed| timed.passes.clone()).collect(),
            time: parts
                .iter()
                .flat_map(|timed| &timed.passes)
                .fold(Time::default(), |sum, pass| sum.then(pass.time)),
            whole: None,
            bytes: bytes(subject, settings),
            picture: verdict.picture,
            model_rms_over_mean: verdict.model_rms_over_mean,
            rounding: verdict.rounding,
            flicker: None,
            frontier: false,
            dominated: None,
        });
        progress.done(index + 1);
    }
    Ok((found, not_finite))
}

/// What a way keeps beside the surfaces that it reads.
fn bytes(subject: &Subject<'_>, settings: &Settings) -> BTreeMap<String, u64> {
    let resources = subject.plan(settings).resources;
    let own = resources.iter().filter(|one| [Part::Indirect, Part::Visibility].contains(&one.part));
    own.map(|one| (one.name.to_owned(), one.bytes)).collect()
}

/// What a cell holds, made if it holds nothing.
fn made<T>(
    cell: &OnceCell<T>,
    make: impl FnOnce() -> Result<T, FrontierError>,
) -> Result<&T, FrontierError> {
    if let Some(made) = cell.get() {
        return Ok(made);
    }
    let new = make()?;
    Ok(cell.get_or_init(|| new))
}

/// Lights that are made by default, as they are held.
struct DefaultLights {
    settings: Settings,
    lights: Indirect,
}

/// Times of hiding and reflecting the lights that are made by default, by the shading variant: of all that were not
/// measured before, in turns.
fn time_shadings(
    workshop: &Workshop<'_, '_>,
    ways: &[Settings],
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<BTreeMap<String, Timed>, FrontierError> {
    let subject = workshop.subject;
    let mut found = BTreeMap::new();
    let mut lacking: BTreeMap<String, (Settings, Key, Runs)> = BTreeMap::new();
    for settings in ways.iter().map(of_shading) {
        let id = settings.shade().id().to_string();
        if found.contains_key(&id) || lacking.contains_key(&id) {
            continue;
        }
        let key = subject.key("shading", &way::name(&settings, &subject.base), &settings)?;
        match cache.find::<Timed>(&key) {
            Some(timed) => drop(found.insert(id, timed)),
            None => drop(lacking.insert(id, (settings, key, Runs::default()))),
        }
    }
    let steps = lacking.len() * (RUNS + 1);
    if steps > 0 {
        let what = format!("{}: {} shading variants in turns", subject.scene.name, lacking.len());
        progress.start(&what, steps);
    }
    let mut held: Vec<DefaultLights> = Vec::new();
    let mut done = 0;
    for run in 0..=RUNS {
        for (settings, _, runs) in lacking.values_mut() {
            let alike = |one: &DefaultLights| held_alike(settings, &one.settings);
            let at = match held.iter().position(alike) {
                Some(at) => at,
                None => {
                    let (maps, _) = subject.maps(settings, 0)?;
                    let (lights, _) = subject.lights(settings, &maps, 0)?;
                    held.push(DefaultLights { settings: settings.clone(), lights });
                    held.len() - 1
                }
            };
            let hiding = workshop.hiding(settings)?;
            let shading = workshop.shading(settings)?;
            // The first run compiles.
            let mut discarded = Runs::default();
            let runs = if run == 0 { &mut discarded } else { runs };
            subject.time_shading(&held[at].lights, hiding.as_deref(), &shading, runs)?;
            done += 1;
            progress.done(done);
        }
    }
    for (id, (_, key, runs)) in lacking {
        found.insert(id, cache.get(&key, || Ok::<_, FrontierError>(Timed::of(&runs)))?);
    }
    Ok(found)
}

/// Whether settings have all that the scene needs, which `base` has.
fn complete(settings: &Settings, base: &Settings) -> bool {
    let specular = settings.specular != Specular::None && settings.lobes == Lobes::Both;
    settings.diffuse != Diffuse::None && (base.specular == Specular::None || specular)
}

/// Whole pictures of ways, and of the reference.
fn pictures(
    subject: &Subject<'_>,
    chosen: &[(String, &Settings)],
    truth: &Truth,
    cache: &Cache,
) -> Result<Pictures, FrontierError> {
    let whole = |indirect: &Radiance| -> Result<Radiance, FrontierError> {
        let Drawn { renderer, frame, .. } = subject.drawn()?;
        Ok(Judge::new(subject, truth, frame, renderer.eye()).whole(indirect))
    };
    let mut found = Pictures {
        reference: cache.get(&subject.scene_key("reference picture"), || whole(&truth.indirect))?,
        ways: BTreeMap::new(),
    };
    for (name, settings) in chosen {
        let picture = cache.get(&subject.key("picture", name, settings)?, || {
            let workshop = Workshop::new(subject);
            let (maps, _) = subject.maps(settings, 0)?;
            let (lights, _) = subject.lights(settings, &maps, 0)?;
            let hiding = workshop.hiding(settings)?;
            if let Some(hiding) = &hiding {
                subject.hide(hiding, &lights)?;
            }
            let shading = workshop.shading(settings)?;
            whole(&subject.reflect(&lights, hiding.as_deref(), &shading)?)
        })?;
        found.ways.insert(name.clone(), picture);
    }
    Ok(found)
}

/// The frontier and the default once more: whole frames in turns, and their flicker.
fn again(
    subject: &Subject<'_>,
    chosen: &[(String, &Settings)],
    measured: &mut [Way],
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<(), FrontierError> {
    let names: Vec<&str> = chosen.iter().map(|one| one.0.as_str()).collect();
    progress.start(&format!("{}: the frontier in turns", subject.scene.name), 0);
    let times = turns(subject, chosen, cache)?;
    progress.start(&format!("{}: flicker of {} ways", subject.scene.name, names.len()), 0);
    let walk = Walk { frames: 5, pixels: 400, samples: 128, step: 0.002 };
    let followed = together(subject, "flicker", chosen)?.on("walk", format!("{walk:?}"));
    let flickers: Vec<f64> = cache.get(&followed, || follow(subject, chosen, walk))?;
    for ((name, time), flicker) in names.iter().zip(times).zip(flickers) {
        if let Some(way) = measured.iter_mut().find(|way| way.name == *name) {
            way.whole = Some(time);
            way.flicker = Some(flicker);
        }
    }
    Ok(())
}

/// The key of what several ways were measured for together.
fn together(
    subject: &Subject<'_>,
    what: &str,
    chosen: &[(String, &Settings)],
) -> Result<Key, FrontierError> {
    let names: Vec<&str> = chosen.iter().map(|one| one.0.as_str()).collect();
    let mut key = subject.scene_key(&format!("{what} of {}", names.join(" ")));
    for (name, settings) in chosen {
        key = key.on(name, format!("{:?}", subject.key(what, name, settings)?));
    }
    Ok(key)
}

/// Times of whole frames of each way, which were taken in one run: with another company all are taken again.
fn turns(
    subject: &Subject<'_>,
    chosen: &[(String, &Settings)],
    cache: &Cache,
) -> Result<Vec<Time>, FrontierError> {
    cache.get(&together(subject, "frontier in turns", chosen)?, || in_turns(subject, chosen))
}

/// How much each way flickers while the light moves.
fn follow(
    subject: &Subject<'_>,
    chosen: &[(String, &Settings)],
    walk: Walk,
) -> Result<Vec<f64>, FrontierError> {
    let contender = |(name, settings): &(String, &Settings)| Contender {
        name: name.clone(),
        settings: (*settings).clone(),
    };
    let contenders: Vec<Contender> = chosen.iter().map(contender).collect();
    let Subject { gpu, package, scene, .. } = *subject;
    let found = flicker::flicker(gpu, package, scene, &contenders, walk, |_| {})?;
    Ok(found.contenders.into_iter().map(|one| one.flicker).collect())
}

/// Whole frames of indirect light of each way, in turns.
fn in_turns(
    subject: &Subject<'_>,
    chosen: &[(String, &Settings)],
) -> Result<Vec<Time>, FrontierError> {
    let Drawn { renderer, .. } = subject.drawn()?;
    let gpu = subject.gpu;
    let made = chosen
        .iter()
        .map(|(_, settings)| {
            let light = renderer.indirect().settings().light;
            let settings = Settings { light, ..(*settings).clone() };
            let indirect =
                Indirect::with_package(&gpu.device, &gpu.queue, &settings, subject.package)?;
            let hiding = light_maps(gpu, subject.package, subject.scene, &settings)?;
            Ok((indirect, hiding))
        })
        .collect::<Result<Vec<_>, FrontierError>>()?;
    let mut runs = vec![Vec::new(); chosen.len()];
    for run in 0..=RUNS {
        for ((indirect, hiding), runs) in made.iter().zip(&mut runs) {
            let passes = one_frame(renderer, indirect, hiding.as_ref(), gpu)?;
            if run > 0 {
                runs.push(passes.iter().map(|pass| pass.1).sum());
            }
        }
    }
    Ok(runs.into_iter().map(Time::of).collect())
}

/// The passes of one frame of indirect light.
pub(super) fn one_frame(
    renderer: &Renderer<'_>,
    indirect: &Indirect,
    hiding: Option<&Visibility>,
    gpu: &sglow_runtime::device::Gpu,
) -> Result<Vec<(&'static str, std::time::Duration)>, FrontierError> {
    let inputs = Inputs { visibility: hiding, ..renderer.inputs() };
    let mut timer = Timer::new(gpu);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    indirect.encode(&mut encoder, &inputs, Some(&mut timer));
    gpu.queue.submit([encoder.finish()]);
    let passes = timer.finish()?;
    gpu.finish()?;
    Ok(passes)
}

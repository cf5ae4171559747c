//! What a scene needs, derived: facts, values on axes, numbers, and what a frame then takes.

use std::collections::{BTreeMap, BTreeSet};

use sglow_runtime::package::Assumption;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shader_gen::library::{AxisValue, Library, Setting};
use sglow_shader_gen::matrix::{Allowed, AllowedValues, Facts};
use sglow_shaders::{Light, Ndf, Specular};

use crate::light;
use crate::needs::{Needs, least_limits, needs};
use crate::plan::{Plan, Surfaces};
use crate::request::RequestError;

/// The settings that are requested, before the scene's needs.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// The preset that is changed.
    pub preset: Option<String>,
    /// Parameters, as `name=value`.
    pub numbers: Vec<String>,
}

impl Request {
    /// Defaults for a picture of a size.
    pub fn of(size: [u32; 2]) -> Self {
        Self { size, ..Self::default() }
    }

    /// Settings for an input of which `facts` are known: the preset, else the defaults for its class; then numbers. What
    /// is `set` by hand (`axis=value`) is not applied here, but decides which defaults hold.
    ///
    /// # Errors
    ///
    /// An unknown preset, with the known ones; an invalid number; what is given twice with different values.
    pub fn settings(
        &self,
        library: &Library,
        facts: &Facts,
        set: &[String],
    ) -> Result<Settings, RequestError> {
        let others = others(library);
        let mut settings = Settings { size: self.size, others, ..Settings::default() };
        let given = || self.numbers.iter().chain(set);
        let twice = contradictions(given());
        if !twice.is_empty() {
            return Err(RequestError::Settings(twice));
        }
        let by_hand = || given().filter_map(|one| one.split('=').next());
        let preset = self.preset.as_ref().map(|name| library.find_preset(name)).transpose()?;
        for rule in &library.class_default {
            let axis = |axis: &str| {
                let value =
                    |one: &String| Some(one.strip_prefix(axis)?.strip_prefix('=')?.to_owned());
                let preset = || Some(preset?.set.get(axis)?.to_string());
                given().find_map(value).or_else(preset).or_else(|| settings.get(axis))
            };
            if rule.holds(facts, by_hand(), axis) {
                apply(&rule.set, &mut settings)?;
            }
        }
        if let Some(preset) = preset {
            apply(&preset.set, &mut settings)?;
        }
        for number in &self.numbers {
            if let Some((name, value)) = number.split_once('=') {
                settings.set(name, value)?;
            }
        }
        Ok(settings)
    }
}

/// A line for each value that differs from the first one of the same name.
pub fn contradictions<'a>(given: impl Iterator<Item = &'a String>) -> Vec<String> {
    let mut known = BTreeMap::new();
    let given = given.filter_map(|one| one.split_once('='));
    let twice = given.filter_map(|(name, value)| {
        let first = *known.entry(name).or_insert(value);
        (first != value).then(|| format!("`{name}` is given twice: {first} and {value}"))
    });
    twice.collect()
}

fn apply(set: &BTreeMap<String, Setting>, settings: &mut Settings) -> Result<(), RequestError> {
    for (name, value) in set {
        settings.set(name, &value.to_string())?;
    }
    Ok(())
}

/// What follows from a scene, and from what was requested beside it.
#[derive(Debug)]
pub struct Derivation {
    /// What was requested, before the scene's needs.
    pub request: Request,
    /// What is true of the scene, and its numbers.
    pub needs: Needs,
    /// What its facts leave of each axis.
    pub allowed: AllowedValues,
    /// A value on each axis and every number, with what was taken for granted.
    pub settings: Settings,
    /// What the surfaces are drawn with.
    pub surfaces: Surfaces,
    /// What a frame takes.
    pub plan: Plan,
}

impl Derivation {
    /// Settles every axis of a scene with all its lights: by `set` (`axis=value`), else by what the scene
    /// needs, else by what is requested: the preset, else the default for scenes of its class.
    ///
    /// # Errors
    ///
    /// Everything that is wrong with `set`.
    pub fn new(
        library: &Library,
        scene: &Scene,
        set: &[String],
        request: &Request,
    ) -> Result<Self, RequestError> {
        let facts = scene.facts();
        let allowed = library.needed(&facts.known())?;
        let requested = request.settings(library, &facts.known(), set)?;
        let mut settings = settle(library, &allowed, set, &requested)?;
        // One light may be rendered as several are.
        if settings.light != Light::Several && !scene.lights.is_empty() {
            settings.light = light::kind_of_all(&scene.lights);
        }
        settings.light_faces = light::faces(&scene.lights).max(1);
        let of = &library.frame().ok_or(RequestError::NoFrame)?.description;
        let needs = needs(of, scene, 0, &settings, &least_limits());
        let mut settings = needs.settings.clone();
        settings.assumed = assumptions(library, &allowed, &axes(&requested), set);
        let surfaces = Surfaces::of(scene, settings.complete);
        let plan = plan(library, &settings, &surfaces)?;
        Ok(Self { request: request.clone(), needs, allowed, settings, surfaces, plan })
    }
}

/// The defaults of what a library that is laid over this one adds: axes and parameters, and nothing yet for axes of which it
/// has more values.
pub fn others(library: &Library) -> BTreeMap<String, Setting> {
    let own = Settings::default();
    let settings = || library.axis.iter().filter(|(_, axis)| axis.setting);
    let more = settings().filter(|(name, axis)| {
        let unknown = |value: &AxisValue| own.clone().set(name, &value.name).is_err();
        own.get(name).is_some() && axis.value.iter().any(unknown)
    });
    let more: Vec<_> = more.map(|(name, _)| (name.clone(), Setting::Name(String::new()))).collect();
    let axes = settings().map(|(name, axis)| (name.clone(), Setting::Name(axis.default.clone())));
    let parameters = library.parameters().filter(|(_, parameter)| !parameter.host);
    let parameters =
        parameters.map(|(name, parameter)| (name.clone(), Setting::Number(parameter.default)));
    axes.chain(parameters).filter(|(name, _)| own.get(name).is_none()).chain(more).collect()
}

/// The axes that settings have values on.
pub fn axes(settings: &Settings) -> Vec<&str> {
    let others = settings.others.iter().filter(|(_, other)| matches!(other, Setting::Name(_)));
    let others = others.map(|(axis, _)| axis.as_str());
    let others = others.filter(|axis| !Settings::AXES.contains(axis));
    Settings::AXES.iter().copied().chain(others).collect()
}

/// What a frame takes, at any size.
///
/// # Errors
///
/// What the library's frame says against the settings.
pub fn plan(
    library: &Library,
    settings: &Settings,
    surfaces: &Surfaces,
) -> Result<Plan, RequestError> {
    let Some(frame) = library.frame() else {
        return Err(RequestError::NoFrame);
    };
    Ok(Plan::of_any_size(&frame.description, settings, surfaces)?)
}

/// Whether `set` decides an axis.
#[must_use]
pub fn decides(set: &[String], axis: &str) -> bool {
    set.iter().any(|setting| setting.split('=').next() == Some(axis))
}

/// What the rules that narrowed these axes took to be so, but for axes that `set` decides.
pub fn assumptions(
    library: &Library,
    allowed: &AllowedValues,
    axes: &[&str],
    set: &[String],
) -> Vec<Assumption> {
    let narrowed =
        axes.iter().filter(|axis| !decides(set, axis)).filter_map(|axis| allowed.get(*axis));
    let rules: BTreeSet<&str> =
        narrowed.flat_map(|allowed| &allowed.because).map(|rule| rule.need.as_str()).collect();
    let of_rule = |rule: &sglow_shader_gen::library::Need| {
        let name = rule.name.clone();
        rule.when
            .iter()
            .map(|(fact, &holds)| Assumption { rule: name.clone(), fact: fact.clone(), holds })
            .collect::<Vec<_>>()
    };
    library
        .need
        .iter()
        .filter(|rule| rules.contains(rule.name.as_str()))
        .flat_map(of_rule)
        .collect()
}

/// A value on every axis.
///
/// # Errors
///
/// Everything that is wrong with `set`.
pub fn settle(
    library: &Library,
    allowed: &AllowedValues,
    set: &[String],
    requested: &Settings,
) -> Result<Settings, RequestError> {
    let mut settings = requested.clone();
    for axis in axes(requested) {
        let (Some(allowed), Some(value)) = (allowed.get(axis), settings.get(axis)) else {
            continue;
        };
        if let Some(value) = nearest(library, axis, allowed, &value) {
            settings.set(axis, value)?;
        }
    }
    let mut wrong = Vec::new();
    for setting in set {
        match setting.split_once('=') {
            None => wrong.push(format!("`{setting}` is not AXIS=VALUE")),
            Some((axis, value)) => {
                if let Err(error) = settings.set(axis, value) {
                    wrong.push(error.to_string());
                }
            }
        }
    }
    if !wrong.is_empty() {
        return Err(RequestError::Settings(wrong));
    }
    if !decides(set, "ndf") {
        match_distribution(&mut settings);
    }
    Ok(settings)
}

/// A distribution goes with specular reflection; whoever requests one of them need not request the other.
pub fn match_distribution(settings: &mut Settings) {
    if settings.specular == Specular::None {
        settings.ndf = Ndf::None;
    } else if settings.ndf == Ndf::None {
        settings.ndf = Ndf::Ggx;
    }
}

/// The requested value, if it remains; else the last one before it, or the first one behind it.
fn nearest<'a>(
    library: &Library,
    axis: &str,
    allowed: &'a Allowed,
    requested: &str,
) -> Option<&'a str> {
    let values = &library.axis.get(axis)?.value;
    let place = |name: &str| values.iter().position(|value| value.name == name);
    let requested = place(requested)?;
    let remaining = || allowed.values.iter().map(String::as_str);
    let before = remaining().rfind(|value| place(value).is_some_and(|place| place <= requested));
    before.or_else(|| remaining().next())
}

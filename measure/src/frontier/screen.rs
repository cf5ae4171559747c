//! Screening: one axis at a time about the default, then what is on the axis' own frontier crossed.
//!
//! All legal combinations of all values are too many to be measured. An axis whose value is dominated while all else is
//! as by default is taken to be dominated beside other values of other axes too: what is missed by that is what two
//! axes gain together and neither alone.

use std::collections::{BTreeMap, BTreeSet};

use sglow_oracle::cut::tile::MAX_ROOTS;
use sglow_renderer::variants::Variants as _;
use sglow_results::frontier::document::{Configuration, Kept, Metric};
use sglow_results::frontier::rank::{Place, SAME_ERROR, rank};
use sglow_results::progress::Progress;
use sglow_runtime::settings::Settings;
use sglow_shaders::frame::parameter;
use sglow_shaders::{
    Cut, Density, Draw, Emitter, Filter, Kernel, Precision, Solver, Space, Visibility,
};

use super::depends::Depends;
use super::references::references;
use super::subject::{FrontierError, Subject};
use super::{configuration, measure};
use crate::cache::Cache;

/// K of the configurations that are screened.
const SIZE_FACTORS: [f32; 5] = [0.125, 0.25, 0.5, 1.0, 2.0];
/// Their numbers of lights.
const LIGHTS: [u32; 4] = [64, 256, 1024, 4096];
/// The most configurations that are crossed on one scene.
pub const CROSSED: usize = 48;

/// A configuration that differs from the default in one axis or parameter.
#[derive(Clone, Debug)]
pub struct Single {
    /// The axis or the parameter.
    pub axis: String,
    /// Its value.
    pub value: String,
    /// The configuration.
    pub settings: Settings,
}

/// Every axis that methods are compared by, with all its values, and the parameters that are screened, with theirs.
fn choices() -> Vec<(&'static str, Vec<String>)> {
    fn names<T: ToString>(all: &[T]) -> Vec<String> {
        all.iter().map(T::to_string).collect()
    }
    let axes = Settings::COMPARED.iter().map(|&axis| (axis, names(Settings::values(axis))));
    let numbers =
        [(parameter::LIGHTS, names(&LIGHTS)), (parameter::SIZE_FACTOR, names(&SIZE_FACTORS))];
    axes.chain(numbers).collect()
}

/// Axes and parameters of kernels, which clusters have none of.
const OF_KERNELS: [&str; 6] =
    ["kernel", "solver", "filter", "precision", "size_factor", "iterations"];

/// `base` with one value, and with what goes with it: clusters have no kernels to size and are held in 32 bits, so that
/// a value of kernels goes with no clusters; a cut for each tile has its tree; previous kernels have no equation to solve, and
/// a distribution goes with specular reflection. None if the base has it already, or there is no such value.
#[must_use]
pub fn with(base: &Settings, axis: &str, value: &str) -> Option<Settings> {
    let mut settings = base.clone();
    settings.set(axis, value).ok()?;
    if configuration::value(base, axis) == configuration::value(&settings, axis) {
        return None;
    }
    if OF_KERNELS.contains(&axis) {
        settings.space = Space::None;
    }
    // A cut for each tile begins with a few nodes of a tree, whose emitters are discs.
    if axis == Cut::AXIS && settings.cut != Cut::None {
        (settings.space, settings.emitter) = (Space::Tree, Emitter::Disc);
        settings.lights = settings.lights.min(configuration::ROOTS);
    }
    if settings.space != Space::Tree || settings.lights as usize > MAX_ROOTS {
        settings.cut = Cut::None;
    }
    let maps = settings.visibility != Visibility::None;
    if maps && base.near_scale == configuration::near_scale(base) && axis != parameter::NEAR_SCALE {
        settings.near_scale = configuration::near_scale(&settings);
    }
    // Density and draw do not apply to trees.
    if settings.space == Space::Tree && [Density::AXIS, Draw::AXIS].contains(&axis) {
        return None;
    }
    settings.ndf = configuration::distribution(settings.specular, base);
    if settings.space != Space::None {
        settings.kernel = Kernel::Modified;
        settings.solver = Solver::Bracketed;
        settings.filter = Filter::Exact;
        settings.precision = Precision::F32;
    }
    settings.solver = match (settings.kernel, settings.solver) {
        (Kernel::Previous, _) => Solver::None,
        (Kernel::Modified, Solver::None) => Solver::Bracketed,
        (Kernel::Modified, solver) => solver,
    };
    // What goes with another value may have taken this one back.
    let has = configuration::value(&settings, axis).as_deref() == Some(value);
    (has && configuration::name(&settings, base) != "default").then_some(settings)
}

/// Every configuration that differs from `base` in one axis or parameter, is legal and is `allowed`.
#[must_use]
pub fn singles(base: &Settings, allowed: &dyn Fn(&Settings) -> bool) -> Vec<Single> {
    let mut all = Vec::new();
    for (axis, values) in choices() {
        for value in values {
            if let Some(settings) = with(base, axis, &value)
                && legal(&settings)
                && allowed(&settings)
            {
                all.push(Single { axis: axis.to_owned(), value, settings });
            }
        }
    }
    all
}

/// Whether no rule excludes what makes and what reflects the lights.
fn legal(settings: &Settings) -> bool {
    settings.shade().excluded().is_none() && settings.sample().excluded().is_none()
}

/// What one scene says of one value of an axis.
#[derive(Clone, Debug)]
struct Said {
    axis: String,
    value: String,
    /// Whether it is on the axis' own frontier.
    stays: bool,
    /// Whether it is the default's.
    default: bool,
    /// How much it changes time and error: the sum of the sizes of both logarithms.
    weight: f64,
}

/// What one scene says of the values of every axis.
#[derive(Clone, Debug)]
pub struct Screened(Vec<Said>);

/// Measures `base` and the singles about it, and says which values stay. `base` is the scene's default, or what comes
/// nearest to it where only some values are requested.
///
/// # Errors
///
/// When the scene does not render, a variant is missing or a result cannot be kept.
pub fn screen(
    subject: &Subject<'_>,
    base: &Settings,
    singles: &[Single],
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<Screened, FrontierError> {
    let all = singles.iter().map(|single| single.settings.clone());
    let all = std::iter::once(base.clone()).chain(all);
    let settings = distinct(&subject.base, &subject.depends, all);
    let references = references(subject, cache, progress)?;
    let measured = measure::every(subject, &settings, &references, cache, progress)?;
    let name = |settings: &Settings| configuration::name(settings, &subject.base);
    Ok(said(base, singles, &name, &measured.configurations))
}

/// What the measurements of the default and the singles say.
fn said(
    base: &Settings,
    singles: &[Single],
    name: &dyn Fn(&Settings) -> String,
    configurations: &[Configuration],
) -> Screened {
    let metric = Metric::default();
    let place = |configuration: &Configuration| Place {
        time: configuration.time,
        error: configuration.picture.of(metric),
        uncertainty: configuration.picture.measured(metric).uncertainty,
    };
    let find = |settings: &Settings| {
        let name = name(settings);
        configurations.iter().find(|configuration| configuration.name == name)
    };
    let mut all = Vec::new();
    let Some(default) = find(base).map(place) else { return Screened(all) };
    // A value of kernels comes with kernels: what it changes itself is against them.
    let no_clusters = |single: &&Single| single.axis == Space::AXIS && single.value == "none";
    let kernels = singles.iter().find(no_clusters);
    let kernels = kernels.and_then(|single| find(&single.settings));
    let kernels = kernels.filter(|kernels| kernels.complete).map_or(default, place);
    let axes: BTreeSet<&str> = singles.iter().map(|single| single.axis.as_str()).collect();
    for axis in axes {
        let own = singles.iter().filter(|single| single.axis == axis);
        // What leaves light out is on no frontier of pictures.
        let own: Vec<(&Single, &Configuration)> =
            own.filter_map(|single| Some((single, find(&single.settings)?))).collect();
        let own: Vec<(&Single, Place)> = own
            .into_iter()
            .filter(|(_, configuration)| configuration.complete)
            .map(|(single, configuration)| (single, place(configuration)))
            .collect();
        let mut places = vec![default];
        places.extend(own.iter().map(|(_, place)| *place));
        let dominated = rank(&places);
        // The default gives way only to what is clearly better.
        let stays = dominated[0].is_none_or(|by| !clearly(&places[by], &default));
        all.push(Said {
            axis: axis.to_owned(),
            value: configuration::value(base, axis).unwrap_or_default(),
            stays,
            default: true,
            weight: f64::INFINITY,
        });
        let usual = if OF_KERNELS.contains(&axis) { kernels } else { default };
        for ((single, place), by) in own.iter().zip(&dominated[1..]) {
            all.push(Said {
                axis: axis.to_owned(),
                value: single.value.clone(),
                stays: by.is_none(),
                default: false,
                weight: change(place.time.median, usual.time.median)
                    + change(place.error, usual.error),
            });
        }
    }
    Screened(all)
}

/// Whether times are apart by more than their spreads, or errors by more than noise.
fn clearly(one: &Place, other: &Place) -> bool {
    let noise = (SAME_ERROR * other.error).max(one.uncertainty.hypot(other.uncertainty));
    one.time.most < other.time.least || other.error - one.error > noise
}

fn change(one: f64, other: f64) -> f64 {
    let change = (one / other).ln().abs();
    if change.is_finite() { change } else { 0.0 }
}

/// What becomes of each axis over all scenes: a value is crossed that stays on any of them, unless there were more than
/// `most` configurations; then those that change time and error the least are left out, the default's never.
#[must_use]
pub fn keep(scenes: &[Screened], most: usize) -> Vec<Kept> {
    let mut values: BTreeMap<(&str, &str), (bool, f64)> = BTreeMap::new();
    for said in scenes.iter().flat_map(|scene| &scene.0) {
        let (stays, weight) = values.entry((&said.axis, &said.value)).or_default();
        *stays |= said.stays;
        *weight = weight.max(if said.default { f64::INFINITY } else { said.weight });
    }
    let mut kept: BTreeMap<&str, Kept> = BTreeMap::new();
    let mut weights: BTreeMap<(&str, &str), f64> = BTreeMap::new();
    for ((axis, value), (stays, weight)) in values {
        let none = || Kept {
            axis: axis.to_owned(),
            values: Vec::new(),
            cut: Vec::new(),
            dominated: Vec::new(),
        };
        let of_axis = kept.entry(axis).or_insert_with(none);
        if stays {
            of_axis.values.push(value.to_owned());
            weights.insert((axis, value), weight);
        } else {
            of_axis.dominated.push(value.to_owned());
        }
    }
    let count = |kept: &BTreeMap<&str, Kept>| {
        kept.values().map(|one| one.values.len().max(1)).fold(1usize, usize::saturating_mul)
    };
    while count(&kept) > most.max(1) {
        let several =
            |(axis, _): &&(&str, &str)| kept.get(axis).is_some_and(|one| one.values.len() > 1);
        let least = weights
            .keys()
            .filter(several)
            .min_by(|one, other| weights[*one].total_cmp(&weights[*other]))
            .copied();
        let Some((axis, value)) = least else { break };
        weights.remove(&(axis, value));
        if let Some(one) = kept.get_mut(axis) {
            one.values.retain(|kept| kept != value);
            one.cut.push(value.to_owned());
        }
    }
    kept.into_values().collect()
}

/// Every legal and `allowed` configuration of the values that were kept, all else as in `base`. A value that a scene
/// does not allow is as in its base.
#[must_use]
pub fn crossed(
    base: &Settings,
    kept: &[Kept],
    allowed: &dyn Fn(&Settings) -> bool,
) -> Vec<Settings> {
    let mut all = vec![base.clone()];
    for Kept { axis, values, .. } in kept {
        let more = |settings: &Settings| -> Vec<Settings> {
            let one = |value: &String| {
                let with = with(settings, axis, value);
                with.filter(|with| legal(with) && allowed(with)).unwrap_or_else(|| settings.clone())
            };
            if values.is_empty() {
                vec![settings.clone()]
            } else {
                values.iter().map(one).collect()
            }
        };
        let mut names = BTreeSet::new();
        all = all.iter().flat_map(more).collect();
        all.retain(|settings| names.insert(configuration::name(settings, base)));
    }
    let sized = |settings: &Settings| (settings.size_factor, settings.iterations);
    all.retain(|settings| {
        // What sizes kernels changes nothing of clusters.
        let differs = settings.space == Space::None || sized(settings) == sized(base);
        differs && legal(settings) && allowed(settings)
    });
    all
}

/// Configurations without those of a name that came before, in an order in which those that share maps and lights
/// follow each other.
#[must_use]
pub fn distinct(
    base: &Settings,
    depends: &Depends,
    all: impl IntoIterator<Item = Settings>,
) -> Vec<Settings> {
    let mut names = BTreeSet::new();
    let mut distinct: Vec<Settings> = all
        .into_iter()
        .filter(|settings| names.insert(configuration::name(settings, base)))
        .collect();
    distinct.sort_by_cached_key(|settings| depends.shared(settings));
    distinct
}

#[cfg(test)]
mod tests {
    use sglow_results::time::Time;

    use super::*;

    #[test]
    fn singles_differ_in_one_axis_are_legal_and_lead_back() {
        let base = Settings::default();
        let all = singles(&base, &|_| true);
        let names: BTreeSet<String> =
            all.iter().map(|single| configuration::name(&single.settings, &base)).collect();
        assert_eq!(names.len(), all.len());
        for wanted in ["emitter=lobe", "lights=64", "size_factor=0.125", "visibility=shadow_map"] {
            assert!(names.contains(wanted), "{wanted}: {names:?}");
        }
        for single in &all {
            assert!(legal(&single.settings), "{}", single.value);
            assert_eq!(
                configuration::value(&single.settings, &single.axis).as_ref(),
                Some(&single.value)
            );
        }
        assert!(!names.contains("default"));
        let few = singles(&base, &|settings| settings.emitter == Emitter::Cosine);
        assert!(few.len() < all.len() && few.iter().all(|single| single.axis != "emitter"));
        // The equation goes with the kernels, and kernels with no clusters.
        let previous = with(&base, "kernel", "previous").unwrap();
        assert_eq!(previous.solver, Solver::None);
        let half = Settings { precision: Precision::F16, ..base.clone() };
        assert_eq!(with(&half, "space", "world").unwrap().precision, Precision::F32);
        let clusters = with(&base, "space", "world").unwrap();
        let previous = with(&clusters, "kernel", "previous").unwrap();
        assert_eq!((previous.space, previous.kernel), (Space::None, Kernel::Previous));
        assert!(with(&clusters, "kernel", "modified").is_none());
        // A cut remains one as long as a tile holds its roots.
        let cut = Settings { lights: 448, ..with(&base, "cut", "tile").unwrap() };
        assert_eq!(with(&cut, "emitter", "lobe").unwrap().cut, Cut::Tile);
        assert_eq!(with(&cut, "lights", "4096").unwrap().cut, Cut::None);
        assert!(singles(&clusters, &|_| true).iter().any(|single| single.axis == "size_factor"));
        assert!(
            with(&base, "emitter", "cosine").is_none() && with(&base, "colour", "red").is_none()
        );
    }

    fn measured(name: &str, time: f64, error: f64) -> Configuration {
        let mut configuration = Configuration {
            name: name.to_owned(),
            complete: true,
            time: Time { median: time, least: time, most: time },
            ..Configuration::default()
        };
        configuration.picture.relative_mse = error;
        configuration
    }

    #[test]
    fn what_is_on_the_frontier_of_its_axis_stays_in_any_scene() {
        let base = Settings::default();
        let all = singles(&base, &|single| single.space == Space::None);
        let worse = |factor: f64| {
            let name = |single: &Single| configuration::name(&single.settings, &base);
            let mut configurations = vec![measured("default", 10.0, 0.1)];
            configurations.extend(all.iter().map(|single| match name(single).as_str() {
                "lights=64" => measured("lights=64", 1.0, 0.5),
                "emitter=disc" => measured("emitter=disc", 9.0, 0.1 * factor),
                "variance=planar" => measured("variance=planar", 12.0, 0.098),
                other => measured(other, 11.0, 0.2),
            }));
            said(&base, &all, &|settings| configuration::name(settings, &base), &configurations)
        };
        let of =
            |kept: &[Kept], axis: &str| kept.iter().find(|one| one.axis == axis).cloned().unwrap();
        let kept = keep(&[worse(2.0)], CROSSED);
        assert_eq!(of(&kept, "lights").values, ["1024", "64"]);
        assert_eq!(of(&kept, "emitter").values, ["cosine", "disc"]);
        assert_eq!(of(&kept, "variance").values, ["planar", "trace"]);
        assert_eq!(of(&kept, "sharpness").values, ["exact"]);
        // Better in both, the default is dominated; on another scene it stays.
        assert_eq!(of(&keep(&[worse(0.5)], CROSSED), "emitter").values, ["disc"]);
        assert_eq!(of(&keep(&[worse(0.5), worse(2.0)], CROSSED), "emitter").values.len(), 2);
        // Of too many the least change is cut, and said.
        let few = keep(&[worse(2.0)], 4);
        assert_eq!(of(&few, "variance").cut, ["planar"]);
        assert_eq!(crossed(&base, &few, &|_| true).len(), 4);
        assert_eq!(crossed(&base, &keep(&[worse(2.0)], 1), &|_| true).len(), 1);
        let names: BTreeSet<String> = crossed(&base, &few, &|_| true)
            .iter()
            .map(|one| configuration::name(one, &base))
            .collect();
        assert!(names.contains("emitter=disc,lights=64") && names.contains("default"), "{names:?}");
        // K is crossed with kernels alone.
        let clusters = with(&base, "space", "world").unwrap();
        let values = |axis: &str, values: [&str; 2]| Kept {
            axis: axis.to_owned(),
            values: values.map(str::to_owned).to_vec(),
            cut: Vec::new(),
            dominated: Vec::new(),
        };
        let base_size = clusters.size_factor.to_string();
        let kept = [values("size_factor", [&base_size, "4"]), values("space", ["none", "world"])];
        let names: Vec<String> = crossed(&clusters, &kept, &|_| true)
            .iter()
            .map(|one| configuration::name(one, &clusters))
            .collect();
        assert_eq!(names, ["space=none", "default", "space=none,size_factor=4"]);
    }
}

//! Screening: one axis at a time about the default, then what is on the axis' own frontier crossed.
//!
//! All legal combinations of all values are too many to be measured. An axis whose value is dominated while all else is
//! as by default is taken to be dominated beside other values of other axes too: what is missed by that is what two
//! axes gain together and neither alone.

use std::collections::{BTreeMap, BTreeSet};

use sglow_results::frontier::document::{Configuration, Kept, Metric};
use sglow_results::frontier::rank::{Place, SAME_ERROR, rank};
use sglow_results::progress::Progress;
use sglow_runtime::settings::Settings;
use sglow_shaders::frame::parameter;

use super::depends::Depends;
use super::references::references;
use super::space::Space;
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

/// Every configuration that differs from `base` in one axis or parameter and in what that needs, and is `allowed`.
#[must_use]
pub fn singles(
    space: &Space<'_>,
    base: &Settings,
    allowed: &dyn Fn(&Settings) -> bool,
) -> Vec<Single> {
    let mut all = Vec::new();
    for (axis, values) in choices() {
        for value in values {
            if let Some(settings) = space.with(base, axis, &value).filter(allowed) {
                let name = configuration::name(&settings, base);
                // Of two values that need each other the last one has the configuration: the lobe, not the distribution.
                all.retain(|one: &Single| configuration::name(&one.settings, base) != name);
                all.push(Single { axis: axis.to_owned(), value, settings });
            }
        }
    }
    all
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
    // A value that needs others counts against these alone: kernels are faster than a cut, whatever draws them.
    let others = |single: &Single| {
        let mut others = single.settings.clone();
        let own = configuration::value(base, &single.axis).unwrap_or_default();
        others.set(&single.axis, &own).ok()?;
        let differs = name(&others) != name(base);
        find(&others).filter(|others| differs && others.complete).map(place)
    };
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
        places.extend(own.iter().filter_map(|(single, _)| others(single)));
        let dominated = rank(&places);
        // The default gives way only to what is clearly better.
        let by = rank(&places[..=own.len()])[0];
        let stays = by.is_none_or(|by| !clearly(&places[by], &default));
        all.push(Said {
            axis: axis.to_owned(),
            value: configuration::value(base, axis).unwrap_or_default(),
            stays,
            default: true,
            weight: f64::INFINITY,
        });
        for ((single, place), by) in own.iter().zip(&dominated[1..]) {
            let usual = others(single).unwrap_or(default);
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
    one.time.maximum < other.time.minimum || other.error - one.error > noise
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
    space: &Space<'_>,
    base: &Settings,
    kept: &[Kept],
    allowed: &dyn Fn(&Settings) -> bool,
) -> Vec<Settings> {
    let mut all = vec![base.clone()];
    for Kept { axis, values, .. } in kept {
        let more = |settings: &Settings| -> Vec<Settings> {
            let one = |value: &String| {
                let with = space.with(settings, axis, value).filter(allowed);
                with.unwrap_or_else(|| settings.clone())
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
    // A number that nothing depends on changes nothing.
    all.retain(|settings| space.plain(settings, base) && allowed(settings));
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
    use sglow_runtime::package::Package;
    use sglow_shader_gen::matrix::Facts;
    use sglow_shaders::Emitter;

    use super::*;

    #[test]
    fn singles_differ_in_one_axis_are_legal_and_lead_back() {
        let (package, facts) = (Package::embedded(), Facts::new());
        let space = Space::new(package.description().unwrap(), &facts);
        let base = Settings::default();
        let all = singles(&space, &base, &|_| true);
        let names: BTreeSet<String> =
            all.iter().map(|single| configuration::name(&single.settings, &base)).collect();
        assert_eq!(names.len(), all.len());
        for wanted in ["emitter=lobe", "lights=64", "size_factor=0.125", "visibility=shadow_map"] {
            assert!(names.contains(wanted), "{wanted}: {names:?}");
        }
        for single in &all {
            assert!(space.legal(&single.settings), "{}", single.value);
            assert_eq!(
                configuration::value(&single.settings, &single.axis).as_ref(),
                Some(&single.value)
            );
        }
        assert!(!names.contains("default"));
        let few = singles(&space, &base, &|settings| settings.emitter == Emitter::Cosine);
        assert!(few.len() < all.len() && few.iter().all(|single| single.axis != "emitter"));
        let clusters = space.with(&base, "space", "world").unwrap();
        let sizes = singles(&space, &clusters, &|_| true);
        assert!(sizes.iter().any(|single| single.axis == "size_factor"));
    }

    fn measured(name: &str, time: f64, error: f64) -> Configuration {
        let mut configuration = Configuration {
            name: name.to_owned(),
            complete: true,
            time: Time { median: time, minimum: time, maximum: time },
            ..Configuration::default()
        };
        configuration.picture.relative_mse = error;
        configuration
    }

    #[test]
    fn what_is_on_the_frontier_of_its_axis_stays_in_any_scene() {
        let (package, facts) = (Package::embedded(), Facts::new());
        let space = Space::new(package.description().unwrap(), &facts);
        let base = Settings::default();
        let all = singles(&space, &base, &|single| single.space == sglow_shaders::Space::None);
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
        assert_eq!(crossed(&space, &base, &few, &|_| true).len(), 4);
        assert_eq!(crossed(&space, &base, &keep(&[worse(2.0)], 1), &|_| true).len(), 1);
        let names: BTreeSet<String> = crossed(&space, &base, &few, &|_| true)
            .iter()
            .map(|one| configuration::name(one, &base))
            .collect();
        assert!(names.contains("emitter=disc,lights=64") && names.contains("default"), "{names:?}");
        // K is crossed with kernels alone.
        let clusters = space.with(&base, "space", "world").unwrap();
        let values = |axis: &str, values: [&str; 2]| Kept {
            axis: axis.to_owned(),
            values: values.map(str::to_owned).to_vec(),
            cut: Vec::new(),
            dominated: Vec::new(),
        };
        let base_size = clusters.size_factor.to_string();
        let kept = [values("size_factor", [&base_size, "4"]), values("space", ["none", "world"])];
        let names: Vec<String> = crossed(&space, &clusters, &kept, &|_| true)
            .iter()
            .map(|one| configuration::name(one, &clusters))
            .collect();
        assert_eq!(names, ["space=none", "default", "space=none,size_factor=4"]);
    }

    #[test]
    fn a_value_of_kernels_is_compared_with_kernels() {
        let (package, facts) = (Package::embedded(), Facts::new());
        let space = Space::new(package.description().unwrap(), &facts);
        let base = space.with(&Settings::default(), "cut", "tile").unwrap();
        let name = |settings: &Settings| configuration::name(settings, &base);
        let all = singles(&space, &base, &|_| true);
        let kept = |previous: f64| {
            let mut configurations = vec![measured("default", 10.0, 0.1)];
            configurations.extend(all.iter().map(|single| match name(&single.settings).as_str() {
                kernels @ "cut=none,space=none" => measured(kernels, 2.0, 0.2),
                own @ "cut=none,kernel=previous,space=none" => measured(own, 2.0, previous),
                other => measured(other, 11.0, 0.3),
            }));
            let kept = keep(&[said(&base, &all, &name, &configurations)], CROSSED);
            kept.into_iter().find(|one| one.axis == "kernel").unwrap().values
        };
        // Both are faster than the cut; only one gains anything as kernels.
        assert_eq!(kept(0.4), ["modified"]);
        assert_eq!(kept(0.15), ["modified", "previous"]);
    }
}

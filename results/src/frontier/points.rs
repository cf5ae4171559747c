//! Named points of the frontier over several scenes.

use std::collections::{BTreeMap, BTreeSet};

use crate::frontier::choose::time;
use crate::frontier::document::{Configuration, Metric, SceneReport};
use crate::frontier::promise::named;
use crate::frontier::rank::{Place, rank};
use crate::time::Time;

/// A named point: what it is called, by what it was chosen, and the configuration of each scene.
#[derive(Clone, Debug)]
pub struct Point<'a> {
    /// What it is called.
    pub name: &'static str,
    /// By what it was chosen.
    pub description: &'static str,
    /// Each scene with its configuration.
    pub scenes: Vec<(&'a SceneReport, &'a Configuration)>,
}

/// A configuration over all scenes: geometric means of its times and errors over the default's.
struct Mean<'a> {
    name: &'a str,
    time: f64,
    error: f64,
}

/// `fast`, `balanced` and `accurate`, by relative MSE and the time of indirect light, of the configurations that were
/// measured of every scene: geometric means over scenes, each over the scene's default. None without scenes, or without
/// a configuration that is as good as the papers'.
#[must_use]
pub fn points(scenes: &[SceneReport]) -> Option<[Point<'_>; 3]> {
    let find = |scene: &'_ SceneReport, name: &str| {
        scene.configurations.iter().position(|configuration| configuration.name == name)
    };
    let first = scenes.first()?;
    let default: Vec<&Configuration> = scenes
        .iter()
        .map(|scene| scene.configurations.iter().find(|configuration| configuration.default))
        .collect::<Option<_>>()?;
    let mean = |name: &str| -> Option<[f64; 2]> {
        let mut sums = [0.0; 2];
        for (scene, default) in scenes.iter().zip(&default) {
            let configuration = &scene.configurations[find(scene, name)?];
            let error = |configuration: &Configuration| {
                configuration.picture.of(Metric::RelativeMse).max(f64::MIN_POSITIVE)
            };
            sums[0] += (time(configuration).median / time(default).median).ln();
            sums[1] += (error(configuration) / error(default)).ln();
        }
        let means = sums.map(|sum| (sum / scenes.len() as f64).exp());
        means.iter().all(|mean| mean.is_finite()).then_some(means)
    };
    let whole = first.configurations.iter().filter(|configuration| configuration.complete);
    let names: BTreeSet<&str> = whole.map(|configuration| configuration.name.as_str()).collect();
    let means: Vec<Mean<'_>> = names
        .into_iter()
        .filter_map(|name| mean(name).map(|[time, error]| Mean { name, time, error }))
        .collect();
    let places: Vec<Place> = means
        .iter()
        .map(|mean| Place {
            time: Time { median: mean.time, minimum: mean.time, maximum: mean.time },
            error: mean.error,
            uncertainty: 0.0,
        })
        .collect();
    let dominated = rank(&places);
    let frontier: Vec<&Mean<'_>> =
        means.iter().zip(&dominated).filter(|(_, by)| by.is_none()).map(|(mean, _)| mean).collect();
    // The papers' configuration is called otherwise on each scene, for their needs differ.
    let mut printed = Some(0.0);
    for (scene, default) in scenes.iter().zip(&default) {
        let names = scene.screening.as_ref().map(|screening| &screening.named);
        let name = names.and_then(|names| names.get(named::PRINTED));
        let configuration = name.and_then(|name| {
            scene.configurations.iter().find(|configuration| configuration.name == *name)
        });
        let error = |configuration: &Configuration| {
            configuration.picture.of(Metric::RelativeMse).max(f64::MIN_POSITIVE)
        };
        printed = printed
            .zip(configuration)
            .map(|(sum, configuration)| sum + (error(configuration) / error(default)).ln());
    }
    let limit = printed.map_or(f64::INFINITY, |sum| (sum / scenes.len() as f64).exp());
    let fast = frontier
        .iter()
        .filter(|mean| mean.error <= limit)
        .min_by(|one, other| one.time.total_cmp(&other.time))?;
    let accurate = frontier.iter().min_by(|one, other| one.error.total_cmp(&other.error))?;
    let part = |value: f64, from: f64, to: f64| {
        if from == to { 0.0 } else { (value / from).ln() / (to / from).ln() }
    };
    let far = |mean: &Mean<'_>| {
        part(mean.time, fast.time, accurate.time).max(part(mean.error, accurate.error, fast.error))
    };
    let between = frontier.iter().filter(|mean| mean.time >= fast.time);
    let balanced = between.min_by(|one, other| far(one).total_cmp(&far(other)))?;
    let point = |name, description, mean: &Mean<'_>| {
        let of = |scene: &'_ SceneReport| find(scene, mean.name);
        let all =
            scenes.iter().filter_map(|scene| Some((scene, &scene.configurations[of(scene)?])));
        Point { name, description, scenes: all.collect() }
    };
    Some([
        point(
            "fast",
            "the least time of indirect light whose relative MSE is at most that of tokuyoshi2016",
            fast,
        ),
        point(
            "balanced",
            "between fast and accurate by geometric means over the scenes; on a single scene it may be dominated",
            balanced,
        ),
        point(
            "accurate",
            "the minimum geometric mean over the scenes of the relative MSE over the default's",
            accurate,
        ),
    ])
}

/// The values that make a point on any scene: those of a scene with specular reflection where one has it; else what
/// only specular reflection needs is left to each scene. The size of the map is left out, for it is no part of a
/// configuration, and so is a number in which the scenes differ, which is the default of each one's class.
#[must_use]
pub fn values(point: &Point<'_>) -> BTreeMap<String, String> {
    let has = |configuration: &Configuration| {
        configuration.axes.get("specular").is_some_and(|value| value != "none")
    };
    let glossy = point.scenes.iter().find(|(_, configuration)| has(configuration));
    let Some((_, configuration)) = glossy.or_else(|| point.scenes.first()) else {
        return BTreeMap::new();
    };
    let of_specular = ["lobes", "specular", "ndf", "specular_power"];
    let axes = configuration
        .axes
        .iter()
        .filter(|(axis, _)| glossy.is_some() || !of_specular.contains(&axis.as_str()));
    // The solver follows from previous kernels.
    let axes = axes.filter(|(axis, value)| *axis != "solver" || *value != "none");
    let numbers = shared(point.scenes.iter().map(|(_, configuration)| *configuration));
    let axes = axes.map(|(axis, value)| (axis.clone(), value.clone()));
    axes.chain(numbers.into_iter().filter(|(name, _)| name != "map")).collect()
}

/// The numbers that all configurations have.
fn shared<'a>(all: impl IntoIterator<Item = &'a Configuration>) -> BTreeMap<String, String> {
    let numbers = all.into_iter().map(|configuration| configuration.parameters.clone());
    let both = |mut one: BTreeMap<String, String>, other: BTreeMap<String, String>| {
        one.retain(|name, value| other.get(name) == Some(value));
        one
    };
    numbers.reduce(both).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_in_which_scenes_differ_is_left_to_their_class() {
        let of = |lights: &str| {
            let numbers = [("lights", lights), ("tile", "64")];
            let parameters = numbers.map(|(name, value)| (name.to_owned(), value.to_owned()));
            Configuration { parameters: parameters.into(), ..Configuration::default() }
        };
        let [one, other] = ["256", "448"].map(of);
        let names = |all: [&Configuration; 2]| shared(all).into_keys().collect::<Vec<_>>();
        assert_eq!(names([&one, &other]), ["tile"]);
        assert_eq!(names([&one, &one]), ["lights", "tile"]);
    }
}

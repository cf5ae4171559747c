//! Bounds on the errors and times of scenes' defaults, each with its reason, checked against the measurements.

use std::collections::BTreeMap;

use super::choose::time;
use super::document::{Configuration, Metric, PictureError, SceneReport};
use super::equal::{Candidate, time_to_equal};
use crate::check::{Check, Relation};

/// Names of the configurations that promises are about.
pub mod named {
    /// What the scene gets if nobody chooses.
    pub const DEFAULT: &str = "default";
    /// The default before emission, sharpness and K were axes.
    pub const OLD: &str = "default of version 0.1.0";
    /// The papers' configuration.
    pub const PRINTED: &str = "tokuyoshi2016";
    /// A cut for each tile of pixels, without visibility.
    pub const BARE: &str = "cut for each tile without visibility";
    /// The same from 256 nodes that have shadow maps.
    pub const CUT: &str = "cut for each tile, 256 shadow maps";
    /// 1024 clusters with a shadow map each.
    pub const FLAT: &str = "1024 flat lights";
    /// 64 of them.
    pub const FLAT_64: &str = "64 flat lights";
    /// 64 clusters, without visibility.
    pub const BARE_64: &str = "64 flat lights without visibility";
    /// 256 clusters, without visibility.
    pub const BARE_256: &str = "256 flat lights without visibility";
    /// 1024 clusters, without visibility.
    pub const BARE_1024: &str = "1024 flat lights without visibility";
    /// 16384 clusters, without visibility.
    pub const BARE_16384: &str = "16384 flat lights without visibility";
    /// The default with the emitter lobe.
    pub const LOBE: &str = "default with the emitter lobe";
    /// The default with the emitter cosine.
    pub const COSINE: &str = "default with the emitter cosine";
}

/// What an error is against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Against {
    /// Facets of the map, without visibility on either side: of [`named::BARE`].
    Facets,
    /// Paths, with visibility: of the default.
    Paths,
}

/// A bound on an error of a scene's default, or of [`named::BARE`].
#[derive(Clone, Copy, Debug)]
struct ErrorBound {
    scene: &'static str,
    against: Against,
    metric: Metric,
    at_most: f64,
    reason: &'static str,
}

/// The bounds on errors. Those against facets are what 1024 kernels with K = 0.25 reach in f64.
const ERRORS: &[ErrorBound] = &[
    bound(
        "cornell",
        Against::Facets,
        Metric::Rmse,
        0.075,
        "1024 kernels have 6.3 % in f64, rounded up by a fifth",
    ),
    bound(
        "cornell",
        Against::Facets,
        Metric::RelativeMse,
        0.008,
        "1024 kernels have 0.0067 in f64",
    ),
    bound("columns", Against::Facets, Metric::Rmse, 0.15, "1024 kernels have 13.7 % in f64"),
    bound(
        "columns",
        Against::Facets,
        Metric::RelativeMse,
        0.010,
        "1024 kernels have 0.0085 in f64",
    ),
    bound(
        "atrium",
        Against::Facets,
        Metric::RelativeMse,
        0.13,
        "1024 kernels have 0.118 in f64 with 75k triangles",
    ),
    bound(
        "atrium",
        Against::Facets,
        Metric::Median,
        0.11,
        "1024 kernels have 9.9 % in f64 with 75k triangles",
    ),
    bound(
        "cornell",
        Against::Paths,
        Metric::RelativeMse,
        0.008,
        "what f64 has with exact visibility of texels' means",
    ),
    bound(
        "columns",
        Against::Paths,
        Metric::RelativeMse,
        0.02,
        "twice the error without visibility, for maps' texels",
    ),
    bound(
        "cornell",
        Against::Paths,
        Metric::Bias,
        0.03,
        "below a twentieth of a stop, which is not visible",
    ),
    bound(
        "columns",
        Against::Paths,
        Metric::Bias,
        0.03,
        "below a twentieth of a stop, which is not visible",
    ),
];

const fn bound(
    scene: &'static str,
    against: Against,
    metric: Metric,
    at_most: f64,
    reason: &'static str,
) -> ErrorBound {
    ErrorBound { scene, against, metric, at_most, reason }
}

/// Relative MSE with 16384 lights over that with 1024, against facets.
const MORE_LIGHTS: &[(&str, f64)] = &[("cornell", 0.5), ("columns", 0.2), ("atrium", 0.2)];

/// Maximum ratio of an error of the default to that of the old default, by any metric.
const WORSE: f64 = 1.05;

/// Minimum speed-up of shading at the papers' relative MSE.
const TIMES_FASTER: f64 = 8.0;

/// The stem of a scene's name: the scene without its number of triangles.
fn stem(scene: &str) -> &str {
    scene.split(':').next().unwrap_or(scene)
}

/// A number that was promised.
#[derive(Clone, Debug, PartialEq)]
pub struct Promised {
    /// What it is.
    pub name: String,
    /// What was measured; not a number if it was not.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// Whether the bound is a minimum rather than a maximum.
    pub at_least: bool,
    /// The bound.
    pub bound: f64,
    /// Why this bound, and what is compared.
    pub note: String,
}

/// Checks the measurements of a scene against its bounds. A bound on a configuration that was not measured fails. Scenes
/// that were not screened have no bounds.
#[must_use]
pub fn hold(scene: &SceneReport) -> Vec<Promised> {
    scene.screening.as_ref().map_or_else(Vec::new, |screening| {
        held(&scene.scene, &screening.named, &scene.configurations)
    })
}

fn held(
    scene: &str,
    names: &BTreeMap<String, String>,
    configurations: &[Configuration],
) -> Vec<Promised> {
    let find = |what: &str| {
        let name = names.get(what)?;
        configurations.iter().find(|configuration| configuration.name == *name)
    };
    let mut all = Vec::new();
    let mut at_most = |name: String, value: Option<f64>, unit, bound, note: String| {
        let value = value.unwrap_or(f64::NAN);
        all.push(Promised { name, value, unit, at_least: false, bound, note });
    };
    let [default, old, bare] = [named::DEFAULT, named::OLD, named::BARE].map(find);
    for metric in Metric::ALL {
        let ratio =
            default.zip(old).map(|(ours, theirs)| over(&ours.picture, &theirs.picture, metric));
        let note = "against paths; differences within the reference's noise count as none";
        let name = format!("{scene}: {} of the default over the old default's", metric.title());
        at_most(name, ratio, "times", WORSE, note.to_owned());
    }
    let flickers =
        default.zip(old).and_then(|(ours, theirs)| Some((ours.flicker?, theirs.flicker?)));
    at_most(
        format!("{scene}: flicker of the default over the old default's"),
        flickers.map(|(ours, theirs)| ours / theirs),
        "times",
        1.0,
        "less error is not bought with more flicker".to_owned(),
    );
    for one in ERRORS.iter().filter(|one| one.scene == stem(scene)) {
        let (configuration, what) = match one.against {
            Against::Facets => (
                bare.and_then(|configuration| configuration.unshadowed),
                "the cut without visibility, against facets",
            ),
            Against::Paths => {
                (default.map(|configuration| configuration.picture), "the default, against paths")
            }
        };
        let name = format!("{scene}: {} of {what}", one.metric.title());
        let value = configuration.map(|error| error.of(one.metric));
        at_most(name, value, "", one.at_most, one.reason.to_owned());
    }
    let facets = |what: &str| find(what).and_then(|configuration| configuration.unshadowed);
    if let Some((_, bound)) = MORE_LIGHTS.iter().find(|one| one.0 == stem(scene)) {
        let few = facets(named::BARE_64).zip(facets(named::OLD));
        for metric in [Metric::RelativeMse, Metric::Median] {
            at_most(
                format!(
                    "{scene}: {} of 64 lights over that of 1024 of the old default",
                    metric.title()
                ),
                few.map(|(few, many)| few.of(metric) / many.of(metric)),
                "times",
                1.0,
                "against facets, without visibility".to_owned(),
            );
        }
        let many = facets(named::BARE_16384).zip(facets(named::BARE_1024));
        at_most(
            format!("{scene}: relative MSE of 16384 flat lights over that of 1024"),
            many.map(|(many, few)| many.of(Metric::RelativeMse) / few.of(Metric::RelativeMse)),
            "times",
            *bound,
            "against facets, without visibility: an error that more lights do not take away is one of the form".to_owned(),
        );
    }
    let lobe = find(named::LOBE).and_then(shading);
    for (what, which) in [("the default", named::DEFAULT), ("the emitter cosine", named::COSINE)] {
        let ours = find(which).and_then(shading);
        at_most(
            format!("{scene}: shading time of {what} over that with the emitter lobe"),
            ours.zip(lobe).map(|(ours, theirs)| ours / theirs),
            "times",
            1.0 + super::rank::SAME_TIME,
            "in turns, with the same maps; runs differ by as much as the bound allows".to_owned(),
        );
    }
    all.push(faster(scene, find(named::PRINTED), configurations));
    all
}

/// An error over another's; a difference within the noise of both counts as none.
fn over(ours: &PictureError, theirs: &PictureError, metric: Metric) -> f64 {
    let (one, other) = (ours.of(metric), theirs.of(metric));
    let noise = ours.measured(metric).uncertainty.hypot(theirs.measured(metric).uncertainty);
    if one - other <= noise { (one / other).min(1.0) } else { one / other }
}

/// The time of the shading pass, in milliseconds.
fn shading(configuration: &Configuration) -> Option<f64> {
    let pass = configuration.passes.iter().find(|pass| pass.name == "shade")?;
    Some(pass.time.median)
}

/// A configuration by its shading time and its relative MSE.
fn candidate(configuration: &Configuration) -> Option<Candidate<&String>> {
    Some(Candidate::new(
        &configuration.name,
        shading(configuration)?,
        &configuration.picture,
        Metric::RelativeMse,
    ))
}

/// How many times less shading takes to the error of the papers' configuration.
fn faster(
    scene: &str,
    printed: Option<&Configuration>,
    configurations: &[Configuration],
) -> Promised {
    // Frames no longer than that one alone: cheap shading in a slow frame does not count.
    let longest = printed.map_or(0.0, |printed| time(printed).median);
    let within = configurations
        .iter()
        .filter(|configuration| configuration.complete && time(configuration).median <= longest);
    let all: Vec<Candidate<&String>> = within.filter_map(candidate).collect();
    let printed = printed.and_then(candidate);
    let equal = printed.as_ref().and_then(|printed| time_to_equal(&all, printed));
    Promised {
        name: format!("{scene}: shading time to the relative MSE of the papers' configuration"),
        value: equal.map_or(f64::NAN, |equal| equal.ratio),
        unit: "times shorter",
        at_least: true,
        bound: TIMES_FASTER,
        note: equal.map_or_else(
            || "no configuration is as good in a frame that is no longer".to_owned(),
            |equal| format!("by {}, in a frame that is no longer", equal.cheapest.which),
        ),
    }
}

/// What is promised of a scene.
#[must_use]
pub fn checks(scene: &SceneReport) -> Vec<Check> {
    let mut checks = Vec::new();
    let name = &scene.scene;
    checks.push(Check::new(
        format!("{name}: numbers that are not finite, in all variants"),
        scene.not_finite as f64,
        "numbers",
        Relation::Equal,
        0.0,
    ));
    for promised in hold(scene) {
        let Promised { name, value, unit, at_least, bound, note } = promised;
        let relation = if at_least { Relation::AtLeast } else { Relation::AtMost };
        checks.push(Check::new(name, value, unit, relation, bound).note(note));
    }
    let Some(pruned) = &scene.pruned else { return checks };
    let [width, height] = pruned.size;
    let note = format!("{width} x {height}, map of {} squared, in turns", scene.rsm_size);
    let (full, needed) = (&pruned.full, &pruned.needed);
    checks.push(
        Check::new(
            format!("{name}: bytes of indirect light's textures that leaving out saves"),
            1.0 - needed.texture_bytes as f64 / full.texture_bytes as f64,
            "of all",
            Relation::AtLeast,
            0.4,
        )
        .note(note.as_str()),
    );
    checks.push(
        Check::new(
            format!("{name}: shading pass with everything over what the scene needs"),
            full.shade_time.median / needed.shade_time.median,
            "times",
            Relation::AtLeast,
            1.8,
        )
        .note(note),
    );
    checks.push(Check::new(
        format!("{name}: numbers of the picture that leaving out changes"),
        pruned.differing as f64,
        "numbers",
        Relation::Equal,
        0.0,
    ));
    checks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frontier::choose::tests::configuration;
    use crate::frontier::document::Pass;
    use crate::time::Time;

    fn measured(name: &str, error: f64, milliseconds: f64) -> Configuration {
        let mut one = configuration(name, milliseconds, error, error);
        one.picture.relative_mse = error;
        one.picture.median = error;
        one.unshadowed = Some(one.picture);
        one.flicker = Some(error);
        one.frontiers.insert(Metric::RelativeMse);
        let time = Time { median: milliseconds, minimum: milliseconds, maximum: milliseconds };
        one.passes = vec![Pass { name: "shade".to_owned(), time }];
        one
    }

    fn example() -> (BTreeMap<String, String>, Vec<Configuration>) {
        let all = [
            (named::DEFAULT, measured("default", 0.004, 8.0)),
            (named::OLD, measured("old", 0.2, 9.0)),
            (named::BARE, measured("bare", 0.006, 7.0)),
            (named::BARE_1024, measured("bare 1024", 0.006, 7.0)),
            (named::BARE_64, measured("bare 64", 0.05, 0.5)),
            (named::BARE_16384, measured("bare 16384", 0.001, 100.0)),
            (named::LOBE, measured("lobe", 0.1, 9.0)),
            (named::COSINE, measured("cosine", 0.01, 8.5)),
            (named::PRINTED, measured("printed", 0.3, 12.0)),
        ];
        let names = all
            .iter()
            .map(|(what, configuration)| ((*what).to_owned(), configuration.name.clone()))
            .collect();
        (names, all.into_iter().map(|one| one.1).collect())
    }

    fn failing(names: &BTreeMap<String, String>, configurations: &[Configuration]) -> Vec<String> {
        let holds = |one: &Promised| {
            if one.at_least { one.value >= one.bound } else { one.value <= one.bound }
        };
        held("cornell", names, configurations)
            .into_iter()
            .filter(|one| !holds(one))
            .map(|one| one.name)
            .collect()
    }

    #[test]
    fn what_is_kept_holds_and_each_promise_can_fail() {
        let (names, configurations) = example();
        assert_eq!(failing(&names, &configurations), [] as [&str; 0]);
        // Cheap shading in a frame longer than the papers', or of a part of the light, does not count.
        for change in
            [(|one: &mut Configuration| one.time.median = 20.0) as fn(&mut Configuration), |one| {
                one.complete = false
            }]
        {
            let mut cheap = configurations.clone();
            cheap.iter_mut().filter(|one| one.name.starts_with("bare")).for_each(change);
            let failing = failing(&names, &cheap);
            assert!(failing.iter().any(|name| name.contains("shading time to the")), "{failing:?}");
        }
        let broken = |what: &str, change: fn(&mut Configuration)| {
            let mut configurations = configurations.clone();
            change(
                configurations
                    .iter_mut()
                    .find(|configuration| configuration.name == names[what])
                    .unwrap(),
            );
            failing(&names, &configurations).join("\n")
        };
        let found = broken(named::DEFAULT, |configuration| configuration.picture.flip = 0.5);
        assert!(found.contains("over the old default's"), "{found}");
        let found = broken(named::DEFAULT, |configuration| configuration.picture.bias = -0.04);
        assert!(found.contains("against paths"), "{found}");
        let found = broken(named::DEFAULT, |configuration| configuration.flicker = Some(0.3));
        assert!(found.contains("flicker"), "{found}");
        let found = broken(named::BARE, |configuration| configuration.unshadowed = None);
        assert!(found.contains("against facets"), "{found}");
        let found = broken(named::BARE_64, |configuration| {
            configuration.unshadowed =
                Some(PictureError { relative_mse: 0.4, ..configuration.picture });
        });
        assert!(found.contains("of 64 lights"), "{found}");
        let found = broken(named::BARE_16384, |configuration| {
            configuration.unshadowed =
                Some(PictureError { relative_mse: 0.005, ..configuration.picture });
        });
        assert!(found.contains("16384"), "{found}");
        let found = broken(named::LOBE, |configuration| configuration.passes[0].time.median = 7.0);
        assert!(found.contains("with the emitter lobe"), "{found}");
        let found =
            broken(named::COSINE, |configuration| configuration.passes[0].time.median = 10.0);
        assert!(found.contains("of the emitter cosine over"), "{found}");
        let found =
            broken(named::PRINTED, |configuration| configuration.passes[0].time.median = 3.0);
        assert!(found.contains("papers' configuration"), "{found}");
        // What was not measured is not kept, and other scenes have fewer bounds.
        assert!(!failing(&BTreeMap::new(), &configurations).is_empty());
        assert!(
            held("caustic", &names, &configurations).len()
                < held("atrium:75k", &names, &configurations).len()
        );
    }

    #[test]
    fn noise_makes_nothing_worse() {
        let exact = PictureError { relative_mse: 0.1, ..PictureError::default() };
        let mut noisy = PictureError { relative_mse: 0.12, ..PictureError::default() };
        assert!(over(&noisy, &exact, Metric::RelativeMse) > WORSE);
        noisy.uncertainty.relative_mse = 0.03;
        assert_eq!(over(&noisy, &exact, Metric::RelativeMse), 1.0);
        assert_eq!(over(&exact, &noisy, Metric::RelativeMse), 0.1 / 0.12);
    }
}

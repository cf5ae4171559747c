//! What `report` has measured and other commands tell: the milliseconds that rules save.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sglow_consumers::machine::target_folder;
use sglow_measure::cache::{Cache, CacheError, Key};
use sglow_measure::frontier::subject::scene_hash;
use sglow_renderer::device::AdapterFacts;
use sglow_results::frontier::document::{Pruned, Side};
use sglow_scene::Scene;

/// Passes that are no indirect light's.
const OTHERS: [&str; 6] =
    ["surface light", "surface camera", "shadow", "direct", "emission", "compose"];

/// The milliseconds that rules save in a frame of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Measured {
    /// The GPU, or what took its place.
    pub(crate) adapter: String,
    /// Its driver.
    pub(crate) driver: String,
    /// Pixels of the picture.
    pub(crate) size: [u32; 2],
    /// By the name of the rule.
    pub(crate) rules: BTreeMap<String, f64>,
}

/// The folder of results, unless another one is named.
pub(crate) fn folder() -> std::path::PathBuf {
    target_folder().join("measured")
}

/// The time of passes that leaving out the specular lobe, or emission, spares.
pub(crate) fn saved(pruned: &Pruned) -> BTreeMap<String, f64> {
    let sum = |side: &Side, counts: &dyn Fn(&str) -> bool| -> f64 {
        let passes = side.passes.iter().filter(|pass| counts(&pass.name));
        passes.map(|pass| pass.time.median).sum()
    };
    let spared =
        |counts: &dyn Fn(&str) -> bool| sum(&pruned.full, counts) - sum(&pruned.needed, counts);
    BTreeMap::from([
        ("no-specular-surface".to_owned(), spared(&|pass| !OTHERS.contains(&pass))),
        ("no-emitter".to_owned(), spared(&|pass| pass == "emission")),
    ])
}

fn key(scene: &Scene) -> Key {
    Key::new(&[("what", "milliseconds that rules save"), ("scene", &scene.name)])
        .on("scene", scene_hash(scene))
}

/// Keeps what was measured of a scene.
///
/// # Errors
///
/// When it cannot be written.
pub(crate) fn keep(
    cache: &Cache,
    scene: &Scene,
    pruned: &Pruned,
    adapter: &AdapterFacts,
) -> Result<(), CacheError> {
    let measured = Measured {
        adapter: adapter.name.clone(),
        driver: adapter.driver.clone(),
        size: pruned.size,
        rules: saved(pruned),
    };
    let key = key(scene);
    if cache.find::<Measured>(&key).as_ref() == Some(&measured) {
        return Ok(());
    }
    cache.put(&key, &measured)
}

/// What was measured of a scene, if it was and nothing has changed since.
pub(crate) fn find(scene: &Scene) -> Option<Measured> {
    Cache::new(&folder(), false).find(&key(scene))
}

#[cfg(test)]
mod tests {
    use sglow_results::frontier::document::Pass;
    use sglow_results::time::Time;

    use super::*;

    fn side(passes: &[(&str, f64)]) -> Side {
        let time = |median| Time { median, least: median, most: median };
        let pass =
            |&(name, median): &(&str, f64)| Pass { name: name.to_owned(), time: time(median) };
        Side {
            shade: String::new(),
            texture_bytes: 0,
            buffer_bytes: 0,
            shade_time: time(0.0),
            time: time(0.0),
            passes: passes.iter().map(pass).collect(),
        }
    }

    #[test]
    fn each_rule_saves_the_time_of_its_own_passes() {
        let pruned = Pruned {
            full: side(&[
                ("surface light", 9.0),
                ("shade", 5.0),
                ("moments", 2.0),
                ("emission", 0.5),
            ]),
            needed: side(&[("surface light", 1.0), ("shade", 2.0), ("moments", 1.5)]),
            size: [4, 4],
            differing: 0,
        };
        let saved = saved(&pruned);
        assert_eq!((saved["no-specular-surface"], saved["no-emitter"]), (3.5, 0.5));
    }

    #[test]
    fn what_was_measured_of_another_scene_is_not_told() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path(), false);
        let scene = Scene::builtin("cornell").unwrap();
        let both = Pruned { full: side(&[]), needed: side(&[]), size: [4, 4], differing: 0 };
        let adapter = AdapterFacts {
            name: "a".to_owned(),
            driver: "d".to_owned(),
            backend: String::new(),
            software: true,
        };
        keep(&cache, &scene, &both, &adapter).unwrap();
        assert!(cache.find::<Measured>(&key(&scene)).is_some());
        let mut changed = scene.clone();
        changed.materials[0].roughness = 0.5;
        assert!(cache.find::<Measured>(&key(&changed)).is_none());
    }
}

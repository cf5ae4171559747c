//! The milliseconds that rules save, which `report` measures and other commands show.

use std::path::Path;

use sglow_renderer::device::AdapterFacts;
use sglow_results::frontier::document::Pruned;
use sglow_results::saved::{Measured, Rules, saved};
use sglow_scene::Scene;

use crate::cache::{Cache, CacheError, Key};
use crate::frontier::subject::scene_hash;

fn key(scene: &Scene) -> Key {
    Key::new(&[("what", "milliseconds that rules save"), ("scene", &scene.name)])
        .on("scene", scene_hash(scene))
}

/// Keeps what was measured of a scene.
///
/// # Errors
///
/// When it cannot be written.
pub fn keep(
    cache: &Cache,
    scene: &Scene,
    pruned: &Pruned,
    rules: &Rules,
    adapter: &AdapterFacts,
) -> Result<(), CacheError> {
    let measured = Measured {
        adapter: adapter.name.clone(),
        driver: adapter.driver.clone(),
        size: pruned.size,
        rules: saved(pruned, rules),
    };
    let key = key(scene);
    if cache.find::<Measured>(&key).as_ref() == Some(&measured) {
        return Ok(());
    }
    cache.put(&key, &measured)
}

/// What was measured of a scene, if it was and nothing has changed since.
#[must_use]
pub fn find(folder: &Path, scene: &Scene) -> Option<Measured> {
    Cache::new(folder, false).find(&key(scene))
}

#[cfg(test)]
mod tests {
    use sglow_results::frontier::document::{Pass, Side};
    use sglow_results::time::Time;

    use super::*;

    fn side(passes: &[(&str, f64)]) -> Side {
        let time = |median| Time { median, minimum: median, maximum: median };
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
    fn what_was_measured_of_another_scene_is_not_reported() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path(), false);
        let scene = Scene::builtin("cornell").unwrap();
        let (full, needed, axes) = (side(&[]), side(&[]), Default::default());
        let both = Pruned { full, needed, size: [4, 4], differing: 0, axes };
        let adapter = AdapterFacts {
            name: "a".to_owned(),
            driver: "d".to_owned(),
            backend: String::new(),
            software: true,
        };
        keep(&cache, &scene, &both, &Rules::new(), &adapter).unwrap();
        assert!(cache.find::<Measured>(&key(&scene)).is_some());
        let mut changed = scene.clone();
        changed.materials[0].roughness = 0.5;
        assert!(cache.find::<Measured>(&key(&changed)).is_none());
    }
}

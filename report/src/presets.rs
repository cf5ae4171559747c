//! Named points of the frontier as presets of the library.

use std::collections::BTreeMap;

use sglow_results::frontier::document::{Metric, SceneReport};
use sglow_results::frontier::points::Point;
use sglow_results::frontier::{choose, points};
use sglow_shader_gen::library::{Measurement, Preset, PresetFile, Setting};

use crate::failure::{Failure, Result};

/// What stands at the top of the file.
const HEAD: &str = "\
# Written by `cargo xtask report --presets`: named points of the frontier, with the measurements that chose them.
# Errors as in report.json: shares, but for flip.

";

/// The named points of what was measured, as the file of presets has them.
///
/// # Errors
///
/// When there are none.
pub fn text(scenes: &[SceneReport], adapter: &str) -> Result<String> {
    let points = points::points(scenes).ok_or_else(|| {
        Failure::new("no configuration was measured of every scene that is as good as the papers'")
            .help("--presets goes with screening: without --all and --only")
    })?;
    let preset = points.iter().map(|point| preset(point, adapter)).collect();
    let text = PresetFile { preset }.text().map_err(|error| Failure::new(error.to_string()))?;
    Ok(HEAD.to_owned() + &text)
}

fn preset(point: &Point<'_>, adapter: &str) -> Preset {
    let set = points::values(point);
    let measured = point.scenes.iter().map(|(scene, configuration)| Measurement {
        input: scene.scene.clone(),
        device: format!("{adapter}, {}", scene.clock),
        milliseconds: choose::time(configuration).median,
        errors: Metric::ALL
            .map(|metric| (metric.name().to_owned(), configuration.picture.measured(metric).value))
            .into(),
    });
    Preset {
        name: point.name.to_owned(),
        description: point.description.to_owned(),
        set: set
            .into_iter()
            .map(|(name, value)| (name, Setting::read(&value)))
            .collect::<BTreeMap<_, _>>(),
        measured: measured.collect(),
    }
}

#[cfg(test)]
mod tests {
    use sglow_results::frontier::document::Screening;
    use sglow_results::frontier::promise::named;
    use sglow_shader_gen::library::Library;

    use super::*;
    use crate::page::report::made_up;

    #[test]
    fn points_are_presets_that_can_be_read_and_set() {
        let mut scene = made_up::scenes().remove(0).measured;
        let slowest = scene
            .configurations
            .iter()
            .max_by(|one, other| one.time.median.total_cmp(&other.time.median));
        let named = BTreeMap::from([(named::PRINTED.to_owned(), slowest.unwrap().name.clone())]);
        scene.screening = Some(Screening { named, ..Screening::default() });
        let scenes = [scene];
        let points = points::points(&scenes).unwrap();
        let of = |at: usize| points[at].scenes[0].1;
        assert_eq!(points.each_ref().map(|point| point.name), ["fast", "balanced", "accurate"]);
        let time = |at| choose::time(of(at)).median;
        assert!(time(0) <= time(1) && time(1) <= time(2));
        let error = |at: usize| of(at).picture.of(Metric::RelativeMse);
        assert!(error(2) <= error(1) && error(1) <= error(0));
        let file = PresetFile { preset: points.iter().map(|one| preset(one, "made up")).collect() };
        let again = PresetFile::read(&file.text().unwrap()).unwrap();
        assert_eq!(again, file);
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
        let library = Library::load(&folder).unwrap();
        for (name, value) in &again.preset[0].set {
            // Two axes of the made-up scenes are made up, too.
            let known = |axis: &sglow_shader_gen::library::Axis| {
                axis.value.iter().any(|known| known.name == value.to_string())
            };
            assert!(library.axis.get(name).is_none_or(known), "{name}");
        }
        assert!(points::points(&[]).is_none());
    }
}

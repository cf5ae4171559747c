//! What the defaults of lights' maps rest on.

use sglow_runtime::settings::Settings;
use sglow_shaders::Visibility as Axis;

use super::Stage;
use super::config::Config;
use crate::common::whole_space;

/// The light that is wrongly seen or hidden, against exact rays from the same near distance on. Each other choice is worse;
/// of imperfect maps that of filling holes by much the least. (The near distance is chosen against paths, for it is the same
/// in maps and rays: `picture.rs`. Larger tiles are better, and cost as many times more.)
#[test]
fn the_defaults_are_better_than_what_else_was_tried() {
    let settings =
        Settings { lights: 64, size: [48, 27], map: 128, size_factor: 0.25, ..Settings::default() };
    for scene in ["cornell", "columns"] {
        let stage = Stage::of_scene(scene, &settings);
        let own = |axis| {
            let stage = stage.config(axis);
            Config::new(axis, stage.lobes, stage.precision, stage.count)
        };
        let expected = stage.run(&own(Axis::ShadowMap), whole_space()).expected();
        for axis in [Axis::ShadowMap, Axis::Imperfect] {
            let base = own(axis);
            let wrong = |what: &str, config: &Config| {
                let [dark, bright, weighted] =
                    stage.run(config, whole_space()).wrong(&expected).map(|share| 100.0 * share);
                println!(
                    "{scene}, {axis}, {what}: {dark:.2} % too dark, {bright:.2} % too bright, {weighted:.2} % of the light"
                );
                weighted
            };
            let best = wrong("the defaults", &base);
            let mut others = vec![
                ("half the bias", Config { bias_scale: 0.5, ..base.clone() }),
                ("twice the bias", Config { bias_scale: 2.0, ..base.clone() }),
                ("half the tile", Config { tile: base.tile / 2, ..base.clone() }),
            ];
            if axis == Axis::Imperfect {
                others.extend([
                    ("an eighth of the points", Config { points: 1024, ..base.clone() }),
                    ("points without extent", Config { reach: 0, ..base.clone() }),
                    ("holes filled over six levels", Config { levels: 6, ..base.clone() }),
                ]);
            }
            for (what, config) in others {
                assert!(wrong(what, &config) > best, "{scene}, {axis}: {what} is no worse");
            }
        }
    }
}

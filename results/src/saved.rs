//! The milliseconds that rules save in a frame of a scene.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::frontier::document::{Pruned, Side};

/// Passes that are no indirect light's.
const OTHERS: [&str; 6] =
    ["surface light", "surface camera", "shadow", "direct", "emission", "compose"];

/// The milliseconds that rules save in a frame of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The GPU, or what took its place.
    pub adapter: String,
    /// Its driver.
    pub driver: String,
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// By the name of the rule.
    pub rules: BTreeMap<String, f64>,
}

/// The time of passes that leaving out the specular lobe, or emission, spares.
#[must_use]
pub fn saved(pruned: &Pruned) -> BTreeMap<String, f64> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frontier::document::Pass;
    use crate::time::Time;

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
}

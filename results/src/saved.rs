//! The milliseconds that rules save in a frame of a scene.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::frontier::document::{Pass, Pruned, Side};

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

/// Rules by name, each with the axes that it decides.
pub type Rules = BTreeMap<String, BTreeSet<String>>;

/// The time that each of some rules saves: of the passes that depend on the axes that it decides, and on no other axis on
/// which both sides differ.
#[must_use]
pub fn saved(pruned: &Pruned, rules: &Rules) -> BTreeMap<String, f64> {
    let Pruned { full, needed, axes: differing, .. } = pruned;
    let decides = |rule: &(&String, &BTreeSet<String>)| {
        rule.1.iter().any(|axis| differing.contains_key(axis))
    };
    let saves = |(name, axes): (&String, &BTreeSet<String>)| {
        let counts = |pass: &&Pass| {
            let mut on =
                differing.iter().filter(|(_, passes)| passes.contains(&pass.name)).peekable();
            on.peek().is_some() && on.all(|(axis, _)| axes.contains(axis))
        };
        let sum = |side: &Side| -> f64 {
            side.passes.iter().filter(counts).map(|pass| pass.time.median).sum()
        };
        (name.clone(), sum(full) - sum(needed))
    };
    rules.iter().filter(decides).map(saves).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Time;

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

    fn sets(list: &[(&str, &[&str])]) -> Rules {
        let set = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        list.iter().map(|&(name, names)| (name.to_owned(), set(names))).collect()
    }

    #[test]
    fn each_rule_saves_the_time_of_its_own_passes() {
        let pruned = Pruned {
            full: side(&[
                ("surface light", 9.0),
                ("shade", 5.0),
                ("moments", 2.0),
                ("emission", 0.5),
                ("compose", 1.0),
            ]),
            needed: side(&[("surface light", 1.0), ("shade", 2.0), ("moments", 1.5)]),
            size: [4, 4],
            differing: 0,
            axes: sets(&[
                ("lobes", &["moments", "shade", "compose"]),
                ("specular", &["shade", "compose"]),
                ("emission", &["emission", "compose"]),
            ]),
        };
        let rules = sets(&[
            ("no-specular-surface", &["lobes", "specular", "ndf"]),
            ("no-emitter", &["emission"]),
            ("no-occluder", &["visibility"]),
        ]);
        // What depends on axes of several rules counts for none, and what decides no axis that differs is not there.
        let expected = [("no-emitter".to_owned(), 0.5), ("no-specular-surface".to_owned(), 3.5)];
        assert_eq!(saved(&pruned, &rules), BTreeMap::from(expected));
    }
}

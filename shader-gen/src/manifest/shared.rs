//! What several variants have in common stands in a manifest once.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Binding, Described, EntryPoint, Requires, Struct, Variant};

/// What variants refer to by key. A key is a name; where different things have the same name, those after the first have
/// `:2`, `:3` and so on behind it. Types in WGSL name a struct by its name: the one of that name among the variant's own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shared {
    /// Functions that pipelines start in.
    pub entry_points: BTreeMap<String, EntryPoint>,
    /// Resources that a host binds.
    pub bindings: BTreeMap<String, Binding>,
    /// Structs in buffers.
    pub structs: BTreeMap<String, Struct>,
    /// What a device must have, by the name of a pass.
    pub requires: BTreeMap<String, Requires>,
    /// Units and ranges of inputs, one `name: text` each, by the name of a pass.
    pub contracts: BTreeMap<String, Vec<String>>,
}

impl Shared {
    /// A variant that refers to what is here; what it has of its own is added.
    pub fn intern(&mut self, of: Described) -> Variant {
        let Described { id, pass, axes, cost, overrides, files, .. } = of;
        let named = |name: &String| name.clone();
        Variant {
            entry_points: keys(&mut self.entry_points, of.entry_points, |of| named(&of.name)),
            bindings: keys(&mut self.bindings, of.bindings, |of| named(&of.name)),
            structs: keys(&mut self.structs, of.structs, |of| named(&of.name)),
            requires: key(&mut self.requires, &pass, of.requires),
            contract: key(&mut self.contracts, &pass, of.contract),
            accuracy: None,
            time: None,
            id,
            pass,
            axes,
            cost,
            overrides,
            files,
        }
    }
}

fn keys<T: PartialEq>(
    table: &mut BTreeMap<String, T>,
    values: Vec<T>,
    name: impl Fn(&T) -> String,
) -> Vec<String> {
    values.into_iter().map(|value| key(table, &name(&value), value)).collect()
}

/// The key of a value, which is added if it is not there.
pub(super) fn key<T: PartialEq>(table: &mut BTreeMap<String, T>, name: &str, value: T) -> String {
    let (mut key, mut number) = (name.to_owned(), 1);
    while table.get(&key).is_some_and(|known| *known != value) {
        number += 1;
        key = format!("{name}:{number}");
    }
    table.entry(key.clone()).or_insert(value);
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_things_stand_once_and_different_ones_of_a_name_apart() {
        let mut table = BTreeMap::new();
        let keys = [1, 2, 1, 3, 2].map(|value| key(&mut table, "name", value));
        assert_eq!(keys, ["name", "name:2", "name", "name:3", "name:2"]);
        assert_eq!(table.into_values().collect::<Vec<_>>(), [1, 2, 3]);
    }
}

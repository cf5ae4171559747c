//! Figures beside earlier ones.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::cost::{Compiler, Cost, Costs};

/// Whether two results can be compared.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Relation {
    /// The same driver, version and family: figures have to be the same.
    SameCompiler,
    /// Another one: figures say nothing of each other, and none are compared.
    OtherCompiler {
        /// The earlier one.
        old: Compiler,
        /// The later one.
        new: Compiler,
    },
}

/// What has become different.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Change {
    /// A figure of [`Cost`].
    Figure {
        /// Its name.
        figure: String,
        /// Before; none where it has no value.
        old: Option<u64>,
        /// Now; none where it has no value.
        new: Option<u64>,
    },
    /// It was not there before.
    Added,
    /// It is no longer there.
    Removed,
    /// What is said of why it is not compiled.
    Skipped {
        /// Before; none where it was not skipped.
        old: Option<String>,
        /// Now; none where it is not skipped.
        new: Option<String>,
    },
}

/// A difference.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Difference {
    /// The variant's identifier.
    pub id: String,
    /// The entry point; empty for what is skipped.
    pub entry_point: String,
    /// What is different.
    pub change: Change,
}

/// A figure that has to be 0.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// The variant's identifier.
    pub id: String,
    /// The entry point.
    pub entry_point: String,
    /// The figure's name.
    pub figure: String,
    /// Its value.
    pub value: u64,
}

/// What [`compare`] found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Comparison {
    /// Whether figures were compared.
    pub relation: Relation,
    /// All differences, by identifier; empty for another compiler.
    pub differences: Vec<Difference>,
    /// Registers that did not fit and private memory in the new figures, whatever the compiler.
    pub faults: Vec<Fault>,
}

impl Comparison {
    /// Whether nothing is different and nothing at fault. True for another compiler without faults: see `relation`.
    pub fn passes(&self) -> bool {
        self.differences.is_empty() && self.faults.is_empty()
    }
}

const ALWAYS_ZERO: [&str; 3] = ["spilled_vgprs", "spilled_sgprs", "scratch_bytes"];

/// Compares figure by figure.
pub fn compare(old: &Costs, new: &Costs) -> Comparison {
    let same =
        old.compiler.driver == new.compiler.driver && old.compiler.family == new.compiler.family;
    Comparison {
        relation: if same {
            Relation::SameCompiler
        } else {
            Relation::OtherCompiler { old: old.compiler.clone(), new: new.compiler.clone() }
        },
        differences: if same { differences(old, new) } else { Vec::new() },
        faults: faults(new),
    }
}

fn faults(costs: &Costs) -> Vec<Fault> {
    let mut faults = Vec::new();
    for cost in &costs.costs {
        for (figure, value) in cost.figures() {
            let value = value.unwrap_or_default();
            if ALWAYS_ZERO.contains(&figure.as_str()) && value > 0 {
                let (id, entry_point) = (cost.id.clone(), cost.entry_point.clone());
                faults.push(Fault { id, entry_point, figure, value });
            }
        }
    }
    faults
}

fn differences(old: &Costs, new: &Costs) -> Vec<Difference> {
    let mut found = Vec::new();
    let (before, now) = (by_name(old), by_name(new));
    for key @ (id, entry_point) in before.keys().chain(now.keys()).collect::<BTreeSet<_>>() {
        let mut add = |change| {
            let (id, entry_point) = ((*id).to_owned(), (*entry_point).to_owned());
            found.push(Difference { id, entry_point, change });
        };
        match (before.get(key), now.get(key)) {
            (Some(a), Some(b)) => {
                for ((figure, old), (_, new)) in a.figures().into_iter().zip(b.figures()) {
                    if old != new {
                        add(Change::Figure { figure, old, new });
                    }
                }
            }
            (None, _) => add(Change::Added),
            (_, None) => add(Change::Removed),
        }
    }
    let (before, now) = (skipped(old), skipped(new));
    for id in before.keys().chain(now.keys()).collect::<BTreeSet<_>>() {
        let (old, new) = (before.get(id).cloned(), now.get(id).cloned());
        if old != new {
            let (id, entry_point) = ((*id).to_owned(), String::new());
            found.push(Difference { id, entry_point, change: Change::Skipped { old, new } });
        }
    }
    found.sort();
    found
}

fn by_name(costs: &Costs) -> BTreeMap<(&str, &str), &Cost> {
    costs.costs.iter().map(|cost| ((&*cost.id, &*cost.entry_point), cost)).collect()
}

/// All reasons of a variant, since each of its entry points can have one.
fn skipped(costs: &Costs) -> BTreeMap<&str, String> {
    let mut all = BTreeMap::<&str, String>::new();
    for skipped in &costs.skipped {
        let whole = all.entry(&skipped.id).or_default();
        if !whole.is_empty() {
            whole.push_str("; ");
        }
        whole.push_str(&skipped.why);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::Skipped;

    fn costs() -> Costs {
        let cost = |id: &str| Cost { id: id.to_owned(), instructions: 9, ..Cost::default() };
        Costs {
            compiler: Compiler {
                driver: "radv Mesa 22.3.6".to_owned(),
                family: "navi21".to_owned(),
                device: "RADV NAVI21".to_owned(),
            },
            costs: vec![cost("a"), cost("b")],
            skipped: vec![Skipped { id: "c".to_owned(), why: "vertex".to_owned() }],
        }
    }

    #[test]
    fn the_same_passes() {
        let comparison = compare(&costs(), &costs());
        assert_eq!(comparison.relation, Relation::SameCompiler);
        assert!(comparison.passes());
    }

    #[test]
    fn every_figure_is_compared() {
        let mut new = costs();
        new.costs[1] = Cost {
            id: "b".to_owned(),
            entry_point: String::new(),
            instructions: 10,
            code_bytes: 1,
            vgprs: 1,
            sgprs: 1,
            spilled_vgprs: 1,
            spilled_sgprs: 1,
            scratch_bytes: 1,
            lds_bytes: 1,
            subgroups_per_simd: 1,
            inverse_throughput: 1,
            loops: 1,
            loop_instructions: Some(1),
            loop_issue_cycles: Some(1),
        };
        let found = compare(&costs(), &new).differences;
        assert_eq!(found.len(), new.costs[1].figures().len());
        assert_eq!(found.len(), 13);
        assert!(found.iter().all(|difference| difference.id == "b"));
    }

    #[test]
    fn what_comes_and_goes_is_listed() {
        let mut new = costs();
        new.costs.remove(0);
        new.skipped[0].id = "a".to_owned();
        let found = compare(&costs(), &new).differences;
        let ids: Vec<_> = found.iter().map(|difference| difference.id.as_str()).collect();
        assert_eq!(ids, ["a", "a", "c"]);
        assert!(found.iter().any(|difference| difference.change == Change::Removed));
        assert_eq!(compare(&new, &costs()).differences.len(), 3);
    }

    #[test]
    fn another_compiler_is_not_compared_but_faults_are_found() {
        let mut new = costs();
        new.compiler.driver = "radv Mesa 25.0.7".to_owned();
        new.costs[0].instructions = 1;
        let comparison = compare(&costs(), &new);
        assert!(matches!(comparison.relation, Relation::OtherCompiler { .. }));
        assert!(comparison.passes());
        for spoil in [
            |cost: &mut Cost| cost.spilled_vgprs = 4,
            |cost: &mut Cost| cost.spilled_sgprs = 4,
            |cost: &mut Cost| cost.scratch_bytes = 4,
        ] {
            let mut spoilt = new.clone();
            spoil(&mut spoilt.costs[0]);
            let comparison = compare(&costs(), &spoilt);
            assert_eq!((comparison.faults.len(), comparison.passes()), (1, false));
        }
    }
}

//! The manifest's count of a loop's turn compared with what a compiler makes of that loop.

use std::collections::BTreeMap;

use serde::Deserialize;
use sglow_cost::Costs;
use sglow_report::failure::{Context as _, Result};
use sglow_shader_gen::manifest::Cost;

use crate::machine::repository;

/// The minimum rank correlation of scalar operations of a turn with instructions of the loop. It was 0.948 for RDNA 2 and
/// 0.950 for GCN 5 when the count was made; loops that a compiler unrolls keep it below 1.
pub(crate) const AGREEMENT: f64 = 0.9;

#[derive(Deserialize)]
struct Manifest {
    variants: Vec<Variant>,
}

#[derive(Deserialize)]
struct Variant {
    id: String,
    cost: BTreeMap<String, Cost>,
}

/// Scalar operations by a count of the manifest, and instructions of the longest innermost loop by a compiler, of each
/// entry point where both have a loop.
fn pairs(
    manifest: &Manifest,
    costs: &Costs,
    count: impl Fn(&Cost) -> Option<u64>,
) -> Vec<[u64; 2]> {
    let counted: BTreeMap<_, _> = manifest
        .variants
        .iter()
        .flat_map(|one| one.cost.iter().map(|(name, cost)| ((&one.id, name), cost)))
        .collect();
    let pair = |compiled: &sglow_cost::Cost| {
        let counted = counted.get(&(&compiled.id, &compiled.entry_point))?;
        Some([count(counted)?, compiled.loop_instructions?])
    };
    costs.costs.iter().filter_map(pair).collect()
}

/// Scalar operations of the innermost loop that has most.
fn longest(cost: &Cost) -> Option<u64> {
    cost.innermost().map(|one| one.turn.scalars()).max()
}

fn manifest() -> Result<Manifest> {
    let name = "shaders/packages/sglow/manifest.json";
    let text = std::fs::read_to_string(repository().join(name)).context(name)?;
    serde_json::from_str(&text).context(name)
}

/// Spearman's rank correlation of the committed manifest's turns with a compiler's loops, and the number of entry points
/// that have both.
///
/// # Errors
///
/// When the manifest cannot be read.
pub(crate) fn agreement(costs: &Costs) -> Result<(f64, usize)> {
    let pairs = pairs(&manifest()?, costs, longest);
    Ok((correlation(&pairs), pairs.len()))
}

/// Spearman's rank correlation: that of Pearson, of the ranks.
fn correlation(pairs: &[[u64; 2]]) -> f64 {
    let [one, other] =
        [0, 1].map(|at| ranks(&pairs.iter().map(|pair| pair[at]).collect::<Vec<_>>()));
    let mean = (pairs.len() as f64 - 1.0) / 2.0;
    let sum = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    sum(&one, &other) / (sum(&one, &one) * sum(&other, &other)).sqrt()
}

/// The rank of each value; equal values share the mean of theirs.
fn ranks(values: &[u64]) -> Vec<f64> {
    let below = |value| values.iter().filter(|&&other| other < value).count() as f64;
    let equal = |value| values.iter().filter(|&&other| other == value).count() as f64;
    values.iter().map(|&value| below(value) + (equal(value) - 1.0) / 2.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::{FAMILIES, of_family};

    #[test]
    fn turns_rank_as_the_loops_of_compilers_and_other_counts_do_not() {
        for family in FAMILIES {
            let costs = of_family(family).unwrap().unwrap();
            let (agreement, count) = agreement(&costs).unwrap();
            assert!(count > 100 && agreement >= AGREEMENT, "{family}: {agreement} of {count}");
            // Negative controls: the count of the whole text, and what runs once.
            let manifest = manifest().unwrap();
            let with = |count: fn(&Cost) -> u64| {
                let of_loops = |cost: &Cost| longest(cost).map(|_| count(cost));
                correlation(&pairs(&manifest, &costs, of_loops))
            };
            let (text, once) =
                (with(|cost| cost.text().scalars()), with(|cost| cost.once.scalars()));
            assert!(text < AGREEMENT && once < AGREEMENT, "{family}: {text}, {once}");
        }
    }

    #[test]
    fn equal_values_share_their_rank() {
        assert_eq!(ranks(&[5, 1, 5, 9]), [1.5, 0.0, 1.5, 3.0]);
        assert_eq!(correlation(&[[1, 10], [2, 20], [3, 30]]), 1.0);
        assert_eq!(correlation(&[[1, 30], [2, 20], [3, 10]]), -1.0);
    }
}

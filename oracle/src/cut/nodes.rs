//! All nodes and leaves of the tree as lights, and the nodes of the global cut among them.

use std::collections::BTreeMap;

use super::Branch;
use super::global::Cut;
use crate::cluster::Map;
use crate::vsgl::Vsgl;

/// A tree whose nodes and leaves are lights, and the nodes of a global cut, which a cut for each tile refines.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    /// The light of each node.
    pub lights: Vec<Vsgl>,
    /// Its children, power and spread of normals.
    pub branches: Vec<Branch>,
    /// The nodes of the global cut; none of a light without power.
    pub roots: Vec<Option<usize>>,
    /// The root of the whole tree, if anything is lit.
    pub top: Option<usize>,
}

impl LightTree {
    /// That of a map's cut: inner nodes by their numbers, leaves behind them.
    #[must_use]
    pub fn of(cut: &Cut, map: &Map<'_, f64>) -> Self {
        let leaves = cut.texels.len();
        let inner = cut.tree.nodes.iter().map(|node| node.leaves.clone());
        let ranges: Vec<_> = inner.chain((0..leaves).map(|leaf| leaf..leaf + 1)).collect();
        let number: BTreeMap<[usize; 2], usize> =
            ranges.iter().map(|range| [range.start, range.end]).zip(0..).collect();
        let sums: Vec<_> = ranges.iter().map(|range| cut.sums.of(range.clone())).collect();
        let branch = |at: usize| {
            let range = &ranges[at];
            // The number of an inner node is that of the last leaf to its left.
            let children = (at + 1 < leaves)
                .then(|| [number[&[range.start, at + 1]], number[&[at + 1, range.end]]]);
            let normal = |at: usize| {
                let sum = &sums[at];
                (sum.diffuse_direction * (1.0 / sum.diffuse_weight), sum.diffuse_weight)
            };
            let own = normal(at).0;
            let spread = children.map_or(0.0, |children| {
                let [one, other] = children.map(normal);
                let of =
                    |(mean, weight): (crate::Vector3, f64)| weight * (mean - own).length_squared();
                (of(one) + of(other)) / (one.1 + other.1)
            });
            Branch {
                children,
                power: sums[at].diffuse_power.luminance(),
                specular_power: sums[at].specular_power.luminance(),
                spread,
                bounds: sums[at].bounds.map(|corner| corner - sums[at].mean),
            }
        };
        Self {
            lights: sums.iter().map(|sum| sum.light(map.origin, &map.emission)).collect(),
            branches: (0..ranges.len()).map(branch).collect(),
            roots: cut
                .nodes
                .iter()
                .map(|range| number.get(&[range.start, range.end]).copied())
                .collect(),
            top: number.get(&[0, leaves]).copied(),
        }
    }

    /// The leaves below a node.
    #[must_use]
    pub fn leaves(&self, node: usize) -> Vec<usize> {
        let (mut open, mut leaves) = (vec![node], Vec::new());
        while let Some(node) = open.pop() {
            match self.branches[node].children {
                Some(children) => open.extend(children),
                None => leaves.push(node),
            }
        }
        leaves
    }
}

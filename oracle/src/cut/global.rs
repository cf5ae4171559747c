//! A cut without a receiver: as many nodes as there are to be lights.

use core::ops::Range;

use crate::cluster::Map;
use crate::cut::key::{Grid, Key, UNLIT, places};
use crate::cut::{CentralMoments, Sums, Tree};
use crate::vsgl::Vsgl;
use crate::{Real, Vector3};

/// What a spread of directions counts beside one of positions.
///
/// In rooms of boxes and columns any value from 0 to 5 gives the same relative MSE within 3 % with 128 and 512 lights (the test
/// `what_directions_count_is_near_the_best`), because the face of the normal is in the key: it is there for curved surfaces,
/// whose normals vary within a face.
pub const DIRECTIONS: f64 = 0.2;

/// What a node costs as one light: its share of the power times the spread of its positions, over that of all texels, and of
/// its directions. 0 of nothing.
///
/// `directions`: what these count, [`DIRECTIONS`].
pub fn cost<R: Real>(node: &CentralMoments<R>, all: &CentralMoments<R>, directions: f64) -> R {
    if all.weight.value() <= 0.0 {
        return R::zero();
    }
    let spread = |direction: Vector3<R>, length: R| {
        if length.value() <= 0.0 {
            return R::zero();
        }
        let coherence = direction.map(|part| part / length).length().min(R::one());
        (R::one() - coherence) * (R::one() + coherence)
    };
    // Shares of the power first: they are in range whatever the power.
    let diffuse =
        node.diffuse_weight / all.weight * spread(node.diffuse_direction, node.diffuse_weight);
    let specular = node.specular_power.luminance() / all.weight
        * spread(node.specular_direction, node.specular_length);
    let mut positions = R::zero();
    if all.variance.value() > 0.0 {
        positions = node.weight / all.weight * (node.variance / all.variance);
    }
    positions + R::constant(directions) * (diffuse + specular)
}

/// What orders nodes, the smallest first: larger costs before smaller ones, of equal costs the node nearer to the root.
///
/// The six lowest bits are those of the node's prefix, so that costs within 2^-17 of each other count as equal.
#[must_use]
pub fn rank_key(cost: f32, prefix: u32) -> u32 {
    !((cost.max(0.0).to_bits() << 1) & !63 | (63 - prefix.min(63)))
}

/// The least cost of a node and of all nodes above it: what the node is ranked by, so that none comes before its parent. That
/// of the root is infinite.
///
/// Costs themselves fall from a node to its children, as sums of squares about means do, but for rounding and where widths of
/// specular lobes differ.
#[must_use]
pub fn effective(tree: &Tree, costs: &[f32]) -> Vec<f32> {
    let of = |node: usize| {
        let (mut least, mut at) = (f32::INFINITY, node);
        while let Some(parent) = tree.nodes[at].parent {
            least = least.min(costs[at]);
            at = parent;
        }
        least
    };
    (0..tree.nodes.len()).map(of).collect()
}

/// The ranges of leaves of a cut of `count` nodes, or of all leaves if there are fewer: without the nodes of the greatest
/// effective costs. They are what a greedy refinement of the most expensive node gives, wherever its next cost is a new minimum.
#[must_use]
pub fn ranges(tree: &Tree, effective: &[f32], count: usize) -> Vec<Range<usize>> {
    let mut order: Vec<usize> = (0..tree.nodes.len()).collect();
    order.sort_by_key(|&node| (rank_key(effective[node], tree.nodes[node].prefix), node));
    let mut ends: Vec<usize> = order.into_iter().take(count.saturating_sub(1)).collect();
    ends.sort_unstable();
    ends.push(tree.nodes.len());
    let starts = core::iter::once(0).chain(ends.iter().map(|&end| end + 1));
    starts.zip(&ends).map(|(start, &end)| start..end + 1).collect()
}

/// A map's leaves and the nodes of a cut.
#[derive(Clone, Debug)]
pub struct Cut<R = f64> {
    /// The texels that are leaves, in the order of their keys.
    pub texels: Vec<usize>,
    /// The tree over them.
    pub tree: Tree,
    /// Sums over them.
    pub sums: Sums<R>,
    /// The ranges of leaves of its nodes, one after the other.
    pub nodes: Vec<Range<usize>>,
}

/// A cut of at most `count` nodes, at least 1; without lit texels it has none.
pub fn cut<R: Real>(map: &Map<'_, R>, count: usize) -> Cut<R> {
    cut_by(map, count, DIRECTIONS)
}

/// The same with another weight of directions.
#[expect(clippy::cast_possible_truncation, reason = "the device has f32")]
pub fn cut_by<R: Real>(map: &Map<'_, R>, count: usize, directions: f64) -> Cut<R> {
    let mut lit = Vec::new();
    for texel in places(map.size).into_iter().flatten() {
        let of = CentralMoments::of_texel(map, [texel % map.size[0], texel / map.size[0]]);
        if of.lit() {
            lit.push((texel, of));
        }
    }
    let fold = |join: fn(f32, f32) -> f32| {
        lit.iter().fold([join(f32::NAN, f32::NAN); 3], |all, (_, of)| {
            let mean = of.mean.value().to_array();
            core::array::from_fn(|axis| join(all[axis], mean[axis] as f32))
        })
    };
    let grid = Grid::around(fold(f32::min), fold(f32::max));
    let key = |(texel, of): &(usize, CentralMoments<R>)| {
        Key::of(of.mean, map.texels[*texel].normal.value(), &grid).key
    };
    // Stable: equal keys stay in the order of their places.
    lit.sort_by_cached_key(key);
    let keys: Vec<u32> = lit.iter().map(key).collect();
    debug_assert!(keys.iter().all(|&key| key != UNLIT));
    let (texels, leaves): (Vec<usize>, Vec<CentralMoments<R>>) = lit.into_iter().unzip();
    let sums = Sums::of_leaves(&leaves);
    if texels.is_empty() {
        return Cut { texels, tree: Tree::of_keys(&[]), sums, nodes: Vec::new() };
    }
    let tree = Tree::of_keys(&keys);
    let all = sums.all();
    let costs: Vec<f32> = tree
        .nodes
        .iter()
        .map(|node| cost(&sums.of(node.leaves.clone()), &all, directions).value() as f32)
        .collect();
    let nodes = ranges(&tree, &effective(&tree, &costs), count);
    Cut { texels, tree, sums, nodes }
}

impl<R: Real> Cut<R> {
    /// Its lights.
    #[must_use]
    pub fn lights(&self, map: &Map<'_, R>) -> Vec<Vsgl<R>> {
        let light =
            |leaves: &Range<usize>| self.sums.of(leaves.clone()).light(map.origin, &map.emission);
        self.nodes.iter().map(light).collect()
    }
}

/// The lights of a cut of `count` nodes; where a map has fewer lit texels, the rest are lights without power.
pub fn lights<R: Real>(map: &Map<'_, R>, count: usize) -> Vec<Vsgl<R>> {
    let mut lights = cut(map, count).lights(map);
    lights.resize(count, CentralMoments::nothing().light(map.origin, &map.emission));
    lights
}

//! The binary tree of sorted keys.

use core::ops::Range;

/// An inner node. Its number is that of the last leaf of its left child: each gap between two leaves is where one node splits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Node {
    /// Its leaves.
    pub leaves: Range<usize>,
    /// The length of the prefix that the keys of all its leaves share; with equal keys 32 plus that of their numbers.
    pub prefix: u32,
    /// The node above; the root has none.
    pub parent: Option<usize>,
}

/// The inner nodes of a tree, one less than there are leaves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tree {
    /// Node i splits between leaf i and leaf i + 1.
    pub nodes: Vec<Node>,
}

/// The length of the prefix that two leaves' keys share. Ties between equal keys are broken by the leaves' numbers.
// [Karras 2012, Section 4]
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "a map has fewer texels than 2^32")]
pub fn shared_prefix(keys: &[u32], a: usize, b: usize) -> u32 {
    match keys[a] ^ keys[b] {
        0 => 32 + (a as u32 ^ b as u32).leading_zeros(),
        difference => difference.leading_zeros(),
    }
}

impl Tree {
    /// The tree of sorted keys.
    ///
    /// A node's leaves are those whose keys share with its own leaf at least the prefix that the two leaves beside its gap
    /// share, and its parent is the one of the two gaps at its ends whose leaves share the longer prefix.
    // [Karras 2012; Apetrei 2014]
    #[must_use]
    pub fn of_keys(keys: &[u32]) -> Self {
        let gaps = keys.len().saturating_sub(1);
        let prefix: Vec<u32> = (0..gaps).map(|gap| shared_prefix(keys, gap, gap + 1)).collect();
        let node = |gap: usize| {
            let within = |other: usize| shared_prefix(keys, gap, other) >= prefix[gap];
            let first = (0..gap).rev().take_while(|&other| within(other)).last().unwrap_or(gap);
            let last = (gap + 1..keys.len()).take_while(|&other| within(other)).last();
            let last = last.unwrap_or(gap + 1);
            let before = first.checked_sub(1);
            let after = (last < gaps).then_some(last);
            let parent = match (before, after) {
                (Some(a), Some(b)) => Some(if prefix[a] > prefix[b] { a } else { b }),
                (a, b) => a.or(b),
            };
            Node { leaves: first..last + 1, prefix: prefix[gap], parent }
        };
        Self { nodes: (0..gaps).map(node).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::stress::Random;

    /// Splits at the highest differing bit, from the top, by looking at every bit; shares no code with the tree.
    fn split(
        keys: &[u64],
        first: usize,
        bit: u32,
        parent: Option<usize>,
        found: &mut Vec<(usize, Node)>,
    ) {
        if keys.len() < 2 {
            return;
        }
        let ones = keys.iter().filter(|&&key| key >> bit & 1 == 1).count();
        if ones == 0 || ones == keys.len() {
            return split(keys, first, bit.saturating_sub(1), parent, found);
        }
        let left = keys.len() - ones;
        let gap = first + left - 1;
        let leaves = first..first + keys.len();
        found.push((gap, Node { leaves, prefix: 63 - bit, parent }));
        split(&keys[..left], first, bit.saturating_sub(1), Some(gap), found);
        split(&keys[left..], first + left, bit.saturating_sub(1), Some(gap), found);
    }

    #[test]
    fn is_the_tree_of_splits_from_the_top() {
        let mut random = Random::new(7);
        for (length, bits) in [(1, 8), (2, 0), (3, 32), (100, 3), (500, 32), (777, 9), (64, 0)] {
            let mut keys: Vec<u32> = (0..length)
                .map(|_| if bits == 0 { 5 } else { random.bits() >> (32 - bits) })
                .collect();
            keys.sort_unstable();
            let tree = Tree::of_keys(&keys);
            let long: Vec<u64> =
                (0..).zip(&keys).map(|(at, &key)| u64::from(key) << 32 | at).collect();
            let mut found = Vec::new();
            split(&long, 0, 63, None, &mut found);
            found.sort_by_key(|&(gap, _)| gap);
            assert_eq!(found.len(), tree.nodes.len());
            for ((gap, node), own) in found.iter().zip(&tree.nodes) {
                assert_eq!(node, own, "gap {gap} of {length} keys of {bits} bits");
            }
            if length > 1 {
                assert_eq!(tree.nodes.iter().filter(|node| node.parent.is_none()).count(), 1);
            }
        }
        assert_eq!(Tree::of_keys(&[]).nodes, []);
    }
}

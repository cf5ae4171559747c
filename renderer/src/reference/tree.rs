//! The tree over a map's lit texels that a cut for each tile refines, read back from the device.

use sglow_oracle::Vector3;
use sglow_oracle::cut::{Branch, LightTree};
use sglow_oracle::vsgl::Vsgl;
use sglow_runtime::indirect::Indirect;
use sglow_runtime::settings::Settings;
use sglow_shaders::Lobes;

use super::lights_of;
use crate::device::{DeviceError, Gpu};
use crate::readback;

/// What the buffers of the tree hold. A node is an index: of an inner node below `places`, of a leaf from there on.
pub struct TreeBuffers {
    /// The light of each node.
    pub lights: Vec<Vsgl>,
    /// Two children of each node, of a leaf itself.
    pub children: Vec<[u32; 2]>,
    /// Power of each node.
    pub power: Vec<f32>,
    /// Spread of the normals of each node.
    pub spread: Vec<f32>,
    /// Power that each node emits specularly; 0 without specular lobes.
    pub specular_power: Vec<f32>,
    /// The corners of the box around the leaves of each node, relative to its position.
    pub bounds: Vec<[Vector3; 2]>,
    /// The node of each light of the global cut, all bits set where there is none, and the root of the tree.
    pub roots: Vec<u32>,
    /// The inner nodes as the pass cut_tree writes them: first and last leaf, and what else it holds.
    pub nodes: Vec<[u32; 4]>,
    /// Number of leaves.
    pub leaves: usize,
    /// Number of places of the map's square.
    pub places: usize,
}

impl TreeBuffers {
    /// Reads the buffers of a frame with a cut for each tile; none without one.
    ///
    /// # Errors
    /// [`DeviceError`] when the device fails.
    pub fn read(gpu: &Gpu, indirect: &Indirect) -> Result<Option<Self>, DeviceError> {
        let words = |name: &str| {
            let buffer = indirect.buffer(name);
            buffer.map(|buffer| readback::buffer::<u32>(gpu, &buffer)).transpose()
        };
        let (Some(branches), Some(roots), Some(nodes), Some(leaves), Some(lights)) = (
            words("branches")?,
            words("roots")?,
            words("nodes")?,
            words("leaf_count")?,
            indirect.buffer("cut_vsgls"),
        ) else {
            return Ok(None);
        };
        let &Settings { lobes, precision, .. } = indirect.settings();
        let rows = || branches.chunks_exact(12);
        let both = lobes == Lobes::Both;
        let corner = |row: &[u32], at: usize| {
            let part = |axis: usize| f64::from(f32::from_bits(row[at + axis]));
            Vector3::new(part(0), part(1), part(2))
        };
        Ok(Some(Self {
            lights: lights_of(gpu, &lights, lobes, precision)?,
            children: rows().map(|row| [row[0], row[1]]).collect(),
            power: rows().map(|row| f32::from_bits(row[2])).collect(),
            spread: rows().map(|row| f32::from_bits(row[3])).collect(),
            specular_power: rows()
                .map(|row| if both { f32::from_bits(row[7]) } else { 0.0 })
                .collect(),
            bounds: rows().map(|row| [corner(row, 4), corner(row, 8)]).collect(),
            roots,
            places: nodes.len() / 4,
            nodes: nodes.chunks_exact(4).map(|row| [row[0], row[1], row[2], row[3]]).collect(),
            leaves: leaves.first().map_or(0, |&count| count as usize),
        }))
    }

    /// The nodes that there are.
    pub fn all(&self) -> impl Iterator<Item = usize> + '_ {
        let leaves = self.places..self.places + self.leaves;
        (0..self.leaves.saturating_sub(1)).chain(leaves)
    }

    /// The first and the last leaf below a node.
    #[must_use]
    pub fn range(&self, node: usize) -> [usize; 2] {
        if node >= self.places {
            return [node - self.places; 2];
        }
        [self.nodes[node][0] as usize, self.nodes[node][1] as usize]
    }

    /// The device's own numbers, for the oracle.
    #[must_use]
    pub fn tree(&self) -> LightTree {
        let mut exists = vec![false; 2 * self.places];
        self.all().for_each(|node| exists[node] = true);
        let branch = |node: usize| Branch {
            children: (exists[node] && node < self.places)
                .then(|| self.children[node].map(|child| child as usize)),
            power: f64::from(self.power[node]),
            spread: f64::from(self.spread[node]),
            specular_power: f64::from(self.specular_power[node]),
            bounds: self.bounds[node],
        };
        let node = |root: &u32| (*root != u32::MAX).then_some(*root as usize);
        let count = self.roots.len().saturating_sub(1);
        LightTree {
            lights: self.lights.clone(),
            branches: (0..2 * self.places).map(branch).collect(),
            roots: self.roots[..count].iter().map(node).collect(),
            top: self.roots.last().and_then(node),
        }
    }
}

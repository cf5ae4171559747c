//! Transforms of nodes, in 64 bits: the `gltf` crate rounds them to 32, in which a node far from the origin is coarse.

use glam::{DMat4, DQuat, DVec3};
use serde::Deserialize;

/// The part of a document that has the transforms of its nodes.
#[derive(Deserialize)]
pub(super) struct Nodes {
    #[serde(default)]
    pub(super) nodes: Vec<Node>,
}

/// Where a node is in its parent's space. [glTF 2.0, section 3.5.3]
#[derive(Deserialize)]
pub(super) struct Node {
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

impl Node {
    /// From the node's space to its parent's.
    pub(super) fn transform(&self) -> DMat4 {
        if let Some(matrix) = &self.matrix {
            return DMat4::from_cols_array(matrix);
        }
        let rotation = DQuat::from_array(self.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
        DMat4::from_scale_rotation_translation(
            self.scale.map_or(DVec3::ONE, DVec3::from),
            rotation,
            self.translation.map_or(DVec3::ZERO, DVec3::from),
        )
    }
}

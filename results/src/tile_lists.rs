//! How long the lists of a cut for each tile of a picture are.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The lists of a cut for each tile of 8 by 8 pixels, without visibility.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TileLists {
    /// Tiles in a row of the picture.
    pub columns: usize,
    /// Number of nodes in the list of each tile, row by row from the top.
    pub lengths: Vec<usize>,
    /// Mean number of nodes that a pixel with a surface takes something of.
    pub mean: f64,
    /// The number that 95 % of these pixels stay below.
    pub below_95: usize,
    /// The maximum of these numbers.
    pub maximum: usize,
    /// Nodes that a list has room for.
    pub limit: usize,
    /// Tiles whose list had no more room, so that a node was not refined which should have been.
    pub stopped: usize,
}

impl TileLists {
    /// Number of nodes in the longest list.
    #[must_use]
    pub fn longest(&self) -> usize {
        self.lengths.iter().copied().max().unwrap_or(0)
    }
}

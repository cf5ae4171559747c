//! How long the lists of a cut for each tile are, and how far its picture is from all texels as lights.

use serde::Serialize;

use crate::picture_error::PictureError;

/// A cut of the light's map of one size.
#[derive(Clone, Debug, Serialize)]
pub struct CutOfMap {
    /// Width and height of the map in texels.
    pub map: u32,
    /// Lit texels: leaves of the tree.
    pub leaves: usize,
    /// Mean number of nodes that a pixel takes.
    pub nodes_mean: f64,
    /// The number that 95 % of the pixels stay below.
    pub nodes_95: usize,
    /// Number of nodes in the longest list of a tile.
    pub longest: usize,
    /// The picture against all texels as lights of the same emission, where the lights can be as many.
    pub error: Option<CutError>,
}

/// What a cut does to a picture.
#[derive(Clone, Debug, Serialize)]
pub struct CutError {
    /// By every metric.
    pub picture: PictureError,
    /// The largest change of the cut's relative error between neighbouring pixels of one surface, tile borders included.
    pub jump: f64,
    /// What that change is below for 99.9 % of these neighbours.
    pub jump_999: f64,
}

/// Cuts of one scene.
#[derive(Clone, Debug, Serialize)]
pub struct CutsOnScene {
    /// The scene.
    pub scene: String,
    /// By the size of the map.
    pub maps: Vec<CutOfMap>,
}

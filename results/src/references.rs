//! The errors of the references themselves.

use serde::Serialize;

/// Texels on a side of the maps whose facets are compared.
pub const MAPS: [u32; 3] = [128, 256, 512];

/// Texels on a side of the map that they are compared with.
pub const FINEST: u32 = 1024;

/// Width and height of the pictures.
pub const SIZE: [u32; 2] = [56, 32];

/// Paths for each pixel.
pub const PATHS: u32 = 4096;

/// The noise of paths, over the mean of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Noise {
    /// As the standard errors of the pixels state it, root mean square.
    pub stated: f64,
    /// As the two halves differ.
    pub by_halves: f64,
}

/// The facets of a map against those of the finest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MapError {
    /// Texels on a side.
    pub map: u32,
    /// RMSE over the mean.
    pub rmse_over_mean: f64,
    /// Median of the relative error.
    pub median: f64,
}

/// The errors of both references on one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReferenceErrors {
    /// The scene.
    pub scene: String,
    /// The sum over facets, by the size of the map.
    pub facets: Vec<MapError>,
    /// Paths by directions alone.
    pub by_directions: Noise,
    /// Paths that the light's map guides.
    pub guided: Noise,
}

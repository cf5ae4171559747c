//! Filtering kernels on a density.

use serde::Serialize;

/// A kernel's place in pixels of the density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Square {
    /// Centre, x to the right and y down from the top left corner.
    pub centre: [f64; 2],
    /// Side.
    pub side: f64,
}

/// A kernel on a density.
#[derive(Clone, Debug, Serialize)]
pub struct Placed {
    /// In pixels of the image, from its top left corner.
    pub centre: [f64; 2],
    /// The level of the mip chain, which the solver found.
    pub level: f64,
    /// In pixels: 2^level.
    pub side: f64,
    /// The density's sum within the square, over the sum of all, times N.
    pub mass: f64,
    /// The left side of Eq. (3) times N: the same as filtering sees it.
    pub filtered_mass: f64,
    /// Times the filtered power per texel, it is the kernel's power.
    pub weight: f64,
    /// Of a total of 1 that is spread as the density is.
    pub power: f64,
    /// Levels that solve Eq. (3) for K.
    pub roots: Vec<f64>,
}

/// What one way to size kernels makes of a density.
#[derive(Clone, Debug, Serialize)]
pub struct Sizing {
    /// How kernels are sized.
    pub kernel: &'static str,
    /// Standard deviation over mean of the masses.
    pub mass_variation: f64,
    /// The largest mass, times N.
    pub largest_mass: f64,
    /// The brightest light's power times N: 1 is ideal.
    pub brightest: f64,
    /// Sum of all lights' power, of a total of 1.
    pub power: f64,
    /// The share of kernels for which Eq. (3) has no solution.
    pub without_root: f64,
    /// The share of kernels for which it has several.
    pub several_roots: f64,
    /// Each kernel.
    pub kernels: Vec<Placed>,
}

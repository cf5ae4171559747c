//! One frame of a scene by every method.

use serde::Serialize;

use super::method::Method;
use super::overlap::{Overlap, Weighted};

/// What remains when each light is replaced by the texels of its kernel, with their weights, as lit facets:
/// what the choice of kernels costs, whatever the form of a light.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Floor {
    /// RMSE over the mean, as that of the lights.
    pub error: f64,
    /// Relative MSE.
    pub relative_mse: f64,
    /// Median of the relative error.
    pub median: f64,
}

/// What one method makes of a frame.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The method.
    pub method: Method,
    /// K.
    pub size_factor: f32,
    /// How the density is shared out, kernels as their nominal squares.
    pub overlap: Overlap,
    /// The same by the weights of the filter.
    pub weighted: Weighted,
    /// The lights' summed power over that of the photons.
    pub power: f64,
    /// The brightest light's power times their number, over that of the photons: 1 is even.
    pub brightest: f64,
    /// RMSE against the facets of the map on a sample of pixels, without visibility, over their mean.
    pub error: f64,
    /// Relative MSE there.
    pub relative_mse: f64,
    /// Median of the relative error there.
    pub median: f64,
    /// Its 95 % quantile.
    pub q95: f64,
    /// Mean over mean of the reference, less 1.
    pub bias: f64,
    /// The error of the texels of the kernels, summed exactly. None of clusters, whose texels are those of the map.
    pub floor: Option<Floor>,
    /// Numbers that were not finite.
    pub not_finite: usize,
}

/// A frame by every method.
#[derive(Clone, Debug, Serialize)]
pub struct Survey {
    /// Pixels with a reference.
    pub pixels: usize,
    /// Whether no light reaches anything, so that all is black.
    pub dark: bool,
    /// Each method.
    pub rows: Vec<Row>,
}

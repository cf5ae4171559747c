//! What was measured of a scene, as it stands in `report.json`, where an error that is not finite is null.

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::picture_error::{Metric, PictureError, Radiance, Uncertainty};
use crate::tile_lists::TileLists;
use crate::time::Time;

/// One pass of a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Pass {
    /// What it is called.
    pub name: String,
    /// How long it takes.
    pub time: Time,
}

/// A picture's worst pixel, and what was shaded there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Worst {
    /// Column and row, from the top left, from 0.
    pub pixel: [u32; 2],
    /// Indirect radiance that was found there, linear Rec. 709.
    pub found: [f64; 3],
    /// What should have been there.
    pub expected: [f64; 3],
    /// The texels of position, normal and base colour that were shaded, as the bits of their 32-bit floats in
    /// hexadecimal.
    pub surface: [[String; 4]; 3],
}

/// How far the device is from the oracle's f64 with the same virtual lights, on a sample of pixels: rounding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Rounding {
    /// Root of the mean squared difference over the mean.
    #[schemars(with = "Option<f64>")]
    pub rms_over_mean: f64,
    /// The pixel that is furthest off.
    pub worst: Worst,
}

/// What dominates a configuration by one metric: it is as fast and as good, and better in one of both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Dominated {
    /// The name of the configuration on the frontier that dominates it.
    pub by: String,
    /// Its time over that of the one that dominates it.
    #[schemars(with = "Option<f64>")]
    pub time_ratio: f64,
    /// Its error over that of the one that dominates it.
    #[schemars(with = "Option<f64>")]
    pub error_ratio: f64,
    /// Whether the spreads of both times are apart; if they are not, the times may be the same.
    pub clear: bool,
}

/// A configuration of indirect light, measured: a value on each axis and of each parameter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Configuration {
    /// What it is called; no other configuration of the scene is called so.
    pub name: String,
    /// The value on each axis.
    pub axes: BTreeMap<String, String>,
    /// Numbers beside the axes, by name, as `--set` takes them.
    pub parameters: BTreeMap<String, String>,
    /// The variants that make its lights and reflect them.
    pub variants: Vec<String>,
    /// Whether it is what the scene gets if nobody chooses.
    pub default: bool,
    /// Whether it has all that the scene needs; what has not leaves light out.
    pub complete: bool,
    /// Each pass from the maps to reflected light.
    pub passes: Vec<Pass>,
    /// Their sum.
    pub time: Time,
    /// All passes again as one frame, in turns with those that it is compared with: on the frontier alone, and of
    /// frames of at most a second.
    pub whole: Option<Time>,
    /// Bytes of each texture and buffer that it keeps, by name.
    pub bytes: BTreeMap<String, u64>,
    /// How far its picture is from the reference with visibility: what is seen.
    pub picture: PictureError,
    /// How far it is from the reference without visibility, of which every texel of the light's map is a facet. None
    /// with visibility.
    pub unshadowed: Option<PictureError>,
    /// The pixel that is furthest off the reference with visibility.
    pub worst: Worst,
    /// Root of the mean squared difference of the oracle with the same lights from the sum over all facets of the
    /// light's map, over the mean, neither with visibility, on a sample of pixels: the error of the model. None with
    /// visibility.
    pub model_rms_over_mean: Option<f64>,
    /// The device against the oracle. None with visibility, whose maps the tests hold.
    pub rounding: Option<Rounding>,
    /// How much more it changes from frame to frame under a moving light than it has to, over the mean: on the
    /// frontier alone, and of frames of at most four seconds.
    pub flicker: Option<f64>,
    /// The metrics by which it is on the frontier: no other configuration dominates it.
    pub frontiers: BTreeSet<Metric>,
    /// What dominates it by each of the other metrics.
    pub dominated: BTreeMap<Metric, Dominated>,
}

impl Configuration {
    /// Whether no other configuration dominates it by a metric.
    #[must_use]
    pub fn on_frontier(&self, metric: Metric) -> bool {
        self.frontiers.contains(&metric)
    }

    /// Whether it is looked at closely: on the frontier by some metric, or the default.
    #[must_use]
    pub fn is_shown(&self) -> bool {
        self.default || !self.frontiers.is_empty()
    }
}

/// The reference of a scene, paths of one bounce from the camera with exact visibility, and how far it may be off
/// itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Reference {
    /// Paths of each pixel.
    pub samples: u32,
    /// Mean of its indirect light over all numbers.
    pub mean: f64,
    /// Root mean square of its standard error over its mean, or absolute where it is dark.
    pub noise_over_mean: f64,
    /// Whether no indirect light reaches what the camera sees; then errors are absolute.
    pub dark: bool,
}

/// One measurement along a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepPoint {
    /// The number that is varied.
    pub at: f64,
    /// Of the passes that the number bears on; none of what is modelled.
    pub time: Option<Time>,
    /// How far the picture is from the reference; none of what is modelled.
    pub picture: Option<PictureError>,
    /// RMS difference from the limit of the same configuration, over its mean: the error that the number is to blame
    /// for.
    pub own_rms_over_mean: Option<f64>,
    /// How much more it changes from frame to frame under a moving light than it has to, over the mean: of sizes of
    /// kernels alone.
    pub flicker: Option<f64>,
}

/// One line of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Series {
    /// What it is called.
    pub name: String,
    /// In ascending order.
    pub points: Vec<SweepPoint>,
    /// From here on more does not pay: the least number whose RMSE is within 1 % of the best.
    pub pays_until: Option<f64>,
}

/// Error and time against one number, all else as the scene's default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Sweep {
    /// What is varied.
    pub over: SweepOver,
    /// What `own_rms_over_mean` is the difference from.
    pub limit: String,
    /// The lines.
    pub series: Vec<Series>,
}

/// What a sweep varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SweepOver {
    /// Bisection steps of Algorithm 1. [Tokuyoshi 2016]
    Iterations,
    /// K, the size of kernels.
    SizeFactor,
    /// The number of virtual lights, or of a cut's roots.
    Lights,
    /// Width and height of the light's map in texels.
    Map,
}

/// What a frame costs with everything, or with what the scene needs alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Side {
    /// The shading variant.
    pub shade: String,
    /// Bytes of textures that indirect light keeps in a frame, the maps it reads apart.
    pub texture_bytes: u64,
    /// Bytes of buffers.
    pub buffer_bytes: u64,
    /// The shading pass.
    pub shade_time: Time,
    /// The whole frame: surfaces, direct and indirect light, the picture.
    pub time: Time,
    /// Each of its passes.
    pub passes: Vec<Pass>,
}

/// What kernels cost by the texels that they put together, on a sample of pixels without visibility, against the sum
/// over all texels of the map: the scene's default numbers, drawn by power.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Straddling {
    /// K.
    pub size_factor: f64,
    /// Relative MSE of the lights.
    #[schemars(with = "Option<f64>")]
    pub lights_relative_mse: f64,
    /// Median of their relative error.
    #[schemars(with = "Option<f64>")]
    pub lights_median: f64,
    /// Relative MSE of the same kernels with their texels summed exactly, each by its weight.
    #[schemars(with = "Option<f64>")]
    pub texels_relative_mse: f64,
    /// Median of their relative error.
    #[schemars(with = "Option<f64>")]
    pub texels_median: f64,
}

/// What leaving out saves, measured in turns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Pruned {
    /// With everything.
    pub full: Side,
    /// With what the scene needs.
    pub needed: Side,
    /// Pixels of the picture that both were measured at.
    pub size: [u32; 2],
    /// Numbers of the composed pictures whose bits differ.
    pub differing: usize,
    /// The axes on which both differ, each with the passes that depend on it.
    #[serde(default)]
    pub axes: BTreeMap<String, BTreeSet<String>>,
}

/// What screening kept of an axis or a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Kept {
    /// The axis or the parameter.
    pub axis: String,
    /// The values that were crossed with those of the other axes.
    pub values: Vec<String>,
    /// Values on the axis' own frontier that were not crossed, since there would have been too many configurations:
    /// those that change time and error the least.
    pub cut: Vec<String>,
    /// Values that others of the axis dominate, on every scene of the run.
    pub dominated: Vec<String>,
}

/// How the configurations came about: one axis at a time about the default, then what is on its own frontier by
/// relative MSE crossed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Screening {
    /// Configurations that differ from the default in one axis or parameter.
    pub single: usize,
    /// Configurations of values that were crossed.
    pub crossed: usize,
    /// What became of each axis and parameter.
    pub axes: Vec<Kept>,
    /// Configurations that promises are about, by what they are, with their names.
    pub named: BTreeMap<String, String>,
}

/// All that was measured of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SceneReport {
    /// Its name.
    pub scene: String,
    /// Triangles.
    pub triangles: usize,
    /// Kind of its light.
    pub light: String,
    /// Pixels of the pictures.
    pub size: [u32; 2],
    /// Width and height of the light's map.
    pub rsm_size: u32,
    /// Virtual lights.
    pub lights: u32,
    /// Bisection steps, where there are any.
    pub iterations: u32,
    /// K.
    pub size_factor: f64,
    /// How times were taken.
    pub clock: String,
    /// Timed runs of each pass.
    pub runs: usize,
    /// What pictures are compared with.
    pub reference: Reference,
    /// Every configuration, those on the frontier by the default metric first, then by time.
    pub configurations: Vec<Configuration>,
    /// Error and time against numbers.
    pub sweeps: Vec<Sweep>,
    /// The lists of the default's tiles, where it is a cut for each tile.
    pub lists: Option<TileLists>,
    /// The error of lights beside that of their kernels' texels.
    pub straddling: Straddling,
    /// How the configurations were found; none if they were not screened.
    pub screening: Option<Screening>,
    /// What leaving out saves.
    pub pruned: Option<Pruned>,
    /// Numbers that were not finite, in all pictures.
    pub not_finite: usize,
}

/// The pictures that go with a scene's report.
#[derive(Clone, Debug, Default)]
pub struct Pictures {
    /// The whole reference: direct light, emission and the reference's indirect light.
    pub reference: Radiance,
    /// The same of configurations by their name: those of the frontier, and the default.
    pub configurations: BTreeMap<String, Radiance>,
    /// Nodes of a cut that each pixel of the default takes, row by row from the top; empty without a cut for each tile.
    pub nodes: Vec<f32>,
}

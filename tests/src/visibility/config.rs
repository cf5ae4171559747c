//! What maps of virtual lights are made of, with what no setting has.

use std::collections::BTreeMap;

use sglow_graph::Configuration;
use sglow_graph::description::Number;
use sglow_runtime::host;
use sglow_runtime::settings::{BIAS_SCALE, NEAR_SCALE, POINTS, Settings, TILE};
use sglow_shaders::{Lobes, Precision, Visibility};

/// Names and ranges are those of the frame's parameters.
#[derive(Clone, Debug)]
pub(super) struct Config {
    pub(super) visibility: Visibility,
    pub(super) lobes: Lobes,
    pub(super) precision: Precision,
    pub(super) count: u32,
    pub(super) tile: u32,
    pub(super) points: u32,
    /// How many texels a point's disc may reach from the texel of its centre.
    pub(super) reach: u32,
    /// How many times holes are filled from texels twice as wide.
    pub(super) levels: u32,
    pub(super) near_scale: f32,
    /// In world units.
    pub(super) least_near: f32,
    pub(super) bias_scale: f32,
}

impl Config {
    /// The defaults, for lights of a kind.
    pub(super) fn new(
        visibility: Visibility,
        lobes: Lobes,
        precision: Precision,
        count: u32,
    ) -> Self {
        Self {
            visibility,
            lobes,
            precision,
            count,
            tile: TILE,
            points: POINTS,
            reach: 2,
            levels: 0,
            near_scale: NEAR_SCALE,
            least_near: 1e-3,
            bias_scale: BIAS_SCALE,
        }
    }

    pub(super) fn bias(&self) -> f32 {
        host::bias(self.bias_scale, self.tile)
    }

    /// Columns of the atlas, in tiles.
    pub(super) fn columns(&self) -> u32 {
        1 << self.count.max(1).next_power_of_two().ilog2().div_ceil(2)
    }

    /// These settings with what they have of it.
    pub(super) fn settings(&self, settings: &Settings) -> Settings {
        Settings {
            visibility: self.visibility,
            lobes: self.lobes,
            precision: self.precision,
            count: self.count,
            light_tile: self.tile,
            shadow_points: self.points,
            near_scale: self.near_scale,
            bias_scale: self.bias_scale,
            ..settings.clone()
        }
    }

    /// The maps of lights and what reflects them.
    pub(super) fn configuration(&self, settings: &Settings) -> Configuration {
        let parts = ["visibility", "shading"].map(str::to_owned).into();
        let mut configuration = settings.configuration();
        let own = BTreeMap::from([("splat_reach", self.reach), ("fill_levels", self.levels)]);
        let own =
            own.into_iter().map(|(name, number)| (name.to_owned(), Number::Whole(number.into())));
        configuration.parameters.extend(own);
        Configuration { parts: Some(parts), ..configuration }
    }
}

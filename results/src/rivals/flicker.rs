//! Flicker under a moving light.

use serde::Serialize;

/// How long and on how much.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Walk {
    /// Frames, at least 2.
    pub frames: usize,
    /// Pixels that the reference is computed for, spread over the picture by chance.
    pub pixels: usize,
    /// Paths for each of them.
    pub samples: u32,
    /// How far the light moves in each frame, as a share of the scene's radius; a directional light turns by this many
    /// radians.
    pub step: f32,
}

impl Default for Walk {
    fn default() -> Self {
        Self { frames: 17, pixels: 1500, samples: 512, step: 0.001 }
    }
}

/// One contender's error and flicker, each over the mean of the reference.
#[derive(Clone, Debug, Serialize)]
pub struct Flicker {
    /// The contender.
    pub name: String,
    /// RMSE against the reference over all frames.
    pub error: f64,
    /// Its own change from frame to frame, RMS over the mean of the reference.
    pub change: f64,
    /// Root of the mean square of the difference between its change from frame to frame and the reference's own, of which
    /// the reference's noise is no part.
    pub flicker: f64,
    /// The same of the worst pair of frames.
    pub worst: f64,
    /// `flicker` without the twentieth of the pixels that change most.
    pub trimmed: f64,
    /// Numbers that were not finite.
    pub not_finite: usize,
}

/// What a walk found.
#[derive(Clone, Debug, Serialize)]
pub struct Flickers {
    /// The walk.
    pub walk: Walk,
    /// The reference's own change from frame to frame, RMS over its mean.
    pub reference_change: f64,
    /// Each contender.
    pub contenders: Vec<Flicker>,
}

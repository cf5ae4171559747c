//! What 16-bit precision costs in a scene.

use serde::Serialize;

/// What f16 leaves of f32 in one scene. Where there are two numbers they are of f32 and of f16.
#[derive(Clone, Debug, Serialize)]
pub struct HalvesReport {
    /// The scene.
    pub scene: &'static str,
    /// Bytes of moments and density with their mips, and of the virtual lights.
    pub bytes: [u64; 2],
    /// The largest angle between the axes of a lobe whose sharpness is at least 1, in radians.
    pub axis: f64,
    /// Milliseconds of each pass, median; nothing of a pass that is left out.
    pub passes: Vec<(String, [Option<f64>; 2])>,
    /// Each error against its bound.
    pub checks: Vec<HalfCheck>,
}

/// An error against its bound.
#[derive(Clone, Debug, Serialize)]
pub struct HalfCheck {
    /// What is wrong by so much.
    pub name: &'static str,
    /// By how much.
    pub value: f64,
    /// The most that it may be.
    pub at_most: f64,
    /// Why this much and no more.
    pub reason: &'static str,
}

impl HalfCheck {
    /// Whether the bound holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.value <= self.at_most
    }
}

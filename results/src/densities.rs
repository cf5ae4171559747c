//! Densities that stress the sampling pass: what each kind of kernel makes of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Check, Relation};

/// Width and height of the densities.
pub const SIZE: u32 = 256;

/// Kernels on each.
pub const COUNT: u32 = 1024;

/// What one method makes of one density.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct OnDensity {
    /// Its name.
    pub density: String,
    /// The kernel.
    pub kernel: String,
    /// How its size is found.
    pub solver: String,
    /// Summed power of the lights over that of the photons.
    pub power_ratio: f64,
    /// Power of the brightest light times their number, over that of the photons: 1 is ideal.
    pub brightest: f64,
    /// Of the sampling pass.
    pub milliseconds: f64,
}

impl OnDensity {
    /// The kernel and how its size is found.
    #[must_use]
    pub fn kind(&self) -> String {
        if self.solver == "none" {
            self.kernel.clone()
        } else {
            format!("{} {}", self.kernel, self.solver)
        }
    }
}

/// What is promised of kernels on densities of which a few texels hold almost all.
#[must_use]
pub fn checks(rows: &[OnDensity]) -> Vec<Check> {
    let extreme = rows.iter().filter(|row| ["ring", "noise-2"].contains(&row.density.as_str()));
    extreme
        .map(|row| {
            let error = (row.power_ratio - 1.0).abs();
            let (relation, note) = if row.kernel == "modified" {
                (Relation::AtMost, "keeps the power")
            } else {
                (Relation::AtLeast, "does not keep it, which is why")
            };
            let text = format!("power of {} kernels on {}, off by", row.kind(), row.density);
            Check::new(text, error, "of the total", relation, 0.03).note(note)
        })
        .collect()
}

/// The times of the sampling pass with kernels whose size a solver finds over those of the previous kernels on the same
/// density, by solver.
#[must_use]
pub fn sampling_times(rows: &[OnDensity]) -> Vec<(&str, Vec<f64>)> {
    let previous =
        |density: &str| rows.iter().find(|row| row.density == density && row.solver == "none");
    let mut times: Vec<(&str, Vec<f64>)> = Vec::new();
    for row in rows.iter().filter(|row| row.solver != "none") {
        let Some(previous) = previous(&row.density) else { continue };
        let ratio = row.milliseconds / previous.milliseconds;
        match times.iter_mut().find(|one| one.0 == row.solver) {
            Some((_, ratios)) => ratios.push(ratio),
            None => times.push((&row.solver, vec![ratio])),
        }
    }
    times
}

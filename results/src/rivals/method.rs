//! The methods that make virtual lights of a map.

use serde::Serialize;

/// Sizes of kernels K that are compared; the paper has 1, 4 and 16.
pub const SIZE_FACTORS: [f32; 8] = [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// A method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Kernels sized by the density at their centre.
    Previous,
    /// Kernels sized by the density's integral within them, by bisection as the paper has it.
    Modified,
    /// The same, by the bracketed solver.
    Bracketed,
    /// Clusters in the image.
    Image,
    /// Clusters in the world.
    World,
    /// Kernels sized as `Bracketed`, drawn by Markov chains.
    Metropolis,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Previous,
        Self::Modified,
        Self::Bracketed,
        Self::Image,
        Self::World,
        Self::Metropolis,
    ];

    /// What a person calls it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Previous => "previous",
            Self::Modified => "modified",
            Self::Bracketed => "modified, bracketed",
            Self::Image => "k-means (2D image space)",
            Self::World => "k-means (3D world space)",
            Self::Metropolis => "modified, Metropolis-Hastings",
        }
    }

    /// Whether it makes clusters and no kernels.
    #[must_use]
    pub fn clusters(self) -> bool {
        matches!(self, Self::Image | Self::World)
    }
}

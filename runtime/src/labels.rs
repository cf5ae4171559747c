//! What the times of the passes from a map to virtual lights are called.

/// What times are called.
#[derive(Clone, Copy)]
pub(crate) struct Labels {
    pub(crate) moments: &'static str,
    pub(crate) density: &'static str,
    pub(crate) mip_moments: &'static str,
    pub(crate) mip_half_moments: &'static str,
    pub(crate) mip_density: &'static str,
    pub(crate) sample: &'static str,
}

impl Labels {
    /// Of the light's map.
    pub(crate) const LIGHT: Self = Self {
        moments: "moments",
        density: "density",
        mip_moments: "mip moments",
        mip_half_moments: "mip half moments",
        mip_density: "mip density",
        sample: "sample",
    };
    /// Of the camera's.
    pub(crate) const CAMERA: Self = Self {
        moments: "camera moments",
        density: "camera density",
        mip_moments: "camera mip moments",
        mip_half_moments: "camera mip half moments",
        mip_density: "camera mip density",
        sample: "camera sample",
    };
}

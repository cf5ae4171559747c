//! The lights of a scene.

use std::f32::consts::{FRAC_PI_2, PI};
use std::path::Path;

use glam::Vec3;

use super::{Bounds, SceneError};

/// The widest outer half angle of a spot light in radians, 89 degrees: its map is a perspective
/// image, whose half extent grows with the tangent.
pub(super) const WIDEST: f32 = 89.0 * PI / 180.0;

/// A light without extent.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Its name, or `light` and its number.
    pub name: String,
    /// Its kind.
    pub kind: LightKind,
    /// World position; meaningless for directional lights.
    pub position: [f32; 3],
    /// Where it shines, of unit length; meaningless for point lights.
    pub direction: [f32; 3],
    /// Linear Rec. 709. Spot and point: radiant intensity (W/sr, or candela). Directional:
    /// irradiance on a facing surface (W/m^2, or lux).
    pub intensity: [f32; 3],
    /// Where the light is cut off, if anywhere, in scene units.
    pub range: Option<f32>,
    /// Among several lights the share of its tile's width that the light's map has, above 0 to 1.
    pub map_share: f32,
}

/// The kinds of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// A cone. Both angles are measured from its axis, in radians, `0 <= inner < outer < pi/2`.
    Spot {
        /// Full intensity within.
        inner: f32,
        /// No intensity without.
        outer: f32,
    },
    /// Parallel light, from infinitely far away.
    Directional,
    /// The same in all directions.
    Point,
}

impl Light {
    /// The light of a scene that has none: a spot light from above the box that lights all of it,
    /// with an irradiance of pi in the middle, so that a white surface there has radiance 1.
    pub(super) fn above(bounds: &Bounds) -> Self {
        let radius = bounds.radius().max(f32::MIN_POSITIVE);
        let from = Vec3::new(0.25, 1.0, 0.35).normalize();
        let distance = 2.5 * radius;
        let outer = (radius / distance).asin();
        Self {
            name: "derived".to_owned(),
            kind: LightKind::Spot { inner: 0.8 * outer, outer },
            position: (Vec3::from(bounds.center()) + from * distance).into(),
            direction: (-from).into(),
            intensity: [PI * distance * distance; 3],
            range: None,
            map_share: 1.0,
        }
    }

    /// Whether it has no power.
    pub(super) fn is_off(&self) -> bool {
        self.intensity.iter().all(|&channel| channel == 0.0)
    }

    /// What is wrong with the light, if anything.
    pub(super) fn fault(&self, file: &Path) -> Option<SceneError> {
        let (file, light) = (file.into(), self.name.clone());
        if self.is_off() {
            return Some(SceneError::ZeroPower { file, light });
        }
        let reason = if !self.intensity.iter().all(|&channel| channel >= 0.0 && channel.is_finite())
        {
            format!("its intensity {:?} is not finite and non-negative", self.intensity)
        } else if !Vec3::from(self.position).is_finite() {
            format!("its position {:?} is not finite", self.position)
        } else if !Vec3::from(self.direction).is_normalized() {
            format!("its direction {:?} is not a direction", self.direction)
        } else if !(self.map_share > 0.0 && self.map_share <= 1.0) {
            format!("its `map_share` {} is not above 0 and at most 1", self.map_share)
        } else if let LightKind::Spot { inner, outer } = self.kind
            && !(0.0 <= inner && inner < outer && outer < FRAC_PI_2)
        {
            format!(
                "its cone of {} to {} degrees does not hold 0 <= inner < outer < 90",
                inner.to_degrees(),
                outer.to_degrees()
            )
        } else {
            return None;
        };
        Some(SceneError::Light { file, light, reason })
    }
}

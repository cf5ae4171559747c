//! The box around a scene.

use glam::Vec3;

/// An axis-aligned box, both corners included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The smallest coordinates.
    pub min: [f32; 3],
    /// The largest coordinates.
    pub max: [f32; 3],
}

impl Bounds {
    /// The box around `points`; of no points, the origin.
    pub fn around(points: impl IntoIterator<Item = [f32; 3]>) -> Self {
        let mut points = points.into_iter().map(Vec3::from);
        let first = points.next().unwrap_or(Vec3::ZERO);
        let (min, max) =
            points.fold((first, first), |(min, max), point| (min.min(point), max.max(point)));
        Self { min: min.into(), max: max.into() }
    }

    /// The middle of the box.
    pub fn center(&self) -> [f32; 3] {
        // Halved before the sum: two huge coordinates must not overflow.
        (Vec3::from(self.min) * 0.5 + Vec3::from(self.max) * 0.5).into()
    }

    /// The radius of the sphere around the box.
    pub fn radius(&self) -> f32 {
        (Vec3::from(self.max) * 0.5 - Vec3::from(self.min) * 0.5).length()
    }
}

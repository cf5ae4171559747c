//! The camera of a scene.

use std::path::Path;

use glam::Vec3;

use super::{Bounds, SceneError};

/// A perspective camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World position.
    pub position: [f32; 3],
    /// Where it looks, of unit length.
    pub forward: [f32; 3],
    /// Up in the picture, of unit length and at right angles to `forward`.
    pub up: [f32; 3],
    /// The full angle between the picture's lower and upper edge, in radians, within (0, pi).
    pub vertical_fov: f32,
    /// Distance of the near plane; `None` leaves it to the viewer.
    pub near: Option<f32>,
    /// Distance of the far plane; `None` leaves it to the viewer.
    pub far: Option<f32>,
}

impl Camera {
    /// A camera at `position` that looks at `target`. `up` need not be at right angles to the view;
    /// where it is along the view, another is chosen.
    pub fn look_at(position: [f32; 3], target: [f32; 3], up: [f32; 3], vertical_fov: f32) -> Self {
        let forward = (Vec3::from(target) - Vec3::from(position)).normalize_or(Vec3::NEG_Z);
        Self::along(position, forward, Vec3::from(up), vertical_fov)
    }

    /// A camera at `position` that looks along the unit vector `forward`.
    pub(super) fn along(position: [f32; 3], forward: Vec3, up: Vec3, vertical_fov: f32) -> Self {
        let right = forward.cross(up).try_normalize();
        let right = right.unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        Self {
            position,
            forward: forward.into(),
            up: up.into(),
            vertical_fov,
            near: None,
            far: None,
        }
    }

    /// The camera of a scene that has none: outside the box, a little above it, the whole box in the
    /// picture.
    pub(super) fn around(bounds: &Bounds) -> Self {
        const VERTICAL_FOV: f32 = 45.0 * std::f32::consts::PI / 180.0;
        let from = Vec3::new(0.5, 0.4, 1.0).normalize();
        let distance = bounds.radius().max(f32::MIN_POSITIVE) / (VERTICAL_FOV * 0.5).sin();
        let position = Vec3::from(bounds.center()) + from * distance;
        Self::along(position.into(), -from, Vec3::Y, VERTICAL_FOV)
    }

    /// A camera whose picture is a part of this one's: its middle at `at`, within -1 to 1 from left to right and from the
    /// lower edge to the upper one, `share` as wide and as high. Its plane is turned to that middle, so that it is
    /// exact in the middle alone.
    ///
    /// ```
    /// use sglow_scene::Camera;
    /// let camera = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], 1.0);
    /// let same = camera.window([0.0; 2], 1.0, 1.5);
    /// assert!((same.vertical_fov - camera.vertical_fov).abs() < 1e-6 && same.forward == camera.forward);
    /// ```
    #[must_use]
    pub fn window(&self, at: [f32; 2], share: f32, aspect: f32) -> Self {
        let (forward, up) = (Vec3::from(self.forward), Vec3::from(self.up));
        let half = (0.5 * self.vertical_fov).tan();
        let toward = forward + half * (at[0] * aspect * forward.cross(up) + at[1] * up);
        // What is seen along the middle is as much nearer than the plane as that is turned away.
        let own = share * half / toward.length();
        let window = Self::along(self.position, toward.normalize_or(forward), up, 2.0 * own.atan());
        Self { near: self.near, far: self.far, ..window }
    }

    /// What is wrong with the camera, if anything.
    pub(super) fn fault(&self, file: &Path) -> Option<SceneError> {
        let angle = self.vertical_fov;
        let reason = if !(angle > 0.0 && angle < std::f32::consts::PI) {
            format!("its vertical angle of {} degrees is not between 0 and 180", angle.to_degrees())
        } else if !Vec3::from(self.position).is_finite() {
            format!("its position {:?} is not finite", self.position)
        } else if !Vec3::from(self.forward).is_normalized() {
            format!("its direction {:?} is not a direction", self.forward)
        } else {
            return None;
        };
        Some(SceneError::Camera { file: file.into(), reason })
    }

    /// Near and far plane for a scene with these bounds: those given, else as tight as the box
    /// allows, the near plane at least a thousandth of its radius away.
    pub fn planes(&self, bounds: &Bounds) -> (f32, f32) {
        let radius = bounds.radius().max(f32::MIN_POSITIVE);
        let away = Vec3::from(self.position).distance(Vec3::from(bounds.center()));
        let near = self.near.unwrap_or((away - radius).max(radius * 1e-3));
        let far = self.far.unwrap_or((away + radius) * 1.001);
        (near, far.max(near * 2.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a camera's picture has a direction.
    fn place(camera: &Camera, toward: Vec3, aspect: f32) -> [f32; 2] {
        let (forward, up) = (Vec3::from(camera.forward), Vec3::from(camera.up));
        let half = (0.5 * camera.vertical_fov).tan() * toward.dot(forward);
        [toward.dot(forward.cross(up)) / (half * aspect), toward.dot(up) / half]
    }

    #[test]
    fn a_window_is_a_part_of_the_picture() {
        let camera = Camera::look_at([1.0, 2.0, 3.0], [0.2, 0.0, -1.0], [0.0, 1.0, 0.0], 0.9);
        let (aspect, share, at) = (16.0 / 9.0, 0.125, [0.5, -0.5]);
        let window = camera.window(at, share, aspect);
        let [x, y] = place(&camera, window.forward.into(), aspect);
        assert!((x - at[0]).abs() < 1e-5 && (y - at[1]).abs() < 1e-5, "{x} {y}");
        // Its edges; its plane is turned by 26 degrees, with which 1/cos is 1.11.
        let (forward, up) = (Vec3::from(window.forward), Vec3::from(window.up));
        let half = (0.5 * window.vertical_fov).tan();
        let [right, _] = place(&camera, forward + half * aspect * forward.cross(up), aspect);
        let [_, above] = place(&camera, forward + half * up, aspect);
        for (found, expected) in [(right - at[0], share), (above - at[1], share)] {
            assert!((found / expected - 1.0).abs() < 0.15, "{found} {expected}");
        }
        // Negative control: the window in the middle.
        let middle = camera.window([0.0; 2], share, aspect);
        assert!(place(&camera, middle.forward.into(), aspect)[0].abs() < 1e-5);
    }
}

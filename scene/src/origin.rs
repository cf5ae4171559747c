//! What the positions of a scene are relative to.
//!
//! 32-bit floats are coarse far from 0: at 1e6 units their steps are a sixteenth. So positions are read in 64 bits, and an
//! origin near the scene is subtracted from all of them before anything is computed in 32.

use glam::DVec3;

use super::{Camera, Light};

/// How many of its radii the middle of a scene may lie from 0 and be left where it is: there, 32-bit floats round
/// positions by up to 1e-6 of the radius, a hundredth of the distance within which nothing occludes a virtual light.
const NEAR: f64 = 16.0;

/// The origin of a scene by the two corners of the box around it: 0, where the box is near it; else the middle of the
/// box, in whole steps of a power of two from a thirty-second to a sixteenth of the radius. Positions that a file has in
/// 32 bits are whole in these steps' parts, so that the difference is exact.
pub(super) fn of([min, max]: [DVec3; 2]) -> DVec3 {
    // Halved before the sum, as two huge coordinates must not overflow.
    let (middle, radius) = (0.5 * min + 0.5 * max, (0.5 * max - 0.5 * min).length());
    if !(middle.is_finite() && radius.is_finite()) || middle.length() <= NEAR * radius {
        return DVec3::ZERO;
    }
    let step = power_of_two(radius) / 16.0;
    let rounded = (middle / step).round() * step;
    // Of a scene without extent, or so far away that steps are lost.
    if rounded.is_finite() { rounded } else { middle }
}

/// The smallest and the largest coordinates of points; none of none.
pub(super) fn box_around(mut points: impl Iterator<Item = DVec3>) -> Option<[DVec3; 2]> {
    let first = points.next()?;
    Some(points.fold([first; 2], |[min, max], point| [min.min(point), max.max(point)]))
}

/// The largest power of two that is not above a positive number; 0 for one that is subnormal.
pub(super) fn power_of_two(number: f64) -> f64 {
    f64::from_bits(number.to_bits() & (0x7ff << 52))
}

/// A light or a camera, and where it is in the file's space.
#[derive(Clone, Debug)]
pub(super) struct Placed<T> {
    pub(super) position: DVec3,
    pub(super) what: T,
}

/// What has a position.
pub(super) trait Place {
    fn position(&mut self) -> &mut [f32; 3];
}

impl Place for Camera {
    fn position(&mut self) -> &mut [f32; 3] {
        &mut self.position
    }
}

impl Place for Light {
    fn position(&mut self) -> &mut [f32; 3] {
        &mut self.position
    }
}

impl<T: Place> Placed<T> {
    /// At a position of more digits than it holds itself.
    pub(super) fn at(position: DVec3, mut what: T) -> Self {
        *what.position() = position.as_vec3().into();
        Self { position, what }
    }

    /// Relative to an origin.
    pub(super) fn relative_to(mut self, origin: DVec3) -> T {
        *self.what.position() = relative(self.position, origin);
        self.what
    }
}

impl<T: Place> From<T> for Placed<T> {
    fn from(mut what: T) -> Self {
        let position = DVec3::from(what.position().map(f64::from));
        Self { position, what }
    }
}

/// A position relative to an origin, rounded once.
pub(super) fn relative(position: DVec3, origin: DVec3) -> [f32; 3] {
    (position - origin).as_vec3().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around(middle: [f64; 3], half: f64) -> DVec3 {
        let middle = DVec3::from(middle);
        of([middle - half, middle + half])
    }

    #[test]
    fn scenes_near_the_origin_stay_where_they_are() {
        // The radius is the square root of 3.
        assert_eq!(around([0.0; 3], 1.0), DVec3::ZERO);
        assert_eq!(around([27.7, 0.0, 0.0], 1.0), DVec3::ZERO);
        assert_eq!(around([27.8, 0.0, 0.0], 1.0), DVec3::new(27.8125, 0.0, 0.0));
        assert_eq!(around([1e5, 0.3, -1e6], 1.0), DVec3::new(1e5, 0.3125, -1e6));
    }

    #[test]
    fn what_cannot_have_an_origin_has_none() {
        assert_eq!(around([1e300, 0.0, 0.0], 1e299), DVec3::ZERO, "the radius overflows");
        assert_eq!(around([1e300; 3], 0.0), DVec3::splat(1e300), "a point");
        assert_eq!(around([f64::NAN; 3], 1.0), DVec3::ZERO);
        assert_eq!(around([1e3; 3], 1e-300), DVec3::splat(1e3), "steps that are lost");
    }

    #[test]
    fn positions_of_32_bits_lose_nothing() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / (1_u64 << 24) as f64
        };
        for distance in [1e3, 1e5, 1e7] {
            let points: Vec<_> = (0..100)
                .map(|_| DVec3::splat(distance) + DVec3::new(random(), random(), random()) * 5.0)
                .map(|point| point.as_vec3().as_dvec3())
                .collect();
            let origin = of(box_around(points.iter().copied()).unwrap());
            assert_ne!(origin, DVec3::ZERO);
            for &point in &points {
                let found = DVec3::from(relative(point, origin).map(f64::from));
                assert_eq!(found + origin, point);
            }
        }
    }
}

//! The reference of visibility: a straight line between a light and a receiver, and every triangle.

use rayon::prelude::*;

use crate::Vector3;
use crate::visibility::map::{self, View};

/// Where a line from `origin` meets a triangle, from either side, in units of `direction`; nothing where it misses it.
// [Moller and Trumbore 1997, Fast, minimum storage ray/triangle intersection]
fn meet([a, b, c]: &[Vector3; 3], origin: Vector3, direction: Vector3) -> Option<f64> {
    let (ab, ac) = (*b - *a, *c - *a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let from = origin - *a;
    let second = from.dot(p) / determinant;
    let q = from.cross(ab);
    let third = direction.dot(q) / determinant;
    (second >= 0.0 && third >= 0.0 && second + third <= 1.0).then(|| ac.dot(q) / determinant)
}

/// What a ray meets first from `near` on, in units of `direction`, and the number of the triangle.
#[must_use]
pub fn nearest(
    triangles: &[[Vector3; 3]],
    origin: Vector3,
    direction: Vector3,
    near: f64,
) -> Option<(f64, usize)> {
    let mut first: Option<(f64, usize)> = None;
    for (number, triangle) in triangles.iter().enumerate() {
        if let Some(at) = meet(triangle, origin, direction)
            && at >= near
            && first.is_none_or(|(best, _)| at < best)
        {
            first = Some((at, number));
        }
    }
    first
}

/// The share of the way to a receiver that is left out before it: its own surface is there.
pub const OWN_SURFACE: f64 = 1e-4;

/// Whether a light is seen from a receiver: whether that is before the light's plane, and no triangle is on the way but
/// nearer to the light than the near distance.
#[must_use]
pub fn seen(triangles: &[[Vector3; 3]], view: &View, position: Vector3) -> bool {
    let offset = view.offset(position);
    if offset.z <= 0.0 {
        return false;
    }
    let near = view.near / map::distance(offset);
    let way = position - view.position;
    let between = |triangle| {
        meet(triangle, view.position, way).is_some_and(|at| at >= near && at < 1.0 - OWN_SURFACE)
    };
    !triangles.iter().any(between)
}

/// [`seen`] for every light, receiver by receiver.
#[must_use]
pub fn all_seen(
    triangles: &[[Vector3; 3]],
    views: &[View],
    positions: &[Vector3],
) -> Vec<Vec<bool>> {
    positions
        .par_iter()
        .map(|&position| views.iter().map(|view| seen(triangles, view, position)).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visibility::Basis;

    #[test]
    fn walls_hide_what_is_behind_them() {
        let view = View {
            position: Vector3::new(0.0, 0.0, 1.0),
            near: 0.5,
            basis: Basis::about(Vector3::new(0.0, 0.0, 1.0)),
        };
        let wall = |z: f64| {
            [Vector3::new(-9.0, -9.0, z), Vector3::new(9.0, -9.0, z), Vector3::new(0.0, 9.0, z)]
        };
        let at = |z: f64| Vector3::new(0.1, 0.2, z);
        assert!(seen(&[wall(3.0)], &view, at(2.9)) && !seen(&[wall(3.0)], &view, at(3.1)));
        // The receiver's own wall, one that is too near, and one behind.
        assert!(seen(&[wall(3.0), wall(1.2), wall(-1.0)], &view, at(3.0)));
        assert!(!seen(&[], &view, at(0.9)));
        let all = all_seen(&[wall(3.0)], &[view; 2], &[at(2.0), at(4.0)]);
        assert_eq!(all, [[true; 2], [false; 2]]);
        assert_eq!(
            nearest(&[wall(4.0), wall(3.0)], view.position, view.basis.z, 2.5),
            Some((3.0, 0))
        );
    }
}

//! The irradiance of a flat polygon of even radiance.

use crate::Vector3;

/// Corners of a quadrilateral that a plane has cut.
const MOST: usize = 6;

/// What a convex quadrilateral of radiance 1 brings to a surface: the integral of the cosine over the solid angle that
/// it takes up above the horizon. `front` is the normal of its lit side, which the position has to be on. At least 0; 0
/// edge on. Which way its corners go round does not matter. Times radiance it is irradiance; over pi the form factor.
///
/// A surface in the plane of the quadrilateral that looks the same way gets nothing, wherever rounding puts it: the sign
/// of the sum follows from `front`, not from the position.
// [Lambert 1760], as [Baum et al. 1989, Improving radiosity solutions through the use of analytically determined form
// factors, Equation (9)]: half the sum over the edges of the angle under which an edge is seen times the cosine between
// the surface's normal and that of the plane of the edge and the receiver.
pub(crate) fn irradiance(
    corners: &[Vector3; 4],
    front: Vector3,
    position: Vector3,
    normal: Vector3,
) -> f64 {
    let from = corners.map(|corner| corner - position);
    let heights = from.map(|corner| corner.dot(normal));
    if heights.iter().all(|&height| height <= 0.0) {
        return 0.0;
    }
    // Seen from the front, corners go round the one way or the other.
    let [a, b, c, d] = *corners;
    let sign = if (c - a).cross(d - b).dot(front) < 0.0 { 0.5 } else { -0.5 };
    if heights.iter().all(|&height| height >= 0.0) {
        return (sign * around(&from, normal)).max(0.0);
    }
    // What is below the horizon is cut off. [Sutherland and Hodgman 1974, Reentrant polygon clipping]
    let (mut cut, mut count) = ([Vector3::zero(); MOST], 0);
    let mut keep = |corner: Vector3| {
        if let Some(place) = cut.get_mut(count) {
            *place = corner;
            count += 1;
        }
    };
    for index in 0..4 {
        let next = (index + 1) % 4;
        let [above, next_above] = [heights[index], heights[next]];
        if above >= 0.0 {
            keep(from[index]);
        }
        if (above > 0.0 && next_above < 0.0) || (above < 0.0 && next_above > 0.0) {
            let share = above / (above - next_above);
            keep(from[index] + (from[next] - from[index]) * share);
        }
    }
    (sign * around(&cut[..count], normal)).max(0.0)
}

/// The sum over the edges of a polygon around the origin.
fn around(corners: &[Vector3], normal: Vector3) -> f64 {
    let mut sum = 0.0;
    for (index, &from) in corners.iter().enumerate() {
        let to = corners[(index + 1) % corners.len()];
        let across = from.cross(to);
        let length = across.length();
        // An edge through the receiver, or of no length, takes up no angle, or one in the plane of the surface.
        if length > 0.0 {
            // Unlike the arc cosine the arc tangent keeps small angles.
            sum += length.atan2(from.dot(to)) / length * across.dot(normal);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::fis::stress::Random;

    const UP: Vector3 = Vector3::new(0.0, 0.0, 1.0);
    const DOWN: Vector3 = Vector3::new(0.0, 0.0, -1.0);

    /// A rectangle in the plane of height 1, from the axis to `a` and `b`.
    fn corner(a: f64, b: f64) -> [Vector3; 4] {
        [[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]].map(|[x, y]| Vector3::new(x, y, 1.0))
    }

    /// [Howell, A catalog of radiation heat transfer configuration factors, B-3]: parallel to a rectangle, below a
    /// corner.
    fn parallel(a: f64, b: f64) -> f64 {
        let (roots_a, roots_b) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
        0.5 * (a / roots_a * (b / roots_a).atan() + b / roots_b * (a / roots_b).atan())
    }

    /// [Howell, B-4]: at right angles to it, in the plane through the edge along `b`, looking along `a`.
    fn upright(a: f64, b: f64) -> f64 {
        0.5 * (b.atan() - (b / (1.0 + a * a).sqrt()).atan() / (1.0 + a * a).sqrt())
    }

    #[test]
    fn rectangles_have_their_closed_forms() {
        for (a, b) in [(1.0, 1.0), (0.1, 3.0), (50.0, 0.02), (1e-3, 1e-3)] {
            let found = irradiance(&corner(a, b), DOWN, Vector3::zero(), UP);
            assert!((found / parallel(a, b) - 1.0).abs() < 1e-9, "{a} {b} {found}");
            let mut turned = corner(a, b);
            turned.reverse();
            assert!((irradiance(&turned, DOWN, Vector3::zero(), UP) / found - 1.0).abs() < 1e-12);
            let found =
                irradiance(&corner(a, b), DOWN, Vector3::zero(), Vector3::new(1.0, 0.0, 0.0));
            assert!((found / upright(a, b) - 1.0).abs() < 1e-8, "{a} {b} {found}");
            // The horizon cuts it in half.
            let both = [[-a, 0.0], [a, 0.0], [a, b], [-a, b]].map(|[x, y]| Vector3::new(x, y, 1.0));
            let half = irradiance(&both, DOWN, Vector3::zero(), Vector3::new(1.0, 0.0, 0.0));
            assert!((half / found - 1.0).abs() < 1e-8, "{a} {b} {half}");
        }
        // All of the hemisphere, and nothing below it.
        let wide = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| Vector3::new(1e7 * x, 1e7 * y, 1.0));
        assert!((irradiance(&wide, DOWN, Vector3::zero(), UP) / PI - 1.0).abs() < 1e-6);
        assert_eq!(irradiance(&wide, DOWN, Vector3::zero(), -UP), 0.0);
        // Edge on, at a corner, on an edge, of no size: nothing, and a number.
        let flat = corner(1.0, 1.0).map(|place| place - UP);
        let places = [[0.0, 0.0], [0.5, 0.0], [3.0, 3.0], [0.4, 0.3], [0.3, 0.7]];
        for [x, y] in places {
            let place = Vector3::new(x, y, 0.0);
            assert_eq!(irradiance(&flat, UP, place, UP), 0.0);
        }
        assert_eq!(irradiance(&[UP; 4], DOWN, Vector3::zero(), UP), 0.0);
    }

    /// Against many small pieces as points, at any inclination, cut by the horizon or not.
    #[test]
    fn any_quadrilateral_is_the_sum_of_its_pieces() {
        let mut random = Random::new(4);
        let mut vector =
            |scale: f64| Vector3::new(random.normal(), random.normal(), random.normal()) * scale;
        let (mut cut, mut noticed) = (0, 0);
        for _ in 0..60 {
            let (normal, centre) = (vector(1.0).normalized(), vector(1.0));
            let (side, other) = (vector(0.6), vector(0.6));
            let quad = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[u, v]| centre + side * u + other * v);
            let plane = side.cross(other);
            if centre.dot(plane.normalized()).abs() < 0.15 {
                continue;
            }
            let steps = 400;
            let (mut sum, mut signed) = (0.0, 0.0);
            for index in 0..steps * steps {
                let [u, v] = [index % steps, index / steps]
                    .map(|part| (f64::from(part) + 0.5) / f64::from(steps) * 2.0 - 1.0);
                let place = centre + side * u + other * v;
                let square = place.length_squared();
                let seen = place.dot(plane).abs() * place.dot(normal) / (square * square);
                sum += seen.max(0.0);
                signed += seen;
            }
            let scale = 4.0 / f64::from(steps * steps);
            let front = if centre.dot(plane) < 0.0 { plane } else { -plane };
            let found = irradiance(&quad, front, Vector3::zero(), normal);
            let error = (found - sum * scale).abs();
            assert!(error < 2e-4 * found.max(0.05), "{found} {} {error:e}", sum * scale);
            let heights = quad.map(|corner| corner.dot(normal) > 0.0);
            if heights.contains(&true) && heights.contains(&false) {
                cut += 1;
                // Negative control: without the horizon it is another number.
                noticed +=
                    usize::from((found - (signed * scale).abs()).abs() > 2e-4 * found.max(0.05));
            }
        }
        assert!(cut > 10 && noticed * 10 > cut * 9, "{cut} {noticed}");
    }
}

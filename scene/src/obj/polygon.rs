//! Polygons as triangles.

use glam::{DVec2, DVec3};

/// The most corners of a polygon that is not convex: cutting ears takes time in proportion to the square.
pub(super) const MOST_CORNERS: usize = 4096;

/// How many corners are tried as ears for each that there is, before the least bad one is taken untried. Polygons that
/// do not cross themselves take a few.
const TRIES: usize = 16;

/// The normal of a polygon times twice its area. [Newell's method, Sutherland et al. 1974]
pub(super) fn area_normal(corners: &[DVec3]) -> DVec3 {
    let Some(&first) = corners.first() else { return DVec3::ZERO };
    // From the first corner, so that a polygon far from the origin does not cancel.
    let edges = corners.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first));
    edges.sum()
}

/// The triangles of a polygon, as numbers of its corners, in its sense of rotation.
///
/// A convex one is a fan about its first corner. Of any other, ears are cut off in the plane at right angles to its
/// normal [Meisters 1975]; where it crosses itself and has no ear, its least bad corner is. None of one that is not convex
/// and has more than [`MOST_CORNERS`].
pub(super) fn triangles(corners: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let count = corners.len();
    let fan = || Some((2..count).map(|last| [0, last - 1, last]).collect());
    let normal = area_normal(corners);
    if count < 4 || normal.length_squared() == 0.0 || !normal.is_finite() {
        return fan();
    }
    let flat = flattened(corners, normal.normalize());
    let turn = |[a, b, c]: [usize; 3]| (flat[b] - flat[a]).perp_dot(flat[c] - flat[b]);
    let around = |at: usize| [(at + count - 1) % count, at, (at + 1) % count];
    // Convex: no corner turns the other way, and all of them together turn around once.
    let turns_once = {
        let angle = |[a, b, c]: [usize; 3]| (flat[b] - flat[a]).angle_to(flat[c] - flat[b]);
        let all: f64 =
            (0..count).map(|at| angle(around(at))).filter(|angle| angle.is_finite()).sum();
        all < 3.0 * std::f64::consts::PI
    };
    if turns_once && (0..count).all(|at| turn(around(at)) >= 0.0) {
        return fan();
    }
    (count <= MOST_CORNERS).then(|| ears(&flat))
}

/// The corners in a plane at right angles to `normal`, counter-clockwise, about the first.
fn flattened(corners: &[DVec3], normal: DVec3) -> Vec<DVec2> {
    let (x, y) = normal.any_orthonormal_pair();
    let first = corners.first().copied().unwrap_or_default();
    let about = corners.iter().map(|&corner| corner - first);
    about.map(|corner| DVec2::new(corner.dot(x), corner.dot(y))).collect()
}

fn ears(flat: &[DVec2]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..flat.len()).collect();
    let mut triangles = Vec::with_capacity(flat.len().saturating_sub(2));
    let mut at = 0;
    let mut tries = TRIES * flat.len();
    while left.len() > 3 {
        let count = left.len();
        let from_last = (0..count.min(tries)).map(|step| (at + step) % count);
        let found = from_last.inspect(|_| tries -= 1).find(|&at| is_ear(flat, &left, at));
        // It crosses itself, or is flat here.
        let cut = found.unwrap_or_else(|| sharpest(flat, &left));
        triangles.push(corners_around(&left, cut));
        left.remove(cut);
        at = cut % left.len();
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

fn corners_around(left: &[usize], at: usize) -> [usize; 3] {
    let count = left.len();
    [left[(at + count - 1) % count], left[at], left[(at + 1) % count]]
}

fn area([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Whether a corner turns the right way and its triangle holds no other corner.
fn is_ear(flat: &[DVec2], left: &[usize], at: usize) -> bool {
    let corners = corners_around(left, at);
    let [a, b, c] = corners.map(|corner| flat[corner]);
    if area([a, b, c]) <= 0.0 {
        return false;
    }
    left.iter().filter(|corner| !corners.contains(corner)).all(|&corner| {
        let point = flat[corner];
        // Where a seam to a hole is cut in, corners lie upon each other.
        let same = point == a || point == b || point == c;
        let inside =
            [[a, b], [b, c], [c, a]].iter().all(|&[from, to]| area([from, to, point]) >= 0.0);
        same || !inside
    })
}

/// The corner whose triangle has the greatest area in the right sense, which bends the polygon least wrongly.
fn sharpest(flat: &[DVec2], left: &[usize]) -> usize {
    let of = |at: usize| area(corners_around(left, at).map(|corner| flat[corner]));
    (0..left.len()).max_by(|&a, &b| of(a).total_cmp(&of(b))).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lifted(points: &[[f64; 2]]) -> Vec<DVec3> {
        // In a tilted plane, far from the origin.
        let (x, y) = DVec3::new(0.3, -0.5, 0.8).normalize().any_orthonormal_pair();
        points.iter().map(|&[a, b]| DVec3::splat(1e3) + x * a + y * b).collect()
    }

    /// The triangles' areas in the polygon's sense sum to its area, and none is turned over.
    fn covers(points: &[[f64; 2]]) -> Vec<[usize; 3]> {
        let corners = lifted(points);
        let normal = area_normal(&corners);
        let found = triangles(&corners).unwrap();
        let mut sum = 0.0;
        for triangle in &found {
            let own = area_normal(&triangle.map(|corner| corners[corner])).dot(normal.normalize());
            assert!(own >= -1e-9, "{triangle:?} is turned over");
            sum += own;
        }
        assert!((sum / normal.length() - 1.0).abs() < 1e-9, "{sum} {normal}");
        found
    }

    #[test]
    fn convex_polygons_are_fans() {
        assert_eq!(
            covers(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
            [[0, 1, 2], [0, 2, 3]]
        );
        let hexagon: Vec<_> = (0..6).map(|i| f64::from(i).sin_cos()).map(|(y, x)| [x, y]).collect();
        assert_eq!(covers(&hexagon), [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
    }

    #[test]
    fn concave_polygons_keep_their_notches() {
        let arrow = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [1.0, 1.0]];
        covers(&arrow);
        let u = [
            [-1.0, 0.2],
            [1.0, 0.2],
            [1.0, 2.4],
            [0.6, 2.4],
            [0.6, 0.6],
            [-0.6, 0.6],
            [-0.6, 2.4],
            [-1.0, 2.4],
        ];
        for start in 0..8 {
            let turned: Vec<_> = (0..8).map(|i| u[(start + i) % 8]).collect();
            covers(&turned);
            let mirrored: Vec<_> = turned.iter().rev().copied().collect();
            covers(&mirrored);
        }
        // A star, and a frame whose hole is cut in along a seam.
        let star: Vec<_> = (0..24_u8)
            .map(|i| {
                (f64::from(i) * std::f64::consts::TAU / 24.0, if i % 2 == 0 { 1.0 } else { 0.2 })
            })
            .map(|(angle, radius)| [radius * angle.cos(), radius * angle.sin()])
            .collect();
        covers(&star);
        covers(&[
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [0.0, 3.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ]);
    }

    #[test]
    fn polygons_that_cross_themselves_still_end() {
        for points in [
            vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]],
            vec![[0.0, 0.0], [2.0, 0.0], [0.0, 0.0], [2.0, 0.0], [1.0, 1.0]],
            vec![[0.0; 2]; 9],
            (0..4000).map(|i| f64::from(i * 7919 % 4001)).map(|x| [x, x * x % 7.0]).collect(),
            (0..40).map(|i| f64::from(i * i % 17)).map(|x| [x, x * x % 7.0]).collect(),
        ] {
            let found = triangles(&lifted(&points)).unwrap();
            assert_eq!(found.len(), points.len() - 2);
            assert!(found.iter().flatten().all(|&corner| corner < points.len()));
        }
        let many: Vec<_> = (0..=MOST_CORNERS).map(|i| [i as f64, (i % 2) as f64]).collect();
        assert_eq!(triangles(&lifted(&many)), None);
    }
}

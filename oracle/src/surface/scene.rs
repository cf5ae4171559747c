//! Triangles that rays are sent into: the nearest hit, and whether two points see each other.

use core::ops::ControlFlow;

// Of the crates that were tried this is the one that is exact and small: `obvhs` is f32 alone, and `parry3d-f64` brings a
// library of collisions with it. It is maintained, generic over the number, and its nodes are public, so that the walk
// is our own: the crate's leaves out boxes whose face a ray runs along, and its iterator keeps 32 levels at most.
use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::{Bvh, BvhNode};
use nalgebra::Point3;
use thiserror::Error;

use crate::Vector3;
use crate::surface::{Hit, Ray, Triangle};

/// What boxes grow by, relative to the largest coordinate: far above the rounding of f64, far below anything drawn.
const SLACK: f64 = 1e-12;
/// [`Scene::spacing`] over the largest coordinate: 256 roundings of f32, which rasterised positions have, and which
/// interpolation across a triangle makes of them.
const SPACING: f64 = 1.0 / 65536.0;

/// A triangle as a rasteriser draws it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Positions, shading normals and the material's number; counter-clockwise seen from the front.
    pub triangle: Triangle,
    /// Texture coordinates of the corners.
    pub uvs: [[f64; 2]; 3],
    /// Whether its back is there too; otherwise rays pass it from behind, as the rasteriser culls it.
    pub double_sided: bool,
}

/// Where a ray meets a facet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The hit; its triangle is the facet's number.
    pub hit: Hit,
    /// Texture coordinates.
    pub uv: [f64; 2],
    /// Unit geometric normal, facing the ray's origin.
    pub side: Vector3,
}

/// Errors of scenes.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum SceneError {
    /// A corner is not a place.
    #[error("corner {corner} of triangle {triangle} is not finite, and must be")]
    NotFinite {
        /// The triangle's number.
        triangle: usize,
        /// The corner, 0 to 2.
        corner: usize,
    },
}

/// Triangles in a hierarchy of boxes.
#[derive(Clone, Debug)]
pub struct Scene {
    facets: Vec<Facet>,
    /// Number of the facet of each leaf's shape.
    numbers: Vec<usize>,
    hierarchy: Bvh<f64, 3>,
    spacing: f64,
    reach: f64,
}

/// What the hierarchy is built over.
struct Boxed {
    low: [f64; 3],
    high: [f64; 3],
    node: usize,
}

impl Bounded<f64, 3> for Boxed {
    fn aabb(&self) -> Aabb<f64, 3> {
        Aabb::with_bounds(Point3::from(self.low), Point3::from(self.high))
    }
}

impl BHShape<f64, 3> for Boxed {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }
    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl Scene {
    /// A scene of facets; none at all are a scene that nothing is hit in.
    ///
    /// # Errors
    /// [`SceneError`] names the triangle that is not finite.
    pub fn new(facets: Vec<Facet>) -> Result<Self, SceneError> {
        let mut largest = 0.0_f64;
        for (number, facet) in facets.iter().enumerate() {
            for (corner, position) in facet.triangle.positions.iter().enumerate() {
                for part in position.to_array() {
                    if !part.is_finite() {
                        return Err(SceneError::NotFinite { triangle: number, corner });
                    }
                    largest = largest.max(part.abs());
                }
            }
        }
        let slack = SLACK * largest;
        let mut numbers = Vec::with_capacity(facets.len());
        let mut boxes = Vec::with_capacity(facets.len());
        for (number, facet) in facets.iter().enumerate() {
            let [a, b, c] = facet.triangle.positions.map(Vector3::to_array);
            // A triangle without area is never hit.
            let [a_to_b, a_to_c] =
                [1, 2].map(|corner| facet.triangle.positions[corner] - facet.triangle.positions[0]);
            if a_to_b.cross(a_to_c).length_squared() == 0.0 {
                continue;
            }
            numbers.push(number);
            boxes.push(Boxed {
                low: [0, 1, 2].map(|axis| a[axis].min(b[axis]).min(c[axis]) - slack),
                high: [0, 1, 2].map(|axis| a[axis].max(b[axis]).max(c[axis]) + slack),
                node: 0,
            });
        }
        Ok(Self {
            facets,
            numbers,
            hierarchy: Bvh::build(&mut boxes),
            spacing: SPACING * largest,
            reach: 4.0 * largest,
        })
    }

    /// The facets.
    #[must_use]
    pub fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// How far a rasterised position may be from its surface, in world units: what starts at a surface starts this far
    /// above it, and what is this close to the end of a line of sight does not hide it. It is 2^-16 of the largest
    /// coordinate.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// A distance from a position that leads out of the scene in any direction.
    #[must_use]
    pub fn reach_from(&self, position: Vector3) -> f64 {
        self.reach + 2.0 * position.length()
    }

    /// The nearest hit of a ray, among those that `counts` says count: a cutout's hole does not, say.
    ///
    /// Backs of facets that are not double-sided are not hit. Rays through an edge or a corner that triangles share hit
    /// one of them. Of equal distances the lower number is hit.
    pub fn nearest(&self, ray: &Ray, counts: &dyn Fn(&Crossing) -> bool) -> Option<Crossing> {
        let mut nearest: Option<Crossing> = None;
        self.walk(ray, f64::INFINITY, &mut |crossing, limit| {
            let closer = nearest.is_none_or(|found| {
                (crossing.hit.distance, crossing.hit.triangle)
                    < (found.hit.distance, found.hit.triangle)
            });
            if closer && counts(&crossing) {
                *limit = crossing.hit.distance;
                nearest = Some(crossing);
            }
            ControlFlow::Continue(())
        });
        nearest
    }

    /// Whether `from` sees `to`: no hit that counts lies between them but within [`Self::spacing`] of either.
    ///
    /// It is `from` that looks: what it sees the back of does not hide anything unless it is double-sided. Who asks for
    /// light passes the light's position first, as the light's shadow map would look.
    pub fn sees(&self, from: Vector3, to: Vector3, counts: &dyn Fn(&Crossing) -> bool) -> bool {
        let path = to - from;
        let length = path.length();
        if length.is_nan() || length <= 2.0 * self.spacing {
            return true;
        }
        let ray = Ray { origin: from, direction: path * (1.0 / length) };
        let mut free = true;
        self.walk(&ray, length - self.spacing, &mut |crossing, limit| {
            let distance = crossing.hit.distance;
            if distance > self.spacing && distance < *limit && counts(&crossing) {
                free = false;
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        free
    }

    /// [`Self::sees`] from one point to many, in their order.
    #[must_use]
    pub fn sees_each(
        &self,
        from: Vector3,
        to: &[Vector3],
        counts: &dyn Fn(&Crossing) -> bool,
    ) -> Vec<bool> {
        to.iter().map(|&to| self.sees(from, to, counts)).collect()
    }

    /// Calls `found` with crossings no further away than the limit, which it may lower, nearer boxes first.
    fn walk(
        &self,
        ray: &Ray,
        mut limit: f64,
        found: &mut dyn FnMut(Crossing, &mut f64) -> ControlFlow<()>,
    ) {
        let Some(woven) = Sheared::new(ray) else { return };
        if self.hierarchy.nodes.is_empty() {
            return;
        }
        let origin = ray.origin.to_array();
        let direction = ray.direction.to_array();
        let mut stack = Vec::with_capacity(64);
        stack.push((0, 0.0));
        while let Some((index, entry)) = stack.pop() {
            if entry > limit {
                continue;
            }
            match &self.hierarchy.nodes[index] {
                BvhNode::Leaf { shape_index, .. } => {
                    let number = self.numbers[*shape_index];
                    if let Some(crossing) = self.crossing(&woven, number)
                        && crossing.hit.distance <= limit
                        && found(crossing, &mut limit).is_break()
                    {
                        return;
                    }
                }
                BvhNode::Node {
                    child_l_index, child_l_aabb, child_r_index, child_r_aabb, ..
                } => {
                    let enter = |bounds: &Aabb<f64, 3>| {
                        enters(origin, direction, bounds).filter(|&entry| entry <= limit)
                    };
                    let left = enter(child_l_aabb).map(|entry| (*child_l_index, entry));
                    let right = enter(child_r_aabb).map(|entry| (*child_r_index, entry));
                    // What is pushed last is looked at first.
                    match (left, right) {
                        (Some(left), Some(right)) if left.1 < right.1 => {
                            stack.extend([right, left]);
                        }
                        (left, right) => stack.extend(left.into_iter().chain(right)),
                    }
                }
            }
        }
    }

    fn crossing(&self, woven: &Sheared, number: usize) -> Option<Crossing> {
        let facet = &self.facets[number];
        let triangle = &facet.triangle;
        let (distance, weights) = woven.meet(&triangle.positions)?;
        let [a, b, c] = triangle.positions;
        let blend = |corners: [Vector3; 3]| {
            corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
        };
        let geometric = (b - a).cross(c - a);
        let back = geometric.dot(woven.ray.direction) > 0.0;
        if back && !facet.double_sided {
            return None;
        }
        let shading = blend(triangle.normals).normalized_or(geometric.normalized());
        // The shading normal belongs to the side that the geometric normal points to.
        let turn = back != (geometric.dot(shading) < 0.0);
        let uv = [0, 1].map(|axis| (0..3).map(|i| facet.uvs[i][axis] * weights[i]).sum());
        let side = geometric.normalized();
        Some(Crossing {
            hit: Hit {
                distance,
                position: blend(triangle.positions),
                normal: if turn { -shading } else { shading },
                weights,
                triangle: number,
                material: triangle.material,
            },
            uv,
            side: if back { -side } else { side },
        })
    }
}

/// Where a ray enters a box, if it does; boxes are padded, and the comparison has room for rounding.
// [Kay and Kajiya 1986, Ray tracing complex scenes], slabs
fn enters(origin: [f64; 3], direction: [f64; 3], bounds: &Aabb<f64, 3>) -> Option<f64> {
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let (low, high) = (bounds.min[axis], bounds.max[axis]);
        if direction[axis] == 0.0 {
            if origin[axis] < low || origin[axis] > high {
                return None;
            }
            continue;
        }
        let inverse = 1.0 / direction[axis];
        let (first, second) = ((low - origin[axis]) * inverse, (high - origin[axis]) * inverse);
        near = near.max(first.min(second));
        far = far.min(first.max(second));
    }
    let near = near * (1.0 - SLACK);
    (near <= far * (1.0 + SLACK)).then_some(near)
}

/// A ray, and the shear that makes it the z axis: triangles that share an edge get the same number for it, with opposite
/// signs, so that no ray passes between them.
// [Woop et al. 2013, Watertight ray/triangle intersection]
struct Sheared {
    ray: Ray,
    axes: [usize; 3],
    shear: [f64; 3],
}

impl Sheared {
    /// `None` of a ray without direction, or one that is not finite.
    fn new(ray: &Ray) -> Option<Self> {
        let direction = ray.direction.to_array();
        let finite = direction.into_iter().chain(ray.origin.to_array()).all(f64::is_finite);
        let z = (0..3).max_by(|&a, &b| direction[a].abs().total_cmp(&direction[b].abs()))?;
        if !finite || direction[z] == 0.0 {
            return None;
        }
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let shear = [direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]];
        Some(Self { ray: *ray, axes: [x, y, z], shear })
    }

    /// Distance, above 0, and barycentric weights of a triangle, from either side.
    fn meet(&self, positions: &[Vector3; 3]) -> Option<(f64, [f64; 3])> {
        let [a, b, c] = positions.map(|position| {
            let from = (position - self.ray.origin).to_array();
            let [x, y, z] = self.axes.map(|axis| from[axis]);
            [x - self.shear[0] * z, y - self.shear[1] * z, self.shear[2] * z]
        });
        let edge = |from: [f64; 3], to: [f64; 3]| from[0] * to[1] - from[1] * to[0];
        let parts = [edge(c, b), edge(a, c), edge(b, a)];
        if parts.iter().any(|&part| part < 0.0) && parts.iter().any(|&part| part > 0.0) {
            return None;
        }
        let sum = parts[0] + parts[1] + parts[2];
        if sum == 0.0 || !sum.is_finite() {
            return None;
        }
        let weights = parts.map(|part| part / sum);
        let distance = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
        (distance > 0.0).then_some((distance, weights))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::stress::Random;
    use crate::surface::raycast::nearest_hit;

    fn vector(random: &mut Random) -> Vector3 {
        Vector3::new(random.normal(), random.normal(), random.normal())
    }

    fn facet(positions: [Vector3; 3], double_sided: bool) -> Facet {
        let normal = (positions[1] - positions[0]).cross(positions[2] - positions[0]);
        let triangle = Triangle { positions, normals: [normal.normalized(); 3], material: 7 };
        Facet { triangle, uvs: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], double_sided }
    }

    /// Triangles of every size, some without area, some across an axis.
    fn soup(random: &mut Random, count: usize) -> Vec<Facet> {
        (0..count)
            .map(|index| {
                let size = 10f64.powf(-2.0 * random.uniform());
                let centre = vector(random);
                let mut corners = [0; 3].map(|_| centre + vector(random) * size);
                match index % 10 {
                    0 => corners[2] = corners[0],
                    1 => corners[2] = (corners[0] + corners[1]) * 0.5,
                    2 => corners = corners.map(|corner| Vector3 { z: 0.25, ..corner }),
                    _ => {}
                }
                facet(corners, true)
            })
            .collect()
    }

    const ALL: &dyn Fn(&Crossing) -> bool = &|_| true;

    #[test]
    fn is_what_trying_all_gives() {
        let mut random = Random::new(11);
        let facets = soup(&mut random, 300);
        let triangles: Vec<Triangle> = facets.iter().map(|facet| facet.triangle).collect();
        let scene = Scene::new(facets.clone()).unwrap();
        // Negative control: a scene that lacks one triangle in three.
        let lacking = Scene::new(
            facets.iter().copied().enumerate().filter(|f| f.0 % 3 != 0).map(|f| f.1).collect(),
        )
        .unwrap();
        let (mut hits, mut misses, mut noticed) = (0, 0, 0);
        for index in 0..20_000 {
            let origin = vector(&mut random) * 2.0;
            let mut direction = vector(&mut random);
            if index % 4 == 0 {
                // Along an axis, from a corner's coordinates at times.
                let mut parts = [0.0; 3];
                parts[index / 4 % 3] = if index % 8 == 0 { 1.0 } else { -1.0 };
                direction = Vector3::new(parts[0], parts[1], parts[2]);
            } else if index % 4 == 1 {
                // Within a plane of two axes.
                direction.y = 0.0;
            }
            let ray = Ray { origin, direction: direction.normalized() };
            let found = scene.nearest(&ray, ALL);
            match (found, nearest_hit(&triangles, &ray)) {
                (Some(found), Some(expected)) => {
                    let same = found.hit.triangle == expected.triangle;
                    let close = (found.hit.distance - expected.distance).abs();
                    assert!(close < 1e-9 * expected.distance.max(1.0), "{found:?} {expected:?}");
                    assert!(same || close < 1e-12);
                    assert!(!same || (found.hit.normal - expected.normal).length() < 1e-9);
                    assert!((found.hit.position - expected.position).length() < 1e-9);
                    assert!(found.side.dot(ray.direction) <= 0.0);
                    hits += 1;
                }
                (None, None) => misses += 1,
                other => panic!("{ray:?} {other:?}"),
            }
            let without = lacking.nearest(&ray, ALL).map(|crossing| crossing.hit.distance);
            noticed += usize::from(without != found.map(|crossing| crossing.hit.distance));
        }
        assert!(hits > 3000 && misses > 3000 && noticed > 500, "{hits} {misses} {noticed}");
    }

    /// A closed ball around the origin, of latitudes and longitudes.
    fn ball(rows: usize) -> Vec<Facet> {
        let corner = |row: usize, column: usize| {
            let (down, around) = (
                core::f64::consts::PI * row as f64 / rows as f64,
                core::f64::consts::TAU * (column % (2 * rows)) as f64 / (2 * rows) as f64,
            );
            // The poles are points: the sine of the f64 number pi is not 0.
            let radius = if row.is_multiple_of(rows) { 0.0 } else { down.sin() };
            Vector3::new(radius * around.cos(), radius * around.sin(), down.cos())
        };
        let mut facets = Vec::new();
        for row in 0..rows {
            for column in 0..2 * rows {
                let [a, b] = [column, column + 1].map(|column| corner(row, column));
                let [c, d] = [column, column + 1].map(|column| corner(row + 1, column));
                facets.push(facet([a, c, d], true));
                facets.push(facet([a, d, b], true));
            }
        }
        facets
    }

    #[test]
    fn no_ray_leaves_a_closed_ball() {
        let facets = ball(12);
        let scene = Scene::new(facets.clone()).unwrap();
        let mut random = Random::new(5);
        let mut through_gaps = 0;
        for index in 0..20_000 {
            let corners = facets[random.bits() as usize % facets.len()].triangle.positions;
            let share = random.uniform();
            // Through a point of an edge, or through a corner.
            let target = if index % 2 == 0 {
                corners[0] * share + corners[1] * (1.0 - share)
            } else {
                corners[index / 2 % 3]
            };
            let origin = vector(&mut random) * 0.1;
            let ray = Ray { origin, direction: (target - origin).normalized() };
            assert!(scene.nearest(&ray, ALL).is_some(), "{ray:?}");
            assert!(!scene.sees(origin, target * 1.5, ALL));
            // The plain test of the brute force lets some through: what this one is for.
            let triangles: Vec<Triangle> = facets.iter().map(|facet| facet.triangle).collect();
            through_gaps += usize::from(index < 500 && nearest_hit(&triangles, &ray).is_none());
        }
        println!("{through_gaps} of 500 rays through edges slip through the plain test");
    }

    #[test]
    fn backs_are_passed_unless_double_sided_and_holes_always() {
        let at = |z: f64| {
            [Vector3::new(-9.0, -9.0, z), Vector3::new(9.0, -9.0, z), Vector3::new(0.0, 9.0, z)]
        };
        let facets = vec![facet(at(1.0), false), facet(at(2.0), true), facet(at(3.0), false)];
        let scene = Scene::new(facets).unwrap();
        let up = Ray { origin: Vector3::zero(), direction: Vector3::new(0.0, 0.0, 1.0) };
        let down = Ray { origin: Vector3::new(0.0, 0.0, 9.0), direction: -up.direction };
        let number = |ray, counts: &dyn Fn(&Crossing) -> bool| {
            scene.nearest(ray, counts).map(|crossing| crossing.hit.triangle)
        };
        assert_eq!(number(&up, ALL), Some(1));
        assert_eq!(number(&down, ALL), Some(2));
        let hole = |crossing: &Crossing| crossing.hit.triangle != 1;
        assert_eq!(number(&up, &hole), None);
        assert_eq!(number(&down, &|crossing| crossing.hit.triangle == 0), Some(0));
        let back = scene.nearest(&up, ALL).unwrap();
        assert_eq!((back.side, back.hit.normal), (-up.direction, -up.direction));
        assert_eq!(back.hit.material, 7);
        let [u, v] = back.uv;
        assert!((u - 0.25).abs() < 1e-12 && (v - 0.5).abs() < 1e-12, "{u} {v}");

        let place = |z: f64| Vector3::new(0.0, 0.0, z);
        let to = [place(1.5), place(2.5), place(9.0), place(0.5)];
        assert_eq!(scene.sees_each(place(0.0), &to, ALL), [true, false, false, true]);
        assert_eq!(scene.sees_each(place(0.0), &to, &hole), [true; 4]);
        assert_eq!(scene.sees_each(place(9.0), &to, ALL), [false, false, true, false]);
        // What lies at an end does not hide it.
        assert!(scene.sees(place(9.0), place(3.0), ALL) && scene.sees(place(2.0), place(2.9), ALL));
        assert!(!scene.sees(place(9.0), place(3.0 - 3.0 * scene.spacing()), ALL));
    }

    #[test]
    fn what_is_no_scene_or_no_ray_gives_nothing_or_says_so() {
        let ray = Ray { origin: Vector3::zero(), direction: Vector3::new(0.0, 0.0, 1.0) };
        let empty = Scene::new(Vec::new()).unwrap();
        assert!(empty.nearest(&ray, ALL).is_none());
        assert!(empty.sees(Vector3::zero(), Vector3::splat(1.0), ALL));
        let point = Scene::new(vec![facet([Vector3::splat(1.0); 3], true)]).unwrap();
        assert!(
            point
                .nearest(&Ray { direction: Vector3::splat(1.0).normalized(), ..ray }, ALL)
                .is_none()
        );
        let mut corners = [Vector3::zero(), Vector3::splat(1.0), Vector3::new(1.0, 0.0, 0.0)];
        let sound = facet(corners, true);
        corners[1].y = f64::NAN;
        let error = Scene::new(vec![sound, facet(corners, true)]).unwrap_err();
        assert_eq!(error, SceneError::NotFinite { triangle: 1, corner: 1 });
        let scene = Scene::new(vec![sound]).unwrap();
        for direction in [Vector3::zero(), Vector3::splat(f64::NAN)] {
            assert!(scene.nearest(&Ray { direction, ..ray }, ALL).is_none());
        }
    }
}

//! A light's map from points: discs of the scene's surfaces.

use crate::visibility::map::{self, Maps, View};
use crate::{Real, Vector3};

/// A point of a surface, as a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// World position.
    pub position: Vector3,
    /// Radius of the disc.
    pub radius: f64,
    /// Unit normal of the surface, on either side.
    pub normal: Vector3,
}

/// What a texel may hold: any number in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least.
    pub low: f64,
    /// The greatest.
    pub high: f64,
}

impl Range {
    /// Whether rounding may decide if there is anything, or which of two discs there is.
    #[must_use]
    pub fn is_uncertain(&self) -> bool {
        self.high - self.low > 0.01 * self.high
    }
}

/// The height of the light above a disc's plane, over its distance, below which the disc is seen by the edge and left
/// out.
pub const EDGE: f64 = 1e-4;

/// A condition on a number, "it is above 0": whether it may hold, and whether it must.
fn above<R: Real>(number: R) -> [bool; 2] {
    [number.value() + number.error() > 0.0, number.value() - number.error() > 0.0]
}

/// The map of a light from points, row by row: each texel's near distance over that of the nearest disc.
///
/// A disc covers the texels whose centres' rays meet it, and the texel of its own centre in any case, no further than
/// `reach` texels away from that. Along each ray its distance is that of its plane, but never less than that of any point
/// of the disc.
// [Ritschel 2008, Section 3.2], with discs for their splats
pub fn splats<'a, R: Real>(
    view: &View<R>,
    points: impl IntoIterator<Item = &'a Point>,
    maps: &Maps,
    reach: usize,
) -> Vec<Range> {
    let tile = maps.tile;
    let mut texels = vec![Range { low: 0.0, high: 0.0 }; tile * tile];
    for point in points {
        let offset = view.offset(Vector3::constant(point.position));
        let either = view.basis.coordinates(Vector3::constant(point.normal));
        // On the far side of the disc. Where rounding decides which that is, the disc is seen by the edge.
        let normal = if either.dot(offset).value() > 0.0 { either } else { -either };
        let radius = R::constant(point.radius);
        let distance = map::distance(offset);
        let height = normal.dot(offset);
        let mut conditions = vec![
            above(offset.z),
            // A point at just the near distance counts.
            above(distance - view.near + R::constant(1e-300)),
            above(height - R::constant(EDGE) * distance),
        ];
        if !conditions.iter().all(|[may, _]| *may) {
            continue;
        }
        conditions.push([true, view.basis.certain]);
        let nearest = (distance - R::constant(3f64.sqrt()) * radius).max(view.near);
        let centre = map::place(offset, tile).map(|side| map::texels(side, tile));
        // How far the rim can be at most, in texels: only what bounds the work; see the shader.
        let [column, row] = map::place(offset, tile)
            .map(|side| (side * R::constant(2.0) - R::constant(tile as f64)).abs());
        let rim = (R::constant(0.5f64.sqrt() * tile as f64)
            + R::constant(0.75f64.sqrt()) * column.max(row))
            * radius
            / nearest;
        let rim = (R::one() + rim).min(R::constant(reach as f64));
        let [least, most] = [rim.value() - rim.error(), rim.value() + rim.error()]
            .map(|reach| if reach.is_finite() { reach.max(0.0).floor() as usize } else { 8 });
        let range = |axis: usize| {
            centre[axis][0].saturating_sub(most)..=(centre[axis][1] + most).min(tile - 1)
        };
        for row in range(1) {
            for column in range(0) {
                let texel = [column, row];
                let ray = map::ray(texel.map(|side| side as f64 + 0.5), tile);
                // The ray meets the plane at height/facing; all of this times facing.
                let facing = normal.dot(ray);
                let aside = ray * height - offset * facing;
                let inside = above((radius * facing).squared() - aside.length_squared());
                let is_centre = [
                    (0..2).all(|axis| (centre[axis][0]..=centre[axis][1]).contains(&texel[axis])),
                    (0..2).all(|axis| centre[axis] == [texel[axis]; 2]),
                ];
                let within = (0..2).all(|axis| {
                    centre[axis].iter().all(|&centre| texel[axis].abs_diff(centre) <= least)
                });
                let covers = [0, 1].map(|must| is_centre[must] || inside[must]);
                let [may, must] = [0, 1].map(|must| {
                    conditions.iter().all(|condition| condition[must])
                        && above(facing)[must]
                        && covers[must]
                });
                let inverse = facing * (R::one() / height);
                let value = view.near * inverse.min(R::one() / nearest);
                let ceiling = view.near / nearest;
                let held = &mut texels[row * tile + column];
                if may {
                    let high = value.value() + value.error();
                    held.high = held.high.max(high.min(ceiling.value() + ceiling.error()));
                }
                if must && within {
                    held.low = held.low.max(value.value() - value.error());
                }
            }
        }
    }
    texels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::stress::Random;
    use crate::visibility::Basis;

    const MAPS: Maps = Maps { tile: 32, columns: 1, near_scale: 1.0, least_near: 1e-3, bias: 0.05 };

    fn view() -> View {
        let axis = Vector3::new(0.2, -0.5, 0.6).normalized();
        View { position: Vector3::new(0.3, 0.1, 0.2), near: 0.01, basis: Basis::about(axis) }
    }

    #[test]
    fn discs_that_cover_a_plane_make_its_map() {
        // A grid of discs on a plane at the height 1; each covers its square.
        let view = view();
        let (spacing, side) = (0.04, 60);
        let points: Vec<Point> = (0..side * side)
            .map(|index| {
                let at = [index % side, index / side].map(|at| f64::from(at - side / 2) * spacing);
                Point {
                    position: view.position + view.basis.vector(Vector3::new(at[0], at[1], 1.0)),
                    radius: 0.5 * 2f64.sqrt() * spacing,
                    normal: view.basis.z,
                }
            })
            .collect();
        let texels = splats(&view, &points, &MAPS, 4);
        let mut covered = 0;
        for (index, texel) in texels.iter().enumerate() {
            let place = [(index % 32) as f64 + 0.5, (index / 32) as f64 + 0.5];
            let ray: Vector3 = map::ray(place, 32);
            let hit = ray * (1.0 / ray.z);
            // Between the discs' outermost centres every texel holds the plane's own distance.
            if hit.x.abs() < 1.1 && hit.y.abs() < 1.1 {
                covered += 1;
                assert!((texel.low / (view.near * ray.z) - 1.0).abs() < 1e-9, "{index} {texel:?}");
                assert_eq!(texel.low, texel.high);
            } else if hit.x.abs() > 1.6 || hit.y.abs() > 1.6 {
                assert_eq!(texel.high, 0.0);
            }
        }
        assert!(covered > 100, "{covered}");
        // Negative control: half as wide they leave holes.
        let thin: Vec<Point> = points
            .iter()
            .step_by(7)
            .map(|point| Point { radius: 0.1 * point.radius, ..*point })
            .collect();
        let holes = splats(&view, &thin, &MAPS, 4).iter().filter(|texel| texel.high == 0.0).count();
        assert!(holes > 1024 - covered + 20, "{holes} {covered}");
    }

    #[test]
    fn a_disc_is_never_nearer_than_its_nearest_point() {
        let view = view();
        let mut random = Random::new(9);
        for _ in 0..2000 {
            let mut number = || random.normal();
            let position = view.position + Vector3::new(number(), number(), number());
            let normal = Vector3::new(number(), number(), number()).normalized();
            let point = Point { position, radius: 0.05 * random.uniform(), normal };
            let distance = map::distance(view.offset(position));
            for texel in splats(&view, [&point], &MAPS, 2) {
                let nearest = (distance - 3f64.sqrt() * point.radius).max(view.near);
                assert!(texel.high <= view.near / nearest * (1.0 + 1e-12));
            }
        }
    }

    #[test]
    fn rounding_makes_few_texels_uncertain() {
        let exact = view();
        let bounded = View::<crate::Bounded> {
            position: Vector3::constant(exact.position),
            near: Real::constant(exact.near),
            basis: Basis::about(Vector3::constant(exact.basis.z)),
        };
        let mut random = Random::new(8);
        let points: Vec<Point> = (0..2000)
            .map(|_| {
                let mut number = || random.normal();
                let position = Vector3::new(number(), number(), number());
                let normal = Vector3::new(number(), number(), number()).normalized();
                Point { position, radius: 0.03, normal }
            })
            .collect();
        let (plain, hedged) =
            (splats(&exact, &points, &MAPS, 2), splats(&bounded, &points, &MAPS, 2));
        let mut uncertain = 0;
        for (plain, hedged) in plain.iter().zip(&hedged) {
            assert!(hedged.low <= plain.low && plain.high <= hedged.high, "{plain:?} {hedged:?}");
            uncertain += usize::from(hedged.is_uncertain());
        }
        println!("{uncertain} of {}", plain.len());
        assert!(uncertain * 50 < plain.len(), "{uncertain}");
        assert!(plain.iter().filter(|texel| texel.low > 0.0).count() > 300);
    }
}

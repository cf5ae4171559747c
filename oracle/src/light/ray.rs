//! The rays of a light through the points of its map, and back.

use crate::Vector3;
use crate::light::photon::{LEAST_COSINE, Light, LightKind, TILES};
use crate::surface::{Camera, Ray};

/// A point of a light's map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapPoint {
    /// Column and row, in texels: centres are at half-integers, row 0 is the top.
    pub at: [f64; 2],
    /// Texels per steradian around it; per unit of area across the rays of directional lights.
    pub density: f64,
}

impl MapPoint {
    /// The texel that the point lies in, on a map of `size` texels.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped before")]
    pub fn texel(&self, size: [usize; 2]) -> [usize; 2] {
        [0, 1].map(|axis| {
            let last = size[axis].saturating_sub(1);
            (self.at[axis].floor().clamp(0.0, last as f64)) as usize
        })
    }
}

/// The part of a light's map that one camera draws.
struct Tile {
    camera: Camera,
    first: [f64; 2],
    size: [usize; 2],
}

impl Tile {
    /// Texels per steradian in a unit direction, or per area of parallel rays.
    // The solid angle of a small piece of the plane at unit distance is its area times the cubed cosine.
    fn density(&self, direction: Vector3) -> f64 {
        let extent = self.camera.half_extent;
        let texels = self.size[0] as f64 * self.size[1] as f64 / (4.0 * extent[0] * extent[1]);
        if !self.camera.perspective {
            return texels;
        }
        let cosine = direction.dot(self.camera.forward);
        texels / (cosine * cosine * cosine)
    }
}

impl Light {
    fn tile(&self, face: usize, size: [usize; 2]) -> Option<Tile> {
        let camera = self.cameras().get(face).copied()?;
        let [columns, rows] = if self.kind == LightKind::Point { TILES } else { [1, 1] };
        let tile = [size[0] / columns, size[1] / rows];
        let first = [(face % columns * tile[0]) as f64, (face / columns * tile[1]) as f64];
        (tile[0] > 0 && tile[1] > 0).then_some(Tile { camera, first, size: tile })
    }

    /// The ray through a point of the map, and that point; `None` outside the map, in a point light's empty tiles, and
    /// of what is no light.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the map")]
    pub fn ray(&self, at: [f64; 2], size: [usize; 2]) -> Option<(Ray, MapPoint)> {
        if (0..2).any(|axis| !(0.0..=size[axis] as f64).contains(&at[axis])) {
            return None;
        }
        let [columns, rows] = if self.kind == LightKind::Point { TILES } else { [1, 1] };
        let face = |axis: usize, count: usize| {
            let tile = (size[axis] / count).max(1) as f64;
            ((at[axis] / tile) as usize).min(count - 1)
        };
        let tile = self.tile(face(1, rows) * columns + face(0, columns), size)?;
        let ray = tile.camera.ray([at[0] - tile.first[0], at[1] - tile.first[1]], tile.size);
        let density = tile.density(ray.direction);
        Some((ray, MapPoint { at, density }))
    }

    /// The four corners of the piece of a surface that a texel of the map covers, around it: where the rays through
    /// the texel's corners meet the plane of its surface. Texels of one plane share corners.
    ///
    /// Where light grazes the surface (a cosine below 0.05 at the centre, as for [`Light::footprint`], or one that falls
    /// to less than half of that at a corner) the texel is no small piece: there it is the parallelogram that it would
    /// cover at a cosine of at least 0.05, along the surface. `None` of a texel that has no ray.
    #[must_use]
    pub fn quad(
        &self,
        texel: [usize; 2],
        size: [usize; 2],
        position: Vector3,
        normal: Vector3,
    ) -> Option<[Vector3; 4]> {
        let [columns, rows] = if self.kind == LightKind::Point { TILES } else { [1, 1] };
        let column = texel[0].checked_div(size[0] / columns)?.min(columns - 1);
        let row = texel[1].checked_div(size[1] / rows)?.min(rows - 1);
        let tile = self.tile(row * columns + column, size)?;
        let ray = |offset: [f64; 2]| {
            let at = [0, 1].map(|axis| texel[axis] as f64 + offset[axis] - tile.first[axis]);
            tile.camera.ray(at, tile.size)
        };
        let along = ray([0.5; 2]).direction;
        let cosine = -along.dot(normal);
        let rays = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(ray);
        let least = rays.iter().map(|ray| -ray.direction.dot(normal)).fold(cosine, f64::min);
        if least > 0.5 * cosine && cosine >= LEAST_COSINE {
            return Some(rays.map(|ray| {
                let height = (position - ray.origin).dot(normal);
                ray.origin + ray.direction * (height / ray.direction.dot(normal))
            }));
        }
        let forward = tile.camera.forward;
        Some(rays.map(|ray| {
            // On the plane across the camera through the position, from there along the centre's ray to the surface.
            let depth = (position - ray.origin).dot(forward) / ray.direction.dot(forward);
            let aside = ray.origin + ray.direction * depth - position;
            let moved = aside + along * (aside.dot(normal) / cosine.max(LEAST_COSINE));
            position + moved - normal * moved.dot(normal)
        }))
    }

    /// The point of the map whose ray leads to a position; `None` if there is none.
    #[must_use]
    pub fn project(&self, position: Vector3, size: [usize; 2]) -> Option<MapPoint> {
        let from = position - self.position;
        let face = if self.kind == LightKind::Point {
            let parts = from.to_array();
            let axis = (0..3).max_by(|&a, &b| parts[a].abs().total_cmp(&parts[b].abs()))?;
            2 * axis + usize::from(parts[axis] < 0.0)
        } else {
            0
        };
        let tile = self.tile(face, size)?;
        let camera = &tile.camera;
        let depth = from.dot(camera.forward);
        let scale = match (camera.perspective, depth > 0.0) {
            (true, true) => 1.0 / depth,
            (true, false) => return None,
            (false, _) => 1.0,
        };
        let u = from.dot(camera.right) * scale / camera.half_extent[0];
        let v = from.dot(camera.up) * scale / camera.half_extent[1];
        if !(u.abs() <= 1.0 && v.abs() <= 1.0) {
            return None;
        }
        let at = [
            tile.first[0] + 0.5 * (u + 1.0) * tile.size[0] as f64,
            tile.first[1] + 0.5 * (1.0 - v) * tile.size[1] as f64,
        ];
        Some(MapPoint { at, density: tile.density(from.normalized()) })
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::fis::stress::Random;
    use crate::scenery::light;

    fn kinds() -> [LightKind; 3] {
        [
            LightKind::Spot { tan_half_angle: 0.6, cone_scale: 0.0, cone_offset: 1.0 },
            LightKind::Directional { half_extent: 3.0 },
            LightKind::Point,
        ]
    }

    #[test]
    fn a_point_of_the_map_is_found_again_from_what_its_ray_meets() {
        let mut random = Random::new(1);
        for kind in kinds() {
            let (light, size) = (light(kind, Vector3::new(1.0, -2.0, 0.5)), [64, 48]);
            let mut empty = 0;
            for _ in 0..1000 {
                let at = [64.0 * random.uniform(), 48.0 * random.uniform()];
                let Some((ray, point)) = light.ray(at, size) else {
                    empty += 1;
                    continue;
                };
                let found = light.project(ray.origin + ray.direction * 7.0, size).unwrap();
                assert!((0..2).all(|axis| (found.at[axis] - at[axis]).abs() < 1e-9), "{kind:?}");
                assert!((found.density / point.density - 1.0).abs() < 1e-9);
                assert_eq!(found.texel(size), [at[0] as usize, at[1] as usize]);
                // The photon's power by the midpoint: intensity over the density of texels.
                let texel = found.texel(size);
                let middle = [texel[0] as f64 + 0.5, texel[1] as f64 + 0.5];
                let centre = light.ray(middle, size).unwrap().1;
                let power = light.photon_power::<f64>(texel, size).x;
                assert!((power * centre.density - 1.0).abs() < 1e-12, "{kind:?}");
            }
            // Two of a point light's eight tiles.
            let expected = if kind == LightKind::Point { 200..300 } else { 0..1 };
            assert!(expected.contains(&empty), "{kind:?} {empty}");
            assert!(light.ray([-1.0, 0.0], size).is_none());
        }
        let spot = light(kinds()[0], Vector3::zero());
        assert!(spot.project(Vector3::new(0.0, 0.0, 1.0), [8, 8]).is_none(), "behind the light");
        assert!(spot.project(Vector3::new(1.0, 0.0, -1.0), [8, 8]).is_none(), "beside the map");
    }

    fn area(corners: [Vector3; 4]) -> f64 {
        let [a, b, c, d] = corners;
        0.5 * (c - a).cross(d - b).length()
    }

    #[test]
    fn quads_of_a_plane_share_corners_and_cover_the_footprint() {
        let normal = Vector3::new(0.3, 0.2, 0.9).normalized();
        let size = [128, 64];
        for kind in kinds() {
            let light = light(kind, Vector3::new(0.2, 0.1, 3.0));
            let on_plane = |texel: [usize; 2]| {
                let (ray, _) = light.ray(texel.map(|part| part as f64 + 0.5), size)?;
                let along = ray.direction.dot(normal);
                let distance = -ray.origin.dot(normal) / along;
                (along < -0.2).then(|| ray.origin + ray.direction * distance)
            };
            let mut seen = 0;
            for index in 0..128 * 64 {
                let texel = [index % 128, index / 128];
                let Some(position) = on_plane(texel) else { continue };
                let quad = light.quad(texel, size, position, normal).unwrap();
                assert!(quad.iter().all(|corner| corner.dot(normal).abs() < 1e-9), "{kind:?}");
                let (towards, square) = light.towards(position);
                let footprint = light.footprint(texel, size, square, normal.dot(towards));
                assert!((area(quad) / footprint - 1.0).abs() < 0.05, "{kind:?} {texel:?}");
                let right = [texel[0] + 1, texel[1]];
                // Neighbours of one tile.
                if right[0] % 32 != 0
                    && let Some(position) = on_plane(right)
                {
                    let other = light.quad(right, size, position, normal).unwrap();
                    assert!((other[0] - quad[1]).length() < 1e-9);
                    assert!((other[3] - quad[2]).length() < 1e-9);
                    seen += 1;
                }
            }
            assert!(seen > 300, "{seen}");
        }
    }

    /// Along the light's rays a texel has no bounds; its quad stays within those of the least cosine.
    #[test]
    fn quads_at_grazing_light_are_bounded() {
        let size = [64, 32];
        for kind in kinds() {
            let light = light(kind, Vector3::new(0.2, 0.1, 3.0));
            let texel = [17, 9];
            let (ray, point) = light.ray([17.5, 9.5], size).unwrap();
            let position = ray.origin + ray.direction * 2.0;
            let (_, distance_squared) = light.towards(position);
            let across = distance_squared / point.density;
            let (x, _) = ray.direction.basis();
            for cosine in [0.2, 0.06, 0.051, 0.049, 1e-3, 1e-9, 0.0, -1e-3, -0.5] {
                let normal =
                    (x * (1.0_f64 - cosine * cosine).sqrt() - ray.direction * cosine).normalized();
                let quad = light.quad(texel, size, position, normal).unwrap();
                assert!(quad.iter().all(|c| (*c - position).dot(normal).abs() < 1e-9));
                let stretched = area(quad) / across;
                let expected = 1.0 / cosine.max(LEAST_COSINE);
                println!("{kind:?} {cosine}: {stretched} {expected}");
                // Perspective makes corners uneven, at most by the half that is granted.
                assert!(
                    stretched < 2.0 * expected && stretched > 0.2,
                    "{kind:?} {cosine} {stretched}"
                );
                assert!(cosine < 0.051 || stretched > 0.9 * expected);
            }
        }
    }

    #[test]
    fn densities_are_those_of_solid_angle() {
        let mut random = Random::new(2);
        let light = light(LightKind::Point, Vector3::zero());
        let (count, size) = (200_000, [64, 32]);
        let sum: f64 = (0..count)
            .filter_map(|_| {
                let at = [64.0 * random.uniform(), 32.0 * random.uniform()];
                light.ray(at, size).map(|(_, point)| 1.0 / point.density)
            })
            .sum();
        let sphere = sum * 64.0 * 32.0 / f64::from(count);
        assert!((sphere / (4.0 * PI) - 1.0).abs() < 0.01, "{sphere}");
    }
}

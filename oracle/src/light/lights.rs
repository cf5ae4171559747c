//! The lights of one map: one that has it to itself, or several that share it.

use crate::Vector3;
use crate::light::photon::{Light, LightKind, face_axes};

/// The lights of a map.
#[derive(Clone, Copy, Debug)]
pub enum Lights<'a> {
    /// One light, whose image the map is.
    One(&'a Light),
    /// Several, each face of which has a tile of the map.
    Several {
        /// Each of them.
        lights: &'a [Light],
        /// Width in texels of what each has in the middle of its tile, of the tile's proportions, where that is not the
        /// whole tile; of those behind the last it is.
        texels: &'a [Option<usize>],
    },
}

impl<'a> From<&'a Light> for Lights<'a> {
    fn from(light: &'a Light) -> Self {
        Self::One(light)
    }
}

/// A texel of a map as the image of a light has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceTexel {
    /// The light; of a face of a point light a spot light without a cone.
    pub light: Light,
    /// The texel in its image.
    pub texel: [usize; 2],
    /// Width and height of its image.
    pub size: [usize; 2],
}

/// The lights whose images the faces of a light are: itself, or six spot lights of 90 degrees without a cone.
#[must_use]
pub fn faces(light: &Light) -> Vec<Light> {
    if light.kind != LightKind::Point {
        return vec![*light];
    }
    let kind = LightKind::Spot { tan_half_angle: 1.0, cone_scale: 0.0, cone_offset: 1.0 };
    let face = |[right, up, forward]: [Vector3; 3]| Light { kind, right, up, forward, ..*light };
    (0..6).filter_map(face_axes).map(face).collect()
}

/// Columns and rows of the tiles of so many faces: powers of two, as many columns as rows or twice as many.
#[must_use]
pub fn grid(faces: usize) -> [usize; 2] {
    let mut grid = [1, 1];
    while grid[0] * grid[1] < faces {
        grid[usize::from(grid[0] > grid[1])] *= 2;
    }
    grid
}

impl Lights<'_> {
    /// A texel of a map of `size` texels; nothing in a tile that no face has, and around what a light has of one.
    #[must_use]
    pub fn at(&self, texel: [usize; 2], size: [usize; 2]) -> Option<FaceTexel> {
        let (lights, texels) = match *self {
            Self::One(light) => return Some(FaceTexel { light: *light, texel, size }),
            Self::Several { lights, texels } => (lights, texels),
        };
        let all = lights.iter().enumerate().flat_map(|(index, light)| {
            let texels = texels.get(index).copied().flatten();
            faces(light).into_iter().map(move |face| (face, texels))
        });
        let faces: Vec<(Light, Option<usize>)> = all.collect();
        let [columns, rows] = grid(faces.len());
        let size = [size[0] / columns, size[1] / rows];
        let tile = [0, 1].map(|axis| texel[axis].checked_div(size[axis]));
        let [column, row] = [tile[0]?, tile[1]?];
        let (light, width) = *faces.get(row * columns + column)?;
        let own = width.map_or(size, |width| [width, width * size[1] / size[0]]);
        let place = |axis: usize, tile: usize| {
            let first = tile * size[axis] + (size[axis] - own[axis]) / 2;
            texel[axis].checked_sub(first).filter(|&place| place < own[axis])
        };
        Some(FaceTexel { light, texel: [place(0, column)?, place(1, row)?], size: own })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lights() -> [Light; 3] {
        let of = |kind, intensity| Light {
            kind,
            position: Vector3::new(0.3, 2.0, -0.1),
            right: Vector3::new(1.0, 0.0, 0.0),
            up: Vector3::new(0.0, 0.0, -1.0),
            forward: Vector3::new(0.0, -1.0, 0.0),
            intensity: Vector3::splat(intensity),
        };
        let spot = LightKind::Spot { tan_half_angle: 0.6, cone_scale: 20.0, cone_offset: -18.0 };
        [
            of(LightKind::Point, 1.0),
            of(spot, 5.0),
            of(LightKind::Directional { half_extent: 2.0 }, 0.7),
        ]
    }

    fn several(lights: &[Light]) -> Lights<'_> {
        Lights::Several { lights, texels: &[] }
    }

    fn total(lights: Lights<'_>, size: [usize; 2]) -> Vector3 {
        let texels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
        let power = |texel| {
            let of: Option<FaceTexel> = lights.at(texel, size);
            of.map_or(Vector3::zero(), |of| of.light.photon_power(of.texel, of.size))
        };
        texels.map(power).fold(Vector3::zero(), |sum, power| sum + power)
    }

    #[test]
    fn grids_are_the_smallest_that_hold_all_faces() {
        for (faces, expected) in [(1, [1, 1]), (2, [2, 1]), (3, [2, 2]), (5, [4, 2]), (6, [4, 2])] {
            assert_eq!(grid(faces), expected);
        }
        assert_eq!([grid(9), grid(17), grid(64)], [[4, 4], [8, 4], [8, 8]]);
    }

    #[test]
    fn a_map_holds_the_power_of_all_its_lights() {
        let all = lights();
        let each = all.iter().map(|light| total(light.into(), [256, 256]));
        let each = each.fold(Vector3::zero(), |sum, power| sum + power);
        let shared = total(several(&all), [256, 256]);
        assert!((shared.x / each.x - 1.0).abs() < 2e-3, "{shared:?} {each:?}");
        // Negative control: without one of them.
        assert!((total(several(&all[..2]), [256, 256]).x / each.x - 1.0).abs() > 0.1);
    }

    #[test]
    fn images_in_tiles_are_maps_of_their_sizes() {
        let all = lights();
        let texels = [Some(16), Some(30), None];
        let lights = Lights::Several { lights: &all, texels: &texels };
        // Eight faces in a grid of four by two.
        let shared = total(lights, [256, 256]);
        let sizes = [[64, 64], [30, 60], [64, 128]];
        let of = |sizes: [[usize; 2]; 3]| {
            let each = all.iter().zip(sizes).map(|(light, size)| total(light.into(), size));
            each.fold(Vector3::zero(), |sum, power| sum + power)
        };
        let off = |other: Vector3| (shared - other).length() / shared.length();
        assert!(off(of(sizes)) < 1e-12, "{}", off(of(sizes)));
        // Negative control: whole tiles.
        assert!(off(of([[256, 256], [64, 128], [64, 128]])) > 1e-6);
        let dark = (0..64).filter(|&x| lights.at([x, 64], [256, 256]).is_none()).count();
        assert_eq!(dark, 48);
    }

    #[test]
    fn one_among_several_is_what_it_is_alone() {
        for light in lights() {
            let size = [32, 16];
            for index in 0..32 * 16 {
                let at = [index % 32, index / 32];
                let shared = several(std::slice::from_ref(&light)).at(at, size);
                let power =
                    shared.map_or(Vector3::zero(), |of| of.light.photon_power(of.texel, of.size));
                let alone = light.photon_power::<f64>(at, size);
                assert!((power - alone).length() < 1e-15, "{:?} {at:?}", light.kind);
            }
        }
    }
}

//! The exact map of a light, by rays.

use crate::Vector3;
use crate::visibility::exact::nearest;
use crate::visibility::map::{self, View};

/// What a texel of a rasterised map may hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texel {
    /// The near distance over that of what the ray through the texel's centre meets, 0 where there is nothing.
    pub value: f64,
    /// How far the values of rays within `snap` texels of the centre are from it.
    pub spread: f64,
    /// Whether they all meet the same triangle, or nothing.
    pub certain: bool,
}

/// A texel of the map of a light among triangles; what is nearer than the near distance is not met.
///
/// `snap`: by how much of a texel a rasteriser may move vertices.
#[must_use]
pub fn texel(
    triangles: &[[Vector3; 3]],
    view: &View,
    [column, row]: [usize; 2],
    tile: usize,
    snap: f64,
) -> Texel {
    let centre = [column as f64 + 0.5, row as f64 + 0.5];
    let meet = |place: [f64; 2]| {
        let ray: Vector3 = map::ray(place, tile);
        nearest(triangles, view.position, view.basis.vector(ray), view.near)
    };
    let value = |met: Option<(f64, usize)>| met.map_or(0.0, |(distance, _)| view.near / distance);
    let middle = meet(centre);
    let mut texel = Texel { value: value(middle), spread: 0.0, certain: true };
    for aside in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
        let met = meet([0, 1].map(|axis| centre[axis] + snap * aside[axis]));
        texel.spread = texel.spread.max((value(met) - texel.value).abs());
        texel.certain &= met.map(|met| met.1) == middle.map(|met| met.1);
    }
    texel
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visibility::Basis;

    #[test]
    fn a_texel_holds_what_its_ray_meets() {
        let up = Vector3::new(0.0, 0.0, 1.0);
        let view = View { position: Vector3::zero(), near: 0.1, basis: Basis::about(up) };
        let at = |z: f64, side: f64| {
            [
                Vector3::new(-side, -side, z),
                Vector3::new(3.0 * side, -side, z),
                Vector3::new(-side, 3.0 * side, z),
            ]
        };
        let triangles = [at(4.0, 40.0), at(2.0, 0.5), at(0.02, 9.0)];
        let middle = texel(&triangles, &view, [32, 32], 64, 0.125);
        // The centre's ray, a little aside of the axis, meets the nearer wall; what is too near is not met.
        let [x, y, z] = map::ray::<f64>([32.5, 32.5], 64).to_array();
        assert!(middle.certain && (middle.value - 0.1 * z / 2.0).abs() < 1e-15, "{middle:?}");
        assert!(x > 0.0 && y == 0.0 && middle.spread > 0.0 && middle.spread < 1e-2 * middle.value);
        let beside = texel(&triangles, &view, [50, 32], 64, 0.125);
        assert!(beside.value < 0.1 / 4.0 && beside.value > 0.0);
        assert_eq!(texel(&triangles[2..], &view, [32, 32], 64, 0.125).value, 0.0);
    }
}

//! Shadows by comparing depths.

use glam::DMat4;

use crate::Vector3;

/// A light's depth map: row 0 is the top, depth 0 to 1 from near to far.
#[derive(Clone, Copy, Debug)]
pub struct ShadowMap<'a> {
    /// Depths, row by row.
    pub depths: &'a [f32],
    /// Width and height of the whole map in texels.
    pub size: [usize; 2],
    /// First texel and size of the tile to look into; the whole map but for point lights.
    pub tile: [[usize; 2]; 2],
    /// From the world to clip space of the tile, depth 0 to 1.
    pub clip_from_world: DMat4,
    /// Depth subtracted from the surface's, at least 0.
    pub bias: f64,
}

/// The share of a light that is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadow {
    /// 0 in shadow, 1 in light.
    pub visibility: f64,
    /// The smallest distance of the surface's depth to a depth that it was compared with.
    pub margin: f64,
    /// Distance, in texels, of the place to the nearest line where other texels are compared.
    pub texel_margin: f64,
}

impl ShadowMap<'_> {
    /// The mean of four comparisons, weighted bilinearly, with texels clamped to the tile. Behind the light or beside
    /// the tile nothing is in shadow: the light's own cone has to end there.
    // [Reeves et al. 1987, Rendering antialiased shadows with depth maps], on 2 x 2 texels
    #[must_use]
    pub fn shadow(&self, position: Vector3) -> Shadow {
        let lit = Shadow { visibility: 1.0, margin: f64::INFINITY, texel_margin: f64::INFINITY };
        let clip = self.clip_from_world * glam::DVec3::from(position).extend(1.0);
        if clip.w <= 0.0 {
            return lit;
        }
        let [x, y, z] = [clip.x / clip.w, clip.y / clip.w, clip.z / clip.w];
        if x.abs() > 1.0 || y.abs() > 1.0 {
            return lit;
        }
        let [first, size] = self.tile;
        let place =
            [(0.5 + 0.5 * x) * size[0] as f64 - 0.5, (0.5 - 0.5 * y) * size[1] as f64 - 0.5];
        let depth = z - self.bias;
        let mut shadow = Shadow { visibility: 0.0, ..lit };
        for corner in 0..4 {
            let mut texel = [0; 2];
            let mut weight = 1.0;
            for axis in 0..2 {
                let second = (corner >> axis) & 1;
                let floor = place[axis].floor();
                let fraction = place[axis] - floor;
                weight *= if second == 1 { fraction } else { 1.0 - fraction };
                texel[axis] = first[axis]
                    + (floor + second as f64).clamp(0.0, (size[axis] - 1) as f64) as usize;
                shadow.texel_margin = shadow.texel_margin.min(fraction.min(1.0 - fraction));
            }
            let stored = f64::from(self.depths[texel[1] * self.size[0] + texel[0]]);
            shadow.margin = shadow.margin.min((depth - stored).abs());
            if depth <= stored {
                shadow.visibility += weight;
            }
        }
        shadow
    }
}

/// The face of a point light's map that a direction from the light falls in: that of its largest coordinate.
///
/// Of equal coordinates x wins over y, and y over z.
#[must_use]
pub fn face_of(direction: Vector3) -> usize {
    let parts = direction.to_array();
    let magnitude = |axis: usize| parts[axis].abs();
    let axis = if magnitude(0) >= magnitude(1) && magnitude(0) >= magnitude(2) {
        0
    } else if magnitude(1) >= magnitude(2) {
        1
    } else {
        2
    };
    2 * axis + usize::from(parts[axis] < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::photon::face_axes;

    fn map(depths: &[f32]) -> ShadowMap<'_> {
        ShadowMap {
            depths,
            size: [4, 4],
            tile: [[0, 0], [4, 4]],
            // Looks along -z; depth 0 to 1 from z = 0 to z = -10.
            clip_from_world: DMat4::from_scale(glam::DVec3::new(1.0, 1.0, -0.1)),
            bias: 0.01,
        }
    }

    #[test]
    fn edges_of_shadows_are_bilinear() {
        // The right half is occluded at depth 0.2.
        let depths: Vec<f32> =
            (0..16).map(|index| if index % 4 >= 2 { 0.2 } else { 1.0 }).collect();
        let map = map(&depths);
        let seen = |x: f64, z: f64| map.shadow(Vector3::new(x, 0.1, z)).visibility;
        assert_eq!((seen(-0.5, -5.0), seen(0.5, -5.0), seen(0.5, -1.0)), (1.0, 0.0, 1.0));
        assert!((seen(0.0, -5.0) - 0.5).abs() < 1e-12);
        assert!((seen(0.1, -5.0) - 0.3).abs() < 1e-12);
        // The bias lets the occluder itself be lit.
        assert_eq!(seen(0.5, -2.0), 1.0);
        assert_eq!(
            ShadowMap { bias: -0.01, ..map }.shadow(Vector3::new(0.5, 0.1, -2.0)).visibility,
            0.0
        );
    }

    #[test]
    fn row_zero_is_the_top() {
        let depths: Vec<f32> = (0..16).map(|index| if index < 8 { 0.2 } else { 1.0 }).collect();
        assert_eq!(map(&depths).shadow(Vector3::new(0.1, 0.6, -5.0)).visibility, 0.0);
        assert_eq!(map(&depths).shadow(Vector3::new(0.1, -0.6, -5.0)).visibility, 1.0);
    }

    #[test]
    fn faces_hold_their_own_directions() {
        for face in 0..6 {
            let [right, up, forward] = face_axes(face).unwrap();
            assert_eq!(face_of(forward + right * 0.9 - up * 0.7), face);
        }
    }
}

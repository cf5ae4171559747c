//! The photon of every texel of a light's map: its power and its direction.

use crate::surface::Camera;
use crate::{Real, Vector3};

/// The least cosine of light at a surface that a texel's piece of it is stretched by.
pub const LEAST_COSINE: f64 = 0.05;

/// What a light is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// A cone from a point.
    Spot {
        /// Half extent of the map at unit distance, above 0.
        tan_half_angle: f64,
        /// Factor of the cosine in the cone's attenuation.
        cone_scale: f64,
        /// Summand in the cone's attenuation.
        cone_offset: f64,
    },
    /// Parallel rays.
    Directional {
        /// Half extent of the map in world units, above 0.
        half_extent: f64,
    },
    /// All directions from a point.
    Point,
    /// No light but the camera: each texel of its map sends an importance of 1.
    Camera,
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// What the light is.
    pub kind: LightKind,
    /// Where it is; for directional lights the centre of the map.
    pub position: Vector3,
    /// Unit vector to the right of the map.
    pub right: Vector3,
    /// Unit vector to the top of the map.
    pub up: Vector3,
    /// Unit vector along which the light looks.
    pub forward: Vector3,
    /// Radiant intensity (W/sr or cd) of spot and point lights, irradiance on a facing surface (W/m^2 or lux) of
    /// directional ones.
    pub intensity: Vector3,
}

/// Columns and rows of the tiles of a point light's map.
pub const TILES: [usize; 2] = [4, 2];

/// The right, up and forward vectors of a face of a point light's map, 0 to 5 for +x, -x, +y, -y, +z, -z.
#[must_use]
pub fn face_axes(face: usize) -> Option<[Vector3; 3]> {
    let axis = |index: usize, sign: f64| {
        let mut parts = [0.0; 3];
        parts[index] = sign;
        Vector3::new(parts[0], parts[1], parts[2])
    };
    let sign = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    let forward = match face {
        0..6 => axis(face / 2, sign),
        _ => return None,
    };
    let up = if face / 2 == 1 { axis(2, sign) } else { axis(1, 1.0) };
    Some([forward.cross(up), up, forward])
}

/// Where a texel of a light's map lies on the image plane at unit distance (in world units for directional lights).
struct Place {
    /// Coordinates to the right and up, as the half extent's multiples -1 to 1.
    centre: [f64; 2],
    /// Size of the texel in the same unit.
    size: [f64; 2],
    /// Face of a point light.
    face: usize,
}

fn place(kind: LightKind, [x, y]: [usize; 2], [width, height]: [usize; 2]) -> Place {
    let [columns, rows] = if kind == LightKind::Point { TILES } else { [1, 1] };
    let (tile_width, tile_height) = (width / columns, height / rows);
    let (column, row) = (x / tile_width, y / tile_height);
    let size = [2.0 / tile_width as f64, 2.0 / tile_height as f64];
    let centre = [
        ((x % tile_width) as f64 + 0.5) * size[0] - 1.0,
        1.0 - ((y % tile_height) as f64 + 0.5) * size[1],
    ];
    Place { centre, size, face: row * columns + column }
}

impl Light {
    /// The cameras that draw the light's map: one, or six of a point light in the order of the faces.
    #[must_use]
    pub fn cameras(&self) -> Vec<Camera> {
        let own = Camera {
            position: self.position,
            right: self.right,
            up: self.up,
            forward: self.forward,
            half_extent: [1.0; 2],
            perspective: true,
        };
        match self.kind {
            LightKind::Spot { tan_half_angle, .. } => {
                vec![Camera { half_extent: [tan_half_angle; 2], ..own }]
            }
            LightKind::Directional { half_extent } => {
                vec![Camera { half_extent: [half_extent; 2], perspective: false, ..own }]
            }
            LightKind::Point => (0..6)
                .filter_map(face_axes)
                .map(|[right, up, forward]| Camera { right, up, forward, ..own })
                .collect(),
            // The camera's picture is drawn by itself.
            LightKind::Camera => Vec::new(),
        }
    }

    /// The radiant intensity in a direction whose cosine with `forward` is given; the irradiance of a directional light.
    // [KHR_lights_punctual, inner and outer cone angles]
    pub fn intensity_at<R: Real>(&self, cosine: R) -> Vector3<R> {
        let intensity = Vector3::constant(self.intensity);
        match self.kind {
            LightKind::Spot { cone_scale, cone_offset, .. } => {
                let cone =
                    (cosine * R::constant(cone_scale) + R::constant(cone_offset)).clamp(0.0, 1.0);
                intensity * cone.squared()
            }
            LightKind::Directional { .. } | LightKind::Point | LightKind::Camera => intensity,
        }
    }

    /// The power of the photon of a texel of a map of `size` texels; 0 in a point light's empty tiles.
    pub fn photon_power<R: Real>(&self, texel: [usize; 2], size: [usize; 2]) -> Vector3<R> {
        let place = place(self.kind, texel, size);
        let extent = match self.kind {
            LightKind::Spot { tan_half_angle, .. } => R::constant(tan_half_angle),
            LightKind::Directional { half_extent } => R::constant(half_extent),
            LightKind::Point | LightKind::Camera => R::one(),
        };
        let area = extent.squared() * (R::constant(place.size[0]) * R::constant(place.size[1]));
        match self.kind {
            LightKind::Directional { .. } => Vector3::constant(self.intensity) * area,
            LightKind::Camera => Vector3::splat(R::one()),
            LightKind::Point if place.face > 5 => Vector3::zero(),
            LightKind::Spot { .. } | LightKind::Point => {
                let [u, v] = place.centre.map(|part| R::constant(part) * extent);
                let square = R::one() + u.squared() + v.squared();
                let length = square.sqrt();
                let solid_angle = area / (square * length);
                self.intensity_at(R::one() / length) * solid_angle
            }
        }
    }

    /// The unit direction from a position to the light, and the squared distance (1 for directional lights).
    pub fn towards<R: Real>(&self, position: Vector3<R>) -> (Vector3<R>, R) {
        match self.kind {
            LightKind::Directional { .. } => (-Vector3::constant(self.forward), R::one()),
            LightKind::Spot { .. } | LightKind::Point | LightKind::Camera => {
                let path = Vector3::constant(self.position) - position;
                (path.normalized(), path.length_squared())
            }
        }
    }

    /// The area of the surface that a texel of the map covers, at a distance and a cosine of incidence.
    ///
    /// The cosine is kept at or above [`LEAST_COSINE`], where a texel's footprint is no longer a small patch.
    #[must_use]
    pub fn footprint<R: Real>(
        &self,
        texel: [usize; 2],
        size: [usize; 2],
        distance_squared: R,
        cosine: R,
    ) -> R {
        let unit = Self { intensity: Vector3::splat(1.0), kind: self.without_cone(), ..*self };
        let power: Vector3<R> = unit.photon_power(texel, size);
        power.x * distance_squared / cosine.max(R::constant(LEAST_COSINE))
    }

    fn without_cone(&self) -> LightKind {
        match self.kind {
            LightKind::Spot { tan_half_angle, .. } => {
                LightKind::Spot { tan_half_angle, cone_scale: 0.0, cone_offset: 1.0 }
            }
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;

    fn light(kind: LightKind) -> Light {
        Light {
            kind,
            position: Vector3::new(1.0, 2.0, 3.0),
            right: Vector3::new(1.0, 0.0, 0.0),
            up: Vector3::new(0.0, 1.0, 0.0),
            forward: Vector3::new(0.0, 0.0, -1.0),
            intensity: Vector3::new(1.0, 2.0, 0.5),
        }
    }

    fn total(light: &Light, size: [usize; 2]) -> Vector3 {
        let texels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
        texels
            .map(|texel| light.photon_power::<f64>(texel, size))
            .fold(Vector3::zero(), |sum, power| sum + power)
    }

    #[test]
    fn the_photons_of_a_point_light_fill_the_sphere() {
        let light = light(LightKind::Point);
        let error = |size: usize| (total(&light, [size, size]).x / (4.0 * PI) - 1.0).abs();
        // The rule of midpoints: second order.
        assert!(error(256) < 1e-4, "{}", error(256));
        assert!((error(64) / error(256) - 16.0).abs() < 1.0);
        assert_eq!(light.photon_power::<f64>([250, 250], [256, 256]), Vector3::zero());
    }

    #[test]
    fn the_photons_of_a_spot_light_carry_its_cone() {
        // Attenuated from cos 0.9 to cos 0.95: 2 pi times the integral of clamp(20 c - 18, 0, 1)^2.
        let kind = LightKind::Spot { tan_half_angle: 0.6, cone_scale: 20.0, cone_offset: -18.0 };
        let expected = 2.0 * PI * (0.05 + 0.05 / 3.0);
        assert!((total(&light(kind), [512, 512]).x / expected - 1.0).abs() < 1e-4);
        // The map's corners reach beyond the cone, the footprint does not know of the cone.
        assert_eq!(light(kind).photon_power::<f64>([0, 0], [512, 512]), Vector3::zero());
        assert!(light(kind).footprint([0, 0], [512, 512], 4.0, 0.5) > 0.0);
    }

    #[test]
    fn the_photons_of_a_directional_light_carry_its_irradiance() {
        let light = light(LightKind::Directional { half_extent: 3.0 });
        assert!((total(&light, [16, 8]) - Vector3::new(36.0, 72.0, 18.0)).length() < 1e-11);
        assert_eq!(light.towards(Vector3::zero()).0, Vector3::new(0.0, 0.0, 1.0));
    }

    #[test]
    fn faces_look_where_the_conventions_say() {
        for face in 0..6 {
            let [right, up, forward] = face_axes(face).unwrap();
            assert!(
                (right.cross(up) + forward).length() < 1e-15,
                "looks along -z of its own space"
            );
            let sign = if face % 2 == 0 { 1.0 } else { -1.0 };
            assert_eq!(forward.to_array()[face / 2], sign);
            let expected_up = [[0.0, 1.0, 0.0], [0.0, 0.0, sign], [0.0, 1.0, 0.0]][face / 2];
            assert_eq!(up.to_array(), expected_up);
        }
        assert!(face_axes(6).is_none());
    }
}

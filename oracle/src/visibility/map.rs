//! The map of a light: its hemisphere as a square.

use crate::visibility::Basis;
use crate::vsgl::Vsgl;
use crate::{Real, Vector3};

/// What the maps of all lights have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Maps {
    /// Width and height of a light's tile in texels.
    pub tile: usize,
    /// Tiles in a row of the atlas.
    pub columns: usize,
    /// What lies within this many standard deviations of a light's positions does not hide it.
    pub near_scale: f64,
    /// What lies within this distance does not hide it either; above 0.
    pub least_near: f64,
    /// How far a receiver is moved along its normal, over its distance.
    pub bias: f64,
}

/// Where a light's map is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View<R = f64> {
    /// The light's mean position.
    pub position: Vector3<R>,
    /// What is nearer than this does not hide it.
    pub near: R,
    /// Its z is the axis of the diffuse emission, or of the specular lobe where there is none.
    pub basis: Basis<R>,
}

impl<R: Real> View<R> {
    /// Of a light.
    #[must_use]
    pub fn of_light(light: &Vsgl<R>, maps: &Maps) -> Self {
        let near = R::constant(maps.near_scale) * light.variance.sqrt();
        let channels = light.diffuse.coefficient.to_array();
        // Metal alone: a mean of no normals has no direction.
        let none = channels.iter().all(|channel| channel.value() <= 0.0);
        let certain = channels.iter().all(|channel| channel.error() == 0.0)
            || channels.iter().any(|channel| channel.value() > channel.error());
        let (axis, certain) = match &light.specular {
            Some(specular) if none => (specular.axis, certain),
            Some(_) => (light.diffuse.axis, certain),
            None => (light.diffuse.axis, true),
        };
        let basis = Basis::about(axis);
        Self {
            position: light.position,
            near: near.max(R::constant(maps.least_near)),
            basis: Basis { certain: certain && basis.certain, ..basis },
        }
    }

    /// A position of the world in the basis, seen from the light.
    #[must_use]
    pub fn offset(&self, position: Vector3<R>) -> Vector3<R> {
        self.basis.coordinates(position - self.position)
    }
}

/// The distance that maps are in, `|x| + |y| + |z|`: each octant then is a perspective image.
#[must_use]
pub fn distance<R: Real>(offset: Vector3<R>) -> R {
    offset.x.abs() + offset.y.abs() + offset.z.abs()
}

/// Where an offset of the upper hemisphere lies in a tile, in texels.
// [Cigolle 2014, Section 3.2, hemi-oct]
#[must_use]
pub fn place<R: Real>(offset: Vector3<R>, tile: usize) -> [R; 2] {
    let distance = distance(offset);
    let (x, y) = (offset.x / distance, offset.y / distance);
    let half = R::constant(0.5);
    [x + y, x - y].map(|side| (half * side + half) * R::constant(tile as f64))
}

/// The direction of a place in a tile; its [`distance`] is 1.
// [Cigolle 2014, Section 3.2, hemi-oct]
#[must_use]
pub fn ray<R: Real>(place: [f64; 2], tile: usize) -> Vector3<R> {
    // Tiles are powers of two, so that all of this is exact for texels' centres, in f32 as well.
    let [first, second] = place.map(|side| 2.0 * side / tile as f64 - 1.0);
    let (x, y) = (0.5 * (first + second), 0.5 * (first - second));
    Vector3::constant(Vector3::new(x, y, 1.0 - x.abs() - y.abs()))
}

/// The texels that a coordinate may lie in: the lowest and the highest.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the tile")]
pub fn texels<R: Real>(coordinate: R, tile: usize) -> [usize; 2] {
    let (value, error) = (coordinate.value(), coordinate.error());
    [value - error, value + error].map(|end| end.floor().clamp(0.0, (tile - 1) as f64) as usize)
}

/// The least bias with which a plane does not shadow itself in an exact map.
///
/// Rays s of distance 1 meet a plane at the distance `h/(-n.s)`, n its normal towards the light and h its height above
/// it. A receiver lifted by b along n, at the distance w' along s', is compared with the plane along the ray s of a
/// texel's centre, so it is lit if `(h - b)/(-n.s') <= h/(-n.s)`. With `-n.s' = (h - b)/w'` that is
/// `-n.(s - s') <= b/w'`, which holds if b is at least `|s - s'| w'`. Half a texel is 1/tile of half a tile in either
/// direction; on a face of the octahedron that is `|s - s'| <= sqrt(2)/tile`, and two faces lengthen no way. Lifting by b
/// changes the distance by at most sqrt(3) b, so that `b = bias w` is enough if
/// `bias >= sqrt(2)/tile (1 + sqrt(3) bias)`.
#[must_use]
pub fn least_bias(tile: usize) -> f64 {
    2f64.sqrt() / (tile as f64 - 6f64.sqrt())
}

/// The solid angle of a place per area of the square `[-1, 1]^2`: `1/2 |s|^-3`, s the ray of distance 1.
#[must_use]
pub fn solid_angle_density(place: [f64; 2], tile: usize) -> f64 {
    0.5 * ray::<f64>(place, tile).length().powi(-3)
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::Bounded;
    use crate::fis::stress::Random;

    fn upper(random: &mut Random) -> Vector3 {
        let direction = Vector3::new(random.normal(), random.normal(), random.normal());
        Vector3::new(direction.x, direction.y, direction.z.abs()) * (2.0 * random.normal()).exp()
    }

    #[test]
    fn the_map_of_metal_is_about_its_specular_lobe() {
        let lobe = |axis, power| crate::vsgl::Lobe {
            axis,
            sharpness: 2.0,
            coefficient: Vector3::new(0.0, power, 0.0),
        };
        let [diffuse, specular] = [Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.6, 0.0, 0.8)];
        let maps = Maps { tile: 8, columns: 1, near_scale: 1.0, least_near: 1e-3, bias: 0.0 };
        let axis = |power, specular| {
            let light = Vsgl {
                position: Vector3::zero(),
                variance: 1e-4,
                diffuse: lobe(diffuse, power),
                diffuse_mean_length: 0.5,
                specular,
            };
            View::of_light(&light, &maps).basis.z
        };
        let lit = Some(lobe(specular, 1.0));
        assert_eq!(
            [axis(0.0, lit), axis(1e-3, lit), axis(0.0, None)],
            [specular, diffuse, diffuse]
        );
    }

    #[test]
    fn places_and_rays_are_inverse() {
        let mut random = Random::new(1);
        for _ in 0..1000 {
            let offset = upper(&mut random);
            let place = place(offset, 64);
            assert!(place.iter().all(|side| (0.0..=64.0).contains(side)));
            let back: Vector3 = ray(place, 64);
            assert!((distance(back) - 1.0).abs() < 1e-13);
            assert!((back * distance(offset) - offset).length() < 1e-12 * offset.length());
        }
    }

    #[test]
    fn an_octant_is_a_perspective_image() {
        // Straight lines stay straight, and the inverse of the distance is linear along them.
        let mut random = Random::new(2);
        let mut bent = 0.0_f64;
        for _ in 0..1000 {
            let [a, b] = [(); 2].map(|()| upper(&mut random));
            let b = Vector3::new(b.x.copysign(a.x), b.y.copysign(a.y), b.z);
            let middle = (a + b) * 0.5;
            let [from, to, via] = [a, b, middle].map(|offset| place(offset, 1));
            let [near, far, mean] = [a, b, middle].map(|offset| 1.0 / distance(offset));
            let along = (mean - near) / (far - near);
            for axis in 0..2 {
                let straight = from[axis] + along * (to[axis] - from[axis]);
                assert!((straight - via[axis]).abs() < 1e-6 / (far - near).abs().min(1.0));
            }
            // Negative control: a paraboloid [Brabec 2002] bends them.
            let paraboloid = |offset: Vector3| {
                let unit = offset.normalized();
                [unit.x / (1.0 + unit.z), unit.y / (1.0 + unit.z)]
            };
            let [from, to, via] = [a, b, middle].map(paraboloid);
            let (line, aside) =
                ([to[0] - from[0], to[1] - from[1]], [via[0] - from[0], via[1] - from[1]]);
            let cross = line[0] * aside[1] - line[1] * aside[0];
            bent = bent.max(cross.abs() / line[0].hypot(line[1]));
        }
        assert!(bent > 0.05, "{bent}");
    }

    #[test]
    fn texels_of_the_octahedron_and_of_a_paraboloid() {
        let tile = 256;
        let area = 4.0 / (tile * tile) as f64;
        let (mut sum, mut least, mut most) = (0.0, f64::INFINITY, 0.0_f64);
        let (mut used, mut bowl, mut bowl_least, mut bowl_most) = (0, 0.0, f64::INFINITY, 0.0_f64);
        for index in 0..tile * tile {
            let at = [(index % tile) as f64 + 0.5, (index / tile) as f64 + 0.5];
            let density = solid_angle_density(at, tile);
            sum += density * area;
            least = least.min(density);
            most = most.max(density);
            // A paraboloid's map of the same square: directions within the unit circle.
            let square = at.map(|side| (2.0 * side / tile as f64 - 1.0).powi(2));
            let radius = square[0] + square[1];
            if radius <= 1.0 {
                let density = 4.0 / (1.0 + radius).powi(2);
                used += 1;
                bowl += density * area;
                bowl_least = bowl_least.min(density);
                bowl_most = bowl_most.max(density);
            }
        }
        let wasted = 1.0 - f64::from(used) / (tile * tile) as f64;
        println!(
            "octahedron: solid angles {:.3}:1, the largest {most:.3} of the square's area; \
             paraboloid: {:.3}:1, the largest {bowl_most:.3}, {:.1} % of the tile unused",
            most / least,
            bowl_most / bowl_least,
            100.0 * wasted
        );
        assert!((sum / (2.0 * PI) - 1.0).abs() < 1e-4 && (bowl / (2.0 * PI) - 1.0).abs() < 1e-2);
        // 3 sqrt(3) to 1 against 4 to 1; but the coarsest texel is smaller, for none are wasted.
        assert!((most / least - 27f64.sqrt()).abs() < 0.1, "{}", most / least);
        assert!((bowl_most / bowl_least - 4.0).abs() < 0.1);
        assert!((most - 1.5 * 3f64.sqrt()).abs() < 0.02 && (bowl_most - 4.0).abs() < 0.02);
        assert!((wasted - (1.0 - PI / 4.0)).abs() < 1e-3);
    }

    #[test]
    fn half_a_texel_is_no_longer_than_the_bias_counts_on() {
        let tile = 64;
        let mut random = Random::new(3);
        let mut longest = 0.0_f64;
        for _ in 0..100_000 {
            let texel = [(); 2].map(|()| (64.0 * random.uniform()).floor() + 0.5);
            let corner = [(); 2].map(|()| if random.uniform() < 0.5 { 0.5 } else { -0.5 });
            let share = if random.uniform() < 0.5 { 1.0 } else { random.uniform() };
            let at = [0, 1].map(|axis| texel[axis] + share * corner[axis]);
            longest = longest.max((ray::<f64>(at, tile) - ray(texel, tile)).length());
        }
        let bound = 2f64.sqrt() / tile as f64;
        assert!(longest <= bound * (1.0 + 1e-12) && longest > 0.999 * bound, "{longest} {bound}");
        let bias = least_bias(tile);
        assert!((bias - bound * (1.0 + 3f64.sqrt() * bias)).abs() < 1e-15);
    }

    #[test]
    fn tolerances_are_useful() {
        let offset = Vector3::constant(Vector3::new(0.3, -1.2, 0.4));
        for side in place::<Bounded>(offset, 64) {
            assert!(side.error < 1e-4 && side.error > 0.0, "{side:?}");
            let [low, high] = texels(side, 64);
            assert_eq!(low, high);
        }
        assert_eq!(texels(Bounded::with_error(3.0, 1e-6), 64), [2, 3]);
        assert_eq!(texels(Bounded::with_error(64.0, 1e-6), 64), [63, 63]);
        let exact: Vector3<Bounded> = ray([10.5, 3.5], 64);
        assert_eq!(exact.x.error, 0.0);
    }
}

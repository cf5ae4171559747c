//! What the texels of a node add up to.

use core::ops::Range;

use crate::cluster::Map;
use crate::rsm::{Emission, Moments, moments};
use crate::surface::SurfaceTexel;
use crate::vsgl::{LEAST_WEIGHT, Vsgl};
use crate::{Linear, Real, Vector3};

/// The least variance of a light, in squared units of length. A texel's own extent is in its moments, so that nothing else
/// bounds it below.
pub const LEAST_VARIANCE: f64 = 1e-12;

/// Moments of texels about their mean, so that what is small beside its distance from the origin does not cancel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentralMoments<R = f64> {
    /// The luminance of the power of all lobes, which weighs positions.
    pub weight: R,
    /// Mean position, relative to the map's origin.
    pub mean: Vector3<R>,
    /// Mean squared distance from the mean position.
    pub variance: R,
    /// The power that is reflected diffusely.
    pub diffuse_power: Vector3<R>,
    /// Sum of the normals, weighed by the luminance of the diffuse power.
    pub diffuse_direction: Vector3<R>,
    /// Sum of these weights.
    pub diffuse_weight: R,
    /// The power that is reflected specularly.
    pub specular_power: Vector3<R>,
    /// Sum of the mean directions of specular lobes, weighed by the luminance of their power.
    pub specular_direction: Vector3<R>,
    /// Sum of their lengths, weighed alike.
    pub specular_length: R,
    /// The lowest and the highest corner of the box around the texels' positions, relative to the map's origin.
    pub bounds: [Vector3<R>; 2],
}

impl<R: Real> CentralMoments<R> {
    /// Of nothing.
    #[must_use]
    pub fn nothing() -> Self {
        let (zero, none) = (R::zero(), Vector3::zero());
        Self {
            weight: zero,
            mean: none,
            variance: zero,
            diffuse_power: none,
            diffuse_direction: none,
            diffuse_weight: zero,
            specular_power: none,
            specular_direction: none,
            specular_length: zero,
            bounds: [none; 2],
        }
    }

    /// Of a texel of a map, spread evenly over the piece of the surface that it covers: `area/12` along each of the plane's
    /// two axes.
    pub fn of_texel(map: &Map<'_, R>, texel: [usize; 2]) -> Self {
        let Some(surface) = map.texels.get(texel[1] * map.size[0] + texel[0]) else {
            return Self::nothing();
        };
        let Some(of) = map.light.at(texel, map.size).filter(|_| surface.present) else {
            return Self::nothing();
        };
        let (towards, squared) = of.light.towards(surface.position);
        let cosine = towards.dot(surface.normal);
        let area = of.light.footprint(of.texel, of.size, squared, cosine);
        let power = of.light.photon_power(of.texel, of.size);
        let reflecting: SurfaceTexel<R> = map.specular_power.reflecting(surface, towards);
        let origin = Vector3::constant(map.origin);
        let normals = Emission { diffuse_mean_length: 1.0, ..map.emission };
        let of: Moments<R> = moments(&reflecting, power, towards, origin, &normals);
        let specular_weight = of.vector(3).luminance();
        let mut length = R::zero();
        if specular_weight.value() > 0.0 {
            // Not of the product, whose square would leave the range of f32.
            length = of.vector(4).map(|part| part / specular_weight).length();
        }
        Self {
            weight: of.weight(),
            mean: surface.position - origin,
            variance: area * R::constant(1.0 / 6.0),
            diffuse_power: of.vector(1),
            diffuse_direction: of.vector(2),
            diffuse_weight: of.layers[2][3],
            specular_power: of.vector(3),
            specular_direction: of.vector(4),
            specular_length: specular_weight * length,
            bounds: [surface.position - origin; 2],
        }
    }

    /// Whether this is of a texel that becomes a leaf.
    #[must_use]
    pub fn lit(&self) -> bool {
        let finite =
            |vector: &Vector3<R>| vector.to_array().iter().all(|part| part.value().is_finite());
        let weight = self.weight.value();
        weight > LEAST_WEIGHT
            && weight.is_finite()
            && finite(&self.mean)
            && finite(&self.diffuse_direction)
    }

    /// Of the texels of both. The parallel form of the variance, which does not cancel.
    // [Chan 1983, Eq. (2.1)]
    #[must_use]
    pub fn merged(self, other: Self) -> Self {
        if self.weight.value() <= 0.0 {
            return other;
        }
        if other.weight.value() <= 0.0 {
            return self;
        }
        let weight = self.weight + other.weight;
        let share = other.weight / weight;
        let own_share = self.weight / weight;
        let apart = other.mean - self.mean;
        Self {
            weight,
            mean: self.mean + apart * share,
            variance: own_share * self.variance
                + share * other.variance
                + own_share * share * apart.length_squared(),
            diffuse_power: self.diffuse_power + other.diffuse_power,
            diffuse_direction: self.diffuse_direction + other.diffuse_direction,
            diffuse_weight: self.diffuse_weight + other.diffuse_weight,
            specular_power: self.specular_power + other.specular_power,
            specular_direction: self.specular_direction + other.specular_direction,
            specular_length: self.specular_length + other.specular_length,
            bounds: joined(self.bounds, other.bounds),
        }
    }

    /// The light of these texels, relative to the map's origin. Nothing gives a light without power there.
    // [Tokuyoshi 2016, Appendix B]
    #[must_use]
    pub fn light(&self, origin: Vector3, emission: &Emission) -> Vsgl<R> {
        let texel = |vector: Vector3<R>, w: R| [vector.x, vector.y, vector.z, w];
        let mut about_mean = Moments::nothing();
        about_mean.layers[0] = texel(Vector3::zero(), self.weight * self.variance);
        about_mean.layers[1] = texel(self.diffuse_power, self.weight);
        let length = R::constant(emission.diffuse_mean_length);
        about_mean.layers[2] = texel(self.diffuse_direction * length, self.diffuse_weight);
        about_mean.layers[3] = texel(self.specular_power, R::zero());
        about_mean.layers[4] = texel(self.specular_direction, R::zero());
        let mean = Vector3::constant(origin) + self.mean;
        let at_zero = Vsgl::of_moments(&about_mean, Vector3::zero(), LEAST_VARIANCE, emission);
        Vsgl { position: mean, ..at_zero }
    }
}

/// The box around two boxes.
fn joined<R: Real>(one: [Vector3<R>; 2], other: [Vector3<R>; 2]) -> [Vector3<R>; 2] {
    let of = |corner: usize, choose: fn(R, R) -> R| {
        let (one, other) = (one[corner].to_array(), other[corner].to_array());
        let [x, y, z] = [0, 1, 2].map(|axis| choose(one[axis], other[axis]));
        Vector3::new(x, y, z)
    };
    [of(0, R::min), of(1, R::max)]
}

/// Sums of leaves over aligned blocks of 1, 2, 4 … of them, from which those of any range are few additions.
#[derive(Clone, Debug)]
pub struct Sums<R = f64> {
    /// Block i has the blocks 2 i and 2 i + 1; block 1 has all leaves, the blocks from the number of leaves on have one.
    blocks: Vec<CentralMoments<R>>,
}

impl<R: Real> Sums<R> {
    /// Of leaves; those that a power of two has more are nothing.
    #[must_use]
    pub fn of_leaves(leaves: &[CentralMoments<R>]) -> Self {
        let size = leaves.len().next_power_of_two();
        let mut blocks = vec![CentralMoments::nothing(); 2 * size];
        blocks[size..size + leaves.len()].copy_from_slice(leaves);
        for block in (1..size).rev() {
            blocks[block] = blocks[2 * block].merged(blocks[2 * block + 1]);
        }
        Self { blocks }
    }

    /// The sum of all leaves.
    #[must_use]
    pub fn all(&self) -> CentralMoments<R> {
        self.blocks[1]
    }

    /// Every block; the first one is none.
    #[must_use]
    pub fn blocks(&self) -> &[CentralMoments<R>] {
        &self.blocks
    }

    /// The sum of a range of leaves, by at most two blocks of each size.
    #[must_use]
    pub fn of(&self, leaves: Range<usize>) -> CentralMoments<R> {
        let size = self.blocks.len() / 2;
        let (mut first, mut end) = (leaves.start + size, leaves.end + size);
        let (mut left, mut right) = (CentralMoments::nothing(), CentralMoments::nothing());
        while first < end {
            if first % 2 == 1 {
                left = left.merged(self.blocks[first]);
                first += 1;
            }
            if end % 2 == 1 {
                end -= 1;
                right = self.blocks[end].merged(right);
            }
            (first, end) = (first / 2, end / 2);
        }
        left.merged(right)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fis::stress::Random;

    fn leaves(count: usize, offset: f64, power: f64) -> Vec<CentralMoments> {
        let mut random = Random::new(count as u64);
        let mut vector = || Vector3::new(random.normal(), random.normal(), random.normal());
        (0..count)
            .map(|_| {
                let color = vector().map(|part| power * (0.1 + part * part));
                let weight = color.luminance();
                let direction = vector().normalized();
                let mean = vector() + Vector3::splat(offset);
                CentralMoments {
                    weight,
                    mean,
                    bounds: [mean; 2],
                    variance: 0.01,
                    diffuse_power: color,
                    diffuse_direction: direction * weight,
                    diffuse_weight: weight,
                    ..CentralMoments::nothing()
                }
            })
            .collect()
    }

    /// Two passes over the leaves: the mean, then distances from it; shares no code with the merges.
    fn plain(leaves: &[CentralMoments]) -> (f64, Vector3, f64) {
        let weight: f64 = leaves.iter().map(|leaf| leaf.weight).sum();
        let mean = leaves.iter().fold(Vector3::zero(), |sum, leaf| sum + leaf.mean * leaf.weight);
        let mean = mean * (1.0 / weight);
        let squared = |leaf: &CentralMoments| {
            leaf.weight * (leaf.variance + (leaf.mean - mean).length_squared())
        };
        (weight, mean, leaves.iter().map(squared).sum::<f64>() / weight)
    }

    #[test]
    fn sums_of_ranges_are_those_of_two_passes() {
        for (offset, power) in [(0.0, 1.0), (1e6, 1.0), (0.0, 1e13), (10.0, 1e-30)] {
            let leaves = leaves(300, offset, power);
            let sums = Sums::of_leaves(&leaves);
            for range in [0..300, 0..1, 7..8, 3..5, 1..299, 64..128, 100..257] {
                let (weight, mean, variance) = plain(&leaves[range.clone()]);
                let of = sums.of(range.clone());
                assert!((of.weight / weight - 1.0).abs() < 1e-13, "{range:?}");
                assert!((of.mean - mean).length() < 1e-13 * (1.0 + offset), "{range:?}");
                assert!((of.variance / variance - 1.0).abs() < 1e-9, "{range:?} {variance}");
            }
            assert_eq!(sums.of(5..5), CentralMoments::nothing());
        }
    }

    /// Sums of squares from the origin lose the variance where the merges keep it.
    #[test]
    fn far_from_the_origin_nothing_cancels() {
        let leaves = leaves(64, 1e9, 1.0);
        let (weight, mean, variance) = plain(&leaves);
        let of = Sums::of_leaves(&leaves).all();
        assert!((of.variance / variance - 1.0).abs() < 1e-6);
        let square: f64 = leaves.iter().map(|leaf| leaf.weight * leaf.mean.length_squared()).sum();
        let cancelled = square / weight - mean.length_squared();
        assert!((cancelled / variance - 1.0).abs() > 0.1, "{cancelled} {variance}");
    }
}

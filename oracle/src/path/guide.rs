//! Where on the light's map the light comes from that a surface reflects: what guides samples of the map.
//!
//! The map is drawn by rays from the light, one through the centre of each texel. What such a point would bring to a
//! surface without visibility is summed for every texel, and texels are drawn in proportion to its luminance. Near a
//! point the inverse square is bounded as that of a disc of the texel's area A is, on its axis: `1/(d^2 + A/pi)`. A share of the draws follows the photons' power instead, so that no lit texel is left out whatever
//! its centre says.

use core::f64::consts::PI;

use crate::Vector3;
use crate::brdf::{Ndf, fresnel};
use crate::light::{Light, LightKind, MapPoint, TILES};
use crate::surface::{Scene, SurfaceTexel};
use crate::vpl::along_the_curve;
use crate::vpl::arriving::{Arriving, Block, Receiver};
use crate::vpl::lane::{LANES, Lane};

use super::materials::Materials;

/// Blocks that stay in the cache while a group of pixels uses them.
const BLOCKS_AT_ONCE: usize = 192;
/// The share of draws in proportion to the photons' power.
const BY_POWER: f64 = 0.125;
/// The share of draws in proportion to what a patch of texels brings, within it to the photons' power: what is smaller
/// than a texel, as the rim of a cup, is met by some centres of a patch and lit through all of it.
const BY_PATCH: f64 = 0.25;
/// Blocks of a patch: 8 by 8 texels where all of them are lit.
const PATCH: usize = 16;

/// A light's map as the oracle draws it, for samples alone.
pub(super) struct Guide {
    size: [usize; 2],
    ndf: Ndf,
    blocks: Vec<Block>,
    /// The luminance of the photons of each block.
    powers: Vec<Lane>,
    power: f64,
    /// The same of each patch.
    patch_powers: Vec<f64>,
    /// The first texel of each block, a square of two by two.
    firsts: Vec<[usize; 2]>,
    /// The block of each square of the map, by rows, if photons pass it.
    of_square: Vec<Option<u32>>,
}

impl Guide {
    /// The map of a light of about `side` by `side` texels; nothing is drawn from a map of none.
    pub(super) fn new(
        light: &Light,
        scene: &Scene,
        materials: &dyn Materials,
        ndf: Ndf,
        side: usize,
    ) -> Self {
        let side = side.next_multiple_of(2);
        let size = match light.kind {
            // Square faces, six of them on eight tiles.
            LightKind::Point => [side / 2 * TILES[0], side / 2 * TILES[1]],
            _ => [side; 2],
        };
        let across = size[0] / 2;
        let mut squares: Vec<[usize; 2]> =
            (0..size[1] / 2).flat_map(|y| (0..across).map(move |x| [2 * x, 2 * y])).collect();
        squares.sort_by_key(|&square| along_the_curve(square));
        let mut guide = Self {
            size,
            ndf,
            blocks: Vec::new(),
            powers: Vec::new(),
            power: 0.0,
            patch_powers: Vec::new(),
            firsts: Vec::new(),
            of_square: vec![None; squares.len()],
        };
        for first in squares {
            guide.add(light, scene, materials, first, across);
        }
        let power = |patch: &[Lane]| patch.iter().flat_map(|lane| lane.0).sum();
        guide.patch_powers = guide.powers.chunks(PATCH).map(power).collect();
        guide
    }

    fn add(
        &mut self,
        light: &Light,
        scene: &Scene,
        materials: &dyn Materials,
        first: [usize; 2],
        across: usize,
    ) {
        let (mut block, mut powers) = (Block::dark(), Lane::default());
        for (lane, power_of) in powers.0.iter_mut().enumerate() {
            let texel = texel_of(first, lane);
            let power = light.photon_power::<f64>(texel, self.size);
            let at = texel.map(|part| part as f64 + 0.5);
            let Some((ray, _)) = light.ray(at, self.size).filter(|_| power != Vector3::zero())
            else {
                continue;
            };
            *power_of = power.luminance().max(0.0);
            if let Some(crossing) = scene.nearest(&ray, &|crossing| materials.counts(crossing)) {
                let surface = SurfaceTexel {
                    position: crossing.hit.position,
                    normal: materials.normal(&crossing),
                    material: materials.material(&crossing),
                    present: true,
                };
                let (towards, distance_squared) = light.towards(surface.position);
                let cosine = surface.normal.dot(towards);
                let area = light.footprint(texel, self.size, distance_squared, cosine);
                block.put(self.ndf, lane, &surface, towards, power, area / PI);
            }
        }
        let power: f64 = powers.0.iter().sum();
        if power > 0.0 {
            let number = u32::try_from(self.blocks.len()).ok();
            self.of_square[first[1] / 2 * across + first[0] / 2] = number;
            self.blocks.push(block);
            self.powers.push(powers);
            self.power += power;
            self.firsts.push(first);
        }
    }

    /// What the map brings to some surfaces, in their order.
    pub(super) fn seen_from(&self, surfaces: &[SurfaceTexel], eye: Vector3) -> Vec<Seen> {
        let mut seen: Vec<Seen> =
            surfaces.iter().map(|surface| Seen::new(surface, eye, self)).collect();
        for start in (0..self.blocks.len()).step_by(BLOCKS_AT_ONCE) {
            let end = self.blocks.len().min(start + BLOCKS_AT_ONCE);
            for (surface, seen) in surfaces.iter().zip(&mut seen) {
                if surface.present {
                    match self.ndf {
                        Ndf::Ggx => seen.add::<true>(self, start, end),
                        Ndf::Beckmann => seen.add::<false>(self, start, end),
                    }
                }
            }
        }
        for seen in &mut seen {
            seen.patches = seen.luminances.chunks(PATCH).map(|patch| patch.iter().sum()).collect();
            seen.whole = seen.patches.iter().sum();
        }
        seen
    }

    /// How many samples per steradian of the light (per unit of area across the rays of a directional one) one draw
    /// takes at a point of the map.
    pub(super) fn density(&self, seen: &Seen, point: &MapPoint) -> f64 {
        let [x, y] = point.texel(self.size);
        let square = y / 2 * (self.size[0] / 2) + x / 2;
        let Some(block) = self.of_square.get(square).copied().flatten() else {
            return 0.0;
        };
        let lane = x % 2 + 2 * (y % 2);
        seen.masses(self, block as usize).0[lane] * point.density
    }

    /// The point of the map of a position, if photons may be drawn there.
    pub(super) fn project(&self, light: &Light, position: Vector3) -> Option<MapPoint> {
        if self.blocks.is_empty() { None } else { light.project(position, self.size) }
    }

    /// The texels of a map.
    pub(super) fn size(&self) -> [usize; 2] {
        self.size
    }
}

/// The texel of a lane of the square that begins with a texel.
fn texel_of(first: [usize; 2], lane: usize) -> [usize; 2] {
    [first[0] + lane % 2, first[1] + lane / 2]
}

/// What a surface reflects of a light's map towards the eye, texel by texel.
pub(super) struct Seen {
    receiver: Receiver,
    /// The luminance that is reflected per irradiance of each channel: diffusely, and specularly of `D V` and of that
    /// times Schlick's weight.
    weights: [[Lane; 3]; 3],
    /// Of every block.
    luminances: Vec<f64>,
    /// Of every patch.
    patches: Vec<f64>,
    /// Of all of them.
    whole: f64,
}

impl Seen {
    fn new(surface: &SurfaceTexel, eye: Vector3, guide: &Guide) -> Self {
        let material = &surface.material;
        let luminance = |color: Vector3| {
            let [red, green, blue] = color.to_array();
            [[red, 0.0, 0.0], [0.0, green, 0.0], [0.0, 0.0, blue]]
                .map(|[x, y, z]| Lane::all(Vector3::new(x, y, z).luminance()))
        };
        let grazing = Vector3::splat(fresnel::f90(material.specular)) - material.specular;
        Self {
            receiver: Receiver::new(surface, eye, guide.ndf),
            weights: [material.diffuse_brdf(), material.specular, grazing].map(luminance),
            luminances: vec![0.0; guide.blocks.len()],
            patches: Vec::new(),
            whole: 0.0,
        }
    }

    fn add<const GGX: bool>(&mut self, guide: &Guide, start: usize, end: usize) {
        for (block, sum) in guide.blocks[start..end].iter().zip(&mut self.luminances[start..end]) {
            let luminance = luminance(&self.weights, Arriving::new::<GGX>(block, &self.receiver));
            *sum = luminance.0.iter().sum();
        }
    }

    /// The share of draws of each texel of a block.
    fn masses(&self, guide: &Guide, block: usize) -> Lane {
        let by_power = guide.powers[block] * Lane::all(self.per_power(guide, block));
        if self.whole <= 0.0 {
            return by_power;
        }
        let block = &guide.blocks[block];
        let arriving = match guide.ndf {
            Ndf::Ggx => Arriving::new::<true>(block, &self.receiver),
            Ndf::Beckmann => Arriving::new::<false>(block, &self.receiver),
        };
        luminance(&self.weights, arriving) * Lane::all(self.per_luminance()) + by_power
    }

    /// The share of draws of a block.
    fn mass(&self, guide: &Guide, block: usize) -> f64 {
        let power: f64 = guide.powers[block].0.iter().sum();
        let by_power = power * self.per_power(guide, block);
        if self.whole <= 0.0 {
            return by_power;
        }
        self.luminances[block] * self.per_luminance() + by_power
    }

    fn per_luminance(&self) -> f64 {
        (1.0 - BY_POWER - BY_PATCH) / self.whole
    }

    /// The share of draws of a photon's power in a block.
    fn per_power(&self, guide: &Guide, block: usize) -> f64 {
        if self.whole <= 0.0 {
            return 1.0 / guide.power;
        }
        let patch = block / PATCH;
        let of_patch = self.patches[patch] / (self.whole * guide.patch_powers[patch]);
        BY_POWER / guide.power + BY_PATCH * of_patch
    }
}

/// The luminance that lights of a block bring.
#[inline(always)]
fn luminance(weights: &[[Lane; 3]; 3], arriving: Arriving) -> Lane {
    let mut sum = Lane::default();
    for (channel, irradiance) in arriving.irradiance.into_iter().enumerate() {
        let specular = weights[1][channel] + weights[2][channel] * arriving.weight;
        let reflected = weights[0][channel] + arriving.received * specular;
        sum = sum + irradiance * reflected;
    }
    sum
}

/// A walk along the texels of a map in the order of their blocks, neighbours together, so that equal shares of what a
/// surface sees are patches of the map.
pub(super) struct Walk<'a> {
    guide: &'a Guide,
    seen: &'a Seen,
    block: usize,
    /// The shares of the blocks before.
    before: f64,
}

impl<'a> Walk<'a> {
    /// A walk; `None` of a map without photons.
    pub(super) fn new(guide: &'a Guide, seen: &'a Seen) -> Option<Self> {
        (!guide.blocks.is_empty()).then_some(Self { guide, seen, block: 0, before: 0.0 })
    }

    /// The texel at a place on the running sum of shares, 0 to 1, not before that of the last call.
    pub(super) fn texel(&mut self, at: f64) -> [usize; 2] {
        let last = self.guide.blocks.len() - 1;
        let mut mass = self.seen.mass(self.guide, self.block);
        while self.block < last && self.before + mass <= at {
            self.before += mass;
            self.block += 1;
            mass = self.seen.mass(self.guide, self.block);
        }
        let masses = self.seen.masses(self.guide, self.block).0;
        let mut before = self.before;
        let mut drawn = 0;
        for (lane, &mass) in masses.iter().enumerate() {
            // What rounding leaves behind the last share is given to the last texel that has any.
            if mass > 0.0 {
                drawn = lane;
                before += mass;
                if at < before {
                    break;
                }
            }
        }
        debug_assert!(drawn < LANES);
        texel_of(self.guide.firsts[self.block], drawn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenery::{Table, diffuse, glossy, light, square, texel};

    /// Texels are drawn as often as is said of them, each of equal shares once.
    #[test]
    fn draws_follow_the_stated_density() {
        let scene = Scene::new(square([-1.0; 2], [1.0; 2], 0.0, 0).to_vec()).unwrap();
        let table = Table(vec![glossy(0.8, 0.2)]);
        let spot = LightKind::Spot { tan_half_angle: 0.6, cone_scale: 10.0, cone_offset: -8.5 };
        let lights = [
            light(spot, Vector3::new(0.2, -0.1, 1.8)),
            light(LightKind::Point, Vector3::new(0.2, -0.1, 1.8)),
            light(LightKind::Directional { half_extent: 1.5 }, Vector3::new(0.0, 0.0, 2.0)),
        ];
        for light in lights {
            let guide = Guide::new(&light, &scene, &table, Ndf::Ggx, 16);
            let down = Vector3::new(0.0, 0.0, -1.0);
            let places = [Vector3::new(0.3, 0.1, 0.4), Vector3::new(0.0, 0.0, -1.0)];
            let receivers = places.map(|place| texel(place, down, diffuse(0.5)));
            let seen = guide.seen_from(&receivers, Vector3::new(0.0, 0.5, 0.7));
            // From below the map nothing is seen: draws follow the power alone.
            assert!(seen[0].whole > 0.0 && seen[1].whole == 0.0, "{light:?}");
            for seen in &seen {
                let count = 100_000;
                let mut drawn = vec![0_u32; guide.size[0] * guide.size[1]];
                let mut walk = Walk::new(&guide, seen).unwrap();
                for number in 0..count {
                    let [x, y] = walk.texel((f64::from(number) + 0.5) / f64::from(count));
                    drawn[y * guide.size[0] + x] += 1;
                }
                let mut sum = 0.0;
                for (index, &drawn) in drawn.iter().enumerate() {
                    let at = [index % guide.size[0], index / guide.size[0]];
                    let middle = at.map(|part| part as f64 + 0.5);
                    let Some((_, point)) = light.ray(middle, guide.size) else {
                        assert_eq!(drawn, 0);
                        continue;
                    };
                    let share = guide.density(seen, &point) / point.density;
                    let off = (f64::from(drawn) - share * f64::from(count)).abs();
                    assert!(off < 1.01, "{light:?} {at:?} {drawn} {share}");
                    sum += share;
                }
                assert!((sum - 1.0).abs() < 1e-12, "{sum}");
            }
        }
        // Without a map, or in the dark, nothing is drawn.
        let dark = Light { intensity: Vector3::zero(), ..lights[0] };
        for guide in [
            Guide::new(&dark, &scene, &table, Ndf::Ggx, 16),
            Guide::new(&lights[0], &scene, &table, Ndf::Ggx, 0),
        ] {
            let seen = guide.seen_from(&[texel(down(), down(), diffuse(0.5))], Vector3::zero());
            assert!(Walk::new(&guide, &seen[0]).is_none());
            assert!(guide.project(&lights[0], Vector3::zero()).is_none());
        }
    }

    fn down() -> Vector3 {
        Vector3::new(0.0, 0.0, -1.0)
    }
}

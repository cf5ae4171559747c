//! The reference of a picture's indirect light: every texel of the light's map is a virtual point light.
//!
//! Brute force in f64, with the real BRDF at both ends of every path and without visibility: what the virtual spherical
//! Gaussian lights approximate. It is exact but for the geometry term: the inverse square of the distance has no finite
//! integral over the surface, so that a sum over points has bright spots next to them. A texel is not a point but a
//! patch of area A. The form factor of a disc of area A as seen from a small patch on its axis and parallel to it is
//! `A/(A + pi d^2)`, so that the irradiance of a source of power on that disc goes with `1/(d^2 + A/pi)`: bounded at the
//! disc, and the inverse square far from it.
//!
//! [`VisiblePoints`] takes away what is hidden, and says how far the lattice of points may be off.

use core::f64::consts::PI;
use core::ops::{Add, Div, Mul, Sub};

use crate::Vector3;
use crate::brdf::material::MINIMUM_COSINE;
use crate::brdf::{Ndf, fresnel};
use crate::groups::in_groups;
use crate::light::Light;
use crate::shade::Reflected;
use crate::surface::SurfaceTexel;

mod visible;

pub use visible::VisiblePoints;

/// Lights that are summed side by side: the four texels of a square, so that each lane is a coarser map of its own.
const LANES: usize = 4;
/// Blocks of lights that stay in the cache while a group of pixels uses them.
const BLOCKS_AT_ONCE: usize = 192;
/// Pixels that one task works on.
const PIXELS_AT_ONCE: usize = 64;

/// A number of each of some lights.
///
/// Plain loops over arrays, which the compiler turns into vector instructions.
#[derive(Clone, Copy, Debug, Default)]
struct Lane([f64; LANES]);

impl Lane {
    #[inline(always)]
    fn all(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        let mut result = Self::default();
        for lane in 0..LANES {
            result.0[lane] = function(self.0[lane], other.0[lane]);
        }
        result
    }
    #[inline(always)]
    fn map(self, function: impl Fn(f64) -> f64) -> Self {
        self.zip(self, |value, _| function(value))
    }
    /// At least `low`; a plain comparison, since nothing is NaN here.
    #[inline(always)]
    fn at_least(self, low: f64) -> Self {
        self.map(|value| if value > low { value } else { low })
    }
    #[inline(always)]
    fn dot(a: [Self; 3], b: [Self; 3]) -> Self {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }
}

impl Add for Lane {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Lane {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Lane {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Div for Lane {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

/// What the sum needs of some lights; everything that does not depend on the pixel is done beforehand.
#[derive(Clone, Copy, Debug)]
struct Block {
    position: [Lane; 3],
    normal: [Lane; 3],
    towards: [Lane; 3],
    /// Area over pi.
    disc: Lane,
    facet: FixedFacet<Lane>,
    /// `Phi R_d/pi`.
    diffuse: [Lane; 3],
    /// `Phi R_s` and `Phi (1 - R_s)`: the Fresnel term's part without and with Schlick's weight.
    specular: [Lane; 3],
    grazing: [Lane; 3],
}

impl Block {
    /// Lights without power, which the last block is filled up with; finite everywhere.
    fn dark() -> Self {
        let (zero, one) = ([Lane::default(); 3], Lane::all(1.0));
        Self {
            position: zero,
            normal: zero,
            towards: zero,
            disc: one,
            facet: FixedFacet { cosine: one, width: one, masking: one, kept: one },
            diffuse: zero,
            specular: zero,
            grazing: zero,
        }
    }
}

/// The virtual point lights of a light's map.
#[derive(Clone, Debug)]
pub struct VirtualPointLights {
    blocks: Vec<Block>,
    count: usize,
    /// Lanes in use, filled or left empty.
    lanes: usize,
    ndf: Ndf,
}

impl VirtualPointLights {
    /// The lights of a map of `size` texels, row by row from the top; texels without surface or power are left out.
    ///
    /// Lights that are neighbours here are neighbours on the map.
    #[must_use]
    pub fn of_map(light: &Light, texels: &[SurfaceTexel], size: [usize; 2], ndf: Ndf) -> Self {
        let mut lights = Self::none(ndf);
        let mut squares: Vec<[usize; 2]> = (0..size[1].div_ceil(2))
            .flat_map(|y| (0..size[0].div_ceil(2)).map(move |x| [2 * x, 2 * y]))
            .collect();
        squares.sort_by_key(|&square| along_the_curve(square));
        for [x, y] in squares {
            for lane in 0..LANES {
                let texel = [x + lane % 2, y + lane / 2];
                if texel[0] >= size[0] || texel[1] >= size[1] {
                    continue;
                }
                let Some(surface) = texels.get(texel[1] * size[0] + texel[0]) else {
                    continue;
                };
                let power = light.photon_power::<f64>(texel, size);
                if surface.present && power != Vector3::zero() {
                    let (towards, distance_squared) = light.towards(surface.position);
                    let cosine = surface.normal.dot(towards);
                    let area = light.footprint(texel, size, distance_squared, cosine);
                    lights.place(lights.lanes + lane, surface, towards, power, area);
                }
            }
            lights.lanes = LANES * lights.blocks.len();
        }
        lights
    }

    /// Without lights.
    #[must_use]
    pub fn none(ndf: Ndf) -> Self {
        Self { blocks: Vec::new(), count: 0, lanes: 0, ndf }
    }

    /// Adds the light of a surface that a photon of some power reaches against the unit direction `towards`, and that
    /// stands for an area.
    pub fn push(&mut self, surface: &SurfaceTexel, towards: Vector3, power: Vector3, area: f64) {
        self.place(self.lanes, surface, towards, power, area);
        self.lanes += 1;
    }

    /// Puts a light into a lane, counted through all blocks, which is one in use or of the block behind them.
    fn place(
        &mut self,
        lane: usize,
        surface: &SurfaceTexel,
        towards: Vector3,
        power: Vector3,
        area: f64,
    ) {
        let (block, lane) = (lane / LANES, lane % LANES);
        if block >= self.blocks.len() {
            self.blocks.push(Block::dark());
        }
        self.count += 1;
        let Some(block) = self.blocks.get_mut(block) else {
            return;
        };
        let material = surface.material;
        let set = |lanes: &mut [Lane; 3], vector: Vector3| {
            for (lanes, part) in lanes.iter_mut().zip(vector.to_array()) {
                lanes.0[lane] = part;
            }
        };
        set(&mut block.position, surface.position);
        set(&mut block.normal, surface.normal);
        set(&mut block.towards, towards);
        set(&mut block.diffuse, power.times(material.diffuse_brdf()));
        set(&mut block.specular, power.times(material.specular));
        let grazing = Vector3::splat(fresnel::grazing(material.specular));
        set(&mut block.grazing, power.times(grazing - material.specular));
        block.disc.0[lane] = area / PI;
        let facet = FixedFacet::new(self.ndf, surface.normal.dot(towards), material.alpha);
        block.facet.cosine.0[lane] = facet.cosine;
        block.facet.width.0[lane] = facet.width;
        block.facet.masking.0[lane] = facet.masking;
        block.facet.kept.0[lane] = facet.kept;
    }

    /// The number of lights.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are no lights.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The radiance that surfaces reflect towards an eye, in the order of the surfaces.
    ///
    /// `progress` is called from several threads with the number of surfaces done so far, and says whether to go on;
    /// `None` if it said no.
    pub fn reflect(
        &self,
        surfaces: &[SurfaceTexel],
        eye: Vector3,
        // Not a type parameter: the hot loop is then compiled here, as optimised as this crate is.
        progress: &(dyn Fn(usize) -> bool + Sync),
    ) -> Option<Vec<Reflected>> {
        in_groups(surfaces, PIXELS_AT_ONCE, progress, |_, group| match self.ndf {
            Ndf::Ggx => self.reflect_group::<true>(group, eye),
            Ndf::Beckmann => self.reflect_group::<false>(group, eye),
        })
    }

    fn reflect_group<const GGX: bool>(
        &self,
        group: &[SurfaceTexel],
        eye: Vector3,
    ) -> Vec<Reflected> {
        let receivers: Vec<Receiver> =
            group.iter().map(|surface| Receiver::new(surface, eye, self.ndf)).collect();
        let mut sums = vec![Sums::default(); group.len()];
        for blocks in self.blocks.chunks(BLOCKS_AT_ONCE) {
            for ((surface, receiver), sum) in group.iter().zip(&receivers).zip(&mut sums) {
                if surface.present {
                    for block in blocks {
                        sum.add(Arriving::new::<GGX>(block, receiver));
                    }
                }
            }
        }
        group.iter().zip(sums).map(|(surface, sum)| sum.reflected(surface)).collect()
    }
}

/// What the specular BRDF needs of a surface and of the direction that is fixed there.
#[derive(Clone, Copy, Debug)]
struct FixedFacet<T = f64> {
    /// Cosine of the normal with the fixed direction.
    cosine: T,
    /// alpha^2.
    width: T,
    /// The fixed direction's masking: the root in GGX's, or all of Beckmann's over the cosine.
    masking: T,
    /// The fixed direction's cosine, kept above 0.
    kept: T,
}

impl FixedFacet {
    fn new(ndf: Ndf, cosine: f64, alpha: f64) -> Self {
        let (width, kept) = (alpha * alpha, cosine.max(MINIMUM_COSINE));
        let masking = match ndf {
            Ndf::Ggx => (kept * kept * (1.0 - width) + width).sqrt(),
            Ndf::Beckmann => beckmann_masking(kept, width),
        };
        Self { cosine, width, masking, kept }
    }

    fn everywhere(self) -> FixedFacet<Lane> {
        FixedFacet {
            cosine: Lane::all(self.cosine),
            width: Lane::all(self.width),
            masking: Lane::all(self.masking),
            kept: Lane::all(self.kept),
        }
    }

    fn beckmann(self, cosine: f64, square: f64) -> f64 {
        let normal_part = cosine + self.cosine;
        // Light along the horizon or from below counts for nothing: the exponential is saved.
        if cosine <= 0.0 || normal_part <= 0.0 {
            return 0.0;
        }
        let cosine_squared = (normal_part * normal_part / square).min(1.0);
        let exponent = (cosine_squared - 1.0) / (cosine_squared * self.width);
        let distribution = exponent.exp() / (PI * self.width * cosine_squared * cosine_squared);
        0.25 * distribution * self.masking * beckmann_masking(cosine, self.width)
    }
}

impl FixedFacet<Lane> {
    /// `D V` and Schlick's weight, from the cosine of the other direction with the normal (at least 0) and with the
    /// fixed direction. The half vector enters by its squared length and its product with the normal alone.
    #[inline(always)]
    fn evaluate<const GGX: bool>(&self, cosine: Lane, between: Lane) -> (Lane, Lane) {
        let (one, half) = (Lane::all(1.0), Lane::all(0.5));
        let square = (between + one + between + one).at_least(1e-24);
        let rest = (one - half * square.map(f64::sqrt)).at_least(0.0);
        let weight = (rest * rest) * (rest * rest) * rest;
        let value = if GGX {
            let normal_part = cosine + self.cosine;
            let denominator = normal_part * normal_part * (self.width - one) + square;
            let root = (cosine * cosine * (one - self.width) + self.width).map(f64::sqrt);
            let masking = cosine * self.masking + self.kept * root;
            Lane::all(0.5 / PI) * self.width * square * square
                / (denominator * denominator * masking)
        } else {
            let mut value = Lane::default();
            for lane in 0..LANES {
                let facet = FixedFacet {
                    cosine: self.cosine.0[lane],
                    width: self.width.0[lane],
                    masking: self.masking.0[lane],
                    kept: self.kept.0[lane],
                };
                value.0[lane] = facet.beckmann(cosine.0[lane], square.0[lane]);
            }
            value
        };
        (value, weight)
    }
}

/// Beckmann's `G1/cos`, from alpha^2.
// [Walter 2007, Section 5.2, after Eq. (27)]
fn beckmann_masking(cosine: f64, width: f64) -> f64 {
    let slope = (width * (1.0 - cosine * cosine).max(0.0)).sqrt();
    if cosine >= 1.6 * slope {
        1.0 / cosine
    } else {
        let a = cosine / slope;
        (3.535 + 2.181 * a) / (slope * (1.0 + 2.276 * a + 2.577 * a * a))
    }
}

/// What the sum needs of a pixel, for every lane.
#[derive(Clone, Copy, Debug)]
struct Receiver {
    position: [Lane; 3],
    /// Away from the surface's normal and from the eye: against the light's direction.
    against_normal: [Lane; 3],
    against_view: [Lane; 3],
    facet: FixedFacet<Lane>,
}

impl Receiver {
    fn new(surface: &SurfaceTexel, eye: Vector3, ndf: Ndf) -> Self {
        let view = (eye - surface.position).normalized();
        let everywhere = |vector: Vector3| vector.to_array().map(Lane::all);
        let cosine = surface.normal.dot(view);
        Self {
            position: everywhere(surface.position),
            against_normal: everywhere(-surface.normal),
            against_view: everywhere(-view),
            facet: FixedFacet::new(ndf, cosine, surface.material.alpha).everywhere(),
        }
    }
}

/// Irradiance; the same times `D V`; and times Schlick's weight too.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    irradiance: [Lane; 3],
    specular: [Lane; 3],
    grazing: [Lane; 3],
}

/// What lights bring to a receiver.
#[derive(Clone, Copy)]
struct Arriving {
    irradiance: [Lane; 3],
    /// `D V` and Schlick's weight at the receiver.
    received: Lane,
    weight: Lane,
    /// Squared distance.
    square: Lane,
}

impl Arriving {
    #[inline(always)]
    fn new<const GGX: bool>(block: &Block, receiver: &Receiver) -> Self {
        let path = [0, 1, 2].map(|axis| receiver.position[axis] - block.position[axis]);
        let square = Lane::dot(path, path).at_least(1e-30);
        let inverse = Lane::all(1.0) / square.map(f64::sqrt);
        let direction = path.map(|part| part * inverse);
        let cosine_emitted = Lane::dot(block.normal, direction).at_least(0.0);
        let cosine_received = Lane::dot(receiver.against_normal, direction).at_least(0.0);
        let geometry = cosine_emitted * cosine_received / (square + block.disc);

        let towards = Lane::dot(block.towards, direction);
        let (emitted, emitted_weight) = block.facet.evaluate::<GGX>(cosine_emitted, towards);
        let back = Lane::dot(receiver.against_view, direction);
        let (received, weight) = receiver.facet.evaluate::<GGX>(cosine_received, back);
        // A loop, not a map, which is not turned into vector instructions here: a third of the time.
        let mut irradiance = [Lane::default(); 3];
        for (channel, irradiance) in irradiance.iter_mut().enumerate() {
            let fresnel = block.specular[channel] + block.grazing[channel] * emitted_weight;
            *irradiance = geometry * (block.diffuse[channel] + emitted * fresnel);
        }
        Self { irradiance, received, weight, square }
    }
}

impl Sums {
    #[inline(always)]
    fn add(&mut self, arriving: Arriving) {
        for channel in 0..3 {
            let specular = arriving.irradiance[channel] * arriving.received;
            self.irradiance[channel] = self.irradiance[channel] + arriving.irradiance[channel];
            self.specular[channel] = self.specular[channel] + specular;
            self.grazing[channel] = self.grazing[channel] + specular * arriving.weight;
        }
    }

    fn reflected(&self, surface: &SurfaceTexel) -> Reflected {
        self.reflected_of(surface, |_| 1.0)
    }

    /// What is reflected of the lights, each lane times a factor.
    fn reflected_of(&self, surface: &SurfaceTexel, factor: impl Fn(usize) -> f64) -> Reflected {
        let sum = |lanes: &[Lane; 3]| {
            let [x, y, z] = lanes
                .map(|lane| lane.0.iter().enumerate().map(|(at, part)| factor(at) * part).sum());
            Vector3::new(x, y, z)
        };
        let (specular, grazing) = (sum(&self.specular), sum(&self.grazing));
        Reflected {
            diffuse: sum(&self.irradiance).times(surface.material.diffuse_brdf()),
            specular: specular.times(surface.material.specular)
                + grazing.times(
                    Vector3::splat(fresnel::grazing(surface.material.specular))
                        - surface.material.specular,
                ),
        }
    }
}

/// The place of a texel on a curve through the map, whose pieces are compact.
// [Morton 1966, A computer oriented geodetic data base and a new technique in file sequencing]
fn along_the_curve(texel: [usize; 2]) -> u64 {
    let spread = |number: usize| {
        (0..32).fold(0, |spread, bit| spread | ((number as u64 >> bit & 1) << (2 * bit)))
    };
    spread(texel[0]) | spread(texel[1]) << 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::{Directions, Material};
    use crate::fis::stress::Random;
    use crate::light::LightKind;

    fn unit(random: &mut Random) -> Vector3 {
        Vector3::new(random.normal(), random.normal(), random.normal()).normalized()
    }

    fn surface(random: &mut Random) -> SurfaceTexel {
        let mut color = || Vector3::new(random.uniform(), random.uniform(), random.uniform());
        let (diffuse, specular) = (color(), color());
        let material = Material { diffuse, specular, alpha: 0.05 + 0.9 * random.uniform() };
        SurfaceTexel { position: unit(random) * 2.0, normal: unit(random), material, present: true }
    }

    /// The same sum, one light at a time, by the functions of the BRDF.
    fn plainly(
        surface: &SurfaceTexel,
        eye: Vector3,
        emitters: &[(SurfaceTexel, Vector3, Vector3, f64)],
        ndf: Ndf,
    ) -> Reflected {
        let view = (eye - surface.position).normalized();
        let mut sum = Reflected::none();
        for (emitter, towards, power, area) in emitters {
            let path = surface.position - emitter.position;
            let direction = path.normalized();
            let at_emitter =
                Directions { normal: emitter.normal, view: *towards, light: direction };
            let brdf =
                emitter.material.diffuse_brdf() + emitter.material.specular_brdf(ndf, &at_emitter);
            let intensity = power.times(brdf) * emitter.normal.dot(direction).max(0.0);
            let cosine = surface.normal.dot(-direction).max(0.0);
            let irradiance = intensity * (cosine / (path.length_squared() + area / PI));
            let at_surface = Directions { normal: surface.normal, view, light: -direction };
            sum.diffuse = sum.diffuse + irradiance.times(surface.material.diffuse_brdf());
            sum.specular =
                sum.specular + irradiance.times(surface.material.specular_brdf(ndf, &at_surface));
        }
        sum
    }

    #[test]
    fn the_fast_sum_is_the_plain_one() {
        for ndf in [Ndf::Ggx, Ndf::Beckmann] {
            let mut random = Random::new(3);
            let emitters: Vec<_> = (0..100)
                .map(|_| {
                    let surface = surface(&mut random);
                    let aside = unit(&mut random) * 0.9;
                    (
                        surface,
                        (surface.normal + aside).normalized(),
                        Vector3::new(1.0, 2.0, 3.0),
                        0.01,
                    )
                })
                .collect();
            let mut lights = VirtualPointLights::none(ndf);
            for (surface, towards, power, area) in &emitters {
                lights.push(surface, *towards, *power, *area);
            }
            let surfaces: Vec<_> = (0..70).map(|_| surface(&mut random)).collect();
            let eye = Vector3::new(0.1, 0.2, 0.3);
            let fast = lights.reflect(&surfaces, eye, &|_| true).unwrap();
            let mut missed = 0;
            for (surface, fast) in surfaces.iter().zip(&fast) {
                let plain = plainly(surface, eye, &emitters, ndf);
                assert!((plain.diffuse - fast.diffuse).length() <= 1e-12 * plain.diffuse.length());
                assert!(
                    (plain.specular - fast.specular).length() <= 1e-9 * plain.specular.length(),
                    "{plain:?} {fast:?}"
                );
                // Negative control: one light less.
                let less = plainly(surface, eye, &emitters[1..], ndf).diffuse;
                missed += usize::from((less - fast.diffuse).length() > 1e-3 * less.length());
            }
            assert!(missed > 5, "{missed}");
        }
    }

    #[test]
    fn a_map_of_a_wall_lights_what_faces_it() {
        // A directional light on a white diffuse wall of 2 x 2: the irradiance in front of its middle is that of a
        // square of radiosity E, by its form factor.
        let light = Light {
            kind: LightKind::Directional { half_extent: 1.0 },
            position: Vector3::new(0.0, 0.0, 5.0),
            right: Vector3::new(1.0, 0.0, 0.0),
            up: Vector3::new(0.0, 1.0, 0.0),
            forward: Vector3::new(0.0, 0.0, -1.0),
            intensity: Vector3::splat(1.0),
        };
        let size = 64;
        let white =
            Material { diffuse: Vector3::splat(1.0), specular: Vector3::zero(), alpha: 1.0 };
        let texels: Vec<SurfaceTexel> = (0..size * size)
            .map(|index| SurfaceTexel {
                position: light.cameras()[0]
                    .ray([(index % size) as f64 + 0.5, (index / size) as f64 + 0.5], [size, size])
                    .origin
                    - Vector3::new(0.0, 0.0, 5.0),
                normal: Vector3::new(0.0, 0.0, 1.0),
                material: white,
                present: index != 0,
            })
            .collect();
        let lights = VirtualPointLights::of_map(&light, &texels, [size, size], Ndf::Ggx);
        assert_eq!(lights.len(), size * size - 1);
        let position = Vector3::new(0.0, 0.0, 1.0);
        let receiver = SurfaceTexel {
            position,
            normal: Vector3::new(0.0, 0.0, -1.0),
            material: white,
            present: true,
        };
        let reflected =
            lights.reflect(&[receiver], Vector3::new(1.0, 0.0, 0.5), &|_| true).unwrap()[0];
        // Four corners of a unit square at unit distance. Schlick's grazing term of the black dielectric adds a little.
        let corner = 2.0 * (1.0 / 2f64.sqrt()) * (1.0 / 2f64.sqrt()).atan() / (2.0 * PI);
        let radiance = reflected.diffuse.x;
        assert!(
            (radiance / (4.0 * corner / PI) - 1.0).abs() < 0.03,
            "{radiance} {}",
            4.0 * corner / PI
        );
    }

    #[test]
    fn the_sum_can_be_stopped() {
        let mut random = Random::new(1);
        let surfaces: Vec<_> = (0..1000).map(|_| surface(&mut random)).collect();
        let lights = VirtualPointLights::none(Ndf::Ggx);
        assert!(lights.reflect(&surfaces, Vector3::zero(), &|done| done < 100).is_none());
        assert!(lights.reflect(&surfaces, Vector3::zero(), &|_| true).is_some());
    }
}

//! The reference of a picture's indirect light with visibility: paths of one bounce.
//!
//! A path leads from the light to a surface, from there to a surface of the camera's map, and to the eye; with the real
//! BRDF at both surfaces and exact visibility on both pieces. Its middle vertex is drawn in two ways: by a direction
//! from the camera's surface, in proportion to what that reflects, and a ray that finds the surface there; and by a
//! point of the light's map, in proportion to what its texels would bring without visibility ([`guide`]), and the
//! light's own ray through it. Samples of both are weighed by the balance heuristic: directions find large broad
//! sources and narrow lobes of the receiver, the map finds small bright sources, as a mirror's caustic. Neither a
//! bounded geometry term nor the texels of a map bear on the result, which is free of bias; its own error is the noise
//! of finitely many samples, which it states, and it comes in two independent halves.
//!
//! Surfaces that their shading normal tilts reflect as a camera would see them: the cosine of arriving light is that of
//! the shading normal. The sum over a light's map ([`crate::vpl`]) takes the cosine of the geometry there, since photons
//! spread over the true area; where shading normals are those of the triangles both are the same.

use crate::Vector3;
use crate::brdf::{Directions, Ndf};
use crate::estimate::Estimate;
use crate::fis::stress::Random;
use crate::groups::in_groups;
use crate::light::{Light, LightKind};
use crate::shade::Reflected;
use crate::surface::{Crossing, Ray, Scene, SurfaceTexel};

mod draw;
mod guide;
mod materials;

use draw::Draw;
use guide::{Guide, Seen, Walk};

pub use materials::Materials;

/// Pixels that one task works on; each keeps a number of every block of the light's map.
const PIXELS_AT_ONCE: usize = 16;

/// The part of the paths that finds out where they are needed, as its inverse.
const PILOT: u32 = 8;
/// The least part of the average number of paths that a surface gets, as its inverse, and the most.
const LEAST: f64 = 2.0;
const MOST: f64 = 16.0;

/// The width of the map that guides samples, in texels; see [`Paths::map`].
pub const MAP: usize = 256;

/// What paths go through, and how many.
#[derive(Clone, Copy)]
pub struct Paths<'a> {
    /// The triangles.
    pub scene: &'a Scene,
    /// Their materials.
    pub materials: &'a dyn Materials,
    /// The light.
    pub light: &'a Light,
    /// The distribution of facets.
    pub ndf: Ndf,
    /// Paths per pixel on average, in both halves together: half of them by directions, half by the light's map. A
    /// pilot of an eighth more shares them out: a pixel gets from half as many to 16 times as many.
    pub samples: u32,
    /// Width of the light's map that guides samples, in texels; 0 for directions alone. It bears on the noise, not on
    /// what is found.
    pub map: usize,
    /// Other seeds give other noise, the same seed the same picture.
    pub seed: u64,
}

impl Paths<'_> {
    /// The radiance that surfaces reflect towards an eye, in the order of the surfaces; none where there is no surface.
    ///
    /// `progress` is called from several threads with the number of surfaces done so far, and says whether to go on;
    /// `None` if it said no.
    pub fn reflect(
        &self,
        surfaces: &[SurfaceTexel],
        eye: Vector3,
        progress: &(dyn Fn(usize) -> bool + Sync),
    ) -> Option<Vec<Estimate>> {
        let halves = self.halves(surfaces, eye, progress)?;
        Some(halves.iter().map(Estimate::mean_of).collect())
    }

    /// The same as two independent estimates R1 and R2 of half the samples each, whose mean is [`Self::reflect`]: the
    /// mean of `(I - R1)(I - R2)` is the squared error of a picture I without that of the reference.
    pub fn halves(
        &self,
        surfaces: &[SurfaceTexel],
        eye: Vector3,
        progress: &(dyn Fn(usize) -> bool + Sync),
    ) -> Option<Vec<[Estimate; 2]>> {
        let guide = Guide::new(self.light, self.scene, self.materials, self.ndf, self.map);
        let pilot = self.samples.div_ceil(PILOT);
        let scatters =
            self.each(surfaces, eye, &guide, &|_| progress(0), |_, vertex, streams| {
                let found = vertex.estimate(pilot, &mut streams(0));
                found.standard_error.to_array().into_iter().fold(0.0, f64::max)
            })?;
        let counts = shared(self.samples, &scatters);
        self.each(surfaces, eye, &guide, progress, |index, vertex, streams| {
            [1, 2].map(|half| vertex.estimate(counts[index] / 2, &mut streams(half)))
        })
    }

    /// What `work` makes of each surface, its default where there is none; it is given the surface's number, what
    /// paths need of it, and independent streams of random numbers.
    fn each<T: Clone + Default + Send>(
        &self,
        surfaces: &[SurfaceTexel],
        eye: Vector3,
        guide: &Guide,
        progress: &(dyn Fn(usize) -> bool + Sync),
        work: impl Fn(usize, &Vertex<'_>, &dyn Fn(u64) -> Random) -> T + Sync,
    ) -> Option<Vec<T>> {
        in_groups(surfaces, PIXELS_AT_ONCE, progress, |first, group| {
            let seen = guide.seen_from(group, eye);
            let pixels = group.iter().zip(&seen).enumerate();
            let made = |(index, (surface, seen)): (usize, (&SurfaceTexel, &Seen))| {
                if !surface.present {
                    return T::default();
                }
                let view = (eye - surface.position).normalized();
                let vertex = Vertex {
                    paths: self,
                    guide,
                    seen,
                    surface,
                    origin: surface.position + surface.normal * self.scene.spacing(),
                    view,
                    draw: Draw::new(surface, view, self.ndf),
                };
                let number = scrambled((first + index) as u64);
                work(first + index, &vertex, &|stream| {
                    Random::new(scrambled(self.seed ^ scrambled(number ^ stream)))
                })
            };
            pixels.map(made).collect()
        })
    }

    /// The radiance of the light's direct reflection where a ray arrived, in the direction that it came from; whether
    /// the light sees the place is another question.
    fn radiance(&self, crossing: &Crossing, back: Vector3) -> Vector3 {
        let position = crossing.hit.position;
        let normal = self.materials.normal(crossing);
        // The rasteriser turns shading normals to the viewer.
        let normal = if normal.dot(back) < 0.0 { -normal } else { normal };
        let (towards, distance_squared) = self.light.towards(position);
        let cosine = normal.dot(towards);
        if cosine <= 0.0 {
            return Vector3::zero();
        }
        let along = -towards.dot(self.light.forward);
        let scale = cosine / distance_squared.max(1e-30);
        let irradiance = self.light.intensity_at(along) * scale;
        if irradiance == Vector3::zero() {
            return irradiance;
        }
        let material = self.materials.material(crossing);
        // As at a virtual point light: the fixed direction, whose cosine is kept from 0, is that of the light.
        let directions = Directions { normal, view: towards, light: back };
        let brdf = material.diffuse_brdf() + material.specular_brdf(self.ndf, &directions);
        irradiance.times(brdf)
    }

    /// Whether the light sees the side of a surface that a ray met.
    fn is_lit(&self, crossing: &Crossing) -> bool {
        let place = crossing.hit.position + crossing.side * self.scene.spacing();
        let light = match self.light.kind {
            LightKind::Directional { .. } => {
                let (towards, _) = self.light.towards(place);
                place + towards * self.scene.reach_from(place)
            }
            LightKind::Spot { .. } | LightKind::Point | LightKind::Camera => self.light.position,
        };
        self.scene.sees(light, place, &|crossing| self.materials.counts(crossing))
    }
}

/// How many paths each surface gets of `samples` on average, by how much those of a pilot scatter.
///
/// In proportion to the scatter the mean squared error over a picture is least [Cochran 1977, Section 5.5]. Paths of
/// the pilot are not counted again, so that nothing is biased by what it found.
fn shared(samples: u32, scatters: &[f64]) -> Vec<u32> {
    let known: Vec<f64> =
        scatters.iter().copied().filter(|scatter| *scatter > 0.0 && scatter.is_finite()).collect();
    let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
    let share = |&scatter: &f64| {
        let share = if mean > 0.0 && scatter.is_finite() { scatter / mean } else { 1.0 };
        let [least, most] = [1.0 / LEAST, MOST];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let paths = (f64::from(samples) * share.clamp(least, most)).ceil() as u32;
        paths
    };
    scatters.iter().map(share).collect()
}

/// A surface of the camera's map, and what paths to it are drawn by.
struct Vertex<'a> {
    paths: &'a Paths<'a>,
    guide: &'a Guide,
    seen: &'a Seen,
    surface: &'a SurfaceTexel,
    /// Where rays start.
    origin: Vector3,
    view: Vector3,
    draw: Draw,
}

impl Vertex<'_> {
    /// An estimate of some paths.
    fn estimate(&self, paths: u32, random: &mut Random) -> Estimate {
        let walk = Walk::new(self.guide, self.seen);
        let ways = if walk.is_some() { 2 } else { 1 };
        // Of each kind, an even number.
        let count = paths.div_ceil(ways).next_multiple_of(2).max(2);
        let mut sum = Pairs::default();
        for _ in 0..count / 2 {
            let [one, other] = [self.by_direction(random), self.by_direction(random)];
            sum.add(&one, &other);
        }
        if let Some(mut walk) = walk {
            let share = 1.0 / f64::from(count);
            for pair in 0..count / 2 {
                let [one, other] = [2 * pair, 2 * pair + 1].map(|number| {
                    let texel = walk.texel((f64::from(number) + random.uniform()) * share);
                    self.by_map(texel, random)
                });
                sum.add(&one, &other);
            }
        }
        sum.estimate(1.0 / f64::from(count))
    }

    /// What a path brings whose middle is found along a direction, over the sum of both densities.
    fn by_direction(&self, random: &mut Random) -> Reflected {
        let paths = self.paths;
        let Some((direction, density)) = self.draw.direction(random) else {
            return Reflected::none();
        };
        let ray = Ray { origin: self.origin, direction };
        let counts = |crossing: &Crossing| paths.materials.counts(crossing);
        let Some(crossing) = paths.scene.nearest(&ray, &counts) else {
            return Reflected::none();
        };
        let arriving = paths.radiance(&crossing, -direction);
        if arriving == Vector3::zero() || !paths.is_lit(&crossing) {
            return Reflected::none();
        }
        let of_map = self.density_by_map(&crossing, direction);
        self.reflected(arriving, direction, density + of_map)
    }

    /// What a path brings whose middle is found by the light's ray through a random point of a texel, over the sum of
    /// both densities.
    fn by_map(&self, texel: [usize; 2], random: &mut Random) -> Reflected {
        let paths = self.paths;
        let at = texel.map(|part| part as f64 + random.uniform());
        let Some((ray, point)) = paths.light.ray(at, self.guide.size()) else {
            return Reflected::none();
        };
        let counts = |crossing: &Crossing| paths.materials.counts(crossing);
        let Some(crossing) = paths.scene.nearest(&ray, &counts) else {
            return Reflected::none();
        };
        let path = crossing.hit.position - self.origin;
        let direction = path.normalized();
        // What the light sees from one side the receiver may see from the other.
        if self.surface.normal.dot(direction) <= 0.0 || crossing.side.dot(direction) >= 0.0 {
            return Reflected::none();
        }
        let arriving = paths.radiance(&crossing, -direction);
        if arriving == Vector3::zero()
            || !paths.scene.sees(self.origin, crossing.hit.position, &counts)
        {
            return Reflected::none();
        }
        let density = self.guide.density(self.seen, &point) * self.per_steradian(&crossing, path);
        self.reflected(arriving, direction, density + self.draw.density_of(direction))
    }

    /// How densely the map is sampled around a place that a direction leads to, per steradian of the receiver.
    fn density_by_map(&self, crossing: &Crossing, direction: Vector3) -> f64 {
        let position = crossing.hit.position;
        self.guide.project(self.paths.light, position).map_or(0.0, |point| {
            let path = direction * crossing.hit.distance;
            self.guide.density(self.seen, &point) * self.per_steradian(crossing, path)
        })
    }

    /// The light's solid angle (or area across its rays) over that of the receiver, of a place: both are those of a
    /// piece of the surface, whose true normal counts.
    // [Veach 1997, Section 8.2]
    fn per_steradian(&self, crossing: &Crossing, path: Vector3) -> f64 {
        let (towards, distance_squared) = self.paths.light.towards(crossing.hit.position);
        let square = path.length_squared();
        let cosine = crossing.side.dot(path).abs() / square.sqrt();
        let lit = crossing.side.dot(towards).max(0.0);
        if cosine > 0.0 { lit / distance_squared.max(1e-30) * square / cosine } else { 0.0 }
    }

    /// What is reflected of arriving radiance, over a density per steradian.
    fn reflected(&self, arriving: Vector3, direction: Vector3, density: f64) -> Reflected {
        let (surface, view) = (self.surface, self.view);
        let cosine = surface.normal.dot(direction).max(0.0);
        if density.is_nan() || density <= 0.0 {
            return Reflected::none();
        }
        let arriving = arriving * (cosine / density);
        let directions = Directions { normal: surface.normal, view, light: direction };
        Reflected {
            diffuse: arriving.times(surface.material.diffuse_brdf()),
            specular: arriving.times(surface.material.specular_brdf(self.paths.ndf, &directions)),
        }
    }
}

/// A sum of samples that come in pairs of neighbouring strata: the square of a pair's difference is on average the
/// variance of both, and the square of the difference of their means in addition. So it errs to the safe side.
// [Cochran 1977, Section 5A.12], collapsed strata
#[derive(Default)]
struct Pairs {
    sums: [Vector3; 2],
    squares: [Vector3; 3],
}

impl Pairs {
    fn add(&mut self, one: &Reflected, other: &Reflected) {
        let sums = [one.diffuse + other.diffuse, one.specular + other.specular];
        for (sum, part) in self.sums.iter_mut().zip(sums) {
            *sum = *sum + part;
        }
        let differences = [
            one.diffuse - other.diffuse,
            one.specular - other.specular,
            one.total() - other.total(),
        ];
        for (square, difference) in self.squares.iter_mut().zip(differences) {
            *square = *square + difference.times(difference);
        }
    }

    /// The sum times a factor.
    fn estimate(&self, factor: f64) -> Estimate {
        let [diffuse, specular, total] =
            self.squares.map(|square| square.map(|square| square.sqrt() * factor));
        Estimate {
            mean: Reflected { diffuse: self.sums[0] * factor, specular: self.sums[1] * factor },
            standard_errors: Reflected { diffuse, specular },
            standard_error: total,
        }
    }
}

/// Numbers that differ in one bit become numbers that differ in half of them.
// [Steele et al. 2014, Fast splittable pseudorandom number generators], the finaliser of SplitMix64
pub(crate) fn scrambled(number: u64) -> u64 {
    let number = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let number = (number ^ (number >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let number = (number ^ (number >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    number ^ (number >> 31)
}

#[cfg(test)]
mod tests;

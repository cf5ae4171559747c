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
use crate::brdf::{Directions, Material, Ndf};
use crate::estimate::Estimate;
use crate::fis::stress::Random;
use crate::groups::in_groups;
use crate::light::{Light, LightKind};
use crate::shade::Reflected;
use crate::surface::{Crossing, Ray, Scene, SurfaceTexel};

mod draw;
mod guide;

use draw::Draw;
use guide::{Guide, Seen, Walk};

/// Pixels that one task works on; each keeps a number of every block of the light's map.
const PIXELS_AT_ONCE: usize = 16;

/// The width of the map that guides samples, in texels; see [`Paths::map`].
pub const MAP: usize = 256;

/// What a scene's surfaces are made of; the caller knows of textures.
pub trait Materials: Sync {
    /// The material where a ray meets a facet.
    fn material(&self, crossing: &Crossing) -> Material;

    /// Whether there is a surface: not in the holes of a cutout.
    fn counts(&self, _crossing: &Crossing) -> bool {
        true
    }
}

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
    /// Paths per pixel, in both halves together: half of them by directions, half by the light's map. Rounded up to a
    /// multiple of 8.
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
        in_groups(surfaces, PIXELS_AT_ONCE, progress, |first, group| {
            let seen = guide.seen_from(group, eye);
            let pixels = group.iter().zip(&seen).enumerate();
            let both = |(index, (surface, seen)): (usize, (&SurfaceTexel, &Seen))| {
                if !surface.present {
                    return [Estimate::none(); 2];
                }
                let view = (eye - surface.position).normalized();
                let vertex = Vertex {
                    paths: self,
                    guide: &guide,
                    seen,
                    surface,
                    origin: surface.position + surface.normal * self.scene.spacing(),
                    view,
                    draw: Draw::new(surface, view, self.ndf),
                };
                [0, 1].map(|half: u64| {
                    let stream = scrambled((first + index) as u64) ^ half;
                    vertex.estimate(&mut Random::new(scrambled(self.seed ^ scrambled(stream))))
                })
            };
            pixels.map(both).collect()
        })
    }

    /// The radiance of the light's direct reflection where a ray arrived, in the direction that it came from; whether
    /// the light sees the place is another question.
    fn radiance(&self, crossing: &Crossing, back: Vector3) -> Vector3 {
        let position = crossing.hit.position;
        let normal = crossing.hit.normal;
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
    /// An estimate of a half of the samples.
    fn estimate(&self, random: &mut Random) -> Estimate {
        let walk = Walk::new(self.guide, self.seen);
        let ways = if walk.is_some() { 2 } else { 1 };
        // Of each kind, an even number.
        let count = self.paths.samples.div_ceil(2 * ways).next_multiple_of(2).max(2);
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
    // [Veach 1997, Equation (8.2)]
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
            discretisation: Reflected::none(),
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
mod tests {
    use core::f64::consts::PI;

    use super::draw::polar;
    use super::*;
    use crate::quadrature::SphereRule;
    use crate::scenery::{Table, diffuse, facet, glossy, light, square, texel};
    use crate::surface::Facet;
    use crate::vpl::TexelFacets;

    fn paths<'a>(scene: &'a Scene, materials: &'a Table, light: &'a Light) -> Paths<'a> {
        Paths { scene, materials, light, ndf: Ndf::Ggx, samples: 20_000, map: 64, seed: 1 }
    }

    fn one(paths: &Paths<'_>, surface: SurfaceTexel, eye: Vector3) -> Estimate {
        paths.reflect(&[surface], eye, &|_| true).unwrap()[0]
    }

    /// The inside of a sphere around the origin, finely cut.
    fn sphere() -> Vec<Facet> {
        let (rows, columns) = (48, 96);
        let corner = |row: usize, column: usize| {
            let down = PI * row as f64 / rows as f64;
            let radius = if row.is_multiple_of(rows) { 0.0 } else { down.sin() };
            polar(radius, (column % columns) as f64 / columns as f64, down.cos())
        };
        let mut facets = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let [a, b] = [corner(row, column), corner(row, column + 1)];
                let [c, d] = [corner(row + 1, column), corner(row + 1, column + 1)];
                for positions in [[a, d, c], [a, b, d]] {
                    facets.push(facet(positions, Some(positions.map(|corner| -corner)), 0));
                }
            }
        }
        facets
    }

    /// Within a white sphere with a light of intensity I in its middle every surface has irradiance I/R^2, so that the
    /// radiance is I/pi from everywhere, and a surface reflects its albedo of that.
    #[test]
    fn a_furnace_gives_back_the_albedo() {
        let scene = Scene::new(sphere()).unwrap();
        let table = Table(vec![diffuse(1.0)]);
        let light = light(LightKind::Point, Vector3::zero());
        let normal = Vector3::new(0.0, 0.6, 0.8);
        let (x, _) = normal.basis();
        for ndf in [Ndf::Ggx, Ndf::Beckmann] {
            for (angle, alpha) in [(0.3_f64, 0.5), (1.2, 0.3), (0.7, 0.05)] {
                let material =
                    Material { diffuse: Vector3::splat(0.5), specular: Vector3::splat(0.8), alpha };
                let view = normal * angle.cos() + x * angle.sin();
                let position = Vector3::new(0.1, -0.2, 0.05);
                let paths = Paths { ndf, ..paths(&scene, &table, &light) };
                let found = one(&paths, texel(position, normal, material), position + view);
                let albedo = SphereRule::around(normal, 2.0 / (alpha * alpha))
                    .with_azimuths(256)
                    .integrate(|light| {
                        let directions = Directions { normal, view, light };
                        material.specular_brdf(ndf, &directions).x * normal.dot(light).max(0.0)
                    });
                let radiance = 1.0 / PI;
                // The sphere is cut into flat pieces: their distance is off by up to 1e-3 of the radius.
                let tolerance = 5.0 * found.standard_error.x + 4e-3 * radiance;
                let error = (found.mean.total().x - radiance * (0.5 + albedo)).abs();
                println!("{ndf:?} {angle} {alpha}: {found:?}, albedo {albedo}, off by {error:e}");
                assert!(error < tolerance, "{error} {tolerance}");
                assert!(found.standard_error.x < 0.02 * radiance);
                assert!((found.mean.diffuse.y - 2.0 * 0.5 * radiance).abs() < 2.0 * tolerance);
                // Negative control: a BRDF without the other's Fresnel term is another number.
                assert!((found.mean.total().x - radiance * (0.5 + 0.8 * albedo)).abs() > tolerance);
            }
        }
    }

    fn parallel() -> Light {
        light(LightKind::Directional { half_extent: 1.0 }, Vector3::new(0.0, 0.0, 5.0))
    }

    /// The form factor of a square of side 2 seen from its axis at distance 1, by four corners.
    fn form_factor() -> f64 {
        4.0 * 2.0 * (1.0 / 2f64.sqrt()) * (1.0 / 2f64.sqrt()).atan() / (2.0 * PI)
    }

    #[test]
    fn a_lit_patch_lights_by_its_form_factor_and_what_hides_it_counts() {
        let patch = square([-1.0; 2], [1.0; 2], 0.0, 0);
        let table = Table(vec![diffuse(1.0), diffuse(0.0)]);
        let light = parallel();
        let receiver =
            texel(Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.0, 0.0, -1.0), diffuse(1.0));
        let eye = Vector3::new(0.5, 0.0, 0.5);
        let found = |facets: Vec<Facet>| {
            let scene = Scene::new(facets).unwrap();
            one(&paths(&scene, &table, &light), receiver, eye)
        };
        let expected = form_factor() / PI;
        let holds = |found: &Estimate, expected: f64| {
            (found.mean.diffuse.x - expected).abs() < 5.0 * found.standard_error.x
        };
        let whole = found(patch.to_vec());
        assert!(holds(&whole, expected), "{whole:?} {expected}");
        assert!(whole.standard_error.x < 0.01 * expected);
        assert!((whole.mean.diffuse.z - 3.0 * whole.mean.diffuse.x).abs() < 1e-12);
        // Half is hidden by a black wall between; and is in its shadow.
        let wall = square([0.0, -3.0], [3.0, 3.0], 0.5, 1);
        let half = found([patch.as_slice(), &wall].concat());
        assert!(holds(&half, 0.5 * expected), "{half:?} {expected}");
        // Negative control: the hidden half is noticed.
        assert!(!holds(&half, expected) && !holds(&whole, 0.5 * expected));
        // A hole hides nothing.
        let hole = square([0.0, -3.0], [3.0, 3.0], 0.5, 2);
        // Nor does a larger scene change anything but the spacing of rays from surfaces, 2^-16 of its size.
        let alike = |found: &Estimate| (found.mean.diffuse - whole.mean.diffuse).length() < 1e-4;
        assert!(alike(&found([patch.as_slice(), &hole].concat())));
        // In the shadow of a wall behind the receiver nothing is left.
        let roof = square([-3.0; 2], [3.0; 2], 2.0, 1);
        assert_eq!(found([patch.as_slice(), &roof].concat()), Estimate::none());
        // The same roof looks down: from the light its back is seen, which is not there if it has one side.
        let one_sided = roof.map(|roof| {
            let [a, b, c] = roof.triangle.positions;
            Facet { double_sided: false, ..facet([a, c, b], None, 1) }
        });
        assert!(alike(&found([patch.as_slice(), &one_sided].concat())) && !alike(&half));
    }

    #[test]
    fn is_the_sum_of_virtual_point_lights_where_nothing_hides_anything() {
        let patch = square([-1.0; 2], [1.0; 2], 0.0, 0);
        let scene = Scene::new(patch.to_vec()).unwrap();
        let cone = LightKind::Spot { tan_half_angle: 0.6, cone_scale: 10.0, cone_offset: -8.5 };
        let spot = light(cone, Vector3::new(0.2, -0.1, 1.5));
        let size = [128; 2];
        for (light, ndf) in [(&parallel(), Ndf::Ggx), (&spot, Ndf::Ggx), (&spot, Ndf::Beckmann)] {
            for (emitter, material) in
                [(diffuse(0.8), glossy(0.6, 0.3)), (glossy(0.9, 0.25), glossy(0.04, 0.5))]
            {
                let table = Table(vec![emitter]);
                let normal = Vector3::new(0.0, 0.0, 1.0);
                let texels: Vec<SurfaceTexel> = (0..size[0] * size[1])
                    .map(|index| {
                        let (x, y) = (index % size[0], index / size[0]);
                        let ray = light.cameras()[0].ray([x as f64 + 0.5, y as f64 + 0.5], size);
                        let position =
                            ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
                        texel(position, normal, emitter)
                    })
                    .collect();
                let lights = TexelFacets::of_map(light, &texels, size, ndf);
                let receivers: Vec<SurfaceTexel> = (0..12)
                    .map(|index| {
                        let x = 0.1 * f64::from(index) - 0.5;
                        let tilted = Vector3::new(-0.3 * x, 0.2, -0.8).normalized();
                        texel(Vector3::new(x, 0.4, 0.9), tilted, material)
                    })
                    .collect();
                let eye = Vector3::new(0.3, -0.2, 0.4);
                let summed = lights.reflect(&receivers, eye, &|_| true).unwrap();
                let paths = Paths { ndf, samples: 80_000, ..paths(&scene, &table, light) };
                let found = paths.reflect(&receivers, eye, &|_| true).unwrap();
                let mut deviations = 0.0;
                for (summed, found) in summed.iter().zip(&found) {
                    let summed = summed.total();
                    // 128 x 128 texels are off by some thousandths at this distance.
                    let allowed = 5.0 * found.standard_error.y + 5e-3 * summed.y;
                    let error = (found.mean.total().y - summed.y).abs();
                    assert!(error < allowed, "{light:?} {ndf:?} {found:?} {summed:?}");
                    assert!(found.standard_error.y < 0.02 * summed.y, "{found:?} {summed:?}");
                    deviations += error / found.standard_error.y;
                    // Negative control: a tenth more is noticed.
                    let more = 1.1 * summed.y;
                    assert!((found.mean.total().y - more).abs() > 2.0 * found.standard_error.y);
                }
                println!("{ndf:?}: mean deviation {:.2} standard errors", deviations / 12.0);
            }
        }
    }

    /// Standard errors are what repeated pictures scatter by.
    #[test]
    fn the_stated_error_is_the_scatter_between_seeds() {
        let scene = Scene::new(square([-1.0; 2], [1.0; 2], 0.0, 0).to_vec()).unwrap();
        let (table, light) = (Table(vec![glossy(0.5, 0.3)]), parallel());
        let receiver =
            texel(Vector3::new(0.2, 0.0, 1.0), Vector3::new(0.0, 0.0, -1.0), glossy(0.5, 0.3));
        let runs: Vec<Estimate> = (0..200)
            .map(|seed| {
                let paths = Paths { samples: 200, seed, ..paths(&scene, &table, &light) };
                one(&paths, receiver, Vector3::new(0.5, 0.0, 0.5))
            })
            .collect();
        let mean = |value: &dyn Fn(&Estimate) -> f64| {
            runs.iter().map(value).sum::<f64>() / runs.len() as f64
        };
        let centre = mean(&|run| run.mean.total().x);
        let scatter = mean(&|run| (run.mean.total().x - centre).powi(2)).sqrt();
        let stated = mean(&|run| run.standard_error.x);
        // 200 runs give a standard deviation to 5 %.
        assert!((scatter / stated - 1.0).abs() < 0.2, "{scatter} {stated}");
        // Deterministic, and different for another seed.
        assert_ne!(runs[0], runs[1]);
        let again = Paths { samples: 200, seed: 0, ..paths(&scene, &table, &light) };
        assert_eq!(one(&again, receiver, Vector3::new(0.5, 0.0, 0.5)), runs[0]);
    }

    #[test]
    fn bad_input_is_black() {
        let box_of = |material| {
            let mut facets = square([-1.0; 2], [1.0; 2], 0.0, material).to_vec();
            facets.extend(square([-1.0; 2], [1.0; 2], 1.0, material));
            facets
        };
        let table = Table(vec![glossy(0.5, 0.01)]);
        let scene = Scene::new(box_of(0)).unwrap();
        let receiver =
            texel(Vector3::new(0.0, 0.0, 0.5), Vector3::new(0.0, 0.0, 1.0), glossy(0.5, 0.01));
        let finite = |estimate: &Estimate| {
            let parts = [estimate.mean.diffuse, estimate.mean.specular, estimate.standard_error];
            parts.iter().all(|part| part.to_array().iter().all(|p| p.is_finite() && *p >= 0.0))
        };
        let inside_wall = light(LightKind::Point, Vector3::new(0.3, 0.1, 1.0));
        let outside = light(LightKind::Point, Vector3::new(0.0, 0.0, 9.0));
        let away = LightKind::Spot { tan_half_angle: 0.5, cone_scale: 8.0, cone_offset: -7.2 };
        let sees_nothing = Light {
            forward: Vector3::new(0.0, 0.0, 1.0),
            ..light(away, Vector3::new(0.0, 0.0, 9.0))
        };
        for light in [inside_wall, outside, sees_nothing] {
            let paths = Paths { samples: 500, ..paths(&scene, &table, &light) };
            // Eyes at the surface, in a wall, below the surface, far away.
            let eyes = [
                receiver.position,
                Vector3::new(0.0, 0.0, 1.0),
                Vector3::new(0.3, 0.0, -4.0),
                Vector3::splat(1e12),
            ];
            for eye in eyes {
                let found = one(&paths, receiver, eye);
                assert!(finite(&found), "{light:?} {eye:?} {found:?}");
                assert!(light != outside && light != sees_nothing || found == Estimate::none());
            }
            let absent = SurfaceTexel { present: false, ..receiver };
            assert_eq!(one(&paths, absent, Vector3::zero()), Estimate::none());
        }
        // Negative control: the same with a light that is seen is not black.
        let within = light(LightKind::Point, Vector3::new(0.3, 0.1, 0.7));
        let lit = one(&paths(&scene, &table, &within), receiver, Vector3::new(0.2, 0.0, 0.9));
        assert!(finite(&lit) && lit.mean.total().x > 0.0);
        // No triangles at all.
        let empty = Scene::new(Vec::new()).unwrap();
        assert_eq!(
            one(&paths(&empty, &table, &within), receiver, Vector3::zero()),
            Estimate::none()
        );
        let stopped = paths(&scene, &table, &within);
        assert!(stopped.reflect(&[receiver; 100], Vector3::zero(), &|done| done < 20).is_none());
    }
}

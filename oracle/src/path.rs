//! The reference of a picture's indirect light with visibility: paths of one bounce.
//!
//! From each surface of the camera's map a direction is drawn, a ray finds the surface there, and what that surface
//! reflects of the light arrives: with the real BRDF at both ends and exact visibility on both pieces of the path. It
//! needs neither the light's map nor a bounded geometry term, so that it is free of what both change; its own error is
//! the noise of finitely many samples, which it states.
//!
//! Surfaces that their shading normal tilts reflect as a camera would see them: the cosine of arriving light is that of
//! the shading normal. The sum over a light's map ([`crate::vpl`]) takes the cosine of the geometry there, since photons
//! spread over the true area; where shading normals are those of the triangles both are the same.

use core::f64::consts::PI;

use crate::Vector3;
use crate::brdf::material::MINIMUM_COSINE;
use crate::brdf::{Directions, Material, Ndf};
use crate::estimate::Estimate;
use crate::fis::stress::Random;
use crate::groups::in_groups;
use crate::light::{Light, LightKind};
use crate::shade::Reflected;
use crate::surface::{Crossing, Ray, Scene, SurfaceTexel};

/// Pixels that one task works on.
const PIXELS_AT_ONCE: usize = 16;
/// The least probability of drawing by a lobe that exists: the other one's tails then stay bounded.
const LEAST_SHARE: f64 = 0.25;

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
    /// Paths per pixel, at least 1.
    pub samples: u32,
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
        in_groups(surfaces, PIXELS_AT_ONCE, progress, |first, group| {
            let surfaces = group.iter().enumerate();
            surfaces.map(|(index, surface)| self.estimate(first + index, surface, eye)).collect()
        })
    }

    fn estimate(&self, index: usize, surface: &SurfaceTexel, eye: Vector3) -> Estimate {
        if !surface.present {
            return Estimate::none();
        }
        let view = (eye - surface.position).normalized();
        let draw = Draw::new(surface, view, self.ndf);
        let mut random = Random::new(scrambled(self.seed ^ scrambled(index as u64)));
        let mut sum = Reflected::none();
        let mut scatters = [Scatter::default(); 3];
        for number in 1..=self.samples.max(1) {
            let reflected = self.path(surface, view, &draw, &mut random);
            sum.diffuse = sum.diffuse + reflected.diffuse;
            sum.specular = sum.specular + reflected.specular;
            let parts = [reflected.diffuse, reflected.specular, reflected.total()];
            for (scatter, part) in scatters.iter_mut().zip(parts) {
                scatter.add(part, f64::from(number));
            }
        }
        let count = f64::from(self.samples.max(1));
        let [diffuse, specular, total] = scatters.map(|scatter| scatter.standard_error(count));
        Estimate {
            mean: Reflected {
                diffuse: sum.diffuse * (1.0 / count),
                specular: sum.specular * (1.0 / count),
            },
            standard_errors: Reflected { diffuse, specular },
            standard_error: total,
            discretisation: Reflected::none(),
        }
    }

    /// What one path brings.
    fn path(
        &self,
        surface: &SurfaceTexel,
        view: Vector3,
        draw: &Draw,
        random: &mut Random,
    ) -> Reflected {
        let Some((direction, density)) = draw.direction(random) else {
            return Reflected::none();
        };
        let normal = surface.normal;
        let ray = Ray { origin: surface.position + normal * self.scene.spacing(), direction };
        let counts = |crossing: &Crossing| self.materials.counts(crossing);
        let Some(crossing) = self.scene.nearest(&ray, &counts) else {
            return Reflected::none();
        };
        let arriving = self.radiance(&crossing, -direction) * (normal.dot(direction) / density);
        if arriving == Vector3::zero() {
            return Reflected::none();
        }
        let directions = Directions { normal, view, light: direction };
        Reflected {
            diffuse: arriving.times(surface.material.diffuse_brdf()),
            specular: arriving.times(surface.material.specular_brdf(self.ndf, &directions)),
        }
    }

    /// The radiance of the light's direct reflection where a ray arrived, in the direction that it came from.
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
        let place = position + crossing.side * self.scene.spacing();
        let light = match self.light.kind {
            LightKind::Directional { .. } => place + towards * self.scene.reach_from(place),
            LightKind::Spot { .. } | LightKind::Point | LightKind::Camera => self.light.position,
        };
        if !self.scene.sees(light, place, &|crossing| self.materials.counts(crossing)) {
            return Vector3::zero();
        }
        let material = self.materials.material(crossing);
        // As at a virtual point light: the fixed direction, whose cosine is kept from 0, is that of the light.
        let directions = Directions { normal, view: towards, light: back };
        let brdf = material.diffuse_brdf() + material.specular_brdf(self.ndf, &directions);
        irradiance.times(brdf)
    }
}

/// Mean and summed squared deviation of samples.
// [Welford 1962]
#[derive(Clone, Copy, Default)]
struct Scatter {
    mean: Vector3,
    deviation: Vector3,
}

impl Scatter {
    /// Adds a sample; `number` counts them from 1.
    fn add(&mut self, sample: Vector3, number: f64) {
        let from_old = sample - self.mean;
        self.mean = self.mean + from_old * (1.0 / number);
        self.deviation = self.deviation + from_old.times(sample - self.mean);
    }

    /// The standard error of the mean; infinite of a single sample.
    fn standard_error(&self, count: f64) -> Vector3 {
        if count > 1.0 {
            self.deviation.map(|deviation| (deviation.max(0.0) / (count * (count - 1.0))).sqrt())
        } else {
            Vector3::splat(f64::INFINITY)
        }
    }
}

/// How directions are drawn at a surface: by the cosine, or by the specular lobe; their density is that of the mixture,
/// which is the balance heuristic for one sample.
// [Veach 1997, Robust Monte Carlo methods for light transport simulation, Section 9.2.4]
struct Draw {
    normal: Vector3,
    across: [Vector3; 2],
    /// The direction to the viewer in the surface's own axes, turned above the horizon where it is below.
    view: Vector3,
    alpha: f64,
    ndf: Ndf,
    specular_share: f64,
}

impl Draw {
    fn new(surface: &SurfaceTexel, view: Vector3, ndf: Ndf) -> Self {
        let normal = surface.normal;
        let (x, y) = normal.basis();
        let local = Vector3::new(x.dot(view), y.dot(view), normal.dot(view).max(MINIMUM_COSINE))
            .normalized();
        let diffuse = surface.material.diffuse.luminance();
        let specular = surface.material.specular.luminance();
        let specular_share = if specular <= 0.0 {
            0.0
        } else if diffuse <= 0.0 {
            // The lobe of facets leaves out directions of light that several facets would be needed for.
            1.0 - LEAST_SHARE
        } else {
            (specular / (specular + diffuse)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
        };
        let alpha = surface.material.alpha;
        Self { normal, across: [x, y], view: local, alpha, ndf, specular_share }
    }

    /// A unit direction above the horizon and its density per steradian; `None` where the draw fell below.
    fn direction(&self, random: &mut Random) -> Option<(Vector3, f64)> {
        let (choice, u, v) = (random.uniform(), random.uniform(), random.uniform());
        let local = if choice < self.specular_share {
            let facet = self.facet(u, v);
            if facet.dot(self.view) <= 0.0 {
                return None;
            }
            self.view.mirrored(facet)
        } else {
            polar(u.sqrt(), v, (1.0 - u).sqrt())
        };
        if local.z <= 0.0 {
            return None;
        }
        let density = self.density(local);
        let direction = self.across[0] * local.x + self.across[1] * local.y + self.normal * local.z;
        let direction = direction.normalized();
        let above = self.normal.dot(direction) > 0.0;
        (above && density > 0.0 && density.is_finite()).then_some((direction, density))
    }

    fn density(&self, light: Vector3) -> f64 {
        let half = (self.view + light).normalized();
        let facets = self.ndf.distribution(half.z, self.alpha);
        let specular = match self.ndf {
            // Visible normals: G1 D (v.h)/(n.v), over the Jacobian 4 (v.h). [Heitz 2014, Eq. (17)]
            Ndf::Ggx => {
                let (cosine, width) = (self.view.z, self.alpha * self.alpha);
                let root = (width + (1.0 - width) * cosine * cosine).sqrt();
                0.5 * facets / (cosine + root)
            }
            // All normals: D (n.h), over the Jacobian 4 (v.h). [Walter 2007, Eq. (24), Eq. (38)]
            Ndf::Beckmann => facets * half.z / (4.0 * self.view.dot(half)),
        };
        self.specular_share * specular + (1.0 - self.specular_share) * light.z / PI
    }

    /// A facet's normal.
    fn facet(&self, u: f64, v: f64) -> Vector3 {
        match self.ndf {
            // [Dupuy and Benyoub 2023, Sampling visible GGX normals with spherical caps, Listing 3]
            Ndf::Ggx => {
                let stretched = |vector: Vector3| {
                    Vector3::new(self.alpha * vector.x, self.alpha * vector.y, vector.z)
                };
                let view = stretched(self.view).normalized();
                let height = (1.0 - u) * (1.0 + view.z) - view.z;
                let cap = polar((1.0 - height * height).max(0.0).sqrt(), v, height);
                stretched(cap + view).normalized()
            }
            // [Walter 2007, Eq. (28)]
            Ndf::Beckmann => {
                let tangent = self.alpha * (-u.ln()).sqrt();
                let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
                polar(tangent * cosine, v, cosine)
            }
        }
    }
}

/// The vector at a radius and a share of the full turn around z, and a height.
fn polar(radius: f64, turn: f64, height: f64) -> Vector3 {
    let (sine, cosine) = (2.0 * PI * turn).sin_cos();
    Vector3::new(radius * cosine, radius * sine, height)
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
    use super::*;
    use crate::quadrature::SphereRule;
    use crate::scenery::{Table, diffuse, facet, glossy, light, square, texel};
    use crate::surface::Facet;
    use crate::vpl::VirtualPointLights;

    fn paths<'a>(scene: &'a Scene, materials: &'a Table, light: &'a Light) -> Paths<'a> {
        Paths { scene, materials, light, ndf: Ndf::Ggx, samples: 20_000, seed: 1 }
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
        assert_eq!(found([patch.as_slice(), &hole].concat()).mean, whole.mean);
        // In the shadow of a wall behind the receiver nothing is left.
        let roof = square([-3.0; 2], [3.0; 2], 2.0, 1);
        assert_eq!(found([patch.as_slice(), &roof].concat()), Estimate::none());
        // The same roof looks down: from the light its back is seen, which is not there if it has one side.
        let one_sided = roof.map(|roof| {
            let [a, b, c] = roof.triangle.positions;
            Facet { double_sided: false, ..facet([a, c, b], None, 1) }
        });
        assert_eq!(found([patch.as_slice(), &one_sided].concat()).mean, whole.mean);
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
                let lights = VirtualPointLights::of_map(light, &texels, size, ndf);
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
                    // 128 x 128 points and their bounded term are off by some thousandths at this distance.
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
        // No triangles at all; and one path, whose error nobody knows.
        let empty = Scene::new(Vec::new()).unwrap();
        assert_eq!(
            one(&paths(&empty, &table, &within), receiver, Vector3::zero()),
            Estimate::none()
        );
        let single = Paths { samples: 1, ..paths(&scene, &table, &within) };
        assert_eq!(one(&single, receiver, Vector3::zero()).standard_error.x, f64::INFINITY);
        let stopped = paths(&scene, &table, &within);
        assert!(stopped.reflect(&[receiver; 100], Vector3::zero(), &|done| done < 20).is_none());
    }
}

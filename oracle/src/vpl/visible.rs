//! The sum over points of light with visibility.
//!
//! All that reflects light once is a virtual point light [Keller 1997], and the texels of a light's map are such lights
//! [Dachsbacher 2005]. Their sum without visibility is exact and cheap; what is hidden of it is drawn: lights in
//! proportion to the luminance that they bring to this pixel, and a shadow ray to each. The sum is a control variate:
//! where nothing is hidden nothing is uncertain. Two errors are stated apart: the noise of the draws, and how far a
//! lattice of points is from the light's surface.

use super::{Arriving, BLOCKS_AT_ONCE, LANES, Lane, Receiver, Sums, VirtualPointLights};
use crate::Vector3;
use crate::brdf::{Ndf, fresnel};
use crate::estimate::Estimate;
use crate::fis::stress::Random;
use crate::groups::in_groups;
use crate::path::{Materials, scrambled};
use crate::shade::Reflected;
use crate::surface::{Scene, SurfaceTexel};

/// Pixels that one task works on; each keeps a number of every block.
const PIXELS_AT_ONCE: usize = 16;

/// Points of light, what may hide them, and how many shadow rays find that out.
#[derive(Clone, Copy)]
pub struct VisiblePoints<'a> {
    /// The points of light.
    pub lights: &'a VirtualPointLights,
    /// The triangles.
    pub scene: &'a Scene,
    /// Their materials, which say where holes are.
    pub materials: &'a dyn Materials,
    /// Shadow rays per pixel, rounded up to an even number; 0 for the sum without visibility.
    pub rays: u32,
    /// Other seeds give other noise, the same seed the same picture.
    pub seed: u64,
}

impl VisiblePoints<'_> {
    /// The radiance that surfaces reflect towards an eye, in the order of the surfaces; none where there is no surface.
    ///
    /// Noise may take a mean below 0. Standard errors are estimated from the draws themselves: on average they are too
    /// high rather than too low. The discretisation error is that of the sum without visibility; where much is hidden it
    /// is too high.
    ///
    /// `progress` is called from several threads with the number of surfaces done so far, and says whether to go on;
    /// `None` if it said no.
    pub fn reflect(
        &self,
        surfaces: &[SurfaceTexel],
        eye: Vector3,
        progress: &(dyn Fn(usize) -> bool + Sync),
    ) -> Option<Vec<Estimate>> {
        in_groups(surfaces, PIXELS_AT_ONCE, progress, |first, group| match self.lights.ndf {
            Ndf::Ggx => self.group::<true>(first, group, eye),
            Ndf::Beckmann => self.group::<false>(first, group, eye),
        })
    }

    /// The estimates of some pixels, the first of which has a number.
    fn group<const GGX: bool>(
        &self,
        first: usize,
        group: &[SurfaceTexel],
        eye: Vector3,
    ) -> Vec<Estimate> {
        let count = self.lights.blocks.len();
        let mut pixels: Vec<Pixel> =
            group.iter().map(|surface| Pixel::new(surface, eye, self.lights)).collect();
        for start in (0..count).step_by(BLOCKS_AT_ONCE) {
            let end = count.min(start + BLOCKS_AT_ONCE);
            for (surface, pixel) in group.iter().zip(&mut pixels) {
                if surface.present {
                    pixel.add::<GGX>(self.lights, start, end);
                }
            }
        }
        let estimate = |(index, (surface, pixel)): (usize, (&SurfaceTexel, &Pixel))| {
            let number = scrambled((first + index) as u64);
            let mut random = Random::new(scrambled(self.seed ^ number));
            if surface.present {
                self.estimate::<GGX>(surface, pixel, &mut random)
            } else {
                Estimate::none()
            }
        };
        group.iter().zip(&pixels).enumerate().map(estimate).collect()
    }

    fn estimate<const GGX: bool>(
        &self,
        surface: &SurfaceTexel,
        pixel: &Pixel,
        random: &mut Random,
    ) -> Estimate {
        let all = pixel.sums.reflected(surface);
        let hidden = self.hidden::<GGX>(surface, pixel, random);
        Estimate {
            mean: Reflected {
                diffuse: all.diffuse - hidden.mean.diffuse,
                specular: all.specular - hidden.mean.specular,
            },
            discretisation: pixel.discretisation(surface, &all),
            ..hidden
        }
    }

    /// What is hidden of the sum, by one draw from each of equal shares of its luminance.
    ///
    /// Lights that follow each other are neighbours, so that a share is a patch of the map, and only shares that the edge
    /// of a shadow crosses are uncertain. Two neighbouring shares at a time give the variance: the square of their
    /// difference is on average that of both draws, and that between their means in addition.
    // [Cochran 1977, Section 5A.12], collapsed strata
    fn hidden<const GGX: bool>(
        &self,
        surface: &SurfaceTexel,
        pixel: &Pixel,
        random: &mut Random,
    ) -> Estimate {
        let whole = pixel.luminance();
        let rays = self.rays.next_multiple_of(2);
        if rays == 0 || whole <= 0.0 {
            return Estimate::none();
        }
        let share = whole / f64::from(rays);
        let place = surface.position + surface.normal * self.scene.spacing();
        let mut walk = Walk { pixel, block: 0, before: 0.0 };
        let mut known: Option<(Draw, bool)> = None;
        let mut draw = |number: u32| {
            let at = (f64::from(number) + random.uniform()) * share;
            let draw = walk.draw::<GGX>(self.lights, at);
            let seen = match known {
                Some((last, seen)) if last == draw => seen,
                _ => self.sees(place, &draw),
            };
            known = Some((draw, seen));
            if seen {
                Reflected::none()
            } else {
                draw.reflected::<GGX>(self.lights, surface, pixel, share)
            }
        };
        let (mut mean, mut variances) = (Reflected::none(), [Vector3::zero(); 3]);
        for pair in 0..rays / 2 {
            let [one, other] = [draw(2 * pair), draw(2 * pair + 1)];
            mean.diffuse = mean.diffuse + one.diffuse + other.diffuse;
            mean.specular = mean.specular + one.specular + other.specular;
            let differences = [
                one.diffuse - other.diffuse,
                one.specular - other.specular,
                one.total() - other.total(),
            ];
            for (variance, difference) in variances.iter_mut().zip(differences) {
                *variance = *variance + difference.times(difference);
            }
        }
        let [diffuse, specular, total] = variances.map(|variance| variance.map(f64::sqrt));
        Estimate {
            mean,
            standard_errors: Reflected { diffuse, specular },
            standard_error: total,
            discretisation: Reflected::none(),
        }
    }

    /// Whether a place sees a light, as a path from there would find it.
    fn sees(&self, place: Vector3, draw: &Draw) -> bool {
        let block = &self.lights.blocks[draw.block];
        let of = |lanes: &[Lane; 3]| {
            let [x, y, z] = lanes.map(|lanes| lanes.0[draw.lane]);
            Vector3::new(x, y, z)
        };
        let light = of(&block.position) + of(&block.normal) * self.scene.spacing();
        self.scene.sees(place, light, &|crossing| self.materials.counts(crossing))
    }
}

/// The sums of a pixel, and the luminance that every block brings to it.
struct Pixel {
    receiver: Receiver,
    /// The luminance that is reflected per irradiance of each channel: diffusely, and specularly of `D V` and of that
    /// times Schlick's weight.
    weights: [[Lane; 3]; 3],
    sums: Sums,
    luminances: Vec<f64>,
    /// The luminance that twice the area of every light would take away.
    bounded: Lane,
}

impl Pixel {
    fn new(surface: &SurfaceTexel, eye: Vector3, lights: &VirtualPointLights) -> Self {
        let material = &surface.material;
        let luminance = |color: Vector3| {
            let [red, green, blue] = color.to_array();
            [[red, 0.0, 0.0], [0.0, green, 0.0], [0.0, 0.0, blue]]
                .map(|[x, y, z]| Lane::all(Vector3::new(x, y, z).luminance()))
        };
        let grazing = Vector3::splat(fresnel::grazing(material.specular)) - material.specular;
        Self {
            receiver: Receiver::new(surface, eye, lights.ndf),
            weights: [material.diffuse_brdf(), material.specular, grazing].map(luminance),
            sums: Sums::default(),
            luminances: vec![0.0; lights.blocks.len()],
            bounded: Lane::default(),
        }
    }

    /// The luminance of all lights.
    fn luminance(&self) -> f64 {
        self.luminances.iter().sum()
    }

    /// The luminance that lights of a block bring.
    #[inline(always)]
    fn luminance_of(&self, arriving: Arriving) -> Lane {
        let mut sum = Lane::default();
        for channel in 0..3 {
            let specular = self.weights[1][channel] + self.weights[2][channel] * arriving.weight;
            let reflected = self.weights[0][channel] + arriving.received * specular;
            sum = sum + arriving.irradiance[channel] * reflected;
        }
        sum
    }

    fn add<const GGX: bool>(&mut self, lights: &VirtualPointLights, start: usize, end: usize) {
        for (index, block) in (start..end).zip(&lights.blocks[start..end]) {
            let arriving = Arriving::new::<GGX>(block, &self.receiver);
            self.sums.add(arriving);
            let luminance = self.luminance_of(arriving);
            self.luminances[index] = luminance.0.iter().sum();
            let twice = arriving.square + block.disc + block.disc;
            self.bounded = self.bounded + luminance * block.disc / twice;
        }
    }

    /// How far the lattice of points may be off, of each reflection.
    ///
    /// Each lane is a map of a quarter of the texels, with four times the power. Their mean is the whole sum; it is taken
    /// to be off as the mean of four independent samples is. What all lanes share they do not show: that the geometry term
    /// is bounded by the area of a texel. What the bound takes away grows with that area, so that twice the area would
    /// take away as much again; of every channel alike.
    fn discretisation(&self, surface: &SurfaceTexel, all: &Reflected) -> Reflected {
        let mut squares = [Vector3::zero(); 2];
        for own in 0..LANES {
            let only = |lane: usize| if lane == own { LANES as f64 } else { 0.0 };
            let quarter = self.sums.reflected_of(surface, only);
            let differences = [quarter.diffuse - all.diffuse, quarter.specular - all.specular];
            for (square, difference) in squares.iter_mut().zip(differences) {
                *square = *square + difference.times(difference);
            }
        }
        let samples = (LANES * (LANES - 1)) as f64;
        let [diffuse, specular] =
            squares.map(|square| square.map(|square| (square / samples).sqrt()));
        let (whole, bounded) = (self.luminance(), self.bounded.0.iter().sum::<f64>());
        let share = if whole > 0.0 { bounded / whole } else { 0.0 };
        Reflected {
            diffuse: diffuse + all.diffuse * share,
            specular: specular + all.specular * share,
        }
    }
}

/// A light that was drawn.
#[derive(Clone, Copy, PartialEq)]
struct Draw {
    block: usize,
    lane: usize,
    luminance: f64,
}

impl Draw {
    /// What the light brings, over the number of draws that it is to be expected in: its own share of the luminance, in
    /// units of what a draw stands for.
    fn reflected<const GGX: bool>(
        &self,
        lights: &VirtualPointLights,
        surface: &SurfaceTexel,
        pixel: &Pixel,
        share: f64,
    ) -> Reflected {
        if self.luminance <= 0.0 {
            return Reflected::none();
        }
        let mut sums = Sums::default();
        sums.add(Arriving::new::<GGX>(&lights.blocks[self.block], &pixel.receiver));
        let own = share / self.luminance;
        sums.reflected_of(surface, |lane| if lane == self.lane { own } else { 0.0 })
    }
}

/// A walk along the lights of a pixel in their order.
struct Walk<'a> {
    pixel: &'a Pixel,
    block: usize,
    /// The luminance of the blocks before.
    before: f64,
}

impl Walk<'_> {
    /// The light at a place on the running sum of luminances, not before that of the last call.
    fn draw<const GGX: bool>(&mut self, lights: &VirtualPointLights, at: f64) -> Draw {
        let luminances = &self.pixel.luminances;
        while self.block + 1 < luminances.len() && self.before + luminances[self.block] <= at {
            self.before += luminances[self.block];
            self.block += 1;
        }
        let arriving = Arriving::new::<GGX>(&lights.blocks[self.block], &self.pixel.receiver);
        let lanes = self.pixel.luminance_of(arriving).0;
        let mut lane = 0;
        let mut before = self.before + lanes[0];
        while lane + 1 < LANES && before <= at {
            lane += 1;
            before += lanes[lane];
        }
        Draw { block: self.block, lane, luminance: lanes[lane] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Material;
    use crate::light::{Light, LightKind};
    use crate::path::Paths;
    use crate::scenery::{Table, diffuse, glossy, light, square, texel};
    use crate::surface::Facet;

    /// What a light sees of a scene.
    fn map(scene: &Scene, table: &Table, light: &Light, size: [usize; 2]) -> Vec<SurfaceTexel> {
        let camera = light.cameras()[0];
        (0..size[0] * size[1])
            .map(|index| {
                let at = [(index % size[0]) as f64 + 0.5, (index / size[0]) as f64 + 0.5];
                let counts = |crossing: &_| table.counts(crossing);
                scene.nearest(&camera.ray(at, size), &counts).map_or(
                    SurfaceTexel {
                        present: false,
                        ..texel(Vector3::zero(), Vector3::zero(), diffuse(0.0))
                    },
                    |crossing| {
                        texel(crossing.hit.position, crossing.hit.normal, table.material(&crossing))
                    },
                )
            })
            .collect()
    }

    /// A floor that a spot light lights from the side, a black leaf above it, and surfaces above that look down.
    struct Hall {
        scene: Scene,
        table: Table,
        light: Light,
        receivers: Vec<SurfaceTexel>,
    }

    const EYE: Vector3 = Vector3::new(0.3, -0.2, 0.4);

    fn hall(floor: Material, receiver: Material, occluder: bool) -> Hall {
        let mut facets: Vec<Facet> = square([-1.0; 2], [1.0; 2], 0.0, 0).to_vec();
        if occluder {
            facets.extend(square([-0.45; 2], [0.15; 2], 0.5, 1));
        }
        let cone = LightKind::Spot { tan_half_angle: 0.5, cone_scale: 10.0, cone_offset: -8.5 };
        let receivers = (0..24)
            .map(|index| {
                let x = 0.07 * f64::from(index) - 0.8;
                let tilted = Vector3::new(-0.3 * x, 0.2, -0.8).normalized();
                texel(Vector3::new(x, 0.1, 0.9), tilted, receiver)
            })
            .collect();
        Hall {
            scene: Scene::new(facets).unwrap(),
            table: Table(vec![floor, diffuse(0.0)]),
            light: light(cone, Vector3::new(0.2, 0.3, 1.8)),
            receivers,
        }
    }

    impl Hall {
        fn lights(&self, size: usize, ndf: Ndf) -> VirtualPointLights {
            let texels = map(&self.scene, &self.table, &self.light, [size; 2]);
            VirtualPointLights::of_map(&self.light, &texels, [size; 2], ndf)
        }

        fn points(&self, lights: &VirtualPointLights, rays: u32, seed: u64) -> Vec<Estimate> {
            let points =
                VisiblePoints { lights, scene: &self.scene, materials: &self.table, rays, seed };
            points.reflect(&self.receivers, EYE, &|_| true).unwrap()
        }
    }

    fn root_mean_square(values: impl IntoIterator<Item = f64>) -> f64 {
        let (sum, count) = values
            .into_iter()
            .fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
        f64::sqrt(sum / count)
    }

    #[test]
    fn is_what_paths_find_and_visibility_is_part_of_it() {
        for (ndf, floor, receiver) in [
            (Ndf::Ggx, diffuse(0.8), glossy(0.6, 0.3)),
            (Ndf::Beckmann, glossy(0.9, 0.3), glossy(0.04, 0.5)),
        ] {
            let hall = hall(floor, receiver, true);
            let lights = hall.lights(128, ndf);
            let (found, all) = (hall.points(&lights, 512, 3), hall.points(&lights, 0, 3));
            let paths = Paths {
                scene: &hall.scene,
                materials: &hall.table,
                light: &hall.light,
                ndf,
                samples: 60_000,
                seed: 1,
            };
            let expected = paths.reflect(&hall.receivers, EYE, &|_| true).unwrap();
            let mut far = 0;
            // In units of both errors together.
            let deviation = |one: &Estimate, other: &Estimate, part: fn(&Reflected) -> Vector3| {
                let allowed = one.error().y.hypot(other.standard_error.y);
                (part(&one.mean).y - part(&other.mean).y).abs() / allowed
            };
            for part in
                [|all: &Reflected| all.diffuse, |all: &Reflected| all.specular, Reflected::total]
            {
                let of = |ours: &[Estimate]| -> Vec<f64> {
                    ours.iter()
                        .zip(&expected)
                        .map(|(one, other)| deviation(one, other, part))
                        .collect()
                };
                let (with, without) = (of(&found), of(&all));
                println!("{ndf:?} {with:.1?}\n without visibility {without:.1?}");
                let most = |values: &[f64], limit| values.iter().filter(|&&at| at < limit).count();
                // One in 20 may be beyond two, none beyond five.
                assert!(most(&with, 5.0) == 24 && most(&with, 2.0) >= 22, "{with:?}");
                // Negative control: the sum without visibility is far off in the shadow, and never nearer.
                assert!(
                    root_mean_square(without.clone()) > 1.5 * root_mean_square(with),
                    "{without:?}"
                );
                far += 24 - most(&without, 5.0);
            }
            assert!(far > 24, "{far}");
        }
    }

    #[test]
    fn is_the_sum_where_nothing_is_hidden() {
        let hall = hall(glossy(0.9, 0.25), glossy(0.5, 0.3), false);
        let lights = hall.lights(64, Ndf::Ggx);
        let summed = lights.reflect(&hall.receivers, EYE, &|_| true).unwrap();
        let differences = |found: &[Estimate]| -> Vec<f64> {
            let relative = |(one, sum): (&Estimate, &Reflected)| {
                (one.mean.total() - sum.total()).length() / sum.total().length()
            };
            found.iter().zip(&summed).map(relative).collect()
        };
        for rays in [0, 64] {
            let found = hall.points(&lights, rays, 1);
            assert!(differences(&found).iter().all(|&difference| difference < 1e-13));
            assert!(found.iter().all(|one| one.standard_error == Vector3::zero()));
            assert!(found.iter().all(|one| one.discretisation.diffuse.x > 0.0));
        }
        // Negative control: with a leaf between.
        let hidden = self::hall(glossy(0.9, 0.25), glossy(0.5, 0.3), true).points(&lights, 64, 1);
        assert!(differences(&hidden).iter().any(|&difference| difference > 0.1));
    }

    /// Standard errors are not below what repeated pictures scatter by, and not far above it either.
    #[test]
    fn the_stated_noise_is_honest() {
        let hall = hall(diffuse(0.8), glossy(0.6, 0.3), true);
        let lights = hall.lights(64, Ndf::Ggx);
        let runs: Vec<Vec<Estimate>> = (0..64).map(|seed| hall.points(&lights, 64, seed)).collect();
        let count = runs.len() as f64;
        let parts: [fn(&Estimate) -> [Vector3; 2]; 3] = [
            |one| [one.mean.diffuse, one.standard_errors.diffuse],
            |one| [one.mean.specular, one.standard_errors.specular],
            |one| [one.mean.total(), one.standard_error],
        ];
        for part in parts {
            let (mut scatters, mut stated) = (Vec::new(), Vec::new());
            for pixel in 0..hall.receivers.len() {
                let of = |run: &Vec<Estimate>| part(&run[pixel]);
                let centre = runs.iter().map(|run| of(run)[0].y).sum::<f64>() / count;
                let squares = runs.iter().map(|run| (of(run)[0].y - centre).powi(2));
                scatters.push((squares.sum::<f64>() / (count - 1.0)).sqrt());
                stated.push(root_mean_square(runs.iter().map(|run| of(run)[1].y)));
            }
            let ratio = root_mean_square(scatters.clone()) / root_mean_square(stated.clone());
            println!("scatter over stated {ratio:.3}");
            // 64 runs of 24 pixels give a standard deviation to a few per cent.
            assert!(ratio < 1.05 && ratio > 0.3, "{scatters:?} {stated:?}");
            for (scatter, stated) in scatters.iter().zip(&stated) {
                // One pixel's is known to 9 %.
                assert!(*scatter <= 1.3 * stated, "{scatter} {stated}");
            }
        }
        // Deterministic, and different for another seed.
        assert_eq!(hall.points(&lights, 64, 5), runs[5]);
        assert_ne!(runs[4], runs[5]);
    }

    #[test]
    fn the_lattice_s_error_is_seen_and_grows_as_the_map_shrinks() {
        let hall = hall(diffuse(0.8), glossy(0.6, 0.2), false);
        let of_size = |size: usize| hall.points(&hall.lights(size, Ndf::Ggx), 0, 0);
        let truth = of_size(512);
        let stated: Vec<f64> = [16, 32, 64, 128]
            .map(|size| {
                let found = of_size(size);
                let error = |(one, truth): (&Estimate, &Estimate)| {
                    one.mean.total().y - truth.mean.total().y
                };
                let off = root_mean_square(found.iter().zip(&truth).map(error));
                let stated = root_mean_square(found.iter().map(|one| one.discretisation.total().y));
                let mean = root_mean_square(truth.iter().map(|one| one.mean.total().y));
                println!("{size}: off by {off:e}, stated {stated:e} of {mean:e}");
                assert!(off < 2.0 * stated, "{size}: {off} {stated}");
                stated
            })
            .to_vec();
        assert!(stated.is_sorted_by(|larger, smaller| *larger > 1.5 * smaller), "{stated:?}");
    }

    #[test]
    fn bad_input_is_black_and_the_sum_can_be_stopped() {
        let hall = hall(diffuse(0.8), glossy(0.6, 0.3), true);
        let none = VirtualPointLights::none(Ndf::Ggx);
        assert!(hall.points(&none, 16, 0).iter().all(|one| *one == Estimate::none()));
        let lights = hall.lights(16, Ndf::Beckmann);
        let points = VisiblePoints {
            lights: &lights,
            scene: &hall.scene,
            materials: &hall.table,
            rays: 3,
            seed: 0,
        };
        let absent = SurfaceTexel { present: false, ..hall.receivers[0] };
        let in_the_leaf =
            SurfaceTexel { position: Vector3::new(0.0, 0.0, 0.5), ..hall.receivers[0] };
        let found = points.reflect(&[absent, in_the_leaf], Vector3::new(0.0, 0.0, 0.5), &|_| true);
        let found = found.unwrap();
        assert_eq!(found[0], Estimate::none());
        assert!(found[1].mean.total().x.is_finite() && found[1].error().x.is_finite());
        let many = vec![absent; 1000];
        assert!(points.reflect(&many, EYE, &|done| done < 100).is_none());
        assert!(points.reflect(&many, EYE, &|_| true).is_some());
    }
}

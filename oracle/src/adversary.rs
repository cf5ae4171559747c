//! The tolerances of whole stages compared with a number that uses up what the GPU languages grant: whatever
//! [`Bounded`] promises has to hold for it too.

mod number;

use self::number::Adversary;
use crate::brdf::{Ndf, albedo, ndf_filtered, ndf_filtered_2024, reflection};
use crate::direct::direct;
use crate::fis::stress::{Random, Stress};
use crate::fis::{Warped, modified_level, previous_level};
use crate::light::{Light, LightKind};
use crate::rsm::{Emission, Lobes, Moments, Pyramid, moments};
use crate::sg::{Cosine, hemisphere_integral};
use crate::shade::{Diffuse, Emitter, Model, Reflected, Specular, shade};
use crate::surface::SurfaceTexel;
use crate::vsgl::sample::light_of_kernel;
use crate::vsgl::{Kernel, Settings, Solver, Vsgl, sample};
use crate::{Bounded, Linear, Real, Vector3, asg, vmf};

/// How much of the tolerances was used at most, and how many numbers were promised nothing.
#[derive(Debug, Default)]
struct Use {
    largest: f64,
    compared: usize,
    vacuous: usize,
}

impl Use {
    fn compare(&mut self, found: Adversary, bounded: Bounded, what: &str) {
        if !bounded.promises() {
            self.vacuous += 1;
            return;
        }
        let distance = (found.0 - bounded.value).abs();
        assert!(distance <= bounded.error, "{what}: {found:?} {bounded:?}");
        self.compared += 1;
        if bounded.error > 0.0 {
            self.largest = self.largest.max(distance / bounded.error);
        }
    }
    fn color(&mut self, found: Vector3<Adversary>, bounded: Vector3<Bounded>, what: &str) {
        for (found, bounded) in found.to_array().into_iter().zip(bounded.to_array()) {
            self.compare(found, bounded, what);
        }
    }
    fn reflected(
        &mut self,
        found: &Reflected<Adversary>,
        bounded: &Reflected<Bounded>,
        what: &str,
    ) {
        self.color(found.diffuse, bounded.diffuse, what);
        self.color(found.specular, bounded.specular, what);
    }
    fn light(&mut self, found: &Vsgl<Adversary>, bounded: &Vsgl<Bounded>) {
        self.color(found.position, bounded.position, "position");
        self.compare(found.variance, bounded.variance, "variance");
        let lobes = |light: &Vsgl<Adversary>| {
            core::iter::once(light.diffuse).chain(light.specular).collect::<Vec<_>>()
        };
        let bounds = core::iter::once(bounded.diffuse).chain(bounded.specular);
        for (found, bounded) in lobes(found).into_iter().zip(bounds) {
            self.color(found.axis, bounded.axis, "axis");
            self.compare(found.sharpness, bounded.sharpness, "sharpness");
            self.color(found.coefficient, bounded.coefficient, "coefficient");
        }
    }
    /// At least this share of a tolerance was used, and hardly anything was promised nothing.
    fn assert_meaningful(&self, share: f64) {
        println!("{self:?}");
        assert!(self.largest > share, "the tolerances are far too wide: {self:?}");
        assert!(self.vacuous * 50 <= self.compared, "too little is promised: {self:?}");
    }
}

const SIZE: usize = 16;

fn light() -> Light {
    Light {
        kind: LightKind::Spot { tan_half_angle: 0.8, cone_scale: 4.0, cone_offset: -2.5 },
        position: Vector3::new(0.25, 4.0, 0.5),
        right: Vector3::new(1.0, 0.0, 0.0),
        up: Vector3::new(0.0, 0.0, -1.0),
        forward: Vector3::new(0.0, -1.0, 0.0),
        intensity: Vector3::new(30.0, 20.0, 10.0),
    }
}

/// A floor of hills under the light, with materials of all kinds.
fn texels() -> Vec<[[f32; 4]; 3]> {
    let noise = Stress::Noise { sigma: 0.5 }.texels(SIZE, 4);
    (0..SIZE * SIZE)
        .map(|index| {
            let (x, y) = ((index % SIZE) as f32 / 4.0 - 2.0, (index / SIZE) as f32 / 4.0 - 2.0);
            let share = (noise[index] * 0.3).min(1.0);
            let normal = [0.3 * (x * 2.0).sin(), 1.0, 0.2 * (y * 3.0).cos()];
            [
                [x, 0.2 * share, y, if index % 37 == 5 { -1.0 } else { 0.04 }],
                [normal[0], normal[1], normal[2], 0.05 + 0.9 * share],
                [share, 0.5, 1.0 - share, if index % 3 == 0 { 1.0 } else { 0.0 }],
            ]
        })
        .collect()
}

fn surfaces<R: Real>() -> Vec<SurfaceTexel<R>> {
    texels()
        .into_iter()
        .map(|[position, normal, color]| SurfaceTexel::decode(position, normal, color))
        .collect()
}

fn all_moments<R: Real>() -> Vec<Moments<R>> {
    let origin = Vector3::constant(Vector3::new(0.5, 0.0, 0.25));
    surfaces::<R>()
        .iter()
        .enumerate()
        .map(|(index, surface)| {
            let power = light().photon_power([index % SIZE, index / SIZE], [SIZE, SIZE]);
            moments(
                surface,
                power,
                light().towards(surface.position).0,
                origin,
                &Emission::printed(Lobes::Both),
            )
        })
        .collect()
}

fn settings(kernel: Kernel) -> Settings {
    Settings {
        count: 32,
        kernel,
        scale: 1.0,
        origin: Vector3::new(0.5, 0.0, 0.25),
        minimum_variance: 1e-6,
        emission: Emission::printed(Lobes::Both),
    }
}

fn pyramids<R: Real>(texels: Vec<Moments<R>>) -> (Pyramid<R>, Pyramid<Moments<R>>) {
    let density = texels.iter().map(crate::density::power).collect();
    (Pyramid::build(SIZE, density).unwrap(), Pyramid::build(SIZE, texels).unwrap())
}

#[test]
fn moments_and_mips_stay_within_their_tolerances() {
    let mut used = Use::default();
    let (found, bounded) =
        (pyramids(all_moments::<Adversary>()), pyramids(all_moments::<Bounded>()));
    for level in 0..=bounded.0.top_level() {
        for (found, bounded) in found.1.level(level).iter().zip(bounded.1.level(level)) {
            let pairs =
                found.layers.into_iter().flatten().zip(bounded.layers.into_iter().flatten());
            pairs.for_each(|(found, bounded)| used.compare(found, bounded, "moments"));
        }
    }
    used.assert_meaningful(0.05);
}

#[test]
fn moments_in_halves_stay_within_their_tolerances() {
    fn halves<R: Real>() -> Pyramid<Moments<R>> {
        let moments = all_moments::<R>().into_iter().map(Moments::with_specular_weight).collect();
        // A unit that puts the brightest photon near 32768, so that shadows are in range, and others beyond it.
        Pyramid::build_stored(SIZE, moments, |texel: Moments<R>| texel.to_half(1.0 / 262_144.0))
            .unwrap()
    }
    let mut used = Use::default();
    let (found, bounded) = (halves::<Adversary>(), halves::<Bounded>());
    for level in 0..=bounded.top_level() {
        for (found, bounded) in found.level(level).iter().zip(bounded.level(level)) {
            let pairs =
                found.layers.into_iter().flatten().zip(bounded.layers.into_iter().flatten());
            pairs.for_each(|(found, bounded)| used.compare(found, bounded, "moments"));
        }
    }
    used.assert_meaningful(0.5);
}

/// The moments as a texture holds them: exact f32.
fn stored<R: Real>() -> Vec<Moments<R>> {
    let exact = all_moments::<Adversary>();
    exact
        .into_iter()
        .map(|moments| Moments {
            layers: moments.layers.map(|layer| layer.map(|v| R::constant(v.0))),
        })
        .collect()
}

#[test]
fn kernels_and_lights_stay_within_their_tolerances() {
    let texels = stored::<Adversary>();
    let exact = texels.iter().map(|moments| Moments {
        layers: moments.layers.map(|layer| layer.map(|v| Bounded::constant(v.0))),
    });
    let bounded = pyramids(exact.collect());
    let found = pyramids(texels);
    for kernel in [
        Kernel::Previous,
        Kernel::Modified(Solver::Bisection { iterations: 12 }),
        Kernel::Modified(Solver::Bracketed),
    ] {
        let (mut used, mut doubtful) = (Use::default(), 0);
        for index in 0..32 {
            let settings = settings(kernel);
            let ours = sample(index, &bounded.0, &bounded.1, &settings);
            let theirs = sample(index, &found.0, &found.1, &settings);
            if !ours.warped.certain {
                doubtful += 1;
                continue;
            }
            let Warped { centre, texel, .. } = theirs.warped;
            assert_eq!(texel, ours.warped.texel);
            used.compare(centre[0], ours.warped.centre[0], "centre");
            used.compare(centre[1], ours.warped.centre[1], "centre");
            let level = theirs.level.level.value();
            assert!(
                level >= ours.level.certain[0] && level <= ours.level.certain[1],
                "{level} {:?}",
                ours.level
            );
            let [low, high] = ours.level.certain;
            if low == high || kernel == Kernel::Previous {
                used.light(&theirs.light, &ours.light);
            } else {
                // Another level is another light, but the light of that level is known.
                doubtful += usize::from(high - low > 1e-3);
                let exact = |value: Adversary| Bounded::constant(value.0);
                let light = light_of_kernel(
                    &bounded.0,
                    &bounded.1,
                    centre.map(exact),
                    texel,
                    exact(theirs.level.level),
                    &settings,
                );
                used.light(&theirs.light, &light);
            }
        }
        assert!(doubtful < 8, "{doubtful}");
        used.assert_meaningful(0.05);
    }
}

#[test]
fn levels_of_a_stress_stay_within_their_intervals() {
    for (_, stress) in Stress::ALL {
        let texels = stress.texels(SIZE, 9);
        let bounded =
            Pyramid::build(SIZE, texels.iter().copied().map(Bounded::exact).collect()).unwrap();
        let found =
            Pyramid::build(SIZE, texels.iter().map(|&texel| Adversary(f64::from(texel))).collect())
                .unwrap();
        for index in 0..64 {
            let [x, y] = [index % 8, index / 8].map(|part| (f64::from(part) + 0.3) / 8.0);
            let ours = modified_level(&bounded, [x, y].map(Bounded::constant), 16, 1.0, 12);
            let theirs =
                modified_level(&found, [x, y].map(Adversary::constant), 16, 1.0, 12).level.value();
            assert!(
                theirs >= ours.certain[0] && theirs <= ours.certain[1],
                "{stress:?} {theirs} {ours:?}"
            );
            let texel = [(x * 16.0) as usize, (y * 16.0) as usize];
            let ours =
                previous_level(bounded.at(0, texel[0], texel[1]), bounded.top(), 256, 16, 1.0);
            let theirs = previous_level(found.at(0, texel[0], texel[1]), found.top(), 256, 16, 1.0)
                .level
                .value();
            assert!(
                theirs >= ours.certain[0] && theirs <= ours.certain[1],
                "{stress:?} {theirs} {ours:?}"
            );
        }
    }
}

fn some_lights<R: Real>() -> Vec<Vsgl<R>> {
    let texels = stored::<Adversary>();
    texels
        .chunks(29)
        .map(|chunk| {
            let sum = chunk.iter().map(|moments| Moments {
                layers: moments.layers.map(|layer| layer.map(|value| value.0)),
            });
            let sum = sum.fold(Moments::<f64>::nothing(), Moments::plus);
            let light = Vsgl::of_moments(
                &sum,
                Vector3::new(0.5, 0.0, 0.25),
                1e-6,
                &Emission::printed(Lobes::Both),
            );
            let lobe = |lobe: crate::vsgl::Lobe| crate::vsgl::Lobe {
                axis: Vector3::constant(lobe.axis),
                sharpness: R::constant(lobe.sharpness),
                coefficient: Vector3::constant(lobe.coefficient),
            };
            Vsgl {
                position: Vector3::constant(light.position),
                variance: R::constant(light.variance),
                diffuse: lobe(light.diffuse),
                diffuse_mean_length: R::constant(light.diffuse_mean_length),
                specular: light.specular.map(lobe),
            }
        })
        .collect()
}

/// Walls around the floor, so that light arrives.
fn receivers<R: Real>() -> Vec<SurfaceTexel<R>> {
    let mut random = Random::new(8);
    (0..48)
        .map(|_| {
            let mut number = |low: f64, high: f64| (low + (high - low) * random.uniform()) as f32;
            let position = [number(-2.0, 2.0), number(0.3, 2.0), number(-2.0, 2.0), 0.04];
            let normal =
                [number(-1.0, 1.0), number(-1.0, 0.5), number(-1.0, 1.0), number(0.05, 1.0)];
            let color = [number(0.0, 1.0), number(0.0, 1.0), number(0.0, 1.0), number(0.0, 1.0)];
            SurfaceTexel::decode(position, normal, color)
        })
        .collect()
}

#[test]
fn integrals_stay_within_their_tolerances() {
    let mut random = Random::new(21);
    let mut used: Vec<Use> = Cosine::ALL.iter().map(|_| Use::default()).collect();
    let mut hemisphere = Use::default();
    for _ in 0..4000 {
        let sharpness = 10f64.powf(-6.0 + 18.0 * random.uniform()) as f32;
        let reach = (6.0 / f64::from(sharpness).sqrt()).min(1.0);
        let cosine = (reach * (2.0 * random.uniform() - 1.0)) as f32;
        let exact = [cosine, sharpness].map(Bounded::exact);
        let inputs = [cosine, sharpness].map(|input| Adversary(f64::from(input)));
        for (form, used) in Cosine::ALL.into_iter().zip(&mut used) {
            let found = form.integral(inputs[0], inputs[1]);
            assert!(found.0 >= 0.0, "{form:?} {inputs:?} {found:?}");
            used.compare(found, form.integral(exact[0], exact[1]), &format!("{form:?} {inputs:?}"));
        }
        let found = hemisphere_integral(inputs[0], inputs[1]);
        hemisphere.compare(found, hemisphere_integral(exact[0], exact[1]), "hemisphere");
    }
    used.iter().chain([&hemisphere]).for_each(|used| used.assert_meaningful(0.05));
}

#[test]
fn reflections_stay_within_their_tolerances() {
    for emitter in Emitter::ALL {
        for diffuse in Diffuse::ALL {
            // What is specular depends on the emitter alone.
            let count = if diffuse == Diffuse::Fitted { Specular::ALL.len() } else { 1 };
            for specular in &Specular::ALL[..count] {
                for ndf in [Ndf::Ggx, Ndf::Beckmann] {
                    let model =
                        Model { emitter, diffuse: Some(diffuse), specular: Some(*specular), ndf };
                    reflects_within_its_tolerances(&model);
                }
            }
        }
    }
}

fn reflects_within_its_tolerances(model: &Model) {
    let eye = Vector3::new(0.0, 1.0, 6.0);
    let lights = some_lights::<Adversary>();
    let bounds = some_lights::<Bounded>();
    let mut used = Use::default();
    for (found, bounded) in receivers::<Adversary>().iter().zip(&receivers::<Bounded>()) {
        // Lights as a buffer holds them.
        let found = shade(found, Vector3::constant(eye), lights.iter().copied(), model);
        let bounded = shade(bounded, Vector3::constant(eye), bounds.iter().copied(), model);
        used.reflected(&found, &bounded, &format!("{model:?}"));
    }
    // A sum of many terms: the worst case of all of them does not happen at once.
    used.assert_meaningful(0.02);
}

#[test]
fn direct_light_stays_within_its_tolerances() {
    let eye = Vector3::new(0.0, 3.0, 6.0);
    for ndf in [Ndf::Ggx, Ndf::Beckmann] {
        let mut used = Use::default();
        let half = (Adversary::constant(0.5), Bounded::constant(0.5));
        for (found, bounded) in surfaces::<Adversary>().iter().zip(&surfaces::<Bounded>()) {
            let found = direct(found, Vector3::constant(eye), &light(), ndf, half.0);
            let bounded = direct(bounded, Vector3::constant(eye), &light(), ndf, half.1);
            used.reflected(&found, &bounded, "direct");
        }
        used.assert_meaningful(0.05);
    }
}

#[test]
fn the_tolerances_tell_the_models_apart() {
    // Negative control: every other model leaves the tolerances of many receivers.
    let eye = Vector3::new(0.0, 1.0, 6.0);
    let model = |diffuse, specular, ndf| Model {
        emitter: Emitter::Lobe,
        diffuse: Some(diffuse),
        specular: Some(specular),
        ndf,
    };
    let right = model(Diffuse::Constant, Specular::Sg, Ndf::Ggx);
    let outside = |other: &Model| {
        let receivers = receivers::<f64>().into_iter().zip(receivers::<Bounded>());
        let reflected = receivers.map(|(found, bounded)| {
            let found = shade(&found, eye, some_lights::<f64>(), other);
            let eye = Vector3::constant(eye);
            (found, shade(&bounded, eye, some_lights::<Bounded>(), &right))
        });
        let far =
            |found: f64, bounded: Bounded| u32::from((found - bounded.value).abs() > bounded.error);
        reflected.fold([0, 0], |[diffuse, specular], (found, bounded)| {
            [
                diffuse + far(found.diffuse.y, bounded.diffuse.y),
                specular + far(found.specular.y, bounded.specular.y),
            ]
        })
    };
    let sg = |diffuse, ndf| outside(&model(diffuse, Specular::Sg, ndf));
    let mut counts = vec![outside(&right), sg(Diffuse::Gaussian, Ndf::Ggx)];
    counts.push(sg(Diffuse::Constant, Ndf::Beckmann));
    let others = Specular::ALL.into_iter().filter(|&other| other != Specular::Sg);
    counts.extend(others.map(|other| outside(&model(Diffuse::Constant, other, Ndf::Ggx))));
    counts.push(outside(&Model { emitter: Emitter::Cosine, ..right }));
    assert_eq!(counts[0], [0, 0]);
    assert!(counts[1][0] > 20 && counts[2..].iter().all(|count| count[1] > 10), "{counts:?}");
}

const EXTREMES: [f32; 11] = [0.0, 1e-38, 1e-30, 6e-8, 1e-3, 1.0, 1e2, 1e5, 2.2e12, 1e30, f32::MAX];

/// Mean lengths of a sharpness, and sharpnesses of its mean length.
fn von_mises_fisher<R: Real>(sharpness: f64) -> [R; 7] {
    let (length, rest) = (vmf::mean_length(sharpness), vmf::mean_length_complement(sharpness));
    let (length, rest, sharpness) =
        (R::constant(length), R::constant(rest), R::constant(sharpness));
    [
        vmf::mean_length_toksvig(sharpness),
        vmf::mean_length(sharpness),
        vmf::mean_length_complement(sharpness),
        vmf::toksvig(length, rest),
        vmf::banerjee(length, rest),
        vmf::kroeger(length, rest),
        vmf::exact(length, rest),
    ]
}

/// Reflection lobes, and what they reflect of a lobe; polar angles from the normal.
fn reflections<R: Real>(alpha: f64, view: f64, light: f64, sharpness: f64) -> [R; 8] {
    let at = |angle: f64| {
        Vector3::<R>::constant(Vector3::new(0.8 * angle.sin(), 0.6 * angle.sin(), angle.cos()))
    };
    let (view, normal, axis) = (at(view), at(0.0), at(light));
    let (alpha, sharpness) = (R::constant(alpha), R::constant(sharpness));
    let filtered = ndf_filtered::reflection(view, normal, alpha, axis, sharpness);
    [
        reflection::mirror(view, normal, alpha).sharpness,
        reflection::dominant(view, normal, alpha).sharpness,
        asg::convolution(&asg::reflection(view, normal, alpha), axis, sharpness),
        filtered.radiance,
        filtered.cosine,
        asg::convolution(&asg::reflection_flat(view, normal, alpha), axis, sharpness),
        ndf_filtered_2024::reflection(view, normal, alpha, axis, sharpness),
        albedo::directional(Vector3::splat(R::constant(0.04)), axis.dot(normal), alpha).x,
    ]
}

#[test]
fn lobes_stay_finite_and_within_their_tolerances() {
    let mut used = [Use::default(), Use::default()];
    let mut compare = |which: usize, found: &[Adversary], bounded: &[Bounded], what: &str| {
        for (index, (found, bounded)) in found.iter().zip(bounded).enumerate() {
            assert!(found.0.is_finite() && found.0 >= 0.0, "{what}, {index}: {found:?}");
            used[which].compare(*found, *bounded, &format!("{what}, {index}"));
        }
    };
    for sharpness in EXTREMES.map(f64::from) {
        let (found, bounded) = (von_mises_fisher(sharpness), von_mises_fisher(sharpness));
        compare(0, &found, &bounded, &format!("sharpness {sharpness}"));
        for alpha in [0.0, 1e-4, 0.01, 0.3, 1.0] {
            for view in [0.0, 1e-7, 0.5, 1.4, 1.57, 1.58, 3.0] {
                for light in [0.0, 0.5, -0.5, -1.57, 3.0, view + core::f64::consts::PI] {
                    let found = reflections(alpha, view, light, sharpness);
                    let bounded = reflections(alpha, view, light, sharpness);
                    let what = format!("alpha {alpha} {view} {light} sharpness {sharpness}");
                    compare(1, &found, &bounded, &what);
                }
            }
        }
    }
    println!("{used:?}");
    used[0].assert_meaningful(0.05);
    assert!(used[1].largest > 0.05 && used[1].vacuous * 2 < used[1].compared, "{used:?}");
}

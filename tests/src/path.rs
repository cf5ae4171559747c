//! The reference with visibility against what is rasterised: a ray has to find what a pixel shows.

use std::cell::RefCell;

use sglow_measure::references::{Drawn, noise_of};
use sglow_oracle::Vector3;
use sglow_oracle::estimate::{Estimate, Uncertainty};
use sglow_oracle::fis::stress::Random;
use sglow_oracle::metrics;
use sglow_oracle::path::Materials as _;
use sglow_oracle::surface::{Crossing, Ray, Scene as Triangles, SurfaceTexel};
use sglow_renderer::frame::Renderer;
use sglow_renderer::reference::{self, SceneMaterials};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;
use sglow_shaders::Specular;

use crate::common::gpu;

fn settings() -> Settings {
    Settings { size: [48, 32], map: 64, lights: 8, ..Settings::default() }
}

/// Rays through a texel's centre and the rasteriser find the same place, but at outlines.
#[test]
fn rays_find_what_is_rasterised() {
    for name in ["cornell-glossy", "columns", "caustic"] {
        let scene = Scene::builtin(name).unwrap();
        let renderer = Renderer::new(gpu(), &Package::embedded(), &scene, &settings(), 0).unwrap();
        renderer.render().unwrap();
        let frame = renderer.read().unwrap();
        let eye = reference::vector(renderer.eye());
        let triangles = Triangles::new(reference::facets(&scene)).unwrap();
        let materials = SceneMaterials::new(&scene);
        let counts = |crossing: &Crossing| materials.counts(crossing);
        let texels: Vec<SurfaceTexel> = reference::texels(&frame.gbuffer);
        let present: Vec<&SurfaceTexel> = texels.iter().filter(|texel| texel.present).collect();
        let (mut seen, mut hidden, mut alike) = (0, 0, 0);
        for texel in &present {
            let away = (texel.position - eye).normalized();
            seen += usize::from(triangles.sees(eye, texel.position, &counts));
            // Negative control: behind the surface, by more than what is granted.
            let behind = texel.position + away * (100.0 * triangles.spacing());
            hidden += usize::from(!triangles.sees(eye, behind, &counts));
            let ray = Ray { origin: eye, direction: away };
            if let Some(crossing) = triangles.nearest(&ray, &counts) {
                let close = (crossing.hit.position - texel.position).length();
                let facing = crossing.hit.normal.dot(texel.normal);
                let material = materials.material(&crossing);
                // Halves keep a material to one part in a thousand.
                let same = (material.diffuse - texel.material.diffuse).length() < 2e-3
                    && (material.alpha - texel.material.alpha).abs() < 2e-3
                    && (material.specular - texel.material.specular).length() < 2e-3;
                alike += usize::from(close < triangles.spacing() && facing > 0.99 && same);
            }
        }
        println!("{name}: {} texels, {seen} seen, {hidden} hidden, {alike} alike", present.len());
        assert!(present.len() > 500);
        assert!(seen * 1000 > present.len() * 995, "{name}: {seen} of {}", present.len());
        assert!(hidden * 100 > present.len() * 95, "{name}: {hidden} of {}", present.len());
        assert!(alike * 100 > present.len() * 99, "{name}: {alike} of {}", present.len());
    }
}

/// With visibility there is no more light than without, and in a box with blocks in it there is less.
#[test]
fn visibility_takes_light_away_and_only_so_much() {
    let scene = Scene::builtin("cornell").unwrap();
    let settings = Settings {
        specular: Specular::None,
        ndf: sglow_shaders::Ndf::None,
        map: 256,
        size: [24, 16],
        ..settings()
    };
    let renderer = Renderer::new(gpu(), &Package::embedded(), &scene, &settings, 0).unwrap();
    renderer.render().unwrap();
    let frame = renderer.read().unwrap();
    let (light, eye) = (renderer.light(), renderer.eye());
    let settings = renderer.indirect().settings();
    let paths = |seed| {
        reference::paths(light, settings, &scene, &frame.gbuffer, eye, 2000, seed, |_, _| true)
            .unwrap()
            .unwrap()
    };
    let rsm = renderer.read_rsm().unwrap();
    let points =
        reference::unshadowed(light, settings, &rsm, &frame.gbuffer, eye, |_, _| true).unwrap();
    let found = paths(1);
    let sum = |values: &[Vector3]| values.iter().map(|value| value.luminance()).sum::<f64>();
    let with: Vec<Vector3> = found.iter().map(|one| one.mean.total()).collect();
    let without: Vec<Vector3> = points.iter().map(|one| one.total()).collect();
    let ratio = sum(&with) / sum(&without);
    println!("with visibility over without: {ratio:.3}");
    assert!(ratio > 0.5 && ratio < 0.98, "{ratio}");
    // Nowhere is there more, but for noise and for the light's map, which has 256 x 256 points.
    let mut more = 0;
    for (one, without) in found.iter().zip(&without) {
        let excess = one.mean.total().x - 1.1 * without.x;
        more += usize::from(excess > 5.0 * one.standard_error.x);
    }
    println!("{more} of {} pixels have more", found.len());
    assert!(more * 50 < found.len(), "{more} of {}", found.len());
    // The same seed gives the same, another one something else within its error.
    assert_eq!(paths(1), found);
    assert_ne!(paths(2), found);
}

/// A built-in scene with what references are made of.
fn drawn(name: &str, settings: &Settings) -> Drawn {
    Drawn::new(gpu(), &Package::embedded(), Scene::builtin(name).unwrap(), settings).unwrap()
}

/// What points with bounded distances give at diffuse surfaces: facets as they are not.
fn as_points(drawn: &Drawn) -> Vec<[f64; 3]> {
    let light = reference::light(&drawn.light, drawn.settings.light);
    let size = [drawn.settings.map as usize; 2];
    let texels: Vec<SurfaceTexel> = reference::texels(&drawn.rsm);
    let points: Vec<(Vector3, Vector3, Vector3, f64)> = texels
        .iter()
        .enumerate()
        .filter(|(_, texel)| texel.present)
        .map(|(index, texel)| {
            let at = [index % size[0], index / size[0]];
            let (towards, square) = light.towards(texel.position);
            let area = light.footprint(at, size, square, texel.normal.dot(towards));
            let power = light.photon_power::<f64>(at, size);
            let sent = power.times(texel.material.diffuse_brdf());
            (texel.position, texel.normal, sent, area / std::f64::consts::PI)
        })
        .collect();
    let receivers = drawn.receivers();
    let reflected = receivers.iter().map(|receiver| {
        let mut sum = Vector3::zero();
        for &(position, normal, sent, disc) in &points {
            let path = position - receiver.position;
            let square = path.length_squared().max(1e-30);
            let cosines = path.dot(receiver.normal).max(0.0) * (-path.dot(normal)).max(0.0);
            sum = sum + sent * (cosines / (square * (square + disc)));
        }
        sum.times(receiver.material.diffuse_brdf())
    });
    reflected.map(Vector3::to_array).collect()
}

/// What diffuse surfaces reflect of all lit surfaces in front of them, whatever stands between: rays in random
/// directions, and every surface along each. Two independent halves.
fn through_everything(drawn: &Drawn) -> [Vec<[f64; 3]>; 2] {
    let scene = Triangles::new(reference::facets(&drawn.scene)).unwrap();
    let materials = SceneMaterials::new(&drawn.scene);
    let light = reference::light(&drawn.light, drawn.settings.light);
    let radiance = |crossing: &Crossing| {
        let (towards, square) = light.towards(crossing.hit.position);
        let cosine = crossing.side.dot(towards);
        let place = crossing.hit.position + crossing.side * scene.spacing();
        if cosine <= 0.0 || !scene.sees(light.position, place, &|_| true) {
            return Vector3::zero();
        }
        let irradiance = light.intensity_at(-towards.dot(light.forward)) * (cosine / square);
        irradiance.times(materials.material(crossing).diffuse_brdf())
    };
    let receivers = drawn.receivers();
    let side = 32;
    [1, 2].map(|seed| {
        let mut random = Random::new(seed);
        let mut of = |receiver: &SurfaceTexel| {
            let normal = receiver.normal;
            let (x, y) = normal.basis();
            let mut sum = Vector3::zero();
            for index in 0..side * side {
                // By the cosine, stratified.
                let [u, turn] = [index / side, index % side]
                    .map(|part| (f64::from(part) + random.uniform()) / f64::from(side));
                let (sine, cosine) = (2.0 * std::f64::consts::PI * turn).sin_cos();
                let aside = (x * cosine + y * sine) * u.sqrt();
                let direction = (aside + normal * (1.0 - u).sqrt()).normalized();
                let ray = Ray { origin: receiver.position + normal * scene.spacing(), direction };
                let all = RefCell::new(Vec::new());
                // Nothing counts, so that the ray goes on.
                scene.nearest(&ray, &|crossing| {
                    all.borrow_mut().push(*crossing);
                    false
                });
                for crossing in all.borrow().iter() {
                    sum = sum + radiance(crossing);
                }
            }
            // The cosine's density is cos/pi.
            (sum * (1.0 / f64::from(side * side))).times(receiver.material.diffuse).to_array()
        };
        receivers.iter().map(&mut of).collect()
    })
}

fn means(halves: &[[Estimate; 2]]) -> Vec<Estimate> {
    halves.iter().map(Estimate::mean_of).collect()
}

/// Paths that the light's map guides find what paths by directions alone find, with less noise; what they state of it
/// is what their halves differ by.
#[test]
fn guided_paths_find_the_same_with_less_noise() {
    for (name, at_most, gain) in
        [("cornell", 0.04, 2.0), ("columns", 0.03, 1.7), ("caustic", 0.15, 5.0)]
    {
        let drawn = drawn(name, &Settings { map: 256, ..settings() });
        let guided = drawn.halves(1024, 256, 1).unwrap();
        let plain = drawn.halves(1024, 0, 2).unwrap();
        let (guided_mean, plain_mean) = (means(&guided), means(&plain));
        let [ours, theirs] = [&guided_mean, &plain_mean].map(|found| Uncertainty::of(found));
        let noise = noise_of(&guided);
        println!(
            "{name}: guided {:.6}, stated {:.4}, by halves {:.4}; plain {:.6}, stated {:.4}",
            ours.mean,
            ours.relative(),
            noise / ours.mean,
            theirs.mean,
            theirs.relative(),
        );
        assert!(ours.relative() < at_most, "{name}: {ours:?}");
        assert!(theirs.relative() > gain * ours.relative(), "{name}: {theirs:?} {ours:?}");
        let honest = noise / ours.noise;
        // Of a caustic few samples rule both, so that they are uncertain themselves.
        let range = if name == "caustic" { 0.5..2.0 } else { 0.8..1.15 };
        assert!(range.contains(&honest), "{name}: {honest}");
        // The mean over the whole picture has the standard error of its pixels, which are independent.
        let sum = |estimates: &[Estimate]| {
            estimates.iter().map(|one| one.standard_error.y.powi(2)).sum::<f64>().sqrt()
        };
        let mean = |estimates: &[Estimate]| {
            estimates.iter().map(|one| one.mean.total().y).sum::<f64>() / estimates.len() as f64
        };
        let error = sum(&guided_mean).hypot(sum(&plain_mean)) / guided_mean.len() as f64;
        let difference = mean(&guided_mean) - mean(&plain_mean);
        println!(
            "{name}: means differ by {:+.3} %, {:+.1} standard errors",
            100.0 * difference / mean(&guided_mean),
            difference / error,
        );
        // Of what is found by chance alone, as caustics are, the standard error itself is too low.
        if name != "caustic" {
            assert!(difference.abs() < 3.0 * error, "{name}: {difference} {error}");
            assert!(difference.abs() < 5e-3 * mean(&guided_mean), "{name}: {difference}");
        }
    }
}

/// The sum over facets is near what rays find that go through everything, which know no map; that over points is not.
#[test]
fn facets_are_nearer_than_points_to_what_rays_through_everything_find() {
    for (name, at_most) in [("cornell", 0.06), ("columns", 0.04)] {
        let drawn = drawn(name, &Settings { map: 256, ..settings() });
        let halves = through_everything(&drawn);
        let off = |picture: &[[f64; 3]]| {
            let found = metrics::compare(picture, halves.each_ref().map(Vec::as_slice), None);
            found.unwrap().rmse_over_mean().value
        };
        let facets = off(&drawn.facets());
        let points = off(&as_points(&drawn));
        println!("{name}: facets off by {facets:.4}, points by {points:.4}");
        assert!(facets < at_most, "{name}: {facets}");
        // Negative control.
        assert!(points > 1.5 * facets, "{name}: {points} {facets}");
    }
}

/// The same scene by maps of other resolutions.
#[test]
fn facets_of_a_coarse_map_are_near_those_of_a_fine_one() {
    for name in ["cornell", "columns"] {
        let of = |rsm_size| drawn(name, &Settings { map: rsm_size, ..settings() }).facets();
        let fine = of(512);
        let [found, control] = [256, 32].map(|map| {
            let found = metrics::compare_exact(&of(map), &fine).unwrap();
            [found.rmse_over_mean().value, found.median.value]
        });
        println!("{name}: {found:.4?}, of a map of 32 {control:.4?}");
        let bounds = [0.07, 0.01];
        assert!(found.iter().zip(bounds).all(|(found, bound)| *found < bound), "{name}: {found:?}");
        assert!(control.iter().zip(bounds).all(|(found, bound)| *found > bound), "{control:?}");
    }
}

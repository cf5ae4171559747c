//! The reference with visibility against what is rasterised: a ray has to find what a pixel shows.

use sglow_oracle::Vector3;
use sglow_oracle::estimate::Estimate;
use sglow_oracle::path::Materials as _;
use sglow_oracle::surface::{Crossing, Ray, Scene as Triangles, SurfaceTexel};
use sglow_runtime::frame::Renderer;
use sglow_runtime::package::Package;
use sglow_runtime::reference::{self, SceneMaterials};
use sglow_runtime::scene::Scene;
use sglow_runtime::settings::Settings;
use sglow_shaders::Specular;

use crate::common::gpu;

fn settings() -> Settings {
    Settings { size: [48, 32], rsm_size: 64, count: 8, ..Settings::default() }
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
        let materials = SceneMaterials(&scene);
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
        // A fine map: its points' bounded geometry term takes light away within a texel of a corner.
        rsm_size: 256,
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
        reference::virtual_point_lights(light, settings, &rsm, &frame.gbuffer, eye, |_, _| true)
            .unwrap();
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

/// The two references with visibility differ by what they say of their own errors.
#[test]
fn points_and_paths_agree_within_their_errors() {
    for (name, least) in [("cornell", 0.9), ("columns", 0.9)] {
        let scene = Scene::builtin(name).unwrap();
        let settings = Settings { rsm_size: 256, ..settings() };
        let renderer = Renderer::new(gpu(), &Package::embedded(), &scene, &settings, 0).unwrap();
        renderer.draw_maps().unwrap();
        let (light, eye) = (renderer.light(), renderer.eye());
        let (rsm, gbuffer) = (renderer.read_rsm().unwrap(), renderer.read_gbuffer().unwrap());
        let settings = renderer.indirect().settings();
        let paths = reference::paths(light, settings, &scene, &gbuffer, eye, 1000, 1, |_, _| true)
            .unwrap()
            .unwrap();
        let points = |rays, seed| {
            let go_on = |_, _| true;
            reference::points(light, settings, &scene, &rsm, &gbuffer, eye, rays, seed, go_on)
                .unwrap()
                .unwrap()
        };
        let within = |found: &[Estimate]| {
            let lit = found.iter().zip(&paths).filter(|(_, path)| path.mean.total().y > 0.0);
            let (mut count, mut within) = (0, 0);
            for (one, path) in lit {
                let allowed = one.error().y.hypot(path.error().y);
                let error = (one.mean.total().y - path.mean.total().y).abs();
                count += 1;
                within += usize::from(error < 2.0 * allowed);
            }
            assert!(count > 500, "{count}");
            f64::from(u32::try_from(within).unwrap()) / f64::from(count)
        };
        let (with, without) = (within(&points(256, 1)), within(&points(0, 1)));
        println!("{name}: {with:.3} within two errors, without visibility {without:.3}");
        assert!(with > least, "{name}: {with}");
        // Negative control: visibility is needed.
        assert!(without < with - 0.2, "{name}: {without}");
        assert_eq!(points(16, 1), points(16, 1));
        assert_ne!(points(16, 1), points(16, 2));
        // The choice tells of both what they say of themselves.
        let choice = reference::Choice::of(&paths, &points(256, 1));
        println!("{name}: {choice:?}");
        assert!(choice.paths.noise > 0.0 && choice.paths.discretisation == 0.0);
        assert!(choice.points.noise > 0.0 && choice.points.discretisation > 0.0);
        let least = choice.paths.relative().min(choice.points.relative());
        let better = match choice.better {
            reference::Kind::Paths => choice.paths,
            reference::Kind::Points => choice.points,
        };
        assert_eq!(better.relative(), least);
    }
}

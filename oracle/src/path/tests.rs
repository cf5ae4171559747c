//! Paths against closed forms, facets and themselves.

use core::f64::consts::PI;

use super::draw::polar;
use super::*;
use crate::brdf::Material;
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
    let receiver = texel(Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.0, 0.0, -1.0), diffuse(1.0));
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
                    let position = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
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
    let mean =
        |value: &dyn Fn(&Estimate) -> f64| runs.iter().map(value).sum::<f64>() / runs.len() as f64;
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
    let sees_nothing =
        Light { forward: Vector3::new(0.0, 0.0, 1.0), ..light(away, Vector3::new(0.0, 0.0, 9.0)) };
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
    assert_eq!(one(&paths(&empty, &table, &within), receiver, Vector3::zero()), Estimate::none());
    let stopped = paths(&scene, &table, &within);
    assert!(stopped.reflect(&[receiver; 100], Vector3::zero(), &|done| done < 20).is_none());
}

/// Where paths scatter there are more of them, within bounds; where nothing scatters all get the same.
#[test]
fn paths_go_where_they_scatter() {
    assert_eq!(shared(64, &[1.0, 1.0, 0.0]), [64, 64, 32]);
    assert_eq!(shared(64, &[0.5, 1.5]), [32, 96]);
    let mut one = vec![0.001; 1000];
    one[3] = 1e3;
    let found = shared(64, &one);
    assert_eq!((found[3], found[0]), (1024, 32));
    assert_eq!(shared(64, &[0.0; 2]), [64; 2]);
    assert_eq!(shared(64, &[f64::INFINITY, 1.0]), [64; 2]);
}

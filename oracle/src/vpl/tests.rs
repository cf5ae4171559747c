//! Facets against quadrature, closed forms and each other.

use core::f64::consts::PI;

use super::*;
use crate::brdf::{Directions, Material};
use crate::fis::stress::Random;
use crate::light::{Light, LightKind};
use crate::scenery::{diffuse, glossy, texel};

fn unit(random: &mut Random) -> Vector3 {
    Vector3::new(random.normal(), random.normal(), random.normal()).normalized()
}

/// A square of a width around a place.
fn lit(
    position: Vector3,
    normal: Vector3,
    towards: Vector3,
    width: f64,
    material: Material,
) -> Lit {
    let (x, y) = normal.basis();
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[u, v]| position + (x * u + y * v) * (0.5 * width));
    let power = Vector3::new(1.0, 2.0, 3.0) * (width * width);
    Lit { surface: texel(position, normal, material), towards, power, corners }
}

fn facets(lit: &[Lit], ndf: Ndf) -> TexelFacets {
    let mut facets = TexelFacets::none(ndf);
    for four in lit.chunks(LANES) {
        facets.add([0, 1, 2, 3].map(|lane: usize| four.get(lane).copied()));
    }
    facets
}

fn one(facets: &TexelFacets, surface: SurfaceTexel, eye: Vector3) -> Reflected {
    facets.reflect(&[surface], eye, &|_| true).unwrap()[0]
}

/// What points of light bring, one at a time, by the functions of the BRDF.
fn of_points(surface: &SurfaceTexel, eye: Vector3, points: &[Lit], ndf: Ndf) -> Reflected {
    let view = (eye - surface.position).normalized();
    let mut sum = Reflected::none();
    for Lit { surface: emitter, towards, power, .. } in points {
        let path = surface.position - emitter.position;
        let direction = path.normalized();
        let at_emitter = Directions { normal: emitter.normal, view: *towards, light: direction };
        let brdf =
            emitter.material.diffuse_brdf() + emitter.material.specular_brdf(ndf, &at_emitter);
        let intensity = power.times(brdf) * emitter.normal.dot(direction).max(0.0);
        let cosine = surface.normal.dot(-direction).max(0.0);
        let irradiance = intensity * (cosine / path.length_squared());
        let at_surface = Directions { normal: surface.normal, view, light: -direction };
        sum.diffuse = sum.diffuse + irradiance.times(surface.material.diffuse_brdf());
        sum.specular =
            sum.specular + irradiance.times(surface.material.specular_brdf(ndf, &at_surface));
    }
    sum
}

/// A square facet in `steps` by `steps` pieces.
fn pieces(whole: &Lit, steps: usize) -> Vec<Lit> {
    let [a, b, _, d] = whole.corners;
    let share = 1.0 / steps as f64;
    let piece = |index: usize| {
        let at = |x: f64, y: f64| a + (b - a) * (x * share) + (d - a) * (y * share);
        let (x, y) = ((index % steps) as f64, (index / steps) as f64);
        Lit {
            surface: SurfaceTexel { position: at(x + 0.5, y + 0.5), ..whole.surface },
            power: whole.power * (share * share),
            corners: [at(x, y), at(x + 1.0, y), at(x + 1.0, y + 1.0), at(x, y + 1.0)],
            ..*whole
        }
    };
    (0..steps * steps).map(piece).collect()
}

/// The fast sum against the plain one, of facets that are too small to be near.
#[test]
fn far_facets_are_points() {
    for ndf in [Ndf::Ggx, Ndf::Beckmann] {
        let mut random = Random::new(3);
        let mut surface = || {
            let mut color = || Vector3::new(random.uniform(), random.uniform(), random.uniform());
            let (diffuse, specular) = (color(), color());
            let material = Material { diffuse, specular, alpha: 0.05 + 0.9 * random.uniform() };
            let normal = unit(&mut random);
            let towards = (normal + unit(&mut random) * 0.9).normalized();
            (texel(unit(&mut random) * 2.0, normal, material), towards)
        };
        let emitters: Vec<Lit> = (0..101)
            .map(|_| {
                let (surface, towards) = surface();
                lit(surface.position, surface.normal, towards, 1e-7, surface.material)
            })
            .collect();
        let lights = facets(&emitters, ndf);
        assert_eq!((lights.len(), lights.is_empty()), (101, false));
        let surfaces: Vec<_> = (0..70).map(|_| surface().0).collect();
        let eye = Vector3::new(0.1, 0.2, 0.3);
        let fast = lights.reflect(&surfaces, eye, &|_| true).unwrap();
        let mut missed = 0;
        for (surface, fast) in surfaces.iter().zip(&fast) {
            let plain = of_points(surface, eye, &emitters, ndf);
            assert!((plain.diffuse - fast.diffuse).length() <= 1e-12 * plain.diffuse.length());
            assert!(
                (plain.specular - fast.specular).length() <= 1e-9 * plain.specular.length(),
                "{plain:?} {fast:?}"
            );
            // Negative control: one light less.
            let less = of_points(surface, eye, &emitters[1..], ndf).diffuse;
            missed += usize::from((less - fast.diffuse).length() > 1e-3 * less.length());
        }
        assert!(missed > 5, "{missed}");
    }
}

/// Near facets against many points, whose number says how far they are off themselves; a facet as one point fails.
#[test]
fn near_facets_are_the_sum_of_many_points() {
    let materials = [
        (diffuse(0.8), diffuse(0.6)),
        (glossy(0.9, 0.3), diffuse(0.6)),
        (diffuse(0.8), glossy(0.9, 0.2)),
        (glossy(0.9, 0.12), glossy(0.5, 0.12)),
    ];
    let mut random = Random::new(7);
    for ndf in [Ndf::Ggx, Ndf::Beckmann] {
        for (at, (emitter, receiver)) in materials.iter().enumerate() {
            let (mut squares, mut of_point, mut means, mut worst) = (0.0, 0.0, 0.0, 0.0_f64);
            let count = 24;
            for _ in 0..count {
                let normal = unit(&mut random);
                let towards = (normal + unit(&mut random) * 0.8).normalized();
                let whole = lit(unit(&mut random), normal, towards, 1.0, *emitter);
                // In front, from 0.3 to 3 widths away, looking anywhere that sees it.
                let distance = 0.3 * 10f64.powf(random.uniform());
                let out = (normal + unit(&mut random) * 0.8).normalized();
                let looks = (unit(&mut random) * 0.9 - out).normalized();
                let place = whole.surface.position + out * distance;
                let surface = texel(place, looks, *receiver);
                let eye = place + (looks + unit(&mut random) * 0.8).normalized() * 2.0;
                let facet = one(&facets(&[whole], ndf), surface, eye).total().y;
                let sum = |steps| of_points(&surface, eye, &pieces(&whole, steps), ndf).total().y;
                let (quadrature, point) = (sum(160), sum(1));
                squares += (facet - quadrature).powi(2);
                worst = worst.max((facet - quadrature).abs() / quadrature.max(1e-3));
                of_point += (point - quadrature).powi(2);
                means += quadrature;
            }
            let mean = means / f64::from(count);
            let [facet, point] =
                [squares, of_point].map(|sum| (sum / f64::from(count)).sqrt() / mean);
            println!(
                "{ndf:?} {at}: facets off by {facet:.1e} (worst {worst:.1e}), points by {point:.2}"
            );
            // Without lobes it is exact; with them pieces of a sixth of their width are near enough.
            let allowed = if at == 0 { 2e-4 } else { 0.01 };
            assert!(facet < allowed, "{ndf:?} {at} {facet}");
            assert!(point > 20.0 * allowed, "{ndf:?} {at} {point}");
        }
    }
}

#[test]
fn two_facets_side_by_side_are_one_of_both() {
    let normal = Vector3::new(0.0, 0.0, 1.0);
    let towards = Vector3::new(0.3, 0.2, 0.9).normalized();
    for (emitter, receiver, allowed) in
        [(diffuse(0.8), diffuse(0.6), 1e-12), (glossy(0.9, 0.3), glossy(0.5, 0.2), 0.01)]
    {
        let whole = lit(Vector3::zero(), normal, towards, 1.0, emitter);
        let quarters = pieces(&whole, 2);
        for place in [[0.1, 0.2, 0.05], [0.5, 0.5, 0.3], [2.0, 0.3, 0.4], [0.6, 0.0, 0.01]] {
            let place = Vector3::new(place[0], place[1], place[2]);
            for looks in [-normal, Vector3::new(-1.0, 0.3, -0.2).normalized()] {
                let surface = texel(place, looks, receiver);
                let eye = place + (looks + Vector3::new(0.4, 0.1, 0.3)).normalized();
                let of = |lit: &[Lit]| one(&facets(lit, Ndf::Ggx), surface, eye).total().y;
                let (both, single) = (of(&quarters), of(&[whole]));
                assert!((both - single).abs() <= allowed * single, "{place:?} {both} {single}");
                // Negative control: three of the four.
                let less = (0..4).map(|left_out: usize| {
                    let rest: Vec<Lit> =
                        (0..4).filter(|&at| at != left_out).map(|at| quarters[at]).collect();
                    (of(&rest) - single).abs()
                });
                assert!(less.fold(0.0, f64::max) > 0.1 * single, "{place:?} {single}");
            }
        }
    }
}

/// What a square brings as a point where it becomes one, off by a part of what it would bring face to face.
#[test]
fn the_error_of_points_at_the_switch_is_small() {
    let mut random = Random::new(9);
    let (mut worst, mut squares, mut nearer) = (0.0_f64, 0.0, 0.0_f64);
    let count = 20_000;
    for _ in 0..count {
        let whole = lit(Vector3::zero(), unit(&mut random), unit(&mut random), 1.0, diffuse(1.0));
        let normal = unit(&mut random);
        let direction = unit(&mut random);
        let off = |radii: f64| {
            let distance = radii * 0.5_f64.sqrt();
            let place = direction * distance;
            let cosines =
                whole.surface.normal.dot(direction).max(0.0) * normal.dot(-direction).max(0.0);
            let front = place.dot(whole.surface.normal) > 0.0;
            let exact = if front {
                polygon::irradiance(&whole.corners, whole.surface.normal, place, normal)
            } else {
                0.0
            };
            cosines - exact * distance * distance
        };
        let error = off(24.0).abs();
        worst = worst.max(error);
        squares += error * error;
        nearer = nearer.max(off(6.0).abs());
    }
    let mean = (squares / f64::from(count)).sqrt();
    println!(
        "at the switch: off by {mean:.2e} root mean square, {worst:.2e} at most; at a quarter {nearer:.2e}"
    );
    assert!(worst < 7e-3 && mean < 3e-4, "{worst} {mean}");
    // Negative control: at a quarter of the distance it is not.
    assert!(nearer > 0.02, "{nearer}");
}

/// A light map of a plane and of a ball: neither lights itself.
#[test]
fn a_plane_and_a_ball_do_not_light_themselves() {
    let spot = LightKind::Spot { tan_half_angle: 0.5, cone_scale: 0.0, cone_offset: 1.0 };
    let light = crate::scenery::light(spot, Vector3::new(0.2, 0.1, 3.0));
    let size = [64; 2];
    let tilted = Vector3::new(0.3, -0.2, 0.9).normalized();
    let rays = (0..64 * 64).map(|index: usize| {
        let at = [(index % 64) as f64 + 0.5, (index / 64) as f64 + 0.5];
        light.ray(at, size).unwrap().0
    });
    let plane: Vec<SurfaceTexel> = rays
        .clone()
        .map(|ray| {
            let distance = -ray.origin.dot(tilted) / ray.direction.dot(tilted);
            // As a map of f32 numbers has it.
            let place = (ray.origin + ray.direction * distance).map(|part| f64::from(part as f32));
            texel(place, tilted, diffuse(0.8))
        })
        .collect();
    let ball: Vec<SurfaceTexel> = rays
        .map(|ray| {
            let (along, square) = (ray.origin.dot(ray.direction), ray.origin.length_squared());
            let inside = along * along - square + 1.0;
            let place = ray.origin + ray.direction * (-along - inside.max(0.0).sqrt());
            SurfaceTexel { present: inside > 0.0, ..texel(place, place.normalized(), diffuse(0.8)) }
        })
        .collect();
    for (name, texels, allowed) in [("plane", plane, 1e-6), ("ball", ball, 1e-3)] {
        let facets = TexelFacets::of_map(&light, &texels, size, Ndf::Ggx);
        let receivers: Vec<SurfaceTexel> =
            texels.iter().filter(|texel| texel.present).copied().step_by(7).collect();
        let found = facets.reflect(&receivers, light.position, &|_| true).unwrap();
        // What is sent, over pi, is what a facet reflects of the light.
        let (mut received, mut sent) = (0.0, 0.0);
        for (receiver, found) in receivers.iter().zip(&found) {
            let (towards, square) = light.towards(receiver.position);
            received += found.diffuse.y;
            sent += 2.0 * receiver.normal.dot(towards).max(0.0) / square * 0.8 / PI;
        }
        println!("{name}: received over sent {:.2e} at {}", received / sent, receivers.len());
        assert!(received < allowed * sent, "{name} {received} {sent}");
        // Negative control: from a little above, looking down, it is lit.
        let above = |receiver: &SurfaceTexel| SurfaceTexel {
            position: receiver.position + receiver.normal * 0.1,
            normal: -receiver.normal,
            ..*receiver
        };
        let above: Vec<SurfaceTexel> = receivers.iter().map(above).collect();
        let found = facets.reflect(&above, light.position, &|_| true).unwrap();
        assert!(found.iter().map(|one| one.diffuse.y).sum::<f64>() > 0.3 * sent);
    }
}

/// A directional light on a white diffuse wall of 2 x 2: in front of its middle the irradiance is that of a square of
/// even radiosity, by its form factor, at any distance.
#[test]
fn a_map_of_a_wall_lights_by_its_form_factor() {
    let parallel = LightKind::Directional { half_extent: 1.0 };
    let light = Light {
        intensity: Vector3::splat(1.0),
        ..crate::scenery::light(parallel, Vector3::new(0.0, 0.0, 5.0))
    };
    let size = 64;
    let texels: Vec<SurfaceTexel> = (0..size * size)
        .map(|index| {
            let at = [(index % size) as f64 + 0.5, (index / size) as f64 + 0.5];
            let place = light.cameras()[0].ray(at, [size; 2]).origin;
            let wall =
                texel(Vector3 { z: 0.0, ..place }, Vector3::new(0.0, 0.0, 1.0), diffuse(1.0));
            SurfaceTexel { present: index != 0, ..wall }
        })
        .collect();
    let facets = TexelFacets::of_map(&light, &texels, [size; 2], Ndf::Ggx);
    assert_eq!(facets.len(), size * size - 1);
    for distance in [1e-3, 0.01, 0.1, 1.0, 3.0] {
        let looks = Vector3::new(0.0, 0.0, -1.0);
        let receiver = texel(Vector3::new(0.004, 0.003, distance), looks, diffuse(1.0));
        let radiance = one(&facets, receiver, Vector3::new(1.0, 0.0, 0.5)).diffuse.x;
        // Four corners, nearly equal: of a unit square at this distance.
        let (side, root) = (1.0 / distance, (1.0 + 1.0 / (distance * distance)).sqrt());
        let expected = 4.0 * 2.0 * (side / root) * (side / root).atan() / (2.0 * PI) / PI;
        println!("{distance}: {radiance} {expected}");
        assert!((radiance / expected - 1.0).abs() < 2e-3, "{distance}: {radiance} {expected}");
    }
}

#[test]
fn the_sum_can_be_stopped() {
    let surfaces = vec![texel(Vector3::zero(), unit(&mut Random::new(1)), diffuse(1.0)); 1000];
    let facets = TexelFacets::none(Ndf::Ggx);
    assert!(facets.is_empty());
    assert!(facets.reflect(&surfaces, Vector3::zero(), &|done| done < 100).is_none());
    assert!(facets.reflect(&surfaces, Vector3::zero(), &|_| true).is_some());
}

/// What kernels hold: each texel's light as often as it counts.
#[test]
fn a_texel_brings_as_much_as_it_counts() {
    let parallel = LightKind::Directional { half_extent: 1.0 };
    let light = crate::scenery::light(parallel, Vector3::new(0.0, 0.0, 5.0));
    let (size, up) = (8, Vector3::new(0.0, 0.0, 1.0));
    let texels: Vec<SurfaceTexel> = (0..size * size)
        .map(|index| {
            let at = [(index % size) as f64 + 0.5, (index / size) as f64 + 0.5];
            let place = light.cameras()[0].ray(at, [size; 2]).origin;
            texel(Vector3 { z: 0.0, ..place }, up, diffuse(0.5))
        })
        .collect();
    let receiver = texel(Vector3::new(0.2, 0.1, 0.7), -up, diffuse(0.8));
    let lit_by = |counted: &dyn Fn([usize; 2]) -> f64| {
        let map = TexelFacets::of_counted_map(&light, &texels, [size; 2], Ndf::Ggx, counted);
        one(&map, receiver, Vector3::zero()).diffuse.x
    };
    let whole = lit_by(&|_| 1.0);
    assert_eq!(
        whole,
        one(&TexelFacets::of_map(&light, &texels, [size; 2], Ndf::Ggx), receiver, Vector3::zero())
            .diffuse
            .x
    );
    let left = |share: f64| move |[x, _]: [usize; 2]| if x < 4 { share } else { 0.0 };
    let right = lit_by(&|[x, _]| if x < 4 { 0.0 } else { 1.0 });
    assert!((lit_by(&left(3.0)) + right - whole - 2.0 * lit_by(&left(1.0))).abs() < 1e-12 * whole);
    // Negative control: the halves are not alike.
    assert!((right / lit_by(&left(1.0)) - 1.0).abs() > 0.05);
}

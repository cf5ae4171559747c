//! What kernels are drawn by: `shaders/src/density`, and maps whose size is no power of two.

use sglow_oracle::rsm::Moments;
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::vsgl::Vsgl;
use sglow_oracle::{Bounded, Vector3, density, rsm};
use sglow_renderer::stages::Stages as _;
use sglow_renderer::variants::Variants as _;
use sglow_renderer::{readback, reference};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::LightKind;
use sglow_shaders::{Density, Light, Lobes, Precision, SpecularPower};

use crate::common::{Comparison, KINDS, Run, broken, gpu, lights, small, whole_space};

fn kind(kind: LightKind) -> Light {
    match kind {
        LightKind::Spot { .. } => Light::Spot,
        LightKind::Directional => Light::Directional,
        LightKind::Point => Light::Point,
    }
}

fn settings(density: Density, lobes: Lobes) -> Settings {
    Settings { density, lobes, ..small() }
}

/// The texels of a map in the padded square that holds them; what lies beyond has to be 0.
fn unpadded<T: Copy + Into<[f32; 4]>>(texels: &[T], padded: usize, size: [usize; 2]) -> Vec<T> {
    let mut kept = Vec::new();
    for (index, &texel) in texels.iter().enumerate() {
        if index % padded < size[0] && index / padded < size[1] {
            kept.push(texel);
        } else {
            assert_eq!(texel.into(), [0.0, 0.0, 0.0, texel.into()[3]], "beyond the map");
        }
    }
    assert_eq!(kept.len(), size[0] * size[1]);
    kept
}

/// The density at level 0 of the light's map.
fn compare(run: &Run) -> Comparison {
    let settings = run.indirect.settings();
    let size = [settings.map as usize; 2];
    let padded = run.indirect.density().unwrap().width() as usize;
    let measured = readback::texture(gpu(), &run.indirect.density().unwrap(), 0).unwrap();
    let measured = unpadded(&measured, padded, size);
    let moments: Vec<Moments<Bounded>> =
        reference::moments(gpu(), &run.indirect, &run.light, 0).unwrap();
    let camera: Vec<Vsgl<Bounded>> = reference::camera_lights(gpu(), &run.indirect).unwrap();
    let lights = reference::MapLights::of(&run.light);
    let lobes = reference::lobes(settings.lobes);
    let specular_power = reference::specular_power(settings.specular_power());
    let surfaces: Vec<SurfaceTexel<Bounded>> = reference::texels(&run.rsm);
    let mut comparison = Comparison::default();
    for (index, surface) in surfaces.iter().enumerate() {
        let weight = moments[index / size[0] * padded + index % size[0]].weight();
        let expected = match settings.density {
            Density::Power => weight,
            Density::Reflectance => density::reflectance(surface, lobes),
            Density::Bidirectional => {
                let at = [index % size[0], index / size[0]];
                let of = lights.of_map().at(at, size).unwrap();
                let (towards, _) = of.light.towards(surface.position);
                let camera = camera.iter().copied();
                let emitter = reference::emitter(settings.emitter);
                density::bidirectional(
                    weight,
                    surface,
                    towards,
                    camera,
                    emitter,
                    lobes,
                    specular_power,
                )
            }
        };
        comparison.number(|| format!("texel {index}"), measured[index][0], expected);
    }
    comparison
}

/// The camera's moments and density at level 0, and whether its lights carry the importance of every pixel.
fn compare_camera(run: &Run) -> [Comparison; 2] {
    let settings = run.indirect.settings();
    let size = settings.size.map(|side| side as usize);
    let texture = run.indirect.camera_moments().unwrap();
    let padded = texture.width() as usize;
    let texels = readback::texture(gpu(), &texture, 0).unwrap();
    let layers: Vec<_> =
        texels.chunks(padded * padded).map(|layer| unpadded(layer, padded, size)).collect();
    let measured_density =
        readback::texture(gpu(), &run.indirect.camera_density().unwrap(), 0).unwrap();
    let measured_density = unpadded(&measured_density, padded, size);
    let eye = Vector3::constant(reference::vector(run.eye));
    let origin = Vector3::constant(reference::vector(run.light.origin));
    let lobes = reference::lobes(settings.lobes);
    let specular_power = reference::specular_power(settings.specular_power());
    let surfaces: Vec<SurfaceTexel<Bounded>> = reference::texels(&run.gbuffer);
    let mut comparisons = [(); 2].map(|()| Comparison::default());
    for (index, surface) in surfaces.iter().enumerate() {
        let towards = (eye - surface.position).normalized();
        let one = Vector3::constant(Vector3::splat(1.0));
        let expected: Moments<Bounded> = rsm::moments(
            &specular_power.reflecting(surface, towards),
            one,
            towards,
            origin,
            &reference::emission(settings),
        );
        for (layer, texels) in layers.iter().enumerate() {
            let name = format!("layer {layer} of pixel {index}");
            comparisons[0].texel(&name, texels[index], expected.layers[layer]);
        }
        let expected = density::reflectance(surface, lobes);
        let name = || format!("density of pixel {index}");
        comparisons[1].number(name, measured_density[index][0], expected);
    }
    comparisons
}

#[test]
fn agrees_with_the_oracle() {
    for density in Density::ALL {
        for lobes in [Lobes::Diffuse, Lobes::Both] {
            for precision in Precision::ALL {
                let settings = Settings { precision, ..settings(density, lobes) };
                let run = Run::new(&settings, KINDS[0], whole_space(), 6);
                compare(&run).assert_holds(&format!("density {density}, {lobes}, {precision}"));
            }
        }
    }
}

/// Each texel is weighed by what it reflects towards the light of its own face.
#[test]
fn the_incidence_is_that_of_each_face() {
    for precision in Precision::ALL {
        let own = settings(Density::Bidirectional, Lobes::Both);
        let settings = Settings { light: Light::Several, light_faces: 8, precision, ..own };
        let run = Run::lit(&settings, lights(settings.map), whole_space(), 6);
        compare(&run).assert_holds(&format!("density of several lights, {precision}"));
        let id = "density-bidirectional-cosine-both-f0-each";
        let package = broken(id, "face_lights[face]", "face_lights[0]");
        let run = Run::lit(&settings, lights(settings.map), &package, 6);
        compare(&run).assert_fails("the first light alone");
    }
}

/// The power, with Fresnel's term and masking, is divided out of the bidirectional density again.
#[test]
fn the_albedo_is_divided_out() {
    for precision in Precision::ALL {
        let specular_power = SpecularPower::Albedo;
        let base = settings(Density::Bidirectional, Lobes::Both);
        let settings = Settings { precision, specular_power, ..base };
        let run = Run::new(&settings, KINDS[0], whole_space(), 6);
        compare(&run).assert_holds(&format!("density by the albedo, {precision}"));
        compare_camera(&run)[0].assert_holds(&format!("the camera's moments, {precision}"));
    }
    let base = settings(Density::Bidirectional, Lobes::Both);
    let settings = Settings { specular_power: SpecularPower::Albedo, ..base };
    let (from, to) = ("dot(towards, surface.normal)", "0.9 * dot(towards, surface.normal)");
    let package = broken("density-bidirectional-cosine-both-albedo", from, to);
    compare(&Run::new(&settings, KINDS[0], &package, 6)).assert_fails("another angle");
}

#[test]
fn the_camera_sends_importance_through_every_pixel() {
    for lobes in [Lobes::Diffuse, Lobes::Both] {
        let run =
            Run::new(&settings(Density::Bidirectional, lobes), KINDS[0], &Package::embedded(), 6);
        let [moments, density] = compare_camera(&run);
        moments.assert_holds(&format!("the camera's moments, {lobes}"));
        density.assert_holds(&format!("the camera's density, {lobes}"));
    }
}

/// With a pixel's reflectance as density and importance 1, Eq. (5) gives every light the same share.
#[test]
fn the_cameras_lights_carry_all_importance() {
    let run =
        Run::new(&settings(Density::Bidirectional, Lobes::Both), KINDS[0], &Package::embedded(), 6);
    let lights: Vec<Vsgl> = reference::camera_lights(gpu(), &run.indirect).unwrap();
    let surfaces: Vec<SurfaceTexel> = reference::texels(&run.gbuffer);
    let all: f64 =
        surfaces.iter().map(|surface| density::reflectance(surface, rsm::Lobes::Both)).sum();
    let sum: f64 = lights.iter().map(|light| light.power().luminance()).sum();
    assert!((sum / all - 1.0).abs() < 1e-4, "{sum} of {all}");
}

#[test]
fn maps_of_any_size_are_padded() {
    for (size, padded) in [(1, 1), (7, 8), (24, 32), (33, 64)] {
        for density in Density::ALL {
            for light in &KINDS[..2] {
                let settings =
                    Settings { map: size, light: kind(*light), ..settings(density, Lobes::Both) };
                let run = Run::new(&settings, *light, &Package::embedded(), 8);
                assert_eq!(run.indirect.density().unwrap().width(), padded);
                let comparison = compare(&run);
                comparison.assert_holds(&format!("{density} on {size} by {size} texels"));
                let lights: Vec<Vsgl> = reference::lights(gpu(), &run.indirect).unwrap();
                assert!(lights.iter().all(|light| {
                    let power = light.power();
                    power.to_array().iter().all(|part| part.is_finite() && *part >= 0.0)
                }));
            }
        }
    }
    let settings = Settings { map: 20, light: Light::Point, ..small() };
    compare(&Run::new(&settings, KINDS[2], &Package::embedded(), 8)).assert_holds("a point light");
}

#[test]
fn padding_keeps_the_power() {
    let total = |size: u32| {
        let settings = Settings { map: size, lobes: Lobes::Diffuse, ..small() };
        let run = Run::new(&settings, KINDS[0], &Package::embedded(), 9);
        let moments: Vec<Moments> =
            reference::moments(gpu(), &run.indirect, &run.light, 0).unwrap();
        let all: f64 = moments.iter().map(Moments::weight).sum();
        let lights: Vec<Vsgl> = reference::lights(gpu(), &run.indirect).unwrap();
        let sum: f64 = lights.iter().map(|light| light.power().luminance()).sum();
        sum / all
    };
    for size in [32, 24, 33] {
        assert!((total(size) - 1.0).abs() < 1e-4, "{size}: {}", total(size));
    }
}

#[test]
fn a_broken_shader_is_noticed() {
    let breaks = [
        (Density::Power, "id.xy, 1, 0).w", "id.xy, 1, 0).x", "another channel"),
        (
            Density::Reflectance,
            "reflectance += surface.f0",
            "reflectance += 0.99 * surface.f0",
            "less specular",
        ),
        (
            Density::Bidirectional,
            "light.xyz - light.w * surface.position",
            "light.xyz + light.w * surface.position",
            "a light elsewhere",
        ),
        (
            Density::Bidirectional,
            "sglow_luminance(importance) / sglow_luminance(reflectance)",
            "sglow_luminance(importance)",
            "a reflectance that counts twice",
        ),
        (Density::Bidirectional, "+ sglow_specular(from_specular, receiver)", "", "a dropped lobe"),
    ];
    for (density, from, to, what) in breaks {
        let importance = if density == Density::Bidirectional { "cosine" } else { "none" };
        let package = broken(&format!("density-{density}-{importance}-both-f0"), from, to);
        let run = Run::new(&settings(density, Lobes::Both), KINDS[0], &package, 6);
        compare(&run).assert_fails(what);
    }
    let id = "moments-camera-both-f0-exact-f32";
    let package = broken(id, "vec3<f32>(1.0)", "vec3<f32>(1.001)");
    let run = Run::new(&settings(Density::Bidirectional, Lobes::Both), KINDS[0], &package, 6);
    compare_camera(&run)[0].assert_fails("another importance");
}

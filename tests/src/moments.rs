//! The moments of virtual point lights: `shaders/src/rsm/moments.wesl` and `shaders/src/light`.

use sglow_oracle::rsm::{self, Moments};
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::{Bounded, Vector3};
use sglow_renderer::reference;
use sglow_renderer::stages::Stages as _;
use sglow_renderer::variants::Variants as _;
use sglow_runtime::light::LightView;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::LightKind;
use sglow_shaders::{Emitter, Light, Lobes, Precision, Sharpness, SpecularPower};

use crate::common::{Comparison, KINDS, Run, broken, gpu, light, lights, small, whole_space};

fn settings(kind: LightKind, lobes: Lobes) -> Settings {
    let light = match kind {
        LightKind::Spot { .. } => Light::Spot,
        LightKind::Directional => Light::Directional,
        LightKind::Point => Light::Point,
    };
    Settings { light, lobes, ..small() }
}

fn several(lobes: Lobes, precision: Precision) -> Settings {
    Settings { light: Light::Several, light_faces: 8, lobes, precision, ..small() }
}

fn compare(run: &Run) -> Comparison {
    let settings = run.indirect.settings();
    let measured: Vec<Moments> = reference::moments(gpu(), &run.indirect, &run.light, 0).unwrap();
    let size = settings.map as usize;
    let lights = reference::MapLights::of(&run.light);
    let lobes = reference::lobes(settings.lobes);
    let origin = Vector3::constant(reference::vector(run.light.origin));
    let texels: Vec<SurfaceTexel<Bounded>> = reference::texels(&run.rsm);
    let mut comparison = Comparison::default();
    for (index, texel) in texels.iter().enumerate() {
        let at = [index % size, index / size];
        // Around the texels that a light has of its tile there is no power.
        let of = lights.of_map().at(at, [size; 2]);
        let power: Vector3<Bounded> =
            of.map_or(Vector3::zero(), |of| of.light.photon_power(of.texel, of.size));
        let (towards, _) = of.map_or(lights.each[0], |of| of.light).towards(texel.position);
        let texel = reference::specular_power(settings.specular_power()).reflecting(texel, towards);
        let mut expected: Moments<Bounded> =
            rsm::moments(&texel, power, towards, origin, &reference::emission(settings));
        if settings.precision == Precision::F16 {
            expected = expected.with_specular_weight().to_half(f64::from(run.light.power_unit));
        }
        for layer in 0..lobes.layers() {
            let name = format!("layer {layer} of texel {at:?}");
            // What f64 holds is the f32 that was read, to the bit.
            let measured = measured[index].layers[layer].map(|value| value as f32);
            comparison.texel(&name, measured, expected.layers[layer]);
        }
    }
    comparison
}

#[test]
fn agree_with_the_oracle() {
    for kind in KINDS {
        for lobes in [Lobes::Diffuse, Lobes::Both] {
            for precision in Precision::ALL {
                let settings = Settings { precision, ..settings(kind, lobes) };
                let run = Run::new(&settings, kind, whole_space(), 1);
                let what = format!("moments of {kind:?}, lobes {lobes}, precision {precision}");
                compare(&run).assert_holds(&what);
            }
        }
    }
}

#[test]
fn of_several_lights_agree_with_the_oracle() {
    for lobes in [Lobes::Diffuse, Lobes::Both] {
        for precision in Precision::ALL {
            let settings = several(lobes, precision);
            let run = Run::lit(&settings, lights(settings.map), whole_space(), 1);
            compare(&run).assert_holds(&format!("several lights, lobes {lobes}, {precision}"));
        }
    }
    let settings = several(Lobes::Both, Precision::F32);
    for (from, to, what) in [
        ("tile.y * grid.x + tile.x", "tile.y * grid.x", "one light for a row of tiles"),
        ("texel - tile * tile_size", "texel", "a texel of the whole map"),
        ("light.half_extent > 0.0", "light.half_extent > 1e9", "a directional light as a spot"),
    ] {
        let package = broken("moments-several-both-f0-exact-f32", from, to);
        compare(&Run::lit(&settings, lights(settings.map), &package, 1)).assert_fails(what);
    }
}

/// Lights of fewer texels than their tiles; that of a directional light is whole, for random surfaces lie all around.
#[test]
fn of_lights_of_different_sizes_agree_with_the_oracle() {
    let settings = several(Lobes::Both, Precision::F32);
    let tile = settings.map / 4;
    let sized = |mut texels: [Option<u32>; 3]| {
        texels[1] = None;
        let mut each = KINDS.map(|kind| light(kind, settings.map));
        each.iter_mut().zip(texels).for_each(|(light, texels)| light.texels = texels);
        LightView::several(&each).unwrap()
    };
    let own = [Some(tile / 2), None, Some(tile - 2)];
    compare(&Run::lit(&settings, sized(own), whole_space(), 1)).assert_holds("different sizes");
    let id = "moments-several-both-f0-exact-f32";
    let endless = broken(id, "light.cone_scale <= 0.0", "false");
    let run = Run::lit(&settings, sized(own), &endless, 1);
    compare(&run).assert_fails("a point light beyond 90 degrees");
    let mut run = Run::lit(&settings, sized(own), whole_space(), 1);
    run.light = sized([Some(tile), None, Some(tile - 4)]);
    compare(&run).assert_fails("other sizes");
}

#[test]
fn of_every_emission_agree_with_the_oracle() {
    for sharpness in Sharpness::ALL {
        for (emitter, emission_sharpness) in
            [(Emitter::Lobe, 2.0), (Emitter::Lobe, 2.2925), (Emitter::Disc, 2.0)]
        {
            let own = settings(KINDS[0], Lobes::Both);
            let settings = Settings { sharpness, emitter, emission_sharpness, ..own };
            let run = Run::new(&settings, KINDS[0], whole_space(), 1);
            compare(&run).assert_holds(&format!("{emitter} {emission_sharpness}, {sharpness}"));
        }
    }
}

#[test]
fn specular_power_by_albedo_agrees_with_the_oracle() {
    for kind in KINDS {
        for precision in Precision::ALL {
            let specular_power = SpecularPower::Albedo;
            let settings = Settings { precision, specular_power, ..settings(kind, Lobes::Both) };
            let run = Run::new(&settings, kind, whole_space(), 1);
            compare(&run).assert_holds(&format!("moments of {kind:?} by albedo, {precision}"));
        }
    }
    let albedo =
        Settings { specular_power: SpecularPower::Albedo, ..settings(KINDS[0], Lobes::Both) };
    for (from, to, what) in [
        ("dot(incoming, surface.normal)", "0.99 * dot(incoming, surface.normal)", "another angle"),
        ("1696.63", "1696.0", "another constant of what is lost"),
        ("0.935145", "0.936", "another constant of what Fresnel's term adds"),
        ("max(white - added, 0.0)", "white", "light that is reflected twice"),
    ] {
        let package = broken("moments-spot-both-albedo-exact-f32", from, to);
        compare(&Run::new(&albedo, KINDS[0], &package, 1)).assert_fails(what);
    }
    // With diffuse lobes alone there is no specular power to choose, and so no variant of it.
    let diffuse = Settings { lobes: Lobes::Diffuse, ..albedo };
    compare(&Run::new(&diffuse, KINDS[0], whole_space(), 1)).assert_holds("diffuse lobes alone");
}

#[test]
fn a_broken_shader_is_noticed() {
    let breaks = [
        (
            "extent.x * extent.y * cosine * cosine * cosine",
            "extent.x * extent.y * cosine * cosine",
            "a dropped cosine",
        ),
        (
            "weight * vec4<f32>(position, dot(position, position))",
            "vec4<f32>(position, dot(position, position))",
            "a dropped weight",
        ),
        ("2.0 * cosine * normal - view", "2.0 * cosine * normal + view", "a mirrored direction"),
        ("attenuation * attenuation", "attenuation", "an attenuation that is not squared"),
        (
            "diffuse_mean_length * surface.normal",
            "0.99999 * surface.normal",
            "a length that is off by one part in a hundred thousand",
        ),
    ];
    for (from, to, what) in breaks {
        let package = broken("moments-spot-both-f0-exact-f32", from, to);
        let run = Run::new(&settings(KINDS[0], Lobes::Both), KINDS[0], &package, 1);
        compare(&run).assert_fails(what);
    }
}

fn halves(kind: LightKind) -> Settings {
    Settings { precision: Precision::F16, ..settings(kind, Lobes::Both) }
}

/// In halves: what is rounded that must not be, or is not scaled.
#[test]
fn broken_halves_are_noticed() {
    let breaks = [
        (
            "sglow_weight_output, id.xy, 0, vec4<f32>(weight",
            "sglow_weight_output, id.xy, 0, vec4<f32>(unpack2x16float(pack2x16float(vec2<f32>(weight))).x",
            "a weight in half",
        ),
        (
            "weight * vec4<f32>(position, dot(position, position))",
            "weight * vec4<f32>(unpack2x16float(pack2x16float(position.xy)), position.z, dot(position, position))",
            "a position in half",
        ),
        (
            "scaled_weight * direction, scaled_weight)",
            "scaled_weight * direction, 1.001 * scaled_weight)",
            "another weight",
        ),
        ("scale * diffuse_power", "0.998 * scale * diffuse_power", "another power"),
    ];
    for (from, to, what) in breaks {
        let package = broken("moments-spot-both-f0-exact-f16", from, to);
        let run = Run::new(&halves(KINDS[0]), KINDS[0], &package, 1);
        compare(&run).assert_fails(what);
    }
}

#[test]
fn layers_that_are_left_out_do_not_exist() {
    let run = Run::new(&settings(KINDS[0], Lobes::Diffuse), KINDS[0], &Package::embedded(), 1);
    assert_eq!(run.indirect.moments().unwrap().depth_or_array_layers(), 3);
    let run = Run::new(&settings(KINDS[0], Lobes::Both), KINDS[0], &Package::embedded(), 1);
    assert_eq!(run.indirect.moments().unwrap().depth_or_array_layers(), 5);
    assert!(run.indirect.half_moments().is_none());
    for (lobes, layers) in [(Lobes::Diffuse, [1, 2]), (Lobes::Both, [2, 3])] {
        let settings = Settings { lobes, ..halves(KINDS[0]) };
        let run = Run::new(&settings, KINDS[0], whole_space(), 1);
        let textures = [run.indirect.moments().unwrap(), run.indirect.half_moments().unwrap()];
        assert_eq!(textures.map(|texture| texture.depth_or_array_layers()), layers);
    }
}

//! The moments of virtual point lights: `shaders/src/rsm/moments.wesl` and `shaders/src/light`.

use sglow_oracle::rsm::{self, Moments};
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::{Bounded, Vector3};
use sglow_runtime::package::Package;
use sglow_runtime::scene::LightKind;
use sglow_runtime::settings::Settings;
use sglow_runtime::{readback, reference};
use sglow_shaders::{Light, Lobes};

use crate::common::{Comparison, KINDS, Run, broken, gpu, small, whole_space};

fn settings(kind: LightKind, lobes: Lobes) -> Settings {
    let light = match kind {
        LightKind::Spot { .. } => Light::Spot,
        LightKind::Directional => Light::Directional,
        LightKind::Point => Light::Point,
    };
    Settings { light, lobes, ..small() }
}

fn compare(run: &Run) -> Comparison {
    let settings = run.indirect.settings();
    let measured = readback::texture(gpu(), run.indirect.moments(), 0).unwrap();
    let size = settings.rsm_size as usize;
    let light = reference::light(&run.light, settings.light);
    let lobes = reference::lobes(settings.lobes);
    let origin = Vector3::constant(reference::vector(run.light.origin));
    let texels: Vec<SurfaceTexel<Bounded>> = reference::texels(&run.rsm);
    let mut comparison = Comparison::default();
    for (index, texel) in texels.iter().enumerate() {
        let at = [index % size, index / size];
        let power: Vector3<Bounded> = light.photon_power(at, [size; 2]);
        let (towards, _) = light.towards(texel.position);
        let expected: Moments<Bounded> = rsm::moments(texel, power, towards, origin, lobes);
        for layer in 0..lobes.layers() {
            let name = format!("layer {layer} of texel {at:?}");
            let measured = measured[layer * size * size + index];
            comparison.texel(&name, measured, expected.layers[layer]);
        }
    }
    comparison
}

#[test]
fn agree_with_the_oracle() {
    for kind in KINDS {
        for lobes in [Lobes::Diffuse, Lobes::Both] {
            let run = Run::new(&settings(kind, lobes), kind, whole_space(), 1);
            compare(&run).assert_holds(&format!("moments of {kind:?}, lobes {lobes}"));
        }
    }
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
        ("0.6666667", "0.66666", "a constant that is off by one part in a hundred thousand"),
    ];
    for (from, to, what) in breaks {
        let package = broken("moments-spot-both", from, to);
        let run = Run::new(&settings(KINDS[0], Lobes::Both), KINDS[0], &package, 1);
        compare(&run).assert_fails(what);
    }
}

#[test]
fn layers_that_are_left_out_do_not_exist() {
    let run = Run::new(&settings(KINDS[0], Lobes::Diffuse), KINDS[0], &Package::embedded(), 1);
    assert_eq!(run.indirect.moments().depth_or_array_layers(), 3);
    let run = Run::new(&settings(KINDS[0], Lobes::Both), KINDS[0], &Package::embedded(), 1);
    assert_eq!(run.indirect.moments().depth_or_array_layers(), 5);
}

//! What a frame takes is known without a device: the variants that a renderer asks for and the bytes that it keeps are
//! those of the plan, neither more nor fewer.

use std::collections::BTreeSet;

use sglow_renderer::frame::Renderer;
use sglow_renderer::variants::Variants as _;
use sglow_runtime::settings::Settings;
use sglow_scene::{LightKind, Scene};
use sglow_shader_gen::library::Library;
use sglow_shader_gen::matrix::{Facts, Variant};
use sglow_shaders::{
    Density, Diffuse, Draw, Emitter, Filter, Kernel, Light, Lobes, Ndf, Precision, Space, Specular,
    Visibility,
};

use crate::common::{KINDS, gpu, library, plan, whole_space};

fn base() -> Settings {
    Settings {
        size: [24, 17],
        map: 20,
        lights: 33,
        camera_lights: 19,
        shadow_points: 50,
        tile: 8,
        ..Settings::default()
    }
}

/// Each value of each axis, and what goes together in ways of its own.
fn many() -> Vec<Settings> {
    let base = base();
    let plain = || Settings { specular: Specular::None, ndf: Ndf::None, ..base.clone() };
    let mut all = vec![base.clone()];
    let density = Density::Bidirectional;
    all.extend(Emitter::ALL.map(|emitter| Settings { emitter, density, ..base.clone() }));
    all.extend(Lobes::ALL.map(|lobes| Settings { lobes, ..plain() }));
    all.push(Settings { diffuse: Diffuse::None, ..base.clone() });
    all.push(Settings { complete: true, ..base.clone() });
    all.push(Settings { kernel: Kernel::Previous, filter: Filter::Hardware, ..base.clone() });
    for precision in Precision::ALL {
        for density in Density::ALL {
            for lobes in Lobes::ALL {
                all.push(Settings { precision, density, lobes, ..base.clone() });
            }
        }
        for visibility in [Visibility::ShadowMap, Visibility::Imperfect] {
            all.push(Settings { precision, visibility, ..base.clone() });
        }
        all.push(Settings { precision, draw: Draw::Metropolis, ..base.clone() });
    }
    for space in Space::ALL {
        for density in Density::ALL {
            for draw in Draw::ALL {
                all.push(Settings { space, density, draw, ..base.clone() });
            }
        }
    }
    let light = Light::Several;
    for density in Density::ALL {
        all.push(Settings { light, density, ..plain() });
    }
    all.push(Settings { light, space: Space::Tree, ..plain() });
    for space in [Space::Image, Space::World] {
        for count in [1, 1100] {
            all.push(Settings { space, lights: count, lobes: Lobes::Diffuse, ..plain() });
        }
    }
    all
}

fn light(kind: LightKind) -> Light {
    match kind {
        LightKind::Spot { .. } => Light::Spot,
        LightKind::Directional => Light::Directional,
        LightKind::Point => Light::Point,
    }
}

/// What differs between a plan and a renderer.
fn difference(scene: &Scene, settings: &Settings, planned: &Settings) -> Option<String> {
    let package = whole_space().clone();
    let renderer = Renderer::new(gpu(), &package, scene, settings, 0).unwrap();
    let plan = plan(planned, scene);
    let (requested, mut variants) = (package.requested_variants(), plan.variants);
    // A picture may change its size, and with it the lengths of its chains: all of their variants are planned.
    variants.retain(|id| requested.contains(id) || !id.starts_with("mip-"));
    let mut bytes: Vec<_> = plan
        .resources
        .into_iter()
        // A buffer has a multiple of four bytes.
        .map(|of| (of.name, of.bytes.max(4).next_multiple_of(4)))
        .collect();
    let mut kept = renderer.bytes();
    bytes.sort_unstable();
    kept.sort_unstable();
    if requested != variants {
        let [more, fewer] = [&requested - &variants, &variants - &requested];
        return Some(format!(
            "requested and not planned: {more:?}; planned and not requested: {fewer:?}"
        ));
    }
    (bytes != kept).then(|| format!("planned {bytes:?}, kept {kept:?}"))
}

#[test]
fn a_renderer_takes_what_is_planned() {
    let scene = Scene::builtin("cornell").unwrap();
    for settings in many() {
        assert_eq!(difference(&scene, &settings, &settings), None, "{settings:?}");
    }
    // Materials of several kinds, some of them emitting, and every kind of light.
    for kind in KINDS {
        let mut scene = Scene::builtin("atrium:15k").unwrap();
        let drawn: Vec<_> = scene.meshes.iter().map(|mesh| mesh.material).collect();
        scene.materials[drawn[0]].emission = [1.0, 0.5, 0.2];
        scene.lights[0].kind = kind;
        let settings = Settings { light: light(kind), ..base() };
        assert_eq!(difference(&scene, &settings, &settings), None, "{kind:?}");
    }
}

/// What rules of presence leave where settings and surfaces are settled, and what of it no frame runs.
fn left_by_rules(
    library: &Library,
    settings: &Settings,
    surfaces: &[(&str, &str)],
) -> BTreeSet<String> {
    let mut allowed = library.needed(&Facts::new()).unwrap();
    let mut keep = |axis: &str, values: &[String]| {
        allowed.get_mut(axis).unwrap().values.retain(|known| values.contains(known));
    };
    for axis in Settings::AXES.iter().copied() {
        let value = match axis {
            "solver" => settings.sample().solver.to_string(),
            _ => settings.get(axis).unwrap(),
        };
        let mut values = vec![value];
        match axis {
            // The camera is in every scene.
            "light" => values.push(Light::Camera.to_string()),
            // By which its lights are drawn.
            "density" if settings.density == Density::Bidirectional => {
                values.push(Density::Reflectance.to_string());
            }
            _ => {}
        }
        keep(axis, &values);
    }
    for (axis, value) in surfaces {
        keep(axis, &[(*value).to_owned()]);
    }
    keep("start", &["warped".to_owned()]);
    let (variants, absent) = library.remaining(&allowed);
    assert!(!absent.is_empty());
    let measures = |variant: &&Variant| ["check", "function"].contains(&variant.pass.as_str());
    variants.iter().filter(|variant| !measures(variant)).map(Variant::id).collect()
}

#[test]
fn rules_of_presence_leave_what_a_renderer_takes() {
    let library = library();
    let scene = Scene::builtin("cornell").unwrap();
    let constant = [("material", "constant"), ("opacity", "opaque"), ("emission", "none")];
    // The camera's lights are in 32 bits, whatever the light's are.
    let alike = |settings: &Settings| {
        settings.density != Density::Bidirectional || settings.precision == Precision::F32
    };
    let mut settings = many();
    settings.retain(|settings| !settings.complete && alike(settings));
    assert!(settings.len() > 20);
    let planned: Vec<_> =
        settings.iter().map(|settings| (settings, plan(settings, &scene).variants)).collect();
    for (settings, planned) in &planned {
        assert_eq!(left_by_rules(&library, settings, &constant), *planned, "{settings:?}");
    }
    // Negative controls: without a rule something is left that no frame runs.
    for index in 0..library.presence.len() {
        let mut library = library.clone();
        let rule = library.presence.remove(index);
        let noticed = planned
            .iter()
            .any(|(settings, planned)| left_by_rules(&library, settings, &constant) != *planned);
        assert!(noticed, "{} changes nothing", rule.name);
    }
}

#[test]
fn a_plan_of_other_settings_is_noticed() {
    let scene = Scene::builtin("cornell").unwrap();
    for other in [
        Settings { lobes: Lobes::Diffuse, ..base() },
        Settings { map: 33, ..base() },
        Settings { complete: true, ..base() },
        Settings { visibility: Visibility::ShadowMap, ..base() },
    ] {
        assert!(difference(&scene, &base(), &other).is_some(), "{other:?}");
    }
}

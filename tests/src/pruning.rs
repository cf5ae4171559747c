//! What a scene does not need is left out, and nothing changes: for every set of needs the pruned variants render what
//! the complete ones render, bit for bit.

use sglow_runtime::frame::{Frame, Renderer};
use sglow_runtime::package::Package;
use sglow_runtime::scene::{Camera, Image, Light, LightKind, Material, Mesh, Scene, TextureUse};
use sglow_runtime::settings::Settings;
use sglow_shader_gen::library::Library;
use sglow_shaders::Precision;

use crate::common::{KINDS, broken, gpu, whole_space};

#[derive(Clone, Copy, Debug)]
struct Needs {
    specular: bool,
    textured: bool,
    cutout: bool,
    emissive: bool,
    light: LightKind,
}

/// A floor and a wall that have just the properties asked for.
fn scene(needs: Needs) -> Scene {
    let quad = |name: &str, corners: [[f32; 3]; 4], normal: [f32; 3], material| Mesh {
        name: name.to_owned(),
        positions: corners.to_vec(),
        normals: vec![normal; 4],
        uvs: vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]],
        indices: vec![0, 1, 2, 0, 2, 3],
        material,
    };
    let mut floor = Material::diffuse("floor", [0.7, 0.5, 0.4]);
    let mut wall = Material::diffuse("wall", [0.3, 0.6, 0.8]);
    floor.double_sided = true;
    wall.double_sided = true;
    if needs.specular {
        floor.dielectric = 0.04;
        floor.roughness = 0.4;
        wall.metallic = 0.7;
        wall.roughness = 0.5;
    }
    if needs.textured {
        floor.base_color_texture = Some(TextureUse::repeating(0));
    }
    if needs.cutout {
        floor.alpha_cutoff = Some(0.5);
    }
    if needs.emissive {
        wall.emission = [0.5, 0.4, 0.1];
    }
    let checker = Image {
        name: "checker".to_owned(),
        width: 2,
        height: 2,
        rgba8: [[255, 255, 255, 255], [200, 80, 60, 40], [90, 220, 100, 20], [255, 250, 240, 255]]
            .concat(),
        srgb: true,
    };
    Scene {
        name: "needs".to_owned(),
        meshes: vec![
            quad(
                "floor",
                [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]],
                [0.0, 1.0, 0.0],
                0,
            ),
            quad(
                "wall",
                [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 2.0, -1.0], [-1.0, 2.0, -1.0]],
                [0.0, 0.0, 1.0],
                1,
            ),
        ],
        materials: vec![floor, wall],
        images: if needs.textured { vec![checker] } else { Vec::new() },
        lights: vec![Light {
            name: "light".to_owned(),
            kind: needs.light,
            position: [0.4, 1.7, 0.9],
            direction: glam::Vec3::new(-0.2, -1.0, -0.8).normalize().into(),
            intensity: [12.0, 11.0, 9.0],
            range: None,
        }],
        camera: Camera::look_at([0.6, 1.1, 2.6], [0.0, 0.5, -0.4], [0.0, 1.0, 0.0], 0.9),
        notes: Vec::new(),
    }
}

fn every_need() -> Vec<Needs> {
    let mut all = Vec::new();
    for bits in 0..16 {
        let [specular, textured, cutout, emissive] = [1, 2, 4, 8].map(|bit| bits & bit != 0);
        if !cutout || textured {
            all.push(Needs { specular, textured, cutout, emissive, light: KINDS[0] });
        }
    }
    for light in [KINDS[1], KINDS[2]] {
        all.push(Needs { specular: false, textured: false, cutout: false, emissive: false, light });
        all.push(Needs { specular: true, textured: true, cutout: true, emissive: true, light });
    }
    all
}

fn base() -> Settings {
    Settings { size: [40, 30], rsm_size: 32, count: 32, ..Settings::default() }
}

/// The settings after the needs of a scene, by the rules of the library.
fn pruned(scene: &Scene) -> Settings {
    let library =
        Library::load(concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders").as_ref()).unwrap();
    let needed = library.needed(&scene.facts().known()).unwrap();
    let mut settings = base();
    for axis in sglow_runtime::settings::AXES {
        if let [value] = needed[axis].values.as_slice() {
            settings.set(axis, value).unwrap();
        }
    }
    settings
}

fn render(scene: &Scene, settings: &Settings, package: &Package) -> Frame {
    let renderer = Renderer::new(gpu(), package, scene, settings, 0).unwrap();
    renderer.render().unwrap();
    renderer.read().unwrap()
}

fn bits(pixels: &[[f32; 4]]) -> Vec<[u32; 4]> {
    pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

/// Where two frames differ in the bits of anything that both show.
fn difference(pruned: &Frame, complete: &Frame) -> Option<&'static str> {
    let pairs = [
        ("radiance", Some(&pruned.radiance), Some(&complete.radiance)),
        ("direct", Some(&pruned.direct), Some(&complete.direct)),
        ("indirect diffuse", pruned.indirect_diffuse.as_ref(), complete.indirect_diffuse.as_ref()),
        (
            "indirect specular",
            pruned.indirect_specular.as_ref(),
            complete.indirect_specular.as_ref(),
        ),
        ("emission", pruned.emission.as_ref(), complete.emission.as_ref()),
        ("position", Some(&pruned.gbuffer.position), Some(&complete.gbuffer.position)),
        ("normal", Some(&pruned.gbuffer.normal), Some(&complete.gbuffer.normal)),
        ("base colour", Some(&pruned.gbuffer.base_color), Some(&complete.gbuffer.base_color)),
    ];
    pairs.into_iter().find_map(|(name, pruned, complete)| {
        let complete = complete?;
        match pruned {
            Some(pruned) => (bits(pruned) != bits(complete)).then_some(name),
            // What is left out must have been nothing.
            None => complete.iter().any(|pixel| pixel[..3] != [0.0; 3]).then_some(name),
        }
    })
}

#[test]
fn every_set_of_needs_renders_the_same_bits() {
    for needs in every_need() {
        let scene = scene(needs);
        for precision in Precision::ALL {
            let settings = Settings { precision, ..pruned(&scene) };
            let complete = Settings { complete: true, precision, ..base() };
            let [pruned, complete] =
                [&settings, &complete].map(|settings| render(&scene, settings, whole_space()));
            let what = format!("{needs:?}, {precision}");
            assert!(complete.radiance.iter().any(|pixel| pixel[0] > 0.0), "{what} renders black");
            assert_eq!(difference(&pruned, &complete), None, "{what}");
            assert_eq!(pruned.indirect_specular.is_some(), needs.specular, "{what}");
            assert_eq!(pruned.emission.is_some(), needs.emissive, "{what}");
        }
    }
}

#[test]
fn a_variant_that_prunes_too_much_is_noticed() {
    let needs =
        Needs { specular: false, textured: false, cutout: false, emissive: false, light: KINDS[0] };
    let scene = scene(needs);
    let settings = pruned(&scene);
    let complete = render(&scene, &Settings { complete: true, ..base() }, &Package::embedded());
    let package = broken(&settings.shade().id(), "diffuse *= surface.diffuse;", "");
    assert_eq!(difference(&render(&scene, &settings, &package), &complete), Some("radiance"));

    // A specular scene without its specular lobe.
    let scene = self::scene(Needs { specular: true, ..needs });
    let complete = render(&scene, &Settings { complete: true, ..base() }, &Package::embedded());
    assert!(difference(&render(&scene, &settings, &Package::embedded()), &complete).is_some());
}

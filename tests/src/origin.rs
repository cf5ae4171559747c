//! Scenes far from the world's origin: the picture is that of the scene at the origin whose vertices are rounded as
//! in the file far from it.

use std::path::Path;

use glam::DVec3;
use serde_json::{Value, json};
use sglow_renderer::frame::{Frame, Renderer};
use sglow_runtime::light::{LightView, Surroundings};
use sglow_runtime::settings::Settings;
use sglow_scene::{LightKind, Mesh, Options, Scene};

use crate::common::{gpu, whole_space};

const SIZE: [u32; 2] = [48, 27];

/// The lights of a room: its own, one from the open side, one in the middle.
fn lit_by(kind: &str) -> Scene {
    let mut scene = Scene::builtin("cornell-glossy").unwrap();
    let light = &mut scene.lights[0];
    match kind {
        "point" => {
            light.kind = LightKind::Point;
            light.position[1] -= 1.0;
        }
        "directional" => {
            light.kind = LightKind::Directional;
            light.direction = glam::Vec3::new(0.2, -0.4, 1.0).normalize().into();
            light.intensity = [5.0; 3];
        }
        _ => {}
    }
    scene
}

/// Writes a scene as glTF: its vertices mapped by `vertex` and rounded to 32 bits, its camera and its light mapped by `other`
/// in 64.
fn write(
    folder: &Path,
    scene: &Scene,
    vertex: impl Fn(DVec3) -> DVec3,
    other: impl Fn(DVec3) -> DVec3,
) -> String {
    let wide = |position: [f32; 3]| DVec3::from(position.map(f64::from));
    let mut bytes: Vec<u8> = Vec::new();
    let (mut views, mut accessors, mut meshes) = (Vec::new(), Vec::new(), Vec::new());
    for mesh in &scene.meshes {
        let Mesh { positions, normals, indices, material, .. } = mesh;
        let positions: Vec<[f32; 3]> =
            positions.iter().map(|&position| vertex(wide(position)).as_vec3().into()).collect();
        let first = accessors.len();
        let mut add = |part: &[u8], component: u32, kind: &str, count: usize| {
            views.push(json!({
                "buffer": 0, "byteOffset": bytes.len(), "byteLength": part.len(),
            }));
            bytes.extend(part);
            accessors.push(json!({
                "bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind,
            }));
        };
        add(bytemuck::cast_slice(&positions), 5126, "VEC3", positions.len());
        add(bytemuck::cast_slice(normals), 5126, "VEC3", normals.len());
        add(bytemuck::cast_slice(indices), 5125, "SCALAR", indices.len());
        let attributes = json!({ "POSITION": first, "NORMAL": first + 1 });
        meshes.push(json!({ "primitives": [
            { "attributes": attributes, "indices": first + 2, "material": material },
        ] }));
    }
    let materials = scene.materials.iter().map(|material| {
        json!({
            "pbrMetallicRoughness": {
                "baseColorFactor": material.base_color,
                "metallicFactor": material.metallic,
                "roughnessFactor": material.roughness,
            },
            "extensions": { "KHR_materials_specular": {
                "specularFactor": material.dielectric / 0.04,
            } },
        })
    });
    let looking = |position: [f32; 3], forward: [f32; 3], up: DVec3| {
        let back = -wide(forward).normalize();
        let right = up.cross(back).normalize();
        let [x, y, z] = [right, back.cross(right), back];
        let at = other(wide(position));
        let columns = [x.extend(0.0), y.extend(0.0), z.extend(0.0), at.extend(1.0)];
        json!(columns.map(|column| column.to_array()).concat())
    };
    let mut nodes: Vec<Value> = (0..meshes.len()).map(|mesh| json!({ "mesh": mesh })).collect();
    let (camera, light) = (&scene.camera, &scene.lights[0]);
    nodes.push(json!({
        "camera": 0, "matrix": looking(camera.position, camera.forward, wide(camera.up)),
    }));
    nodes.push(json!({
        "matrix": looking(light.position, light.direction, DVec3::Z + 0.1),
        "extensions": { "KHR_lights_punctual": { "light": 0 } },
    }));
    let light = match light.kind {
        LightKind::Spot { inner, outer } => json!({
            "type": "spot", "color": light.intensity, "intensity": 1.0,
            "spot": { "innerConeAngle": inner, "outerConeAngle": outer },
        }),
        LightKind::Directional => json!({ "type": "directional", "color": light.intensity }),
        LightKind::Point => json!({ "type": "point", "color": light.intensity }),
    };
    let document = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_specular"],
        "extensions": { "KHR_lights_punctual": { "lights": [light] } },
        "cameras": [{ "type": "perspective", "perspective": {
            "yfov": camera.vertical_fov, "znear": 0.01,
        } }],
        "scene": 0,
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials.collect::<Vec<_>>(),
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": bytes.len(), "uri": "room.bin" }],
    });
    std::fs::write(folder.join("room.bin"), bytes).unwrap();
    let path = folder.join("room.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    path.to_string_lossy().into_owned()
}

/// The scene as it is loaded from a file that has it `by` away, and the one to compare it with, from a file at the origin:
/// its vertices are those of the first file, moved back in 64 bits.
fn far_and_near(scene: &Scene, by: DVec3, options: &Options) -> [Scene; 2] {
    let folder = tempfile::tempdir().unwrap();
    let far = write(folder.path(), scene, |p| p + by, |p| p + by);
    let far = Scene::load_with(&far, options).unwrap();
    let rounded = |p: DVec3| (p + by).as_vec3().as_dvec3() - by;
    let near = write(folder.path(), scene, rounded, |p| p);
    [far, Scene::load(&near).unwrap()]
}

/// What the pictures of two scenes differ by.
#[derive(Debug)]
struct Difference {
    /// Of the mean of the indirect light, over that of the second.
    indirect: f64,
    /// Of the mean radiance, over that of the second.
    all: f64,
    /// The share of pixels that differ by more than a thousandth of the mean.
    pixels: f64,
}

fn frame(scene: &Scene, settings: &Settings) -> Frame {
    let renderer = Renderer::new(gpu(), whole_space(), scene, settings, 0).unwrap();
    renderer.render().unwrap();
    renderer.read().unwrap()
}

fn difference(scenes: &[Scene; 2], settings: &Settings) -> Difference {
    let frames = scenes.each_ref().map(|scene| frame(scene, settings));
    let mean = |pixels: &[[f32; 4]]| {
        let sum =
            pixels.iter().flat_map(|pixel| &pixel[..3]).map(|&one| f64::from(one)).sum::<f64>();
        sum / (3 * pixels.len()) as f64
    };
    let indirect = frames.each_ref().map(|frame| {
        let layers = [&frame.indirect_diffuse, &frame.indirect_specular];
        layers.into_iter().flatten().map(|layer| mean(layer)).sum::<f64>()
    });
    let all = frames.each_ref().map(|frame| mean(&frame.radiance));
    let unlike = frames[0].radiance.iter().zip(&frames[1].radiance).filter(|(far, near)| {
        far.iter().zip(*near).any(|(far, near)| f64::from((far - near).abs()) > 1e-3 * all[1])
    });
    Difference {
        indirect: indirect[0] / indirect[1] - 1.0,
        all: all[0] / all[1] - 1.0,
        pixels: unlike.count() as f64 / frames[0].radiance.len() as f64,
    }
}

fn settings(set: Set) -> Settings {
    let mut settings = Settings { size: SIZE, map: 64, lights: 64, ..Settings::default() };
    for (axis, value) in set {
        settings.set(axis, value).unwrap();
    }
    settings
}

/// How far a mean may be off: pixels' roundings are 1e-6 of them at most, and independent.
const ROUNDING: f64 = 2e-6;

/// Values of axes by their names.
type Set = &'static [(&'static str, &'static str)];

/// Configurations whose passes have positions of their own, and whether rounding alone may change their pictures: where
/// clusters are close by distance, texels at equal distances of two centres go to either.
const CONFIGURATIONS: [(Set, bool); 5] = [
    (&[], true),
    (&[("visibility", "shadow_map")], true),
    (&[("visibility", "imperfect"), ("precision", "f16")], true),
    (&[("space", "tree"), ("emitter", "disc"), ("visibility", "shadow_map")], true),
    (&[("space", "world"), ("emitter", "disc")], false),
];

/// The origins of the two scenes are other points, so that everything is rounded otherwise.
#[test]
fn pictures_far_from_the_origin_are_those_at_the_origin() {
    for kind in ["spot", "directional", "point"] {
        let scene = lit_by(kind);
        for distance in [1e5, 1e6] {
            let by = DVec3::new(distance, 0.0, -distance);
            let scenes = far_and_near(&scene, by, &Options::default());
            assert_ne!(scenes[0].origin, by.to_array(), "the origin is to be another");
            for (set, exactly) in CONFIGURATIONS {
                let found = difference(&scenes, &settings(set));
                println!("{kind} at {distance:e}, {set:?}: {found:?}");
                let Difference { indirect, all, pixels } = found;
                let bound = if exactly { ROUNDING } else { 2e-2 };
                assert!(indirect.abs() <= bound && all.abs() <= bound, "{kind}: {indirect} {all}");
                assert!(pixels == 0.0 || !exactly, "{kind}, {set:?}: {pixels}");
            }
        }
    }
}

/// An engine's own origin: where it is that which the scene was moved by, every bit is the same.
#[test]
fn an_origin_that_is_given_is_the_one_that_is_used() {
    let by = DVec3::new(1e6, 0.0, -1e6);
    for kind in ["spot", "directional", "point"] {
        let options = Options { origin: Some(by.to_array()), ..Options::default() };
        let scenes = far_and_near(&lit_by(kind), by, &options);
        for (set, _) in CONFIGURATIONS {
            let [far, near] = scenes.each_ref().map(|scene| frame(scene, &settings(set)).radiance);
            assert!(far == near, "{kind}, {set:?}");
        }
    }
}

/// Negative control: positions relative to the world's origin.
#[test]
fn pictures_about_the_worlds_origin_are_others() {
    let by = DVec3::new(1e6, 0.0, -1e6);
    let options = Options { origin: Some([0.0; 3]), ..Options::default() };
    let scenes = far_and_near(&lit_by("spot"), by, &options);
    let found = difference(&scenes, &settings(&[("visibility", "shadow_map")]));
    println!("{found:?}");
    assert!(found.indirect.abs() > 1e3 * ROUNDING && found.pixels > 0.2, "{found:?}");
}

/// Lights that an engine gives with its own origin, far from the world's and near: only the difference from its origin counts.
#[test]
fn lights_of_an_engine_are_relative_to_its_origin() {
    let position = DVec3::new(0.3, 2.5, -0.2);
    let views = |away: DVec3| {
        let shown = |origin: DVec3| {
            let around = Surroundings { origin, center: away, radius: 2.0, map: 64 };
            let down = glam::Vec3::new(0.6, -0.8, 0.0);
            let lights = [
                LightView::spot(&around, position + away, down, [0.3, 0.7], [1.0; 3]),
                LightView::directional(&around, down, [1.0; 3]),
                LightView::point(&around, position + away, [1.0; 3]),
            ];
            format!("{lights:?}")
        };
        [shown(away), shown(DVec3::ZERO)]
    };
    let [near, _] = views(DVec3::ZERO);
    let [far, control] = views(DVec3::new(3.0e6, 0.0, -1.0e6));
    assert_eq!(far, near);
    assert_ne!(control, near, "without the origin");
}

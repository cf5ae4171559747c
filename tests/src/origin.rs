//! Scenes far from the world's origin: the picture is that of the scene at the origin, its vertices rounded as the file
//! far away has them.

use std::path::Path;

use glam::DVec3;
use serde_json::{Value, json};
use sglow_renderer::frame::Renderer;
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

/// Writes a scene as glTF, its vertices where `vertex` says, rounded to 32 bits, its camera and its light where `other`
/// says, in 64.
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

fn difference(scenes: &[Scene; 2], settings: &Settings) -> Difference {
    let frames = scenes.each_ref().map(|scene| {
        let renderer = Renderer::new(gpu(), whole_space(), scene, settings, 0).unwrap();
        renderer.render().unwrap();
        renderer.read().unwrap()
    });
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

fn settings(set: &[(&str, &str)]) -> Settings {
    let mut settings = Settings { size: SIZE, map: 64, lights: 64, ..Settings::default() };
    for (axis, value) in set {
        settings.set(axis, value).unwrap();
    }
    settings
}

#[test]
fn pictures_far_away_are_those_of_the_origin() {
    let configurations: [&[(&str, &str)]; 5] = [
        &[],
        &[("visibility", "shadow_map")],
        &[("visibility", "imperfect"), ("precision", "f16")],
        &[("space", "world"), ("emitter", "disc")],
        &[("space", "tree"), ("emitter", "disc"), ("visibility", "shadow_map")],
    ];
    for kind in ["spot", "directional", "point"] {
        let scene = lit_by(kind);
        for distance in [1e3, 1e4, 1e5, 1e6] {
            let by = DVec3::new(distance, 0.0, -distance);
            let scenes = far_and_near(&scene, by, &Options::default());
            for set in configurations {
                let found = difference(&scenes, &settings(set));
                println!("{kind} at {distance:e}, {set:?}: {found:?}");
            }
        }
    }
}

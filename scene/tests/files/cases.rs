//! Small files of each kind that once went wrong, with what is right for each.

use crate::common::{case, said, triangles};
use sglow_scene::{Material, Mesh, Scene, UvTransform, Wrap};

fn load(name: &str) -> Scene {
    Scene::from_file(&case(name)).unwrap_or_else(|fault| panic!("{fault}"))
}

fn material<'a>(scene: &'a Scene, name: &str) -> &'a Material {
    scene.materials.iter().find(|material| material.name == name).unwrap()
}

/// The one material that the cases of glTF differ in.
fn last(scene: &Scene) -> &Material {
    scene.materials.last().unwrap()
}

#[test]
fn encodings_continuation_and_libraries_change_no_picture() {
    let base = load("obj/obj_base.obj");
    assert_eq!(base.triangle_count(), 8);
    for same in [
        "obj/obj_bom_silent.obj",
        "obj/obj_latin1_comment.obj",
        "obj/obj_continuation.obj",
        "obj/obj_two_mtllib_one_line.obj",
    ] {
        let scene = load(same);
        assert_eq!(triangles(&scene), triangles(&base), "{same}");
        assert_eq!(scene.materials, base.materials, "{same}");
        assert_eq!(scene.notes, base.notes, "{same}");
    }
    // Negative control.
    assert_ne!(triangles(&load("obj/obj_concave.obj")), triangles(&base));
}

#[test]
fn a_polygon_keeps_its_notch() {
    let scene = load("obj/obj_concave.obj");
    let mut area = 0.0;
    for triangle in scene.triangles().filter(|one| one.positions.iter().all(|p| p[2] == 0.0)) {
        let [a, b, c] = triangle.positions.map(glam::Vec3::from);
        let own = (b - a).cross(c - a);
        assert!(own.z > 0.0, "{triangle:?} is turned over");
        area += own.z / 2.0;
        let middle = (a + b + c) / 3.0;
        assert!(!(middle.x.abs() < 0.6 && middle.y > 0.6), "{triangle:?} fills the notch");
    }
    assert!((area - (2.0 * 2.2 - 1.2 * 1.8)).abs() < 1e-5, "{area}");
}

#[test]
fn texture_coordinates_may_have_one_number() {
    let scene = load("obj/obj_vt_one.obj");
    assert_eq!(scene.triangle_count(), 9);
    let mut found: Vec<_> = scene.meshes.iter().flat_map(|mesh: &Mesh| &mesh.uvs).collect();
    found.retain(|uv| uv[0] != 0.0);
    // v is 0, at the lower edge of the image.
    assert_eq!(found, [&[0.5, 1.0], &[0.6, 1.0], &[1.0, 1.0]]);
}

#[test]
fn mtl_is_read_as_files_have_it() {
    let one = load("obj/mtl_Kd_one.obj");
    assert_eq!(material(&one, "tex").base_color, [0.5, 0.5, 0.5, 1.0]);

    let halo = load("obj/mtl_d_halo.obj");
    assert_eq!(material(&halo, "tex").base_color, [0.2, 0.4, 0.9, 1.0]);
    assert_eq!(material(&halo, "white").base_color, [0.7, 0.7, 0.7, 1.0]);
    assert!(said(&halo, "mtl_d_halo.mtl:9:3: `-halo` is not read"), "{:?}", halo.notes);

    let scaled = load("obj/mtl_map_scale.obj");
    let texture = material(&scaled, "tex").base_color_texture.unwrap();
    assert_eq!(texture.wrap, [Wrap::Repeat; 2]);
    assert_eq!(
        texture.transform,
        UvTransform { offset: [0.0, -1.0], rotation: 0.0, scale: [2.0; 2] }
    );
    assert_eq!(scaled.images[texture.image].name, "quad.png");

    let physical = load("obj/mtl_pbr.obj");
    let metal = material(&physical, "tex");
    assert_eq!((metal.roughness, metal.metallic, metal.dielectric), (0.2, 1.0, 0.04));
    let surface = &physical.images[metal.metallic_roughness_texture.unwrap().image];
    assert!(!surface.srgb);
    // Roughness is the map's, metallic is not.
    assert!(surface.rgba8.as_chunks::<4>().0.iter().all(|texel| texel[2] == 255));
    assert!(surface.rgba8.as_chunks::<4>().0.iter().any(|texel| texel[1] != 255));

    let glowing = load("obj/mtl_Ke_map.obj");
    let lamp = material(&glowing, "tex");
    assert_eq!(lamp.emission, [1.0, 0.0, 0.0]);
    assert_eq!(glowing.images[lamp.emission_texture.unwrap().image].name, "quad.png");
}

#[test]
fn specular_glossiness_maps_are_read() {
    let mapped = load("gltf/specgloss_map.gltf");
    let (found, images) = (last(&mapped), &mapped.images);
    let texel = |texture: Option<sglow_scene::TextureUse>, at: usize| {
        let image = &images[texture.unwrap().image];
        image.rgba8[4 * at..4 * at + 4].to_vec()
    };
    let factors = load("gltf/specgloss_factors.gltf");
    let same = last(&factors);
    // The map's specular colour is a dark grey, as the other file's factor is, and its alpha is the factor's glossiness.
    assert!(found.dielectric < 0.05 && found.dielectric > 0.0, "{found:?}");
    let surface = texel(found.metallic_roughness_texture, 0);
    assert_eq!(surface[2], 0, "not metallic");
    assert!((f32::from(surface[1]) / 255.0 - same.roughness).abs() < 0.01, "{surface:?}");
    // The diffuse colour is what it was, less what is reflected.
    let [ours, theirs] = [texel(found.base_color_texture, 77), {
        let image = &factors.images[same.base_color_texture.unwrap().image];
        image.rgba8[4 * 77..4 * 77 + 4].to_vec()
    }];
    for (ours, theirs) in ours.iter().zip(&theirs) {
        assert!(ours.abs_diff(*theirs) <= 6, "{ours} {theirs}");
    }
}

#[test]
fn a_second_set_of_texture_coordinates_is_read() {
    let scene = load("gltf/uv1_emissive.gltf");
    let glowing = last(&scene);
    let base = glowing.base_color_texture.unwrap();
    let emission = glowing.emission_texture.unwrap();
    assert_eq!(glowing.emission, [1.0; 3]);
    assert_eq!(base.transform, UvTransform::default());
    let mesh = scene.meshes.last().unwrap();
    // Where the file's second coordinates lead, by its accessor.
    let rows = emission.transform.rows();
    let at: Vec<_> =
        mesh.uvs.iter().map(|[u, v]| rows.map(|[a, b, c]| a * u + b * v + c)).collect();
    let file: serde_json::Value =
        serde_json::from_slice(&std::fs::read(case("gltf/uv1_emissive.gltf")).unwrap()).unwrap();
    let expected = second_coordinates(&file);
    assert_eq!(at.len(), expected.len());
    for (found, expected) in at.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() < 1e-5, "{at:?} {expected:?}");
    }
    let none = load("gltf/uv1_none.gltf");
    assert_eq!(last(&none).emission, [0.0; 3]);
}

/// What accessor 20 of the case holds, read here on its own.
fn second_coordinates(file: &serde_json::Value) -> Vec<[f32; 2]> {
    use base64::Engine;
    let number = |value: &serde_json::Value| value.as_u64().unwrap_or(0) as usize;
    let accessor = &file["accessors"][20];
    let view = &file["bufferViews"][number(&accessor["bufferView"])];
    let uri = file["buffers"][number(&view["buffer"])]["uri"].as_str().unwrap();
    let (_, payload) = uri.split_once(',').unwrap();
    let bytes = base64::engine::general_purpose::STANDARD.decode(payload).unwrap();
    let first = number(&view["byteOffset"]) + number(&accessor["byteOffset"]);
    let floats = bytes[first..].as_chunks::<4>().0.iter().map(|four| f32::from_le_bytes(*four));
    let floats: Vec<_> = floats.take(2 * number(&accessor["count"])).collect();
    floats.as_chunks::<2>().0.to_vec()
}

#[test]
fn copies_of_a_mesh_are_all_there() {
    let scene = load("gltf/gpu_instancing.gltf");
    assert_eq!(scene.triangle_count(), 8 + 3 * 2);
    let mesh = scene.meshes.last().unwrap();
    let mut middles: Vec<_> = mesh
        .positions
        .as_chunks::<4>()
        .0
        .iter()
        .map(|quad| quad.iter().map(|p| p[0]).sum::<f32>() / 4.0)
        .collect();
    middles.sort_by(f32::total_cmp);
    for (found, expected) in middles.iter().zip([-1.0, 0.0, 1.0]) {
        assert!((found - expected).abs() < 1e-6, "{middles:?}");
    }
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
}

#[test]
fn one_object_does_not_refuse_a_file() {
    let base = load("gltf/meta_base.gltf");
    let dark = load("gltf/light_zero_beside.gltf");
    assert_eq!((triangles(&dark), dark.lights.clone()), (triangles(&base), base.lights.clone()));
    assert!(said(&dark, "light without power: it lights nothing (light 1)"));

    // A buffer that nothing on the picture needs, and a byte order mark.
    let folder = crate::common::Folder::new();
    let text = std::fs::read_to_string(case("gltf/meta_base.gltf")).unwrap();
    let mut document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let add = |document: &mut serde_json::Value, list: &str, element: serde_json::Value| {
        document[list].as_array_mut().unwrap().push(element);
    };
    add(&mut document, "buffers", serde_json::json!({ "byteLength": 4, "uri": "gone.bin" }));
    add(&mut document, "bufferViews", serde_json::json!({ "buffer": 1, "byteLength": 4 }));
    let unused = folder.load("scene.gltf", format!("\u{feff}{document}")).unwrap();
    assert_eq!(triangles(&unused), triangles(&base));
    // Negative control: one that is needed is named.
    document["bufferViews"][0]["buffer"] = serde_json::json!(1);
    let fault = folder.load("scene.gltf", document.to_string()).unwrap_err().to_string();
    assert!(fault.contains("(POSITION): ") && fault.contains("gone.bin: no such file"), "{fault}");

    let webp = load("gltf/webp_only_not_required.gltf");
    // Its image is cut off.
    assert_eq!(webp.materials[0].base_color_texture, None);
    assert_eq!(webp.materials[0].base_color, [1.0; 4]);
    assert!(
        said(&webp, "the base colour is its factor everywhere (material 0)"),
        "{:?}",
        webp.notes
    );
}

#[test]
fn emission_beyond_halves_keeps_its_hue() {
    let scene = load("gltf/emissive_1e5.gltf");
    assert_eq!(last(&scene).emission, [65504.0, 32752.0, 16376.0]);
    assert!(said(
        &scene,
        "emission above 65504, the largest half, scaled to it (material 3: 100000)"
    ));
    // Of dim ones a note reports the rounding, or that they are not seen.
    let folder = crate::common::Folder::new();
    let text = std::fs::read_to_string(case("gltf/emissive_1e5.gltf")).unwrap();
    let document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let dim = |strength: f64| {
        let mut document = document.clone();
        let last = document["materials"].as_array_mut().unwrap().last_mut().unwrap();
        last["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] =
            serde_json::json!(strength);
        folder.load("scene.gltf", document.to_string()).unwrap()
    };
    assert!(said(&dim(1e-5), "emission below 6.1e-5, where halves are coarse"));
    assert!(said(&dim(1e-8), "emission below 6e-8, the smallest half: it is not seen"));
    for fine in [1e-4, 1.0, 6e4] {
        assert!(!said(&dim(fine), "emission"), "{fine}");
    }
}

#[test]
fn positions_far_from_the_origin_are_relative_to_one_near_the_scene() {
    let base = load("gltf/meta_base.gltf");
    assert_eq!(base.origin, [0.0; 3]);
    for (name, away) in [("gltf/offset_1000.gltf", 1e3), ("gltf/offset_10000.gltf", 1e4)] {
        let far = load(name);
        assert_eq!(far.origin, [away, 1.5, -away], "{name}");
        let origin = far.origin.map(|part| part as f32);
        let moved = [away as f32, 0.0, -away as f32];
        // Half a step of 32 bits there, and a step where it is 1.
        let rounding = away as f32 * f32::EPSILON;
        let same = |far: [f32; 3], near: [f32; 3]| {
            for axis in 0..3 {
                let found = far[axis] + (origin[axis] - moved[axis]);
                assert!((found - near[axis]).abs() <= rounding, "{name}: {far:?} {near:?}");
            }
        };
        for (far, near) in far.triangles().zip(base.triangles()) {
            far.positions.into_iter().zip(near.positions).for_each(|(far, near)| same(far, near));
        }
        same(far.camera.position, base.camera.position);
        same(far.lights[0].position, base.lights[0].position);
        let notes: Vec<_> = far.notes.iter().map(ToString::to_string).collect();
        let expected =
            format!("derived: positions are relative to ({away}, 1.5, -{away}), near the scene");
        assert_eq!(notes, [expected]);
    }
}

/// Vertices in 32 bits are rounded by more than a thousandth of the radius, which is noted; transforms of nodes are read in 64.
#[test]
fn rounding_in_a_file_is_noted() {
    let folder = crate::common::Folder::new();
    let file = case("gltf/offset_10000.gltf");
    let mut document: serde_json::Value =
        serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    let rounded = "which so far from its origin are rounded by more than a thousandth";
    assert!(!said(&folder.load("near.gltf", document.to_string()).unwrap(), rounded));
    // The same vertices ten times as near to each other, and as far away.
    for node in 0..5 {
        document["nodes"][node]["scale"] = serde_json::json!([0.1, 0.1, 0.1]);
    }
    assert!(!said(&folder.load("small.gltf", document.to_string()).unwrap(), rounded));
    let base = std::fs::read(case("gltf/meta_base.gltf")).unwrap();
    let mut document: serde_json::Value = serde_json::from_slice(&base).unwrap();
    for node in 0..5 {
        document["nodes"][node]["translation"] = serde_json::json!([1e7, 0.0, 0.0]);
    }
    let moved = folder.load("moved.gltf", document.to_string()).unwrap();
    assert!(!said(&moved, rounded), "{:?}", moved.notes);
    let near = load("gltf/meta_base.gltf");
    for (far, near) in moved.triangles().zip(near.triangles()) {
        let expected = near.positions.map(|[x, y, z]| [x, y - 1.5, z]);
        assert_eq!(far.positions, expected);
    }

    let quad = |away: f64| {
        let at = |x: f64, y: f64| format!("v {} {y} 0\n", away + x);
        format!("{}{}{}f 1 2 3\n", at(0.0, 0.0), at(0.1, 0.0), at(0.0, 0.1))
    };
    // Text has all its digits.
    let text = folder.load("quad.obj", quad(1e9)).unwrap();
    assert!(!said(&text, rounded), "{:?}", text.notes);
    let wide = text.bounds();
    assert!((wide.max[0] - wide.min[0] - 0.1).abs() < 1e-6, "{wide:?}");
}

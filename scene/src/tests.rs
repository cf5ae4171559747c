//! Files made here, each with one thing right or wrong.

use std::path::PathBuf;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::*;
use crate::load::EXTENSIONS;

/// A folder with the files of one test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, contents).unwrap();
        path
    }

    fn load(&self, name: &str, contents: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
        Scene::from_file(&self.write(name, contents))
    }
}

/// Loads a glTF document on its own.
fn load(document: &Value) -> Result<Scene, SceneError> {
    Folder::new().load("scene.gltf", document.to_string())
}

fn message(document: &Value) -> String {
    load(document).unwrap_err().to_string()
}

fn data_uri(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes))
}

fn bytes_of(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// One triangle facing +z, with a material, a spot light and a camera.
fn triangle_of(positions: [f32; 9]) -> Value {
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{
            "name": "lamp", "type": "spot", "color": [1.0, 0.5, 0.25], "intensity": 8.0,
            "spot": { "innerConeAngle": 0.25, "outerConeAngle": 0.5 },
        }] } },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [
            { "mesh": 0 },
            { "translation": [0.0, 0.0, 3.0], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "translation": [0.0, 0.0, 5.0], "camera": 0 },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.75, "znear": 0.1 } }],
        "meshes": [{ "name": "sail", "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "materials": [{ "name": "cloth" }],
        "accessors": [{
            "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 0.0],
        }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36, "uri": data_uri(&bytes_of(&positions)) }],
    })
}

fn triangle() -> Value {
    triangle_of([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0])
}

/// The binary container, all of it but the last `cut` bytes.
fn binary(document: &Value, buffer: &[u8], cut: usize) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = b"glTF\x02\0\0\0".to_vec();
    let number = |n: usize| (n as u32).to_le_bytes();
    file.extend(number(28 + json.len() + buffer.len()));
    file.extend(number(json.len()));
    file.extend(b"JSON");
    file.extend(json);
    file.extend(number(buffer.len()));
    file.extend(b"BIN\0");
    file.extend(buffer);
    file.truncate(file.len() - cut);
    file
}

fn push(list: &mut Value, element: Value) {
    list.as_array_mut().unwrap().push(element);
}

/// A PNG of one texel.
fn png(texel: [u8; 4]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_pixel(1, 1, image::Rgba(texel));
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// The triangle with texture coordinates and an image of one texel.
fn textured() -> Value {
    let mut document = triangle();
    let mut bytes = bytes_of(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    bytes.extend(bytes_of(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]));
    document["buffers"][0] = json!({ "byteLength": 60, "uri": data_uri(&bytes) });
    push(&mut document["bufferViews"], json!({ "buffer": 0, "byteOffset": 36, "byteLength": 24 }));
    push(
        &mut document["accessors"],
        json!({ "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2" }),
    );
    document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(1);
    document["images"] = json!([{ "uri": "texel.png" }]);
    document["textures"] = json!([{ "source": 0 }]);
    document["materials"][0]["pbrMetallicRoughness"] =
        json!({ "baseColorTexture": { "index": 0 } });
    document
}

#[test]
fn a_whole_file_arrives_whole() {
    let scene = load(&triangle()).unwrap();
    assert_eq!(scene.name, "scene");
    assert_eq!(scene.triangle_count(), 1);
    let only = scene.triangles().next().unwrap();
    assert_eq!(only.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(scene.meshes[0].normals, [[0.0, 0.0, 1.0]; 3]);
    assert_eq!(scene.lights[0].intensity, [8.0, 4.0, 2.0]);
    assert_eq!(scene.lights[0].kind, LightKind::Spot { inner: 0.25, outer: 0.5 });
    assert_eq!(scene.lights[0].direction, [0.0, 0.0, -1.0]);
    assert_eq!(scene.camera.position, [0.0, 0.0, 5.0]);
    assert_eq!(scene.camera.vertical_fov, 0.75);
    let [material] = &scene.materials[..] else { panic!() };
    assert_eq!((material.metallic, material.roughness, material.dielectric), (1.0, 1.0, 0.04));
    let notes: Vec<_> = scene.notes.iter().map(ToString::to_string).collect();
    assert_eq!(notes, ["derived: no normals: flat ones made (sail)"]);
}

#[test]
fn nodes_transform_meshes_and_their_normals() {
    let mut document = triangle();
    // Mirrored in z: the triangle must still face away from its mirrored back.
    document["nodes"][0] = json!({ "children": [3], "translation": [10.0, 0.0, 0.0] });
    push(&mut document["nodes"], json!({ "mesh": 0, "scale": [2.0, 1.0, -1.0] }));
    let scene = load(&document).unwrap();
    assert_eq!(scene.bounds(), Bounds { min: [10.0, 0.0, 0.0], max: [12.0, 1.0, 0.0] });
    assert_eq!(scene.meshes[0].normals, [[0.0, 0.0, -1.0]; 3]);

    document["nodes"][3]["children"] = json!([0]);
    assert!(message(&document).contains("nodes[0]: is reached twice"));
}

#[test]
fn the_binary_container_is_read_and_its_faults_are_named() {
    let mut document = triangle();
    let buffer = bytes_of(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    document["buffers"][0] = json!({ "byteLength": 36 });
    let folder = Folder::new();
    let whole = binary(&document, &buffer, 0);
    assert_eq!(folder.load("whole.glb", &whole).unwrap().triangle_count(), 1);
    for length in 1..whole.len() {
        let fault = folder.load("cut.glb", &whole[..length]).unwrap_err();
        let magic = length < 4;
        assert!(magic || matches!(fault, SceneError::Truncated { .. }), "{length}: {fault}");
    }
    let mut other = whole.clone();
    other[4] = 1;
    let fault = folder.load("old.glb", &other).unwrap_err().to_string();
    assert!(
        fault.ends_with("old.glb: glTF version 1 is not supported; supported is 2.0"),
        "{fault}"
    );
    document["buffers"][0]["byteLength"] = json!(40);
    let fault = folder.load("short.glb", binary(&document, &buffer, 0)).unwrap_err().to_string();
    assert!(fault.contains("truncated: buffer 0 announces 40 bytes, found 36"), "{fault}");
}

#[test]
fn versions_and_required_extensions_are_checked() {
    let mut document = triangle();
    document["asset"]["version"] = json!("3.0");
    assert!(message(&document).contains("glTF version 3.0 is not supported"));
    document["asset"]["version"] = json!("2.1");
    assert!(load(&document).is_ok());
    document["asset"]["minVersion"] = json!("2.1");
    assert!(message(&document).contains("glTF version 2.1"));

    let mut document = triangle();
    document["extensionsUsed"] = json!(["KHR_lights_punctual", "ACME_glow"]);
    let notes = load(&document).unwrap().notes;
    assert!(notes.iter().any(|note| note.to_string() == "ignored: extension (ACME_glow)"));
    document["extensionsRequired"] = json!(["ACME_glow"]);
    let fault = message(&document);
    assert!(fault.contains("required extension ACME_glow is not supported"), "{fault}");
    assert!(fault.contains("KHR_lights_punctual"), "{fault}");
}

#[test]
fn structural_faults_come_all_at_once() {
    let mut document = triangle();
    document["meshes"][0]["primitives"][0]["material"] = json!(7);
    document["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = json!(3);
    let fault = message(&document);
    assert_eq!(fault.lines().count(), 2, "{fault}");
    assert!(
        fault.contains("meshes[0].primitives[0].material: the index is out of range"),
        "{fault}"
    );
    document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9);
    assert!(message(&document).contains("there is no accessor 9"));
    let fault = Folder::new().load("scene.gltf", "{\n \"asset\": 7 }").unwrap_err().to_string();
    assert!(fault.contains("scene.gltf:2:"), "{fault}");
}

#[test]
fn accessors_that_do_not_fit_are_named() {
    let mut document = triangle();
    document["accessors"][0]["count"] = json!(4);
    let fault = message(&document);
    assert!(fault.contains("sail: accessor 0 (POSITION): 4 elements of 12 bytes"), "{fault}");
    document["accessors"][0]["count"] = json!(u64::MAX / 8);
    assert!(message(&document).contains("the scene has 2305843009213693951 vertices, more than"));
    document["accessors"][0]["count"] = json!(1 << 20);
    assert!(message(&document).contains("do not fit"));
    document["accessors"][0]["count"] = json!((1 << 24) + 1);
    document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    document["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": 0, "componentType": 5121 },
        "values": { "bufferView": 0 },
    });
    assert!(message(&document).contains("elements without data"), "{}", message(&document));

    let mut document = triangle();
    push(&mut document["bufferViews"], json!({ "buffer": 1, "byteLength": 3 }));
    push(&mut document["buffers"], json!({ "byteLength": 3, "uri": data_uri(&[0, 1, 3]) }));
    push(
        &mut document["accessors"],
        json!({ "bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR" }),
    );
    document["meshes"][0]["primitives"][0]["indices"] = json!(1);
    assert!(message(&document).contains("accessor 1 (indices): vertex 3 is out of range"));
}

#[test]
fn positions_must_be_finite_and_triangles_must_be_there() {
    for broken in [f32::NAN, f32::INFINITY] {
        let fault = message(&triangle_of([0.0, 0.0, 0.0, 1.0, 0.0, broken, 0.0, 1.0, 0.0]));
        assert!(fault.contains("mesh `sail`: vertex 1 has the position"), "{fault}");
    }
    // All on a line.
    let flat = triangle_of([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    assert!(message(&flat).contains("the scene has no triangles"));
    let mut empty = triangle();
    empty["nodes"][0] = json!({});
    assert!(message(&empty).contains("the scene has no triangles"));
}

#[test]
fn vertices_that_a_file_rounds_are_noted() {
    let noted = |away: f32| {
        let scene =
            load(&triangle_of([away, 0.0, 0.0, away + 1.0, 0.0, 0.0, away, 1.0, 0.0])).unwrap();
        scene.notes.iter().any(|note| note.text.contains("rounded by more than a thousandth"))
    };
    // The radius is 0.71, steps at 16384 are 1/512, half of which is more than a thousandth of it.
    assert!(noted(1e6) && noted(16384.0) && !noted(16380.0) && !noted(0.0));
}

#[test]
fn lights_must_have_power_and_a_cone() {
    let mut document = triangle();
    let lights = &mut document["extensions"]["KHR_lights_punctual"]["lights"];
    lights[0]["intensity"] = json!(0.0);
    let fault = message(&document);
    assert!(fault.contains("light `lamp` has zero power"), "{fault}");
    let lights = &mut document["extensions"]["KHR_lights_punctual"]["lights"];
    lights[0] = json!({ "name": "lamp", "type": "point", "intensity": -1.0 });
    assert!(message(&document).contains("light `lamp`: its intensity [-1.0, -1.0, -1.0]"));
}

#[test]
fn sparse_and_quantised_accessors_are_read() {
    let mut document = triangle();
    // Bytes, normalised; the second element replaced by one twice as far.
    let mut bytes = vec![0, 0, 0, 0, 127, 0, 0, 0, 0, 127, 0, 0];
    bytes.extend([1, 0, 0, 0, 127, 127, 0, 0]);
    document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    document["buffers"][0] = json!({ "byteLength": 20, "uri": data_uri(&bytes) });
    document["bufferViews"] = json!([
        { "buffer": 0, "byteLength": 12, "byteStride": 4 },
        { "buffer": 0, "byteOffset": 12, "byteLength": 4 },
        { "buffer": 0, "byteOffset": 16, "byteLength": 4 },
    ]);
    let accessor = &mut document["accessors"][0];
    accessor["componentType"] = json!(5120);
    accessor["normalized"] = json!(true);
    accessor["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": 1, "componentType": 5121 },
        "values": { "bufferView": 2 },
    });
    let positions = load(&document).unwrap().triangles().next().unwrap().positions;
    assert_eq!(positions, [[0.0; 3], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
}

#[test]
fn compressed_views_are_read() {
    use meshopt_rs::vertex::VertexEncodingVersion;
    use meshopt_rs::vertex::buffer::{encode_vertex_buffer, encode_vertex_buffer_bound};
    let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut encoded = vec![0; encode_vertex_buffer_bound(3, 12)];
    let length = encode_vertex_buffer(&mut encoded, &positions, VertexEncodingVersion::default());
    encoded.truncate(length.unwrap());
    let mut document = triangle();
    document["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    document["buffers"] = json!([
        { "byteLength": 36, "extensions": { "EXT_meshopt_compression": { "fallback": true } } },
        { "byteLength": encoded.len(), "uri": data_uri(&encoded) },
    ]);
    document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = json!({
        "buffer": 1, "byteLength": encoded.len(), "byteStride": 12, "count": 3, "mode": "ATTRIBUTES",
    });
    assert_eq!(load(&document).unwrap().triangles().next().unwrap().positions, positions);

    let extension = &mut document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
    extension["count"] = json!(2);
    let fault = message(&document);
    assert!(fault.contains("decodes to 2 elements of 12 bytes, the view has 36 bytes"), "{fault}");
    document["bufferViews"][0].as_object_mut().unwrap().remove("extensions");
    let fault = message(&document);
    assert!(fault.contains("bufferViews[0]: ends at byte 36 of buffer 0, which has 0"), "{fault}");
}

#[test]
fn materials_keep_their_values() {
    let mut document = triangle();
    document["materials"][0] = json!({
        "name": "lamp shade",
        "pbrMetallicRoughness":
            { "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.0, "roughnessFactor": 0.5 },
        "emissiveFactor": [1.0, 0.5, 0.0],
        "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": 20.0 },
            "KHR_materials_ior": { "ior": 1.0 },
        },
    });
    let scene = load(&document).unwrap();
    let expected = Material {
        base_color: [0.1, 0.2, 0.3, 0.4],
        roughness: 0.5,
        emission: [20.0, 10.0, 0.0],
        alpha_cutoff: Some(0.25),
        double_sided: true,
        ..Material::diffuse("lamp shade", [0.0; 3])
    };
    assert_eq!(scene.materials, [expected]);
    let facts =
        |scene: &Scene, names: [&str; 3]| names.map(|name| scene.facts().holds(name).unwrap());
    // Its opacity of 0.4 is not below the cutoff.
    assert_eq!(facts(&scene, ["emissive", "cutout", "specular"]), [true, false, false]);
    let mut fainter = scene;
    fainter.materials[0].base_color[3] = 0.2;
    assert_eq!(facts(&fainter, ["emissive", "cutout", "specular"]), [true, true, false]);
}

#[test]
fn specular_glossiness_keeps_both_reflectances() {
    let material = |diffuse: [f32; 4], specular: [f32; 3]| {
        let mut document = triangle();
        document["materials"][0]["extensions"]["KHR_materials_pbrSpecularGlossiness"] = json!({
            "diffuseFactor": diffuse, "specularFactor": specular, "glossinessFactor": 0.75,
        });
        load(&document).unwrap().materials.remove(0)
    };
    // Grey: exact, with the diffuse part darkened by what is reflected.
    let grey = material([0.8, 0.4, 0.2, 1.0], [0.25; 3]);
    assert_eq!((grey.metallic, grey.dielectric, grey.roughness), (0.0, 0.25, 0.25));
    for (found, diffuse) in grey.base_color.iter().zip([0.8, 0.4, 0.2]) {
        assert!((found - 0.75 * diffuse).abs() < 1e-6);
    }
    // Coloured: the means of R_d and R_s are kept.
    let specular = [0.9, 0.6, 0.3];
    let gold = material([0.5, 0.5, 0.5, 1.0], specular);
    let mean = |color: &[f32]| color.iter().sum::<f32>() / 3.0;
    let base = mean(&gold.base_color[..3]);
    let diffuse = base * (1.0 - gold.metallic);
    let reflected = gold.dielectric * (1.0 - gold.metallic) + base * gold.metallic;
    assert!((diffuse - 0.05).abs() < 1e-4, "{gold:?}");
    assert!((reflected - mean(&specular)).abs() < 1e-4, "{gold:?}");
    // A mirror without a diffuse part is all metal.
    let metal = material([0.0, 0.0, 0.0, 1.0], [1.0, 0.8, 0.2]);
    assert_eq!((metal.metallic, metal.base_color), (1.0, [1.0, 0.8, 0.2, 1.0]));
}

#[test]
fn textures_and_their_transforms_are_read() {
    let folder = Folder::new();
    folder.write("texel.png", png([10, 20, 30, 40]));
    let mut document = textured();
    document["extensionsRequired"] = json!(["KHR_texture_transform"]);
    document["samplers"] =
        json!([{ "wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9985 }]);
    document["textures"][0]["sampler"] = json!(0);
    document["materials"][0]["pbrMetallicRoughness"] = json!({
        "baseColorTexture": { "index": 0, "extensions": { "KHR_texture_transform":
            { "offset": [0.5, 0.25], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2.0, 3.0] } } },
    });
    document["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
    let scene = folder.load("scene.gltf", document.to_string()).unwrap();
    let usage = scene.materials[0].base_color_texture.unwrap();
    assert_eq!(usage.wrap, [Wrap::Clamp, Wrap::Mirror]);
    assert_eq!(usage.magnify, Filter::Nearest);
    assert_eq!((usage.minify, usage.mip), (Filter::Linear, Some(Filter::Nearest)));
    let transform = UvTransform {
        offset: [0.5, 0.25],
        rotation: std::f32::consts::FRAC_PI_2,
        scale: [2.0, 3.0],
    };
    assert_eq!(usage.transform, transform);
    // A quarter turn takes +u to -v, as v points down.
    let rows = transform.rows();
    let apply = |u: f32, v: f32| rows.map(|[a, b, c]| a * u + b * v + c);
    for (found, expected) in [(apply(1.0, 0.0), [0.5, -1.75]), (apply(0.0, 1.0), [3.5, 0.25])] {
        assert!((found[0] - expected[0]).abs() < 1e-6, "{found:?}");
        assert!((found[1] - expected[1]).abs() < 1e-6, "{found:?}");
    }
    // One image, decoded once.
    assert_eq!(scene.materials[0].emission_texture.unwrap().image, usage.image);
    let [image] = &scene.images[..] else { panic!("{:?}", scene.images) };
    assert_eq!((image.width, image.height, image.srgb), (1, 1, true));
    assert_eq!(image.rgba8, [10, 20, 30, 40]);
    assert_eq!(scene.meshes[0].uvs, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    assert_eq!(scene.facts().holds("textured"), Some(true));
}

#[test]
fn images_that_are_missing_or_do_not_decode_are_named() {
    let folder = Folder::new();
    let mut document = textured();
    document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.5, 0.5, 0.5, 1]);
    document["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] =
        json!({ "index": 0 });
    document["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
    document["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
    let lost = |expected: &str| {
        let scene = folder.load("scene.gltf", document.to_string()).unwrap();
        // No factor stays at the 1 that the texture was to make less.
        let expected_material =
            Material { roughness: 1.0, dielectric: 0.04, ..Material::diffuse("cloth", [0.5; 3]) };
        assert_eq!(scene.materials, [expected_material]);
        for lacks in ["the base colour is its factor", "is not metallic", "emits nothing"] {
            let said = |note: &&Note| note.text.contains(expected) && note.text.contains(lacks);
            assert_eq!(scene.notes.iter().filter(said).count(), 1, "{:?}", scene.notes);
        }
    };
    lost("texel.png: no such file");
    let whole = png([1, 2, 3, 4]);
    folder.write("texel.png", &whole[..whole.len() / 2]);
    lost("image `texel.png`: ");
    folder.write("texel.png", "no image");
    lost("image `texel.png`: is not PNG, JPEG, WebP, BMP or TGA");
    // Negative control: one that decodes stays.
    folder.write("texel.png", whole);
    let scene = folder.load("scene.gltf", document.to_string()).unwrap();
    assert_eq!(scene.materials[0].textures().count(), 3);
    assert_eq!(scene.materials[0].metallic, 1.0);
}

const SIDECAR: &str = r#"
[camera]
position = [0.0, 0.0, 9.0]
target = [0.0, 0.0, 0.0]
vertical_fov_degrees = 30.0

[[light]]
kind = "directional"
direction = [0.0, -2.0, 0.0]
intensity = [1.0, 2.0, 3.0]
map_share = 0.5
"#;

#[test]
fn a_sidecar_replaces_camera_and_lights() {
    let folder = Folder::new();
    folder.write("scene.gltf.sglow.toml", SIDECAR);
    let scene = folder.load("scene.gltf", triangle().to_string()).unwrap();
    assert_eq!(scene.camera.position, [0.0, 0.0, 9.0]);
    assert_eq!(scene.camera.forward, [0.0, 0.0, -1.0]);
    let [light] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!((light.kind, light.direction), (LightKind::Directional, [0.0, -1.0, 0.0]));
    assert_eq!((light.intensity, light.map_share), ([1.0, 2.0, 3.0], 0.5));
    for share in ["0.0", "1.5", "nan"] {
        let wrong = SIDECAR.replace("map_share = 0.5", &format!("map_share = {share}"));
        folder.write("scene.gltf.sglow.toml", &wrong);
        let error = folder.load("scene.gltf", triangle().to_string()).unwrap_err().to_string();
        assert!(error.contains("`map_share`"), "{error}");
    }
}

#[test]
fn faults_of_a_sidecar_have_a_place() {
    let fault = |sidecar: &str| {
        let folder = Folder::new();
        folder.write("scene.gltf.sglow.toml", sidecar);
        let loaded = folder.load("scene.gltf", triangle().to_string());
        let fault = loaded.unwrap_err().to_string();
        fault.rsplit_once("scene.gltf.sglow.toml:").unwrap().1.to_owned()
    };
    let unknown = fault(&SIDECAR.replace("vertical_fov_degrees", "fov"));
    assert!(unknown.starts_with("5:1: unknown field `fov`, expected one of"), "{unknown}");
    assert!(unknown.contains("`vertical_fov_degrees`"), "{unknown}");
    let kind = fault(&SIDECAR.replace("directional", "sun"));
    assert!(kind.starts_with("8:8: unknown variant `sun`, expected one of `spot`"), "{kind}");
    let dark = fault(&SIDECAR.replace("[1.0, 2.0, 3.0]", "[0.0, 0.0, 0.0]"));
    assert!(dark.starts_with("7:1: light `light 0` has zero power"), "{dark}");
    let aimless = fault(&SIDECAR.replace("direction = [0.0, -2.0, 0.0]", ""));
    assert!(aimless.contains("a directional light needs `direction` or `target`"), "{aimless}");
    let wide = fault(&SIDECAR.replace("= 30.0", "= 180.0"));
    assert!(wide.starts_with("2:1: camera: its vertical angle of 180 degrees"), "{wide}");
}

#[test]
fn what_cannot_be_a_scene_is_refused() {
    let message = |name: &str| Scene::load(name).unwrap_err().to_string();
    assert!(message("missing.glb").contains("missing.glb: no such file"));
    assert!(message("scene.fbx").contains("unsupported file extension `fbx`; supported are glb"));
}

#[test]
fn camera_and_light_are_derived_where_there_are_none() {
    let mut document = triangle();
    document["nodes"][1] = json!({});
    document["nodes"][2] = json!({});
    let scene = load(&document).unwrap();
    let derived: Vec<_> = scene.notes.iter().filter(|n| n.kind == NoteKind::Derived).collect();
    assert_eq!(derived.len(), 3, "{derived:?}");
    let bounds = scene.bounds();
    let light = &scene.lights[0];
    let LightKind::Spot { outer, .. } = light.kind else { panic!() };
    let (near, far) = scene.camera.planes(&bounds);
    for corner in scene.triangles().next().unwrap().positions.map(glam::Vec3::from) {
        // The whole scene is lit and in the picture.
        let towards = (corner - glam::Vec3::from(light.position)).normalize();
        assert!(towards.dot(glam::Vec3::from(light.direction)) > outer.cos());
        let view = corner - glam::Vec3::from(scene.camera.position);
        let depth = view.dot(glam::Vec3::from(scene.camera.forward));
        assert!(depth / view.length() > (scene.camera.vertical_fov * 0.5).cos());
        assert!(near < depth && depth < far);
    }
}

#[test]
fn scenes_of_the_user_load() {
    let Ok(folder) = std::env::var("SGLOW_SCENES") else {
        println!("skipped: SGLOW_SCENES is not set to a folder with scenes");
        return;
    };
    let mut loaded = 0;
    for folder in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        for file in std::fs::read_dir(&folder).into_iter().flatten() {
            let file = file.unwrap().path();
            let extension = file.extension().and_then(|e| e.to_str()).unwrap_or_default();
            if EXTENSIONS.contains(&extension) {
                let scene = Scene::from_file(&file).unwrap_or_else(|fault| panic!("{fault}"));
                assert!(scene.triangle_count() > 0 && !scene.lights.is_empty());
                loaded += 1;
            }
        }
    }
    assert!(loaded > 0, "SGLOW_SCENES holds no scenes");
}

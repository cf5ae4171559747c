//! What few surfaces of glTF have: colours of vertices, normal maps, tangents, two sets of texture coordinates.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use sglow_scene::Scene;

use crate::common::{Folder, said};

/// A triangle that faces +z with two sets of texture coordinates, tangents along y, colours, and images for all.
fn document() -> Value {
    let lists: [(&str, &[f32]); 5] = [
        ("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        ("VEC2", &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]),
        ("VEC2", &[0.5, 0.1, 0.2, 0.3, 0.9, 0.7]),
        ("VEC4", &[0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0, -1.0]),
        ("VEC4", &[1.0, 0.5, 0.0, 1.0, 0.0, 1.0, 0.0, 0.25, 0.0, 0.0, 1.5, 1.0]),
    ];
    let mut bytes = Vec::new();
    let (mut views, mut accessors) = (Vec::new(), Vec::new());
    for (kind, list) in lists {
        views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": 4 * list.len() }));
        bytes.extend(list.iter().flat_map(|number| number.to_le_bytes()));
        accessors.push(json!({
            "bufferView": views.len() - 1, "componentType": 5126, "count": 3, "type": kind,
        }));
    }
    // Normals that face +z, as bytes.
    views
        .push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": 12, "byteStride": 4 }));
    bytes.extend([0, 0, 127, 0].repeat(3));
    accessors.push(json!({
        "bufferView": views.len() - 1, "componentType": 5120, "count": 3, "type": "VEC3",
        "normalized": true,
    }));
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_mesh_quantization", "KHR_texture_transform"],
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "material": 0, "attributes": {
            "POSITION": 0, "NORMAL": 5, "TEXCOORD_0": 1, "TEXCOORD_1": 2, "TANGENT": 3, "COLOR_0": 4,
        } }] }],
        "materials": [{
            "alphaMode": "MASK",
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
            "normalTexture": {
                "index": 0, "texCoord": 1, "scale": 0.5,
                "extensions": { "KHR_texture_transform": { "offset": [0.25, 0.5], "scale": [2.0, 3.0] } },
            },
        }],
        "textures": [{ "source": 0 }],
        "images": [{ "uri": "texel.png" }],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": bytes.len(), "uri": uri }],
    })
}

fn load(document: &Value) -> Scene {
    let folder = Folder::new();
    let mut png = std::io::Cursor::new(Vec::new());
    let texel = image::RgbaImage::from_pixel(1, 1, image::Rgba([128, 128, 255, 255]));
    texel.write_to(&mut png, image::ImageFormat::Png).unwrap();
    folder.write("texel.png", png.into_inner());
    folder.load("scene.gltf", document.to_string()).unwrap()
}

fn fact(scene: &Scene, name: &str) -> bool {
    scene.facts().holds(name).unwrap()
}

#[test]
fn everything_that_few_surfaces_have_is_read() {
    let scene = load(&document());
    let mesh = &scene.meshes[0];
    let material = &scene.materials[mesh.material];
    assert_eq!(mesh.uvs, [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
    assert_eq!(mesh.detail.uvs, [[0.5, 0.1], [0.2, 0.3], [0.9, 0.7]]);
    assert_eq!(mesh.detail.tangents, [[0.0, 1.0, 0.0, -1.0]; 3]);
    let colors = [[1.0, 0.5, 0.0, 1.0], [0.0, 1.0, 0.0, 0.25], [0.0, 0.0, 1.0, 1.0]];
    assert_eq!(mesh.detail.colors, colors);
    assert!(said(&scene, "vertex colours clamped to their range"));
    let map = material.normal_texture.unwrap();
    assert!(map.second && !material.base_color_texture.unwrap().second);
    assert_eq!((map.transform.offset, map.transform.scale), ([0.25, 0.5], [2.0, 3.0]));
    assert_eq!(material.normal_scale, 0.5);
    // One image, read in two ways.
    let srgb: Vec<_> = scene.images.iter().map(|image| image.srgb).collect();
    assert_eq!(srgb, [true, false]);
    // By the opacity of one vertex.
    assert!(fact(&scene, "detailed") && fact(&scene, "cutout"));
}

#[test]
fn tangents_are_made_where_the_file_has_none_and_turn_with_their_mesh() {
    let mut document = document();
    let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
    attributes.as_object_mut().unwrap().remove("TANGENT");
    // Of the first set, whose u is x.
    document["materials"][0]["normalTexture"] = json!({ "index": 0 });
    assert_eq!(load(&document).meshes[0].detail.tangents, [[1.0, 0.0, 0.0, 1.0]; 3]);
    let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
    attributes["TANGENT"] = json!(3);
    // Mirrored along y, and turned from z to x: what was up is down, and the bitangent's sign is another.
    document["nodes"][0]["matrix"] = json!([0, 0, -1, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1]);
    let turned = load(&document);
    assert_eq!(turned.meshes[0].detail.tangents, [[0.0, -1.0, 0.0, 1.0]; 3]);
    assert_eq!(turned.meshes[0].normals, [[1.0, 0.0, 0.0]; 3]);
    // Flat normals are made where there are none, and the file's tangents are not theirs.
    let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
    attributes.as_object_mut().unwrap().remove("NORMAL");
    document["nodes"][0].as_object_mut().unwrap().remove("matrix");
    assert_eq!(load(&document).meshes[0].detail.tangents, [[1.0, 0.0, 0.0, 1.0]; 3]);
}

#[test]
fn what_is_not_there_costs_nothing() {
    let mut document = document();
    document["materials"][0].as_object_mut().unwrap().remove("normalTexture");
    document["materials"][0]["alphaMode"] = json!("OPAQUE");
    let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
    attributes.as_object_mut().unwrap().remove("COLOR_0");
    let scene = load(&document);
    assert_eq!(scene.meshes[0].detail, sglow_scene::Detail::default());
    assert!(!fact(&scene, "detailed") && !fact(&scene, "cutout"));

    // A second set is one of any number; a third one has no place.
    document["materials"][0]["normalTexture"] = json!({ "index": 0, "texCoord": 1 });
    document["materials"][0]["emissiveTexture"] = json!({ "index": 0, "texCoord": 7 });
    document["materials"][0]["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
    document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_7"] = json!(6);
    document["bufferViews"][4]["byteStride"] = json!(16);
    // Red and green of the colours.
    document["accessors"].as_array_mut().unwrap().push(json!({
        "bufferView": 4, "componentType": 5126, "count": 3, "type": "VEC2",
    }));
    let scene = load(&document);
    let mesh = &scene.meshes[0];
    let material = &scene.materials[mesh.material];
    assert_eq!(mesh.detail.uvs, [[1.0, 0.5], [0.0, 1.0], [0.0, 0.0]]);
    assert!(material.emission_texture.unwrap().second && material.normal_texture.is_none());
    let lacks = "texture at a third set of texture coordinates; the surface is shaded smooth";
    assert!(said(&scene, lacks), "{:?}", scene.notes);
}

#[test]
fn a_texture_without_an_image_costs_that_texture_alone() {
    let with = |textures: Value| {
        let mut document = document();
        document["textures"] = textures;
        load(&document)
    };
    for (textures, reason) in [
        (json!([{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }]), "texture 0 is KTX2"),
        (json!([{}]), "texture 0 has no image"),
    ] {
        let scene = with(textures);
        let material = &scene.materials[scene.meshes[0].material];
        assert!(material.textures().next().is_none());
        assert!(said(&scene, reason), "{:?}", scene.notes);
        for lacks in ["the base colour is its factor everywhere", "the surface is shaded smooth"] {
            assert!(said(&scene, lacks), "{:?}", scene.notes);
        }
    }
    // The other format is an alternative; what is not used may be anything.
    let both = json!([
        { "source": 0, "extensions": { "KHR_texture_basisu": { "source": 0 } } }, {}, { "source": 1 },
    ]);
    let mut document = document();
    document["textures"] = both;
    document["images"].as_array_mut().unwrap().push(json!({ "uri": "gone.png" }));
    let scene = load(&document);
    assert!(scene.materials[0].base_color_texture.is_some());
    assert!(!said(&scene, "gone.png") && !said(&scene, "no image"), "{:?}", scene.notes);
}

#[test]
fn accessors_without_a_view_are_zeros() {
    let mut document = document();
    document["accessors"][1].as_object_mut().unwrap().remove("bufferView");
    let scene = load(&document);
    assert_eq!(scene.meshes[0].uvs, [[0.0; 2]; 3]);
}

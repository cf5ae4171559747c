//! What a scene may open: regular files of a limited size, in its folder.

use crate::common::{Folder, case, said};
use serde_json::{Value, json};
use sglow_scene::{Limits, Options, Scene, SceneError};

const OUTSIDE: &str =
    "lies outside of the scene's folder; move it there, or allow it (`--allow-outside`)";

/// A case whose one buffer is a file of this name.
fn with_buffer(uri: &str) -> (String, Vec<u8>) {
    use base64::Engine;
    let text = std::fs::read(case("gltf/meta_base.gltf")).unwrap();
    let mut document: Value = serde_json::from_slice(&text).unwrap();
    let inline =
        document["buffers"][0]["uri"].as_str().unwrap().split_once(',').unwrap().1.to_owned();
    document["buffers"][0]["uri"] = json!(uri);
    (document.to_string(), base64::engine::general_purpose::STANDARD.decode(inline).unwrap())
}

#[test]
fn files_stay_inside_the_folder() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("scene/buffers")).unwrap();
    let (inside, bytes) = with_buffer("buffers/../buffers/a%20b.bin");
    folder.write("scene/buffers/a b.bin", &bytes);
    folder.write("secret.bin", &bytes);
    assert_eq!(folder.load("scene/scene.gltf", inside).unwrap().triangle_count(), 10);
    let absolute = folder.path("secret.bin").display().to_string();
    for uri in [
        "../secret.bin",
        "%2e%2e/secret.bin",
        "buffers/../../secret.bin",
        "..%2fsecret.bin",
        &absolute,
    ] {
        let (document, _) = with_buffer(uri);
        let fault = folder.load("scene/scene.gltf", &document).unwrap_err();
        assert!(fault.to_string().contains(OUTSIDE), "{uri}: {fault}");
        // Where it is allowed, it loads.
        let options = Options { allow_outside: true, ..Options::default() };
        let path = folder.path("scene/scene.gltf");
        assert_eq!(Scene::from_file_with(&path, &options).unwrap().triangle_count(), 10, "{uri}");
    }
    for uri in ["file:///etc/passwd", "https://example.org/a.bin"] {
        let fault = folder.load("scene/scene.gltf", with_buffer(uri).0).unwrap_err().to_string();
        assert!(fault.contains("only data URIs and relative paths are read"), "{fault}");
    }
}

#[test]
fn material_libraries_and_images_stay_inside_the_folder() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("scene")).unwrap();
    folder.write("secret.mtl", "newmtl m\nKd 1 0 0\n");
    folder.write("scene/own.mtl", "newmtl m\nmap_Ke ../secret.png\n");
    std::fs::copy(case("obj/quad.png"), folder.path("secret.png")).unwrap();
    let load = |library: &str, options: &Options| {
        let text = format!("mtllib {library}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
        Scene::from_file_with(&folder.write("scene/scene.obj", text), options).unwrap()
    };
    let (closed, open) =
        (Options::default(), Options { allow_outside: true, ..Options::default() });
    for library in ["../secret.mtl", folder.path("secret.mtl").to_str().unwrap()] {
        let scene = load(library, &closed);
        assert!(said(&scene, OUTSIDE) && said(&scene, "scene.obj:1:1: "), "{:?}", scene.notes);
        assert_eq!(load(library, &open).materials[0].base_color, [1.0, 0.0, 0.0, 1.0]);
    }
    let scene = load("own.mtl", &closed);
    assert!(said(&scene, OUTSIDE) && said(&scene, "own.mtl:2:1: "), "{:?}", scene.notes);
    assert_eq!(scene.materials[0].emission, [0.0; 3]);
    assert!(load("own.mtl", &open).materials[0].emission_texture.is_some());
}

#[test]
fn large_files_and_scenes_are_refused_by_name() {
    let options = |limits: Limits| Options { limits, ..Options::default() };
    let load = |name: &str, limits| Scene::from_file_with(&case(name), &options(limits));
    let fault =
        load("gltf/meta_base.gltf", Limits { file_bytes: 100, ..Limits::default() }).unwrap_err();
    assert!(
        fault.to_string().ends_with("meta_base.gltf: has 6062 bytes, more than the limit of 100"),
        "{fault}"
    );
    for name in ["gltf/meta_base.gltf", "obj/obj_concave.obj"] {
        for limits in [
            Limits { vertices: 7, ..Limits::default() },
            Limits { triangles: 7, ..Limits::default() },
        ] {
            let fault = load(name, limits).unwrap_err();
            assert!(matches!(fault, SceneError::TooMuch { limit: 7 | 21, .. }), "{name} {fault}");
        }
    }
    // An image that is too large is a texture that is not there.
    for limits in [
        Limits { image_texels: 100, ..Limits::default() },
        Limits { texels: 100, ..Limits::default() },
    ] {
        let scene = load("gltf/uv1_none.gltf", limits).unwrap();
        assert!(said(&scene, "is 64 by 64 texels, more than the 100 left"), "{:?}", scene.notes);
        assert_eq!(scene.materials.last().unwrap().base_color_texture, None);
    }
}

#[cfg(unix)]
#[test]
fn devices_pipes_and_links_out_of_the_folder_are_refused() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("scene")).unwrap();
    let (_, bytes) = with_buffer("");
    folder.write("secret.bin", &bytes);
    symlink("/dev/zero", folder.path("scene/zero.bin")).unwrap();
    symlink("../secret.bin", folder.path("scene/link.bin")).unwrap();
    symlink("/dev/zero", folder.path("scene/zero.gltf")).unwrap();
    symlink("/dev/null", folder.path("scene/null.obj")).unwrap();
    let pipe = folder.path("scene/pipe.obj");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    let open = Options { allow_outside: true, ..Options::default() };
    for options in [Options::default(), open] {
        for (name, there) in [
            ("zero.gltf", true),
            ("null.obj", true),
            ("pipe.obj", made.as_ref().is_ok_and(|s| s.success())),
        ] {
            let loaded = Scene::from_file_with(&folder.path("scene").join(name), &options);
            assert!(
                !there || matches!(loaded, Err(SceneError::NotRegular { .. })),
                "{name}: {loaded:?}"
            );
        }
        let path = folder.write("scene/scene.gltf", with_buffer("zero.bin").0);
        let fault = Scene::from_file_with(&path, &options).unwrap_err();
        let expected = if options.allow_outside { "is not a regular file" } else { OUTSIDE };
        assert!(fault.to_string().contains(expected), "{fault}");
        let path = folder.write("scene/scene.gltf", with_buffer("link.bin").0);
        assert_eq!(Scene::from_file_with(&path, &options).is_ok(), options.allow_outside);
    }
    let fault = Scene::from_file(&folder.path("scene/scene.gltf/")).unwrap_err();
    assert!(matches!(fault, SceneError::Outside { .. } | SceneError::Read { .. }), "{fault}");
    // A folder called like a scene.
    std::fs::create_dir(folder.path("scene/folder.glb")).unwrap();
    let fault = Scene::from_file(&folder.path("scene/folder.glb")).unwrap_err();
    assert!(fault.to_string().ends_with("folder.glb: is not a regular file"), "{fault}");
    // A link within the folder is a file like any other.
    std::fs::remove_file(folder.path("scene/link.bin")).unwrap();
    folder.write("scene/own.bin", &bytes);
    symlink("own.bin", folder.path("scene/link.bin")).unwrap();
    assert_eq!(
        folder.load("scene/scene.gltf", with_buffer("link.bin").0).unwrap().triangle_count(),
        10
    );
}

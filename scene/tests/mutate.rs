//! Scene files with seeded mutations: none may panic, overflow the stack, run long or take much memory.
//!
//! Each mutated file is a copy of one in `cases/` in a folder of its own, with all that it refers to. What a longer run
//! finds becomes a case of its own.

#![allow(clippy::panic, clippy::unwrap_used, reason = "helpers of tests are tests, too")]

use std::alloc::System;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use cap::Cap;
use sglow_fuzz::{Case, MAXIMUM_SIZE, MAXIMUM_TIME, Random, Target, corpus};
use sglow_scene::{Limits, Options, Scene};

/// Beyond this the allocator says no, and the process ends: of inputs below 64 KB.
const MAXIMUM_MEMORY: usize = 256 << 20;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MAXIMUM_MEMORY);

/// What a loaded file may take; an ordinary scene of 64 KB takes less.
const OPTIONS: Options = Options {
    allow_outside: false,
    limits: Limits {
        file_bytes: 1 << 20,
        vertices: 1 << 18,
        triangles: 1 << 18,
        image_texels: 1 << 18,
        texels: 1 << 20,
    },
    origin: None,
};

/// Pieces that formats give a meaning to.
const WORDS: [&[u8]; 16] = [
    b"\\\n",
    b"%2e%2e/",
    b"/dev/zero",
    b"f 1 2 3 4 5 6 7 8\n",
    b"f -1 -2 -3\n",
    b"s 1\n",
    b"v 1e30 -1e30 1e-30\n",
    b"v 0 0 0 1 0 0\n",
    b"newmtl x\n",
    b"map_d quad.png\n",
    b"map_Pr -s 9 9 quad.png\n",
    b"d 0.1\n",
    b"Pm 1\n",
    b"mtllib room.mtl\n",
    b"usemtl tex\n",
    b"position = ",
];

/// The files of a folder of cases, copied into one of their own.
fn copied(cases: &Path, to: &Path) -> Vec<PathBuf> {
    let mut files: Vec<_> =
        fs::read_dir(cases).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    for file in &files {
        fs::copy(file, to.join(file.file_name().unwrap())).unwrap();
    }
    files.into_iter().map(|file| to.join(file.file_name().unwrap())).collect()
}

/// The scene that shows what a file says: itself, or the one that refers to it.
fn scene_of(file: &Path) -> Option<PathBuf> {
    let name = file.file_name()?.to_str()?;
    let scene = match name {
        _ if name.ends_with(".obj") || name.ends_with(".gltf") || name.ends_with(".glb") => {
            name.to_owned()
        }
        "quad.png" => "mtl_pbr.obj".to_owned(),
        "room.mtl" => "obj_base.obj".to_owned(),
        "a_white.mtl" | "b_colour.mtl" => "obj_two_mtllib_one_line.obj".to_owned(),
        _ => name
            .strip_suffix(".sglow.toml")
            .map(str::to_owned)
            .or_else(|| Some(format!("{}.obj", name.strip_suffix(".mtl")?)))?,
    };
    Some(file.with_file_name(scene))
}

/// A glTF document with its one buffer as a binary container.
fn binary(document: &[u8]) -> Vec<u8> {
    use base64::Engine;
    let mut document: serde_json::Value = serde_json::from_slice(document).unwrap();
    let uri = document["buffers"][0].as_object_mut().unwrap().remove("uri").unwrap();
    let payload = uri.as_str().unwrap().split_once(',').unwrap().1;
    let buffer = base64::engine::general_purpose::STANDARD.decode(payload).unwrap();
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
    file
}

#[test]
fn no_mutated_file_panics_runs_long_or_takes_much_memory() {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for kind in ["obj", "gltf"] {
        let own = folder.path().join(kind);
        fs::create_dir(&own).unwrap();
        files.extend(copied(&cases.join(kind), &own));
    }
    for name in ["specgloss_map", "gpu_instancing"] {
        let whole = fs::read(cases.join(format!("gltf/{name}.gltf"))).unwrap();
        let file = folder.path().join(format!("gltf/{name}.glb"));
        fs::write(&file, binary(&whole)).unwrap();
        files.push(file);
    }
    let scenes: BTreeMap<String, (PathBuf, PathBuf)> = files
        .iter()
        .map(|file| {
            let Some(scene) = scene_of(file).filter(|scene| scene.exists()) else {
                panic!("{}: no scene refers to it", file.display());
            };
            Scene::from_file_with(&scene, &OPTIONS).unwrap_or_else(|fault| panic!("{fault}"));
            let name = file.strip_prefix(folder.path()).unwrap().to_string_lossy().into_owned();
            (name, (file.clone(), scene))
        })
        .collect();
    let cases: Vec<Case> = corpus(folder.path());
    assert_eq!(cases.len(), scenes.len());
    let tried = Target::new("scene", 100).run(&cases, &WORDS, |case| {
        let (file, scene) = &scenes[&case.name];
        let whole = fs::read(file).unwrap();
        // A file that is written over is flushed by some systems; a new one is not.
        let write = |bytes: &[u8]| {
            fs::remove_file(file).unwrap();
            fs::write(file, bytes).unwrap();
        };
        write(&case.bytes);
        let loaded = Scene::from_file_with(scene, &OPTIONS);
        write(&whole);
        match &loaded {
            Ok(scene) => sound(scene),
            // One line for each fault, all of them with the file.
            Err(fault) => assert!(!fault.to_string().is_empty(), "{}", case.name),
        }
        loaded.is_ok()
    });
    // Both happen, or the mutations are no test.
    assert!(tried.refused > 100 && tried.taken > 100, "{tried:?}");
}

/// Inputs of at most 64 KB that would take much more than they are.
#[test]
fn no_crafted_file_panics_runs_long_or_takes_much_memory() {
    const SIZE: usize = MAXIMUM_SIZE;
    let fill = |piece: &str| piece.repeat(SIZE / piece.len());
    let many = |of: &dyn Fn(usize) -> String| {
        let mut text = String::new();
        for number in 0.. {
            let next = of(number);
            if text.len() + next.len() > SIZE {
                return text;
            }
            text += &next;
        }
        text
    };
    let mut random = Random(7);
    let mut scattered = String::new();
    let count = 4000;
    for _ in 0..count {
        scattered += &format!("v {} {} 0\n", random.below(1000), random.below(1000));
    }
    scattered +=
        &format!("f {}\n", (1..=count).map(|n| n.to_string()).collect::<Vec<_>>().join(" "));
    let comb = {
        let vertices = many(&|n| format!("v {} {} 0\n", n / 2, n % 2 * (n % 3)));
        let count = vertices.lines().count();
        format!(
            "{vertices}f {}\n",
            (1..=count).map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
        )
    };
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let head = "\"asset\":{\"version\":\"2.0\"}";
    let mesh = "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"scenes\":[{\"nodes\":[0]}]";
    let accessor = |count: u64| {
        format!(
            "{{\"componentType\":5126,\"type\":\"VEC3\",\"count\":{count},\"min\":[0,0,0],\"max\":[0,0,0]}}"
        )
    };
    let copies = "\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":1}}}}]";
    let gltf = |parts: &[&str]| format!("{{{head},{}}}", parts.join(","));
    let accessors = |a: u64, b: u64| format!("\"accessors\":[{},{}]", accessor(a), accessor(b));
    let files: Vec<(&str, String)> = vec![
        ("a.gltf", fill("[")),
        ("b.gltf", format!("{{{head},\"extras\":{}", fill("[{\"a\":"))),
        ("c.gltf", gltf(&[&format!("\"nodes\":[{}{{}}]", fill("{},"))])),
        ("d.gltf", gltf(&[mesh, copies, &accessors(3, u64::MAX)])),
        ("e.gltf", gltf(&[mesh, copies, &accessors(3, 80_000)])),
        ("f.gltf", gltf(&[mesh, copies, &accessors(0, 250_000)])),
        ("g.gltf", gltf(&[mesh, "\"nodes\":[{\"mesh\":0}]", &accessors(u64::MAX, 1)])),
        (
            "h.gltf",
            gltf(&[
                mesh,
                &accessors(200_000, 1),
                &format!(
                    "\"nodes\":[{}{{\"mesh\":0}}]",
                    many(&|n| format!("{{\"mesh\":0,\"children\":[{}]}},", n + 1))
                ),
            ]),
        ),
        ("a.obj", fill("f")),
        ("b.obj", fill("\\\n")),
        ("c.obj", fill("f 1 2 3\n")),
        ("d.obj", format!("{triangle}{}", many(&|n| format!("g {n}\nf 1 2 3\n")))),
        ("e.obj", format!("{triangle}{}", many(&|n| format!("usemtl {n}\nf 1 2 3\n")))),
        ("f.obj", format!("{triangle}f {}", fill("1 2 3 "))),
        ("g.obj", scattered),
        ("h.obj", comb),
        ("i.obj", format!("{triangle}f 1 2 3\nmtllib {}", fill("a "))),
        ("j.obj", fill("mtllib a\n")),
        (
            "k.obj",
            format!("{triangle}{}", many(&|n| format!("v 0 0 {n} {n} 0 0\ng {n}\nf 1 2 -1\n"))),
        ),
        ("l.obj", format!("{triangle}f 1 2 3\nmtllib l.mtl\nusemtl a\n{}", fill("s 1\nf 1 2 3\n"))),
        ("l.mtl", many(&|n| format!("newmtl a\nmap_Ks -imfchan r q{n}.png\n"))),
        (
            "m.obj",
            format!("mtllib m.mtl\n{triangle}{}", many(&|n| format!("usemtl {n}\nf 1 2 3\n"))),
        ),
        ("m.mtl", many(&|n| format!("newmtl {n}\nmap_Ks wide.png\nmap_Kd wide.png\n"))),
        ("n.obj", format!("{triangle}f 1 2 3\n")),
        ("n.obj.sglow.toml", format!("light = {}", fill("["))),
        ("o.obj", format!("{triangle}f 1 2 3\n")),
        ("o.obj.sglow.toml", format!("[{}a]", fill("a."))),
        ("p.obj", format!("{triangle}f 1 2 3\n")),
        ("p.obj.sglow.toml", fill("[[light]]\n")),
    ];
    let folder = tempfile::tempdir().unwrap();
    // As many texels as one image may have, and one row more.
    for (name, rows) in [("wide.png", 512), ("wider.png", 513)] {
        image::GrayImage::new(512, rows).save(folder.path().join(name)).unwrap();
    }
    for (name, text) in &files {
        assert!(text.len() < 3 * SIZE, "{name}");
        fs::write(folder.path().join(name), text).unwrap();
    }
    for (name, _) in
        files.iter().filter(|(name, _)| name.ends_with(".obj") || name.ends_with(".gltf"))
    {
        let start = Instant::now();
        let loaded = Scene::from_file_with(&folder.path().join(name), &OPTIONS);
        assert!(start.elapsed() < MAXIMUM_TIME, "{name}: runs long");
        if let Ok(scene) = &loaded {
            sound(scene);
        }
    }
}

/// What a scene promises to whoever draws it.
fn sound(scene: &Scene) {
    assert!(scene.triangle_count() > 0 && !scene.lights.is_empty());
    for mesh in &scene.meshes {
        assert!(mesh.material < scene.materials.len());
        assert_eq!(mesh.positions.len(), mesh.normals.len());
        assert!(mesh.uvs.is_empty() || mesh.uvs.len() == mesh.positions.len());
        assert!(mesh.indices.iter().all(|&index| (index as usize) < mesh.positions.len()));
        let finite = |list: &[[f32; 3]]| list.iter().flatten().all(|number| number.is_finite());
        assert!(finite(&mesh.positions) && finite(&mesh.normals));
    }
    for material in &scene.materials {
        assert!(material.textures().all(|texture| texture.image < scene.images.len()));
        let factors = [material.roughness, material.metallic, material.dielectric];
        assert!(
            factors.iter().chain(&material.base_color).all(|factor| (0.0..=1.0).contains(factor))
        );
        assert!(material.emission.iter().all(|channel| (0.0..=65504.0).contains(channel)));
    }
    for image in &scene.images {
        assert_eq!(image.rgba8.len(), 4 * image.width as usize * image.height as usize);
    }
    assert!(!scene.facts().known().is_empty());
}

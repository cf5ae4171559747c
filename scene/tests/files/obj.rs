//! OBJ and MTL as files have them.

use std::io::Cursor;

use crate::common::{Folder, said, triangles};
use sglow_scene::{Material, SceneError};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// A PNG of one texel.
fn png(texel: [u8; 4]) -> Vec<u8> {
    encoded(texel, image::ImageFormat::Png)
}

fn encoded(texel: [u8; 4], format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(1, 1, image::Rgba(texel)).write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// The one material of a file with this library.
fn material(folder: &Folder, library: &str) -> (Material, sglow_scene::Scene) {
    folder.write("scene.mtl", format!("newmtl m\n{library}\n"));
    let obj = format!("mtllib scene.mtl\n{TRIANGLE}vt 0 0\nusemtl m\nf 1/1 2/1 3/1\n");
    let scene = folder.load("scene.obj", obj).unwrap();
    (scene.materials[0].clone(), scene)
}

#[test]
fn obj_files_bring_their_materials() {
    const OBJ: &str = "mtllib scene.mtl\n\
        v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
        usemtl shiny\nf 1/1 2/2 3/3 4/4\nf 1/1 2/2 5/3\nl 1 2\n";
    const MTL: &str = "newmtl shiny\nKa 20 20 20\nKd 0.5 0.25 0.125\nKs 0.1 0.2 0.3\nNs 30\n\
        Ke 3 2 1\nmap_Kd texel.png\n";
    let folder = Folder::new();
    let bare = folder.load("scene.obj", OBJ).unwrap();
    assert_eq!(bare.materials[0].base_color, [0.5, 0.5, 0.5, 1.0]);
    assert!(said(&bare, "scene.obj:1:1: material library `scene.mtl`: "), "{:?}", bare.notes);
    assert!(said(&bare, "material that no library defines (shiny)"));
    assert_eq!(bare.facts().holds("specular"), Some(false));

    folder.write("scene.mtl", MTL);
    folder.write("texel.png", png([255; 4]));
    let scene = folder.load("scene.obj", OBJ).unwrap();
    assert_eq!(scene.triangle_count(), 2);
    assert!(said(&scene, "degenerate triangles dropped"));
    assert!(scene.notes.iter().any(|note| note.text.contains("Ka")));
    assert_eq!(scene.meshes[0].uvs[0], [0.0, 1.0]);
    let material = &scene.materials[0];
    assert_eq!(material.base_color, [0.5, 0.25, 0.125, 1.0]);
    assert_eq!(material.emission, [3.0, 2.0, 1.0]);
    assert!((material.dielectric - 0.2).abs() < 1e-6);
    // alpha = sqrt(2 / 32) = 1/4
    assert!((material.roughness - 0.5).abs() < 1e-6);
    for fact in ["specular", "textured"] {
        assert_eq!(scene.facts().holds(fact), Some(true), "{fact}");
    }
}

#[test]
fn one_bad_line_costs_that_line_alone() {
    let folder = Folder::new();
    let text = format!(
        "{TRIANGLE}v 1 1\nv 1 1 x\nv inf 0 0\nvt 1 y\nvn 0 0\nf 1 2 3\nf 1 2\nf 1 2 9\nf 1 2 4\n\
         f 1 2 0\nf 1/a 2 3\nf -9 1 2\nf 1/2/3/4 2 3\nfoo 7\ns many\nmtllib\nf 3 2 1\n"
    );
    let scene = folder.load("scene.obj", &text).unwrap();
    assert_eq!(scene.triangle_count(), 2);
    let lines: Vec<_> = scene
        .notes
        .iter()
        .filter_map(|note| note.text.rsplit_once("scene.obj:").map(|(_, line)| line.to_owned()))
        .collect();
    assert_eq!(
        lines,
        [
            "4:6: a vertex needs x, y and z, this has 2 of them",
            "5:7: `x` is not a number",
            "6:3: `inf` is not a finite number",
            "7:6: `y` is not a number",
            "8:7: a normal needs x, y and z, this has 2 of them",
            "10:1: a face needs 3 corners, this has 2",
            "11:7: there is no vertex 9; the file has 6",
            "12:1: the face has a vertex whose line cannot be read",
            "13:7: numbers start at 1; -1 is the last one",
            "14:3: corner `1/a`: `a` is not a whole number",
            "15:3: `-9` reaches before the first of 6",
            "16:3: `1/2/3/4` is not a corner; expected `v`, `v/vt`, `v//vn` or `v/vt/vn`",
            "17:1: `foo` is not a statement of OBJ",
            "18:3: `many` is not a smoothing group; expected a number or `off`",
            "19:1: the name of a material library is missing",
        ]
    );
    // Where nothing is left they are errors, all at once.
    let fault = folder.load("scene.obj", "v 0 0\nf 1 2 3\nbar\n").unwrap_err();
    assert!(matches!(&fault, SceneError::Several(faults) if faults.len() == 4), "{fault}");
    assert!(fault.to_string().contains("scene.obj:1:6: a vertex needs"), "{fault}");
    assert!(matches!(folder.load("scene.obj", "# 1\n"), Err(SceneError::NoTriangles { .. })));
    // Many are counted.
    let many = format!("{TRIANGLE}f 1 2 3\n{}", "nonsense\n".repeat(1000));
    assert!(said(&folder.load("scene.obj", many).unwrap(), "900 more lines that cannot be read"));
}

#[test]
fn faces_refer_back_and_ahead() {
    let folder = Folder::new();
    let plain = folder.load("scene.obj", format!("{TRIANGLE}f 1 2 3\n")).unwrap();
    for same in [
        format!("f 1 2 3\n{TRIANGLE}"),
        format!("{TRIANGLE}f -3 -2 -1\n"),
        format!("{TRIANGLE}fo 1// 2// 3//\n"),
        format!("{TRIANGLE}f 1/ 2/ 3/\n"),
        format!("{TRIANGLE}f 1 1 2 3 3 1\n"),
        format!("{TRIANGLE}f\t1\t2 \t 3 # the only one\n"),
        format!("{TRIANGLE}F 1 2 3\n").replace('\n', "\r"),
        format!("{TRIANGLE}\0\0f 1 2 3").replace("v 1 0 0", "v 1.0e0 +.0 -0. 1.0"),
    ] {
        let scene = folder.load("scene.obj", &same).unwrap();
        let unsigned = |scene| {
            let all = triangles(scene).into_iter();
            all.map(|(_, corners)| corners.map(|c| c.map(|bits| f32::from_bits(bits) + 0.0)))
                .collect::<Vec<_>>()
        };
        assert_eq!(unsigned(&scene), unsigned(&plain), "{same:?}");
    }
}

#[test]
fn smoothing_groups_make_normals_where_there_are_none() {
    // A roof: two squares that meet at a right angle along x = 0.
    let roof = "v -1 -1 0\nv 0 0 0\nv 0 0 1\nv -1 -1 1\nv 1 -1 0\nv 1 -1 1\nvn 0 0 1\n";
    let folder = Folder::new();
    let normal_at_ridge = |faces: &str| {
        let scene = folder.load("scene.obj", format!("{roof}{faces}")).unwrap();
        let mesh = &scene.meshes[0];
        let ridge = mesh.positions.iter().position(|p| p[0] == 0.0).unwrap();
        (glam::Vec3::from(mesh.normals[ridge]), mesh.positions.len(), scene)
    };
    let (smooth, vertices, scene) = normal_at_ridge("s 1\nf 4 3 2 1\nf 3 6 5 2\n");
    assert!(smooth.abs_diff_eq(glam::Vec3::Y, 1e-6), "{smooth}");
    assert_eq!(vertices, 6);
    assert!(said(&scene, "means over smoothing groups"));
    // Different groups, or none, keep the edge.
    for edge in ["s 1\nf 4 3 2 1\ns 2\nf 3 6 5 2\n", "s off\nf 4 3 2 1\nf 3 6 5 2\n"] {
        let (flat, _, scene) = normal_at_ridge(edge);
        assert!(flat.abs_diff_eq(glam::Vec3::new(-1.0, 1.0, 0.0).normalize(), 1e-6), "{flat}");
        assert_eq!(scene.triangle_count(), 4);
    }
    // Given ones count; faces without any beside them are flat.
    let (given, _, scene) = normal_at_ridge("f 4//1 3//1 2//1 1//1\nf 3 6 5 2\n");
    assert_eq!(given, glam::Vec3::Z);
    assert!(said(&scene, "some faces have no normals: flat ones made"));
}

#[test]
fn names_have_blanks_signs_and_other_systems_separators() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("maps")).unwrap();
    folder.write("maps/my wood.png", png([9; 4]));
    folder.write("Tile.PNG", png([8; 4]));
    folder
        .write("my library.mtl", "newmtl Material #25\nKd 1 0 0\nnewmtl Material #26\nKd 0 1 0\n");
    folder.write(
        "b.mtl",
        "newmtl b c # a comment\nmap_Kd -clamp on -o .25 maps\\my wood.png\n\
        newmtl d\nmap_Kd C:\\artist\\tile.png # gone\n",
    );
    let obj = format!(
        "mtllib my library.mtl \"b.mtl\"\n{TRIANGLE}usemtl Material #26\nf 1 2 3\nusemtl b c\nf 1 2 3\nusemtl d\nf 1 2 3\n"
    );
    let scene = folder.load("scene.obj", obj).unwrap();
    let colors: Vec<_> = scene.materials.iter().map(|m| (m.name.as_str(), m.base_color)).collect();
    assert_eq!(colors, [("Material", [0.0, 1.0, 0.0, 1.0]), ("b c", [1.0; 4]), ("d", [1.0; 4])]);
    let names: Vec<_> = scene.images.iter().map(|image| image.name.as_str()).collect();
    assert_eq!(names, ["maps\\my wood.png", "C:\\artist\\tile.png"], "{:?}", scene.notes);
    let texture = scene.materials[1].base_color_texture.unwrap();
    assert_eq!(
        (texture.wrap, texture.transform.offset),
        ([sglow_scene::Wrap::Clamp; 2], [0.25, 0.0])
    );
    assert!(said(&scene, "image of the same name in the scene's folder (C:\\artist\\tile.png)"));
}

#[test]
fn factors_of_every_kind_are_read() {
    let folder = Folder::new();
    folder.write("texel.png", png([128, 64, 255, 100]));
    let read = |library: &str| material(&folder, library);
    let (two, _) = read("Kd 0.5 0.25");
    assert_eq!(two.base_color, [0.5, 0.25, 0.25, 1.0]);
    // D65 is white.
    let (white, _) = read("Kd xyz 0.95047 1.0 1.08883");
    assert!(white.base_color.iter().all(|channel| (channel - 1.0).abs() < 1e-3), "{white:?}");
    let (_, spectral) = read("Kd spectral file.rfl 1.0");
    assert!(said(&spectral, "scene.mtl:2:4: `spectral` is not read"));
    // Opacity, and its opposite.
    for (line, alpha) in
        [("d 0.75", 0.75), ("Tr 0.25", 0.75), ("d 0.75\nTr 0.75", 0.75), ("Tr 1", 1.0)]
    {
        let (found, scene) = read(line);
        assert_eq!(found.base_color[3], alpha, "{line}");
        assert!(
            said(&scene, if alpha < 1.0 { "blended alpha" } else { "Tr of 1 without d" }),
            "{line}"
        );
    }
    let (glass, _) = read("Pr 0.1\nNi 1.5\nKs 0.5 0.5 0.5");
    assert!((glass.dielectric - 0.04).abs() < 1e-6);
    assert_eq!((glass.roughness, glass.metallic), (0.1, 0.0));
    // Whatever is not a number costs that line.
    for (line, place) in
        [("Ns 3O", "2:4"), ("Kd", "2:3"), ("d", "2:2"), ("map_Kd -s", "2:10"), ("Qq 1", "2:1")]
    {
        let (found, scene) = read(line);
        assert!(said(&scene, &format!("scene.mtl:{place}: ")), "{line}: {:?}", scene.notes);
        assert_eq!(found, Material::diffuse("m", [1.0; 3]), "{line}");
    }
    // Maps that the picture is drawn without are named, and what it lacks.
    for (line, lacks) in [
        ("map_Bump -bm 2 texel.png", "heights are not read; the surface is shaded smooth"),
        ("norm missing.png", "missing.png: no such file; the surface is shaded smooth"),
        ("map_Ns texel.png", "map_Ns"),
        ("Pc 1", "clearcoat"),
        ("map_Kd -mm 0 2 texel.png", "option `-mm` of map_Kd"),
    ] {
        assert!(said(&read(line).1, lacks), "{line}");
    }
}

#[test]
fn maps_of_every_kind_are_read_or_are_neutral() {
    let folder = Folder::new();
    folder.write("texel.png", png([128, 64, 255, 100]));
    folder.write("grey.png", png([51, 51, 51, 255]));
    let read = |library: &str| material(&folder, library);
    // A map times 0 would be no use of it.
    let (zero, scene) = read("Kd 0 0 0\nmap_Kd texel.png\nKe 0 0 0\nmap_Ke texel.png");
    assert_eq!((zero.base_color, zero.emission), ([1.0; 4], [1.0; 3]));
    assert!(said(&scene, "Kd of 0 beside its map taken as 1"));
    // Holes: the alpha of a map that has one, or else its brightness.
    for (mask, alpha) in [("texel.png", 100), ("grey.png", 51), ("-imfchan r texel.png", 128)] {
        let (cut, scene) = read(&format!("map_Kd texel.png\nmap_d {mask}"));
        let image = &scene.images[cut.base_color_texture.unwrap().image];
        assert_eq!(
            (cut.alpha_cutoff, image.rgba8.as_slice()),
            (Some(0.5), &[128, 64, 255, alpha][..]),
            "{mask}"
        );
    }
    let (metal, scene) = read("map_Pr -imfchan g texel.png\nmap_Pm -imfchan b texel.png");
    let image = &scene.images[metal.metallic_roughness_texture.unwrap().image];
    assert_eq!((image.rgba8.as_slice(), image.srgb), (&[0, 64, 255, 255][..], false));
    assert_eq!((metal.roughness, metal.metallic), (1.0, 1.0));
    let (shiny, _) = read("Ks 0.5 0.5 0.5\nmap_Ks grey.png");
    // sRGB 0.2, halved.
    assert!((shiny.dielectric - 0.033_105 / 2.0).abs() < 1e-5, "{shiny:?}");

    // What cannot be read leaves no factor of 1 behind.
    folder.write("broken.png", "no image");
    for name in ["missing.png", "broken.png"] {
        let maps = ["Kd", "Ke", "d"].map(|key| format!("map_{key} {name}\n")).concat();
        let (lost, scene) = read(&format!("Kd 0.5 0.5 0.5\n{maps}map_Pm {name}\nmap_Pr {name}"));
        assert_eq!((lost.emission, lost.metallic, lost.dielectric), ([0.0; 3], 0.0, 0.04));
        assert_eq!((lost.textures().count(), lost.alpha_cutoff), (0, None));
        for (line, lacks) in [
            (3, "is Kd everywhere"),
            (4, "emits nothing"),
            (5, "no holes"),
            (6, "not metallic"),
            (7, "is Pr"),
        ] {
            let found = scene.notes.iter().any(|note| {
                note.text.contains(&format!("scene.mtl:{line}:1: ")) && note.text.contains(lacks)
            });
            assert!(found, "{line} {lacks}: {:?}", scene.notes);
        }
        let (lost, _) = read(&format!("Ks 1 1 1\nmap_Ks {name}"));
        assert_eq!(lost.dielectric, 0.04);
    }
}

#[test]
fn images_of_other_formats_are_read() {
    use image::ImageFormat::{Bmp, Tga, WebP};
    let folder = Folder::new();
    for (format, name) in [(Bmp, "a.bmp"), (Tga, "a.tga"), (WebP, "a.webp"), (Bmp, "bmp.png")] {
        folder.write(name, encoded([10, 20, 30, 255], format));
        let (found, scene) = material(&folder, &format!("map_Kd {name}"));
        let image = &scene.images[found.base_color_texture.unwrap().image];
        assert_eq!(image.rgba8, [10, 20, 30, 255], "{name}");
    }
}

#[test]
fn normal_maps_are_read_and_heights_are_not_taken_for_them() {
    let folder = Folder::new();
    folder.write("normals.png", png([128, 128, 255, 255]));
    folder.write("heights.png", png([130, 130, 130, 255]));
    for line in ["norm normals.png", "map_Kn normals.png", "map_Bump -bm 2 normals.png"] {
        let (found, scene) = material(&folder, line);
        let map = found.normal_texture.unwrap();
        assert!(!scene.images[map.image].srgb, "{line}");
        let bump = line.contains("Bump");
        assert_eq!(found.normal_scale, if bump { 2.0 } else { 1.0 });
        assert_eq!(said(&scene, "map_Bump holds normals, and is read as such (m)"), bump);
        assert_eq!(scene.facts().holds("detailed"), Some(true));
    }
    let (found, scene) = material(&folder, "bump heights.png");
    assert_eq!(found.normal_texture, None);
    assert!(said(&scene, "image `heights.png`: heights are not read"), "{:?}", scene.notes);
    assert_eq!(scene.facts().holds("detailed"), Some(false));
}

#[test]
fn vertex_colours_tint_a_mesh() {
    let folder = Folder::new();
    let load = |colors: [&str; 3]| {
        let [a, b, c] = colors;
        folder
            .load("scene.obj", format!("v 0 0 0 {a}\nv 1 0 0 {b}\nv 0 1 0 {c}\nf 1 2 3\n"))
            .unwrap()
    };
    let color = |scene: &sglow_scene::Scene| scene.materials[scene.meshes[0].material].base_color;
    let same = load(["1 0.5 0"; 3]);
    assert_eq!(color(&same), [0.5, 0.25, 0.0, 1.0]);
    assert!(!said(&same, "vertex colours"));
    let varying = load(["1 0 0", "0 1 0", "0 0 1"]);
    assert_eq!(color(&varying), [0.5, 0.5, 0.5, 1.0]);
    let expected = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]];
    assert_eq!(varying.meshes[0].detail.colors, expected);
    assert_eq!(varying.facts().holds("detailed"), Some(true));
    assert_eq!(same.facts().holds("detailed"), Some(false));
    assert_eq!(color(&load(["1 1 1"; 3])), [0.5, 0.5, 0.5, 1.0]);
}

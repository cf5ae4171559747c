//! Normal maps, colours of vertices and second texture coordinates, rasterised, against rays: `shaders/src/surface/detail.wesl`.

use glam::{DVec2, DVec3, DVec4};
use sglow_oracle::Bounded;
use sglow_oracle::path::Materials as _;
use sglow_oracle::surface::{Crossing, Hit};
use sglow_renderer::frame::Renderer;
use sglow_renderer::reference::{self, SceneMaterials};
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::{Filter, Image, Scene, TextureUse, UvTransform, Wrap};

use crate::common::{Comparison, broken, gpu};
use crate::surface::{HALF_ULP, camera, triangles};

/// An image without edges, of few texels.
fn image(name: &str, texel: impl Fn(f32, f32) -> [f32; 3]) -> Image {
    let mut rgba8 = Vec::new();
    for y in 0..8 {
        for x in 0..8 {
            let at = |part: i32| std::f32::consts::TAU * (part as f32 + 0.5) / 8.0;
            rgba8.extend(texel(at(x), at(y)).map(|channel| (255.0 * channel + 0.5) as u8));
            rgba8.push(255);
        }
    }
    Image { name: name.to_owned(), width: 8, height: 8, rgba8, srgb: false }
}

/// The glossy Cornell box with everything that few surfaces have: colours of vertices on all, textures at second
/// coordinates, normal maps of which one is mirrored; one wall has holes by its vertices' opacity.
pub(crate) fn scene() -> Scene {
    let mut scene = Scene::builtin("cornell-glossy").unwrap();
    let waves = image("waves", |u, v| {
        let slope = [0.5 * u.sin(), 0.4 * v.cos()];
        let length = (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
        [slope[0] / length, slope[1] / length, 1.0 / length].map(|part| 0.5 + 0.5 * part)
    });
    let color = image("colour", |u, v| {
        [0.6 + 0.3 * u.sin(), 0.6 + 0.3 * v.sin(), 0.5 + 0.2 * (u + v).cos()]
    });
    scene.images = vec![waves, color];
    // One level, so that rays and pixels read the same.
    let read = |image: usize, second: bool, rotation: f32| TextureUse {
        image,
        wrap: [Wrap::Repeat; 2],
        magnify: Filter::Linear,
        minify: Filter::Linear,
        mip: None,
        transform: UvTransform { offset: [0.1, 0.2], rotation, scale: [0.35, -0.3] },
        second,
    };
    for (index, material) in scene.materials.iter_mut().enumerate() {
        if index != 1 {
            material.normal_texture = Some(read(0, index % 2 == 0, 0.4 * index as f32));
            material.normal_scale = 1.0 + 0.25 * index as f32;
        }
        if index != 2 {
            material.base_color_texture = Some(read(1, index % 2 == 1, 0.3));
        }
        material.alpha_cutoff = (index == 1).then_some(0.5);
    }
    let materials = scene.materials.clone();
    for mesh in &mut scene.meshes {
        let corner = |vertex: usize| mesh.positions[vertex];
        let detail = &mut mesh.detail;
        for vertex in 0..mesh.positions.len() {
            let [x, y, z] = corner(vertex);
            detail.uvs.push([0.4 * x + 0.2 * z, 0.3 * y - 0.5 * z + 0.1 * x]);
            let wave = |phase: f32| 0.6 + 0.4 * (x + 1.7 * y + 0.6 * z + phase).sin();
            let opacity = if vertex % 2 == 0 { 1.0 } else { 0.1 };
            detail.colors.push([wave(0.0), wave(1.0), wave(2.0), opacity]);
        }
        if let Some(map) = &materials[mesh.material].normal_texture {
            mesh.derive_tangents(map);
        }
    }
    scene
}

/// The mean over a triangle's corners.
fn mixed<const N: usize>(list: &[[f32; N]], corners: [usize; 3], weights: [f64; 3]) -> [f64; N] {
    std::array::from_fn(|part| {
        (0..3).map(|corner| weights[corner] * f64::from(list[corners[corner]][part])).sum()
    })
}

/// A texel of an image with repeating texels, blended from four.
fn blended(image: &Image, at: [f64; 2]) -> DVec3 {
    let place = DVec2::from(at) * f64::from(image.width) - 0.5;
    let (first, share) = (place.floor(), place - place.floor());
    let texel = |dx: f64, dy: f64| {
        let inside = |part: f64| part.rem_euclid(f64::from(image.width)) as usize;
        let first = 4 * (inside(first.y + dy) * 8 + inside(first.x + dx));
        DVec3::from([0, 1, 2].map(|channel| f64::from(image.rgba8[first + channel]) / 255.0))
    };
    let row = |dy: f64| texel(0.0, dy) * (1.0 - share.x) + texel(1.0, dy) * share.x;
    row(0.0) * (1.0 - share.y) + row(1.0) * share.y
}

/// What the surface textures should hold where a ray hits: the normal, before it faces anything, and the base colour with
/// the opacity.
fn expected(scene: &Scene, hit: &Hit) -> (DVec3, DVec4) {
    let mut first = 0;
    let mesh = scene.meshes.iter().find(|mesh| {
        first += mesh.triangle_count();
        hit.triangle < first
    });
    let mesh = mesh.unwrap();
    let triangle = hit.triangle - (first - mesh.triangle_count());
    let corners = [0, 1, 2].map(|corner| mesh.indices[3 * triangle + corner] as usize);
    let material = &scene.materials[mesh.material];
    let texel = |texture: &TextureUse| {
        let list = if texture.second { &mesh.detail.uvs } else { &mesh.uvs };
        let [u, v] = mixed(list, corners, hit.weights);
        let UvTransform { offset, rotation, scale } = texture.transform;
        let (scaled, turn) =
            ([u * f64::from(scale[0]), v * f64::from(scale[1])], f64::from(rotation));
        // Counter-clockwise with v pointing down.
        let (sin, cos) = turn.sin_cos();
        let at = [
            cos * scaled[0] + sin * scaled[1] + f64::from(offset[0]),
            -sin * scaled[0] + cos * scaled[1] + f64::from(offset[1]),
        ];
        blended(&scene.images[texture.image], at)
    };
    let normal = DVec3::from(mixed(&mesh.normals, corners, hit.weights));
    let mapped = material.normal_texture.as_ref().map_or(normal, |map| {
        let [x, y, z, sign] = mixed(&mesh.detail.tangents, corners, hit.weights);
        let tangent = DVec3::new(x, y, z);
        let texel = 2.0 * texel(map) - 1.0;
        let scale = f64::from(material.normal_scale);
        scale * texel.x * tangent
            + scale * texel.y * sign * normal.cross(tangent)
            + texel.z * normal
    });
    let color = DVec4::from(mixed(&mesh.detail.colors, corners, hit.weights));
    let base = DVec4::from(material.base_color.map(f64::from));
    let texture = material.base_color_texture.as_ref().map_or(DVec3::ONE, texel);
    (mapped.normalize(), color * base * texture.extend(1.0))
}

/// Compares the camera's pixels whose eight neighbours see the same triangle, and counts those that are holes.
fn compare(package: &Package) -> (Comparison, usize) {
    let scene = scene();
    let settings = Settings { size: [96, 72], map: 64, lights: 8, ..Settings::default() };
    let renderer = Renderer::new(gpu(), package, &scene, &settings, 0).unwrap();
    renderer.render().unwrap();
    let surfaces = renderer.read_gbuffer().unwrap();
    let size = settings.size.map(|side| side as usize);
    let hits = camera(&scene, settings.size).image(&triangles(&scene), size);
    let eye = reference::vector(scene.camera.position);
    let mut comparison = Comparison::default();
    let mut holes = 0;
    for y in 1..size[1] - 1 {
        for x in 1..size[0] - 1 {
            let index = y * size[0] + x;
            let at = |dx: i32, dy: i32| -> Option<&Hit> {
                hits[(y as i32 + dy) as usize * size[0] + (x as i32 + dx) as usize].as_ref()
            };
            let Some(hit) = at(0, 0) else { continue };
            let same = |dx, dy| at(dx, dy).is_some_and(|other| other.triangle == hit.triangle);
            if !(-1..=1).all(|dy| (-1..=1).all(|dx| same(dx, dy))) {
                continue;
            }
            let (Some(right), Some(below)) = (at(1, 0), at(0, 1)) else { continue };
            let [(normal, color), (right_normal, right_color), (below_normal, below_color)] =
                [hit, right, below].map(|hit| expected(&scene, hit));
            // Vertices may be snapped to a sixteenth of a pixel, as in `surface`; bilinear weights may have 8 bits.
            let turn = (right_normal - normal).length() + (below_normal - normal).length();
            let change = (right_color - color).length() + (below_color - color).length();
            let (turn, change) = (2.0 * turn / 16.0, 2.0 * change / 16.0);
            if scene.materials[hit.material as usize].alpha_cutoff.is_some() {
                let above = color.w - 0.5;
                if above.abs() <= change + HALF_ULP {
                    continue;
                }
                // What shows through a hole is another surface.
                let there = (surfaces.position[index][0] - hit.position.x as f32).abs() < 0.05;
                comparison.number(
                    || format!("hole at {x} {y}"),
                    f32::from(u8::from(there)),
                    Bounded::exact(f32::from(u8::from(above > 0.0))),
                );
                holes += usize::from(above < 0.0);
                if above < 0.0 {
                    continue;
                }
            }
            let view = eye - hit.position;
            let view = DVec3::new(view.x, view.y, view.z).normalize();
            let facing = if hit.normal.dot(eye - hit.position) < 0.0 { -normal } else { normal };
            // One that is turned away is brought back to the horizon.
            let facing = (facing - facing.dot(view).min(0.0) * view).normalize();
            let error = HALF_ULP + turn + 2.0 / 256.0;
            for axis in 0..3 {
                comparison.number(
                    || format!("normal of {x} {y}"),
                    surfaces.normal[index][axis],
                    Bounded::with_error(facing[axis], error),
                );
                let error = change + color[axis] * HALF_ULP + 2.0 / 256.0;
                comparison.number(
                    || format!("colour of {x} {y}"),
                    surfaces.base_color[index][axis],
                    Bounded::with_error(color[axis], error),
                );
            }
        }
    }
    (comparison, holes)
}

/// The reference's paths meet the same surfaces.
#[test]
fn paths_read_the_same_details() {
    let scene = scene();
    let size = [96, 72];
    let materials = SceneMaterials::new(&scene);
    let hits = camera(&scene, size).image(&triangles(&scene), size.map(|side| side as usize));
    let facets = reference::facets(&scene);
    let (mut compared, mut mapped) = (0, 0);
    for hit in hits.iter().flatten() {
        let uvs = facets[hit.triangle].uvs;
        let uv =
            [0, 1].map(|part| (0..3).map(|corner| hit.weights[corner] * uvs[corner][part]).sum());
        let crossing = Crossing { hit: *hit, uv, side: hit.normal };
        let (normal, color) = expected(&scene, hit);
        let found = materials.normal(&crossing);
        let found = DVec3::new(found.x, found.y, found.z);
        // Transforms of texture coordinates are rounded to 32 bits there.
        assert!((found - normal).length() < 1e-6, "{found} {normal}");
        let of_surface = DVec3::new(hit.normal.x, hit.normal.y, hit.normal.z);
        mapped += usize::from((found - of_surface).length() > 0.05);
        let material = &scene.materials[hit.material as usize];
        if material.metallic == 0.0 {
            let diffuse = materials.material(&crossing).diffuse;
            let diffuse = DVec3::new(diffuse.x, diffuse.y, diffuse.z);
            assert!((diffuse - color.truncate()).length() < 1e-6, "{diffuse} {color}");
            if let Some(cutoff) = material.alpha_cutoff {
                assert_eq!(materials.counts(&crossing), color.w >= f64::from(cutoff));
            }
            compared += 1;
        }
    }
    assert!(compared > 1000 && mapped > 1000, "{compared} {mapped}");
}

#[test]
fn details_agree_with_rays() {
    let (comparison, holes) = compare(&Package::embedded());
    comparison.assert_holds("G-buffer with details");
    assert!(holes > 20, "{holes}");
}

#[test]
fn a_broken_detail_is_noticed() {
    for (from, to, what) in [
        ("fragment.tangent.w * cross", "cross", "mirror images that are not known"),
        ("slope.y * bitangent", "-slope.y * bitangent", "green that points down"),
        ("sglow_material.normal_scale * texel.xy", "texel.xy", "a scale that is left out"),
        ("rows[0].w > 0.5", "false", "a second set that is not read"),
        ("color * fragment.color", "color", "colours of vertices that are left out"),
    ] {
        let package = broken("surface-detailed-opaque", from, to);
        assert!(compare(&package).0.violations() > 0, "{what} went unnoticed");
    }
}

//! Rasterised surfaces against rays: `shaders/src/surface`.

use glam::Vec3;
use sglow_oracle::surface::{Camera, Hit, Triangle};
use sglow_oracle::{Bounded, Vector3};
use sglow_renderer::frame::{Renderer, Surfaces};
use sglow_renderer::reference;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::Scene;

use crate::common::{Comparison, broken, gpu};

/// What a half float may be off by, relatively: the rounding of colour attachments is the driver's choice (Vulkan,
/// "Representation of non-fixed-point formats"); lavapipe cuts off.
pub(crate) const HALF_ULP: f64 = 1.0 / 1024.0;

fn settings() -> Settings {
    Settings { size: [96, 72], map: 64, lights: 8, ..Settings::default() }
}

pub(crate) fn triangles(scene: &Scene) -> Vec<Triangle> {
    let vector = |value: [f32; 3]| reference::vector(value);
    scene
        .meshes
        .iter()
        .flat_map(|mesh| {
            mesh.indices.chunks_exact(3).map(move |corners| Triangle {
                positions: [0, 1, 2].map(|corner| vector(mesh.positions[corners[corner] as usize])),
                normals: [0, 1, 2].map(|corner| vector(mesh.normals[corners[corner] as usize])),
                material: mesh.material as u32,
            })
        })
        .collect()
}

pub(crate) fn camera(scene: &Scene, [width, height]: [u32; 2]) -> Camera {
    let camera = &scene.camera;
    let forward = Vec3::from(camera.forward);
    let up = Vec3::from(camera.up);
    let tangent = f64::from(0.5 * camera.vertical_fov).tan();
    Camera {
        position: reference::vector(camera.position),
        right: reference::vector(forward.cross(up)),
        up: reference::vector(up),
        forward: reference::vector(forward),
        half_extent: [tangent * f64::from(width) / f64::from(height), tangent],
        perspective: true,
    }
}

/// A vector whose parts have an error each.
fn within(value: Vector3, error: f64) -> Vector3<Bounded> {
    let [x, y, z] = value.to_array().map(|part| Bounded::with_error(part, error));
    Vector3::new(x, y, z)
}

/// Compares the pixels whose eight neighbours see the same triangle, as the rays tell.
fn compare(
    scene: &Scene,
    surfaces: &Surfaces,
    camera: &Camera,
    eye: Vector3,
    size: [usize; 2],
) -> Comparison {
    let hits = camera.image(&triangles(scene), size);
    let mut comparison = Comparison::default();
    for y in 1..size[1] - 1 {
        for x in 1..size[0] - 1 {
            let at = |dx: i32, dy: i32| -> Option<&Hit> {
                hits[(y as i32 + dy) as usize * size[0] + (x as i32 + dx) as usize].as_ref()
            };
            let Some(hit) = at(0, 0) else { continue };
            let same = |dx, dy| at(dx, dy).is_some_and(|other| other.triangle == hit.triangle);
            if !(-1..=1).all(|dy| (-1..=1).all(|dx| same(dx, dy))) {
                continue;
            }
            let (Some(right), Some(below)) = (at(1, 0), at(0, 1)) else { continue };
            // Vertices may be snapped to a grid of a sixteenth of a pixel (Vulkan's least subPixelPrecisionBits is 4),
            // which moves what a pixel's centre sees by up to that share of its footprint in both directions; the
            // factor 2 is for the change of the footprint itself over a pixel.
            let footprint =
                (right.position - hit.position).length() + (below.position - hit.position).length();
            let error = 2.0 * footprint / 16.0 + 1e-5 * hit.distance;
            let index = y * size[0] + x;
            let material = &scene.materials[hit.material as usize];
            let expected = within(hit.position, error);
            let [px, py, pz, dielectric] = surfaces.position[index];
            comparison.vector(&format!("position of {x} {y}"), [px, py, pz], expected);
            comparison.number(
                || "dielectric".to_owned(),
                dielectric,
                Bounded::exact(material.dielectric),
            );
            let facing =
                if hit.normal.dot(eye - hit.position) < 0.0 { -hit.normal } else { hit.normal };
            // The oracle's normals are interpolated at the exact centre, so that curved surfaces get the footprint's
            // share as well as the rounding.
            let turn = (right.normal - hit.normal).length() + (below.normal - hit.normal).length();
            let expected = within(facing, HALF_ULP + 2.0 * turn / 16.0);
            let [nx, ny, nz, alpha] = surfaces.normal[index];
            comparison.vector(&format!("normal of {x} {y}"), [nx, ny, nz], expected);
            let half = |value: f64| Bounded::with_error(value, value.abs() * HALF_ULP + 1e-7);
            let roughness = f64::from(material.roughness);
            comparison.number(
                || "alpha".to_owned(),
                alpha,
                half((roughness * roughness).max(0.01)),
            );
            let [r, g, b, _] = material.base_color.map(f64::from);
            let expected = [r, g, b, f64::from(material.metallic)].map(half);
            comparison.texel(&format!("colour of {x} {y}"), surfaces.base_color[index], expected);
        }
    }
    comparison
}

fn run(name: &str, package: &Package) -> [Comparison; 2] {
    let scene = Scene::builtin(name).unwrap();
    let settings = settings();
    let renderer = Renderer::new(gpu(), package, &scene, &settings, 0).unwrap();
    renderer.render().unwrap();
    let frame = renderer.read().unwrap();
    let eye = reference::vector(scene.camera.position);
    let size = settings.size.map(|side| side as usize);
    let seen = compare(&scene, &frame.gbuffer, &camera(&scene, settings.size), eye, size);

    let rsm = renderer.read_rsm().unwrap();
    let light = reference::light(renderer.light(), sglow_shaders::Light::Spot);
    let lit =
        compare(&scene, &rsm, &light.cameras()[0], light.position, [settings.map as usize; 2]);
    [seen, lit]
}

#[test]
fn agree_with_rays() {
    for name in ["cornell", "cornell-glossy"] {
        let [seen, lit] = run(name, &Package::embedded());
        seen.assert_holds(&format!("G-buffer of {name}"));
        lit.assert_holds(&format!("reflective shadow map of {name}"));
    }
}

#[test]
fn a_broken_shader_is_noticed() {
    let breaks = [
        (
            "dot(normal, viewer) < 0.0",
            "dot(normal, viewer) > 0.0",
            "normals that turn away from the viewer",
        ),
        ("max(roughness * roughness, 0.01)", "roughness", "roughness that is not squared"),
        (
            "fragment.offset, sglow_material.dielectric",
            "1.02 * fragment.offset, sglow_material.dielectric",
            "moved positions",
        ),
    ];
    for (from, to, what) in breaks {
        let package = broken("surface-constant-opaque", from, to);
        let [seen, lit] = run("cornell-glossy", &package);
        assert!(seen.violations() + lit.violations() > 0, "{what} went unnoticed");
    }
}

/// The positions of a scene in the camera's view and in the light's, far from the world's origin and after it was moved back,
/// so that its vertices are rounded alike: pixels that both show, and the largest difference of a coordinate.
fn moved_apart(package: &Package) -> [f64; 2] {
    const AWAY: f32 = 1e6;
    let moved = |scene: &Scene, by: f32| {
        let mut scene = scene.clone();
        let positions = scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions);
        let lights = scene.lights.iter_mut().map(|light| &mut light.position);
        for position in positions.chain(lights).chain([&mut scene.camera.position]) {
            *position = position.map(|part| part + by);
        }
        scene
    };
    let far = moved(&Scene::builtin("cornell-glossy").unwrap(), AWAY);
    let near = moved(&far, -AWAY);
    let maps = |scene: &Scene| {
        let renderer = Renderer::new(gpu(), package, scene, &settings(), 0).unwrap();
        renderer.draw_maps().unwrap();
        [renderer.read_gbuffer().unwrap(), renderer.read_rsm().unwrap()]
    };
    let (far, near) = (maps(&far), maps(&near));
    let (mut apart, mut others) = (0_f64, 0);
    for (far, near) in far.iter().zip(&near) {
        for (far, near) in far.position.iter().zip(&near.position) {
            if far[3] < 0.0 || near[3] < 0.0 {
                others += usize::from(far[3] != near[3]);
                continue;
            }
            for axis in 0..3 {
                let [far, near] = [far, near].map(|position| f64::from(position[axis]));
                apart = apart.max((far - f64::from(AWAY) - near).abs());
            }
        }
    }
    [apart, others as f64]
}

/// Far from the world's origin positions are rounded once, to the nearest that f32 has; nothing else is another picture.
#[test]
fn positions_far_from_the_origin_are_rounded_once() {
    let half_ulp = 0.5 / 16.0;
    let found = moved_apart(&Package::embedded());
    println!("apart by {found:?}");
    assert!(found[0] < 1.001 * half_ulp && found[1] == 0.0, "{found:?}");
    // Negative control: positions that are interpolated in the world.
    let id = "surface-constant-opaque";
    let mut text = Package::embedded().text(id).unwrap().to_owned();
    for (from, to) in [
        ("clip, offset, vertex.normal", "clip, vertex.position, vertex.normal"),
        ("-fragment.offset", "sglow_view.eye.xyz - fragment.offset"),
        ("sglow_view.origin + fragment.offset", "fragment.offset"),
    ] {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text = text.replace(from, to);
    }
    let found = moved_apart(&Package::embedded().with_text(id, text));
    println!("interpolated in the world: apart by {found:?}");
    assert!(found[0] > 1.5 * half_ulp, "{found:?}");
}

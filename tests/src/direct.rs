//! Direct light and its shadow map: `shaders/src/direct`.

use sglow_oracle::direct::shadow::face_of;
use sglow_oracle::direct::{ShadowMap, direct};
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::{Bounded, Vector3};
use sglow_renderer::frame::{Renderer, SHADOW_SIZE};
use sglow_renderer::reference;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::{LightKind, Scene};
use sglow_shaders::{Light, Ndf, Specular};

use crate::common::{Comparison, KINDS, broken, gpu, whole_space};

fn run(kind: LightKind, ndf: Ndf, package: &Package) -> Comparison {
    let mut scene = Scene::builtin("cornell-glossy").unwrap();
    let light = &mut scene.lights[0];
    light.kind = kind;
    if kind == LightKind::Directional {
        light.direction = glam::Vec3::new(-0.3, -0.5, -0.8).normalize().into();
        light.intensity = [3.0, 2.5, 2.0];
    }
    let specular = if ndf == Ndf::None { Specular::None } else { Specular::Asg };
    let size = [64, 48];
    let settings = Settings { size, map: 32, lights: 4, specular, ndf, ..Settings::default() };
    let axis = match kind {
        LightKind::Spot { .. } => Light::Spot,
        LightKind::Directional => Light::Directional,
        LightKind::Point => Light::Point,
    };
    let renderer = Renderer::new(gpu(), package, &scene, &settings, 0).unwrap();
    renderer.render().unwrap();
    let frame = renderer.read().unwrap();
    let depths: Vec<f32> =
        renderer.read_shadow_map().unwrap().into_iter().map(|texel| texel[0]).collect();
    let light = reference::light(renderer.light(), axis);
    let eye = Vector3::constant(reference::vector(renderer.eye()));
    let bias = renderer.shadow_bias();
    let side = SHADOW_SIZE as usize;
    let mut comparison = Comparison::default();
    let mut shadowed = 0;
    let mut uncertain = 0;
    let surfaces: Vec<SurfaceTexel<Bounded>> = reference::texels(&frame.gbuffer);
    // In f64 it does not matter that the matrix moves by the light's position too.
    let relative = glam::DMat4::from_translation(-glam::DVec3::from(light.position));
    for (index, surface) in surfaces.iter().enumerate() {
        let normal = surface.normal.value();
        let lifted = surface.position.value() + normal * f64::from(bias.normal);
        let (face, tile) = if axis == Light::Point {
            let face = face_of(lifted - light.position);
            (face, [[(face % 4) * side / 4, face / 4 * side / 2], [side / 4, side / 2]])
        } else {
            (0, [[0, 0], [side, side]])
        };
        let matrix = renderer.light().faces[face].clip_from_light;
        let map = ShadowMap {
            depths: &depths,
            size: [side, side],
            tile,
            clip_from_world: matrix.as_dmat4() * relative,
            bias: f64::from(bias.depth),
        };
        let shadow = map.shadow(lifted);
        // A depth is four products and a quotient of numbers up to a few units: about 16 ULP of 1. A place in the map
        // is as many ULP of its width.
        let depth_error = 16.0 * f64::from(f32::EPSILON);
        let place_error = depth_error * side as f64;
        if surface.present && (shadow.margin < depth_error || shadow.texel_margin < place_error) {
            uncertain += 1;
            continue;
        }
        shadowed += usize::from(surface.present && shadow.visibility < 1.0);
        let partial = shadow.visibility > 0.0 && shadow.visibility < 1.0;
        let error = if partial { 2.0 * place_error } else { 0.0 };
        let visibility = Bounded::with_error(shadow.visibility, error);
        let expected = direct(surface, eye, &light, reference::ndf(ndf), visibility);
        let expected = if ndf == Ndf::None { expected.diffuse } else { expected.total() };
        let [r, g, b, _] = frame.direct[index];
        comparison.vector(&format!("pixel {index}"), [r, g, b], expected);
    }
    assert!(shadowed > 20, "{kind:?}: only {shadowed} pixels in shadow");
    assert!(uncertain * 5 < surfaces.len(), "{kind:?}: {uncertain} of {}", surfaces.len());
    comparison
}

#[test]
fn agrees_with_the_oracle() {
    for kind in KINDS {
        for ndf in [Ndf::None, Ndf::Ggx, Ndf::Beckmann] {
            run(kind, ndf, whole_space()).assert_holds(&format!("direct, {kind:?}, {ndf}"));
        }
    }
}

#[test]
fn a_broken_shader_is_noticed() {
    let breaks = [
        ("direct-spot-ggx", KINDS[0], "/ squared_distance;", ";", "light that does not fall off"),
        (
            "direct-spot-ggx",
            KINDS[0],
            "depth <= textureLoad",
            "depth > textureLoad",
            "inverted shadows",
        ),
        (
            "direct-point-ggx",
            KINDS[2],
            "select(2, 3, offset.y < 0.0)",
            "select(3, 2, offset.y < 0.0)",
            "swapped faces",
        ),
        (
            "direct-directional-ggx",
            KINDS[1],
            "vec2<f32>(0.5, -0.5)",
            "vec2<f32>(0.5, 0.5)",
            "a map upside down",
        ),
        (
            "direct-spot-ggx",
            KINDS[0],
            "surface.diffuse * SGLOW_INV_PI",
            "surface.diffuse * 0.3183",
            "pi to four digits",
        ),
    ];
    for (id, kind, from, to, what) in breaks {
        run(kind, Ndf::Ggx, &broken(id, from, to)).assert_fails(what);
    }
}

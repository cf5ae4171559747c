//! Several lights in one map: what is made of them against the oracle, against each of them by itself, and bad input.

use sglow_oracle::direct::shadow::face_of;
use sglow_oracle::direct::{ShadowMap, direct};
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::vsgl::Vsgl;
use sglow_oracle::{Bounded, Vector3};
use sglow_renderer::frame::{Frame, FrameError, Pixels, Renderer};
use sglow_renderer::reference;
use sglow_renderer::request::shot;
use sglow_runtime::indirect::{Indirect, Inputs, PARTS};
use sglow_runtime::light::{LightView, LightsError, MAXIMUM_FACES};
use sglow_runtime::occluders::Occluders;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::{Light, LightKind, Scene};
use sglow_shaders::{
    Cut, Density, Emitter, Light as Kind, Ndf, Precision, Space, Specular, Visibility,
};

use crate::common::{
    Comparison, KINDS, Uploaded, broken, gpu, light, lights, random_surfaces, small, whole_space,
};

/// The glossy box, with its blocks or without, lit by lights of these kinds at places that differ.
fn scene(kinds: &[LightKind], blocks: bool) -> Scene {
    let mut scene = Scene::builtin("cornell-glossy").unwrap();
    if !blocks {
        scene.meshes.retain(|mesh| !mesh.name.contains("block"));
    }
    let own = scene.lights[0].clone();
    let of = |(number, &kind): (usize, &LightKind)| {
        let [x, y, z] = own.position;
        let aside = 0.3 * number as f32 - 0.2;
        let mut light =
            Light { kind, position: [x + aside, y - 0.4, z + 0.5 * aside], ..own.clone() };
        if kind == LightKind::Point {
            light.intensity = light.intensity.map(|channel| 0.3 * channel);
        }
        if kind != LightKind::Directional {
            return light;
        }
        let direction = glam::Vec3::new(-0.3, -0.5, -0.8).normalize().into();
        Light { direction, intensity: [3.0, 2.5, 2.0], ..light }
    };
    scene.lights = kinds.iter().enumerate().map(of).collect();
    scene
}

fn settings() -> Settings {
    Settings { size: [48, 36], map: 64, lights: 64, ..Settings::default() }
}

fn several() -> Settings {
    Settings { light: Kind::Several, ..settings() }
}

fn rendered(scene: &Scene, settings: &Settings, light: usize) -> Frame {
    let renderer = Renderer::new(gpu(), whole_space(), scene, settings, light).unwrap();
    renderer.render().unwrap();
    renderer.read().unwrap()
}

fn indirect(frame: &Frame) -> Vec<[f64; 3]> {
    let layers =
        [frame.indirect_diffuse.as_ref().unwrap(), frame.indirect_specular.as_ref().unwrap()];
    let sum = |at: usize| {
        std::array::from_fn(|channel| {
            layers.iter().map(|layer| f64::from(layer[at][channel])).sum()
        })
    };
    (0..frame.direct.len()).map(sum).collect()
}

fn mean(radiance: &[[f64; 3]]) -> f64 {
    radiance.iter().flatten().sum::<f64>() / (3 * radiance.len()) as f64
}

/// The root mean square of the difference over the mean of the second.
fn apart(one: &[[f64; 3]], other: &[[f64; 3]]) -> f64 {
    let pairs = one.iter().flatten().zip(other.iter().flatten());
    let square: f64 = pairs.map(|(one, other)| (one - other).powi(2)).sum();
    (square / (3 * one.len()) as f64).sqrt() / mean(other)
}

fn sum(one: &[[f64; 3]], other: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let pairs = one.iter().zip(other);
    pairs.map(|(a, b)| std::array::from_fn(|channel| a[channel] + b[channel])).collect()
}

fn colors(pixels: &Pixels) -> Vec<[f64; 3]> {
    pixels.iter().map(|&[r, g, b, _]| [r, g, b].map(f64::from)).collect()
}

/// Direct light of one light of each kind against the sum of the oracle's, by the depths that the device has drawn.
fn compare_direct(kinds: &[LightKind], ndf: Ndf, package: &Package) -> Comparison {
    let specular = if ndf == Ndf::None { Specular::None } else { Specular::Asg };
    let settings = Settings { size: [64, 48], map: 32, lights: 4, specular, ndf, ..several() };
    let renderer = Renderer::new(gpu(), package, &scene(kinds, true), &settings, 0).unwrap();
    renderer.render().unwrap();
    let frame = renderer.read().unwrap();
    let depths: Vec<f32> =
        renderer.read_shadow_map().unwrap().into_iter().map(|texel| texel[0]).collect();
    let side = depths.len().isqrt();
    let (view, bias) = (renderer.light(), renderer.shadow_bias());
    let grid = view.grid().map(|count| count as usize);
    let tile = grid.map(|count| side / count);
    let each = reference::MapLights::of(view).each;
    let eye = Vector3::constant(reference::vector(renderer.eye()));
    let surfaces: Vec<SurfaceTexel<Bounded>> = reference::texels(&frame.gbuffer);
    let (mut comparison, mut uncertain, mut shadowed) = (Comparison::default(), 0, 0);
    for (index, surface) in surfaces.iter().enumerate() {
        let (mut expected, mut first, mut certain) = (Vector3::<Bounded>::zero(), 0, true);
        for (light, of_view) in each.iter().zip(&view.lights) {
            let offset = f64::from(bias.faces[first]);
            let lifted = surface.position.value() + surface.normal.value() * offset;
            let from = lifted - light.position;
            let face = first + if of_view.faces.len() == 6 { face_of(from) } else { 0 };
            let place = glam::DVec3::from(light.position);
            let map = ShadowMap {
                depths: &depths,
                size: [side; 2],
                tile: [[face % grid[0] * tile[0], face / grid[0] * tile[1]], tile],
                clip_from_world: view.faces[face].clip_from_light.as_dmat4()
                    * glam::DMat4::from_translation(-place),
                bias: f64::from(bias.depth),
            };
            first += of_view.faces.len();
            let shadow = map.shadow(lifted);
            // As in the test of one light: 16 ULP of a depth, and of a place in the map.
            let depth_error = 16.0 * f64::from(f32::EPSILON);
            let place_error = depth_error * side as f64;
            certain &= shadow.margin >= depth_error && shadow.texel_margin >= place_error;
            shadowed += usize::from(surface.present && shadow.visibility < 1.0);
            let partial = shadow.visibility > 0.0 && shadow.visibility < 1.0;
            let error = if partial { 2.0 * place_error } else { 0.0 };
            let visibility = Bounded::with_error(shadow.visibility, error);
            let reflected = direct(surface, eye, light, reference::ndf(ndf), visibility);
            let reflected = if ndf == Ndf::None { reflected.diffuse } else { reflected.total() };
            expected = expected + reflected;
        }
        if surface.present && !certain {
            uncertain += 1;
            continue;
        }
        let [r, g, b, _] = frame.direct[index];
        comparison.vector(&format!("pixel {index}"), [r, g, b], expected);
    }
    assert!(shadowed > 20, "only {shadowed} in shadow");
    assert!(uncertain * 3 < surfaces.len(), "{uncertain} of {}", surfaces.len());
    comparison
}

#[test]
fn direct_light_agrees_with_the_oracle() {
    for ndf in [Ndf::None, Ndf::Ggx] {
        compare_direct(&KINDS, ndf, whole_space()).assert_holds(&format!("three kinds, {ndf}"));
    }
    // Nine faces have a larger shadow map.
    let many = [KINDS[2], KINDS[0], KINDS[1], KINDS[0]];
    compare_direct(&many, Ndf::Ggx, whole_space()).assert_holds("nine faces");
    for (from, to, what) in [
        ("face / grid.x) * size", "face % grid.x) * size", "tiles of another row"),
        ("light.cone_scale > 0.0", "true", "a point light through all faces"),
        ("light.half_extent > 0.0", "light.half_extent > 1e9", "a directional light as a spot"),
        ("* share", "", "no shadow"),
    ] {
        let package = broken("direct-several-ggx", from, to);
        compare_direct(&KINDS, Ndf::Ggx, &package).assert_fails(what);
    }
}

/// Where nothing is in shadow, the direct light of two lights is the sum of that of each, to rounding.
#[test]
fn direct_light_adds_up() {
    for kinds in [[KINDS[0], KINDS[2]], [KINDS[1], KINDS[0]], [KINDS[2], KINDS[2]]] {
        let scene = scene(&kinds, false);
        let alone = [0, 1].map(|light| colors(&rendered(&scene, &settings(), light).direct));
        let both = colors(&rendered(&scene, &several(), 0).direct);
        let sum = sum(&alone[0], &alone[1]);
        let difference = apart(&both, &sum);
        println!("{kinds:?}: {difference:e}");
        assert!(difference < 1e-6, "{kinds:?}: {difference}");
        // Negative control: one of them.
        assert!(apart(&both, &alone[0]) > 1e-2);
    }
}

/// Indirect light of two lights is the sum of that of each as far as discretisation allows: no farther from it than the sum
/// by maps as coarse as the tiles, and with half of the virtual lights.
#[test]
fn indirect_light_adds_up() {
    let scene = scene(&[KINDS[0], KINDS[2]], true);
    for (what, settings) in [
        ("kernels", Settings { size_factor: 0.25, ..settings() }),
        ("clusters in the image", Settings { space: Space::Image, ..settings() }),
        ("clusters", Settings { space: Space::World, ..settings() }),
        (
            "bidirectional",
            Settings { density: Density::Bidirectional, size_factor: 0.25, ..settings() },
        ),
        ("cut", Settings { space: Space::Tree, emitter: Emitter::Disc, ..settings() }),
    ] {
        let alone = |lights, map| {
            let settings = Settings { lights, map, ..settings.clone() };
            [0, 1].map(|light| indirect(&rendered(&scene, &settings, light)))
        };
        let (alone, coarse) = (alone(1024, 256), alone(512, 64));
        let settings = Settings { lights: 1024, map: 256, light: Kind::Several, ..settings };
        let both = indirect(&rendered(&scene, &settings, 0));
        let expected = sum(&alone[0], &alone[1]);
        let allowed = 1.5 * apart(&sum(&coarse[0], &coarse[1]), &expected);
        let (difference, bias) = (apart(&both, &expected), mean(&both) / mean(&expected) - 1.0);
        println!("{what}: {difference:.4} of the mean, allowed {allowed:.4}, bias {bias:.4}");
        assert!(difference < allowed && bias.abs() < 0.02, "{what}: {difference} {allowed} {bias}");
        // Negative control: one of them.
        assert!(alone.iter().all(|one| (mean(&both) / mean(one) - 1.0).abs() > 0.2), "{what}");
    }
}

/// One light among several is what it is by itself, to rounding.
#[test]
fn one_light_among_several_is_what_it_is_alone() {
    let flat = settings();
    let cut = Settings { space: Space::Tree, emitter: Emitter::Disc, ..settings() };
    let all = [
        ("kernels", flat.clone()),
        ("f16", Settings { precision: Precision::F16, ..flat.clone() }),
        ("bidirectional", Settings { density: Density::Bidirectional, ..flat.clone() }),
        ("clusters", Settings { space: Space::World, ..flat.clone() }),
        ("cut", cut.clone()),
        (
            "tiles",
            Settings { cut: Cut::Tile, visibility: Visibility::ShadowMap, lights: 16, ..cut },
        ),
    ];
    for kind in KINDS {
        let mut scene = scene(&[kind], true);
        for (what, settings) in &all {
            let alone = rendered(&scene, settings, 0);
            let shared = Settings { light: Kind::Several, ..settings.clone() };
            let among = rendered(&scene, &shared, 0);
            for (part, one, other) in [
                ("direct", colors(&among.direct), colors(&alone.direct)),
                ("indirect", indirect(&among), indirect(&alone)),
            ] {
                let difference = apart(&one, &other);
                println!("{kind:?}, {what}, {part}: {difference:e}");
                assert!(difference < 1e-5, "{kind:?}, {what}, {part}: {difference}");
            }
        }
        // Negative control: a light that is a hundredth brighter.
        let alone = rendered(&scene, &flat, 0);
        scene.lights[0].intensity = scene.lights[0].intensity.map(|channel| 1.01 * channel);
        let brighter = rendered(&scene, &Settings { light: Kind::Several, ..flat.clone() }, 0);
        assert!(apart(&indirect(&brighter), &indirect(&alone)) > 5e-3);
        assert!(apart(&colors(&brighter.direct), &colors(&alone.direct)) > 5e-3);
    }
}

/// The power of the lights that a map is made into is that of the maps of its lights, and a share for each by its power.
#[test]
fn the_pool_has_the_power_of_all_maps() {
    let power = |scene: &Scene, settings: &Settings, light: usize| {
        let renderer = Renderer::new(gpu(), whole_space(), scene, settings, light).unwrap();
        renderer.render().unwrap();
        let lights: Vec<Vsgl> = reference::lights(gpu(), renderer.indirect()).unwrap();
        let power: f64 = lights.iter().map(|light| light.power().luminance()).sum();
        let lit = lights.iter().filter(|light| light.power().luminance() > 0.0).count();
        (power, lit)
    };
    let scene = scene(&KINDS, true);
    for space in [Space::Image, Space::World, Space::Tree] {
        let settings = Settings { map: 256, lights: 300, space, ..settings() };
        let each = [0, 1, 2].map(|light| power(&scene, &settings, light).0);
        let (shared, lit) = power(&scene, &Settings { light: Kind::Several, ..settings }, 0);
        let sum: f64 = each.iter().sum();
        println!("{space}: {shared} of {sum}, {each:?}; {lit} lights");
        // Texels at the edges of surfaces, of maps whose texels are 8 times as large.
        assert!((shared / sum - 1.0).abs() < 0.02, "{space}: {shared} {sum}");
        assert!((shared / (sum - each[1]) - 1.0).abs() > 0.04, "{space}: without one of them");
        assert!(lit > 200, "one budget for all: {lit}");
    }
}

/// A light of half of its tile's texels is the light alone with half of the map, here with a virtual light for each of
/// these: fewer are joined in another order.
#[test]
fn a_light_may_have_a_part_of_its_tile() {
    let settings = Settings {
        space: Space::Tree,
        emitter: Emitter::Disc,
        map: 128,
        lights: 4096,
        ..settings()
    };
    let made = |scene: &Scene, settings: &Settings| {
        let renderer = Renderer::new(gpu(), whole_space(), scene, settings, 0).unwrap();
        renderer.render().unwrap();
        let lights: Vec<Vsgl> = reference::lights(gpu(), renderer.indirect()).unwrap();
        let power: f64 = lights.iter().map(|light| light.power().luminance()).sum();
        (power, indirect(&renderer.read().unwrap()))
    };
    let shared = Settings { light: Kind::Several, ..settings.clone() };
    for kind in KINDS {
        let mut scene = scene(&[kind], true);
        let small = made(&scene, &Settings { map: 64, ..settings.clone() });
        let large = made(&scene, &settings);
        scene.lights[0].map_share = 0.5;
        let found = made(&scene, &shared);
        let [power, whole] = [&small, &large].map(|one| (found.0 / one.0 - 1.0).abs());
        let [near, far] = [&small, &large].map(|one| apart(&found.1, &one.1));
        println!(
            "{kind:?}: power {power:.1e}, whole tile {whole:.1e}; picture {near:.1e}, {far:.1e}"
        );
        assert!(power < 1e-6 && near < 1e-4, "{kind:?}: {power} {near}");
        // Negative control: the whole tile.
        assert!(far > 1e-2, "{kind:?}: {far} {near}");
    }
}

/// Both references of a picture with several lights agree with the frame, and those of one light do not.
#[test]
fn references_have_all_lights() {
    let scene = scene(&[KINDS[0], KINDS[2]], true);
    let settings = Settings {
        size: [24, 18],
        map: 256,
        lights: 256,
        space: Space::Tree,
        cut: Cut::Tile,
        emitter: Emitter::Disc,
        ..several()
    };
    let run = |visibility: Visibility| {
        let settings = Settings { visibility, ..settings.clone() };
        let renderer = Renderer::new(gpu(), whole_space(), &scene, &settings, 0).unwrap();
        renderer.render().unwrap();
        let (frame, rsm) = (renderer.read().unwrap(), renderer.read_rsm().unwrap());
        (
            frame,
            rsm,
            renderer.light().clone(),
            renderer.eye(),
            renderer.indirect().settings().clone(),
        )
    };
    let (frame, rsm, view, eye, own) = run(Visibility::None);
    let total = |found: Vec<sglow_oracle::shade::Reflected>| -> Vec<[f64; 3]> {
        found.iter().map(|one| one.total().to_array()).collect()
    };
    let facets =
        total(reference::unshadowed(&view, &own, &rsm, &frame.gbuffer, eye, |_, _| true).unwrap());
    let off = mean(&indirect(&frame)) / mean(&facets) - 1.0;
    println!("facets: bias {off:.4}, {:.4} of the mean", apart(&indirect(&frame), &facets));
    assert!(off.abs() < 0.05, "{off}");
    let (frame, _, view, eye, own) = run(Visibility::ShadowMap);
    let paths = |view: &LightView| {
        let found =
            reference::paths(view, &own, &scene, &frame.gbuffer, eye, 256, 1, |_, _| true).unwrap();
        total(found.unwrap().iter().map(|one| one.mean).collect())
    };
    let (all, found) = (paths(&view), indirect(&frame));
    let off = mean(&found) / mean(&all) - 1.0;
    println!("paths: bias {off:.4}, {:.4} of the mean", apart(&found, &all));
    assert!(off.abs() < 0.1, "{off}");
    // Each light by itself has less, and both together have all.
    let each = [0, 1].map(|light: usize| paths(&view.lights[light]));
    assert!(each.iter().all(|one| mean(&found) / mean(one) - 1.0 > 0.2));
    assert!((mean(&sum(&each[0], &each[1])) / mean(&all) - 1.0).abs() < 0.03);
}

#[test]
fn lights_that_no_map_can_have_are_named() {
    let [spot, _, point] = KINDS.map(|kind| light(kind, 32));
    assert_eq!(LightView::several(&[]).unwrap_err(), LightsError::None);
    let mut dark = spot.clone();
    dark.uniform.intensity = [0.0; 3];
    let text = LightView::several(&[dark.clone(), dark.clone()]).unwrap_err().to_string();
    assert!(text.contains("none of 2 lights has power"), "{text}");
    // One that has power is enough.
    assert_eq!(LightView::several(&[dark, spot.clone()]).unwrap().faces.len(), 2);
    let many = vec![spot.clone(); MAXIMUM_FACES];
    assert_eq!(LightView::several(&many).unwrap().grid(), [8, 8]);
    let text = LightView::several(&[many, vec![point]].concat()).unwrap_err().to_string();
    assert!(text.contains("65 lights have 70 faces") && text.contains("at most 64"), "{text}");
    let other = light(KINDS[0], 48);
    let text = LightView::several(&[spot.clone(), other]).unwrap_err().to_string();
    assert!(text.contains("light 1 is for another scene, or for a map of 48 texels"), "{text}");
    let sized = |texels| {
        let mut light = spot.clone();
        light.texels = Some(texels);
        light
    };
    let fits = |texels| LightView::several(&[sized(texels), spot.clone()]).map(|view| view.map);
    assert_eq!([2, 8, 16].map(fits), [Ok(32), Ok(32), Ok(32)]);
    for texels in [0, 7, 18] {
        let error = fits(texels).unwrap_err();
        assert_eq!(error, LightsError::Size { index: 0, texels, tile: 16 });
        assert!(error.to_string().contains("in a tile of 16;"), "{error}");
    }
    let nested = lights(32);
    let text = LightView::several(&[spot, nested]).unwrap_err().to_string();
    assert!(text.contains("light 1 is several lights"), "{text}");
    let maximum = whole_space().description().unwrap().parameter["light_faces"].maximum;
    assert_eq!(maximum, Some(MAXIMUM_FACES as f64));
}

#[test]
fn scenes_frames_and_engines_refuse_what_does_not_fit() {
    let error = |scene: &Scene, settings: &Settings| {
        Renderer::new(gpu(), &Package::embedded(), scene, settings, 0).err().unwrap().to_string()
    };
    let text = error(&scene(&[KINDS[2]; 11], true), &Settings { map: 64, ..several() });
    assert!(text.contains("11 lights have 66 faces"), "{text}");
    let text = error(&scene(&KINDS, true), &Settings { map: 66, ..several() });
    assert!(text.contains("map: a multiple of the columns of its tiles"), "{text}");
    let mut dark = scene(&KINDS, true);
    dark.lights.iter_mut().for_each(|light| light.intensity = [0.0; 3]);
    assert!(error(&dark, &several()).contains("none of 3 lights has power"));

    let scene = scene(&KINDS, true);
    let mut renderer = Renderer::new(gpu(), &Package::embedded(), &scene, &several(), 0).unwrap();
    let fewer = renderer.move_lights(&scene.lights[..2]).unwrap_err();
    assert!(matches!(fewer, FrameError::OtherFaces { was: 8, is: 2 }), "{fewer}");
    // Other kinds with as many faces are no other frame.
    renderer
        .move_lights(&[scene.lights[2].clone(), scene.lights[0].clone(), scene.lights[0].clone()])
        .unwrap();
    renderer.render().unwrap();

    let settings = Settings { light: Kind::Several, light_faces: 8, ..small() };
    let source = gpu().source(whole_space());
    let own = Indirect::of_parts(source, &settings, &PARTS, &Occluders::default()).unwrap();
    let maps = [settings.map; 2];
    let rsm = Uploaded::new(&random_surfaces(maps, 1), maps);
    let gbuffer = Uploaded::new(&random_surfaces(settings.size, 2), settings.size);
    let encode = |light: &LightView| {
        let (rsm, gbuffer) = (rsm.views(), gbuffer.views());
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        let inputs = Inputs { rsm, gbuffer, light, eye: glam::Vec3::new(0.5, 1.8, 3.0) };
        own.encode(&mut encoder, &inputs, None).map_err(|error| error.to_string())
    };
    encode(&lights(settings.map)).unwrap();
    let two = LightView::several(&[light(KINDS[0], maps[0]), light(KINDS[1], maps[0])]).unwrap();
    let text = encode(&two).unwrap_err();
    assert!(text.contains("2 lights with 2 faces") && text.contains("light_faces"), "{text}");
    let text = encode(&light(KINDS[0], maps[0])).unwrap_err();
    assert!(text.contains("a spot light") && text.contains("light=several"), "{text}");
}

/// What a scene with several lights is rendered with.
#[test]
fn a_scene_is_lit_by_all_its_lights_unless_one_is_chosen() {
    use sglow_renderer::request::derivation::Request;
    let library = crate::common::library();
    let shot = |scene: Scene, set: &[&str]| {
        let set: Vec<_> = set.iter().map(|&one| one.to_owned()).collect();
        shot::Shot::new(&library, scene, &set, &Request::of([16, 16])).unwrap().settings
    };
    let all = shot(scene(&KINDS, true), &[]);
    assert_eq!((all.light, all.light_faces, all.map), (Kind::Several, 8, 256));
    let one = shot(scene(&KINDS[2..], true), &[]);
    assert_eq!((one.light, one.light_faces), (Kind::Point, 6));
    let forced = shot(scene(&KINDS[2..], true), &["light=several"]);
    assert_eq!((forced.light, forced.light_faces), (Kind::Several, 6));
    // The map is a multiple of the columns of tiles.
    let odd = shot(scene(&KINDS, true), &["map=99"]);
    assert_eq!(odd.map, 96);
}

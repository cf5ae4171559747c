//! What a scene does not need is left out, and nothing changes: for every set of needs the pruned variants render what
//! the complete ones render, bit for bit; what was left out was not made; and a scene that needs more is refused.

use std::collections::{BTreeMap, BTreeSet};

use sglow_renderer::device::Gpu;
use sglow_renderer::frame::{Frame, FrameError, Renderer};
use sglow_renderer::plan::Storage;
use sglow_renderer::variants::Variants as _;
use sglow_runtime::package::Assumption;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_scene::{Camera, Image, Light, LightKind, Material, Mesh, Scene, TextureUse};
use sglow_shader_gen::manifest::{Assumed, LeftOut, MadeFor, Saved};
use sglow_shader_gen::package::{Options, Purpose, generate};
use sglow_shaders::{Precision, Specular, Visibility};

use crate::common::{KINDS, broken, gpu, library, package_of, plan, reseal, whole_space};

#[derive(Clone, Copy, Debug)]
struct Needs {
    specular: bool,
    /// Something above the floor; nothing hides anything otherwise.
    occluders: bool,
    textured: bool,
    cutout: bool,
    emissive: bool,
    light: LightKind,
}

/// Nothing but diffuse surfaces.
const PLAIN: Needs = Needs {
    specular: false,
    occluders: false,
    textured: false,
    cutout: false,
    emissive: false,
    light: KINDS[0],
};

/// A floor and a wall that have just the properties requested, and a table if something is to be hidden.
fn scene(needs: Needs) -> Scene {
    let quad = |name: &str, corners: [[f32; 3]; 4], normal: [f32; 3], material| Mesh {
        name: name.to_owned(),
        positions: corners.to_vec(),
        normals: vec![normal; 4],
        uvs: vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]],
        indices: vec![0, 1, 2, 0, 2, 3],
        material,
        detail: sglow_scene::Detail::default(),
    };
    let mut floor = Material::diffuse("floor", [0.7, 0.5, 0.4]);
    let mut wall = Material::diffuse("wall", [0.3, 0.6, 0.8]);
    floor.double_sided = needs.occluders;
    wall.double_sided = needs.occluders;
    if needs.specular {
        floor.dielectric = 0.04;
        floor.roughness = 0.4;
        wall.metallic = 0.7;
        wall.roughness = 0.5;
    }
    if needs.textured {
        floor.base_color_texture = Some(TextureUse::repeating(0));
    }
    if needs.cutout {
        floor.alpha_cutoff = Some(0.5);
    }
    if needs.emissive {
        wall.emission = [0.5, 0.4, 0.1];
    }
    let checker = Image {
        name: "checker".to_owned(),
        width: 2,
        height: 2,
        rgba8: [[255, 255, 255, 255], [200, 80, 60, 40], [90, 220, 100, 20], [255, 250, 240, 255]]
            .concat(),
        srgb: true,
    };
    let table = quad(
        "table",
        [[-0.3, 0.3, 0.3], [0.3, 0.3, 0.3], [0.3, 0.3, -0.3], [-0.3, 0.3, -0.3]],
        [0.0, 1.0, 0.0],
        0,
    );
    let mut scene = Scene {
        name: "needs".to_owned(),
        origin: [0.0; 3],
        meshes: vec![
            quad(
                "floor",
                [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]],
                [0.0, 1.0, 0.0],
                0,
            ),
            quad(
                "wall",
                [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 2.0, -1.0], [-1.0, 2.0, -1.0]],
                [0.0, 0.0, 1.0],
                1,
            ),
        ],
        materials: vec![floor, wall],
        images: if needs.textured { vec![checker] } else { Vec::new() },
        lights: vec![Light {
            name: "light".to_owned(),
            kind: needs.light,
            position: [0.4, 1.7, 0.9],
            direction: glam::Vec3::new(-0.2, -1.0, -0.8).normalize().into(),
            intensity: [12.0, 11.0, 9.0],
            range: None,
            map_share: 1.0,
        }],
        camera: Camera::look_at([0.6, 1.1, 2.6], [0.0, 0.5, -0.4], [0.0, 1.0, 0.0], 0.9),
        notes: Vec::new(),
    };
    if needs.occluders {
        scene.meshes.push(table);
    }
    scene
}

fn every_need() -> Vec<Needs> {
    let mut all = Vec::new();
    for bits in 0..32 {
        let [specular, textured, cutout, emissive, occluders] =
            [1, 2, 4, 8, 16].map(|bit| bits & bit != 0);
        if !cutout || textured {
            all.push(Needs { specular, occluders, textured, cutout, emissive, ..PLAIN });
        }
    }
    for light in [KINDS[1], KINDS[2]] {
        all.push(Needs { light, ..PLAIN });
        all.push(Needs {
            specular: true,
            occluders: true,
            textured: true,
            cutout: true,
            emissive: true,
            light,
        });
    }
    all
}

#[test]
fn facts_are_those_of_the_scenes() {
    for needs in every_need() {
        let facts = scene(needs).facts();
        for (fact, holds) in [
            ("specular", needs.specular),
            ("occluders", needs.occluders),
            ("textured", needs.textured),
            ("cutout", needs.cutout),
            ("emissive", needs.emissive),
        ] {
            assert_eq!(facts.holds(fact), Some(holds), "{fact} of {needs:?}");
        }
    }
    // No fact is left out, and no other one is there.
    let known: BTreeSet<_> = library().fact.into_iter().map(|fact| fact.name).collect();
    let found: BTreeSet<_> = scene(PLAIN).facts().iter().map(|fact| fact.name.to_owned()).collect();
    assert_eq!(found, known);
}

fn base() -> Settings {
    Settings { size: [40, 30], map: 32, lights: 32, ..Settings::default() }
}

/// The settings after the needs of a scene, by the rules of the library.
fn pruned(scene: &Scene) -> Settings {
    let library = library();
    let needed = library.needed(&scene.facts().known()).unwrap();
    let mut settings = base();
    for axis in Settings::AXES.iter().copied() {
        if let [value] = needed[axis].values.as_slice() {
            settings.set(axis, value).unwrap();
        }
        for rule in needed[axis].because.iter().map(|because| &because.need) {
            let rule = library.need.iter().find(|need| need.name == *rule).unwrap();
            let assume = |(fact, &holds): (&String, &bool)| Assumption {
                rule: rule.name.clone(),
                fact: fact.clone(),
                holds,
            };
            settings.assumed.extend(rule.when.iter().map(assume));
        }
    }
    settings.assumed.sort();
    settings.assumed.dedup();
    settings
}

fn render(scene: &Scene, settings: &Settings, package: &Package) -> Frame {
    let renderer = Renderer::new(gpu(), package, scene, settings, 0).unwrap();
    renderer.render().unwrap();
    renderer.read().unwrap()
}

fn bits(pixels: &[[f32; 4]]) -> Vec<[u32; 4]> {
    pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

/// Where two frames differ in the bits of anything that both show.
fn difference(pruned: &Frame, complete: &Frame) -> Option<&'static str> {
    let pairs = [
        ("radiance", Some(&pruned.radiance), Some(&complete.radiance)),
        ("direct", Some(&pruned.direct), Some(&complete.direct)),
        ("indirect diffuse", pruned.indirect_diffuse.as_ref(), complete.indirect_diffuse.as_ref()),
        (
            "indirect specular",
            pruned.indirect_specular.as_ref(),
            complete.indirect_specular.as_ref(),
        ),
        ("emission", pruned.emission.as_ref(), complete.emission.as_ref()),
        ("position", Some(&pruned.gbuffer.position), Some(&complete.gbuffer.position)),
        ("normal", Some(&pruned.gbuffer.normal), Some(&complete.gbuffer.normal)),
        ("base colour", Some(&pruned.gbuffer.base_color), Some(&complete.gbuffer.base_color)),
    ];
    pairs.into_iter().find_map(|(name, pruned, complete)| {
        let complete = complete?;
        match pruned {
            Some(pruned) => (bits(pruned) != bits(complete)).then_some(name),
            // What is left out must have been nothing.
            None => complete.iter().any(|pixel| pixel[..3] != [0.0; 3]).then_some(name),
        }
    })
}

/// A package of just what is planned for a scene.
fn planned(scene: &Scene, settings: &Settings) -> Package {
    let light = sglow_renderer::light::kind(&scene.lights[0]);
    let settings = Settings { light, ..settings.clone() };
    let plan = plan(&settings, scene);
    package_of(&plan.variants)
}

#[test]
fn every_set_of_needs_renders_the_same_bits() {
    for needs in every_need() {
        let scene = scene(needs);
        for precision in Precision::ALL {
            let settings = Settings { precision, ..pruned(&scene) };
            // Another form of reflection is another picture: what is compared is what the same form renders.
            let specular = if needs.specular { settings.specular } else { base().specular };
            let complete = Settings { complete: true, precision, specular, ..base() };
            let what = format!("{needs:?}, {precision}");
            let package = planned(&scene, &settings);
            let pruned = render(&scene, &settings, &package);
            // All lengths of a mip dispatch are planned, and a size takes some of them.
            let requested = package.requested_variants();
            let planned = package.variants().map(str::to_owned);
            let planned = planned.filter(|id| requested.contains(id) || !id.starts_with("mip-"));
            assert_eq!(requested, planned.collect(), "{what}");
            let complete = render(&scene, &complete, whole_space());
            assert!(complete.radiance.iter().any(|pixel| pixel[0] > 0.0), "{what} renders black");
            assert_eq!(difference(&pruned, &complete), None, "{what}");
            assert_eq!(pruned.indirect_specular.is_some(), needs.specular, "{what}");
            assert_eq!(pruned.emission.is_some(), needs.emissive, "{what}");
            assert_eq!(settings.specular != Specular::None, needs.specular, "{what}");
        }
    }
}

#[test]
fn where_nothing_occludes_maps_of_the_lights_change_nothing_in_front_of_them() {
    // The light meets the floor alone, so that every virtual light has the floor's normal and the wall is in front.
    let lit_floor = |occluders| {
        let mut scene = scene(Needs { occluders, ..PLAIN });
        scene.lights[0].kind = LightKind::Spot { inner: 0.1, outer: 0.3 };
        scene.lights[0].position = [0.0, 1.5, 0.2];
        scene.lights[0].direction = [0.0, -1.0, 0.0];
        scene
    };
    for (occluders, changes) in [(false, false), (true, true)] {
        let scene = lit_floor(occluders);
        let settings = Settings { lights: 64, assumed: Vec::new(), ..pruned(&lit_floor(false)) };
        let without = render(&scene, &settings, whole_space());
        let visibility = Visibility::ShadowMap;
        let with = render(&scene, &Settings { visibility, ..settings }, whole_space());
        let [lit, map_lit] = [&without, &with].map(|frame| frame.indirect_diffuse.clone().unwrap());
        let normals = &without.gbuffer.normal;
        // Normals of the wall; the floor lies in the plane of every light, where maps cut the tails of lobes off.
        let wall = (0..lit.len()).filter(|&at| normals[at][2] > 0.5);
        let (mut seen, mut differ) = (0, 0);
        for at in wall {
            seen += usize::from(lit[at][0] > 0.0);
            differ += usize::from(bits(&lit[at..=at]) != bits(&map_lit[at..=at]));
        }
        assert!(seen > 100, "{seen}");
        assert_eq!(differ > 0, changes, "occluders: {occluders}");
    }
}

/// The names and sizes of everything that a device has memory for.
fn allocated(gpu: &Gpu) -> BTreeMap<String, u64> {
    let mut allocated = BTreeMap::new();
    let report = gpu.device.generate_allocator_report().unwrap();
    for allocation in report.allocations {
        *allocated.entry(allocation.name).or_default() += allocation.size;
    }
    allocated
}

#[test]
fn what_is_left_out_takes_no_memory_of_the_device_and_no_binding() {
    let scene = scene(PLAIN);
    let pruned = Settings { size: [200, 150], map: 128, ..pruned(&scene) };
    let full = Settings {
        complete: true,
        visibility: Visibility::ShadowMap,
        ..Settings { size: pruned.size, map: pruned.map, ..base() }
    };
    let left_out = ["specular", "emission", "light_maps"];
    let bindings = |package: &Package| {
        let names = |id: &String| sglow_shaders::variant(id).unwrap().binding_names.concat();
        package.requested_variants().iter().flat_map(names).collect::<BTreeSet<_>>()
    };
    let run = |settings: &Settings| {
        // A device of its own: nobody else's memory is in its report.
        let gpu = Gpu::open(None).unwrap();
        let package = whole_space().clone();
        let renderer = Renderer::new(&gpu, &package, &scene, settings, 0).unwrap();
        renderer.render().unwrap();
        let plan = plan(settings, &scene);
        (allocated(&gpu), bindings(&package), plan.bytes(Storage::Texture, &[]))
    };
    let [(few, few_bindings, few_planned), (all, all_bindings, all_planned)] =
        [&pruned, &full].map(run);
    for name in left_out {
        assert!(!few.contains_key(name), "{name} was made: {few:?}");
        // Negative control: the report shows it where it is made.
        assert!(all.contains_key(name), "{name} is not in the report: {all:?}");
    }
    // Three layers of moments instead of five.
    let (moments, all_moments) = (few["moments"], all["moments"]);
    assert!(10 * moments <= 7 * all_moments, "{moments} of {all_moments}");
    // The device has at least what was planned, and saves about as much as was foreseen.
    let total = |memory: &BTreeMap<String, u64>| memory.values().sum::<u64>();
    assert!(total(&few) >= few_planned && total(&all) >= all_planned);
    let (saved, foreseen) = (total(&all) - total(&few), all_planned - few_planned);
    assert!(10 * saved >= 9 * foreseen, "saved {saved}, foreseen {foreseen}");
    assert!(few_bindings.is_subset(&all_bindings));
    for name in [
        "sglow_specular_output",
        "sglow_indirect_specular_texture",
        "sglow_light_atlas",
        "sglow_emission_texture",
        "sglow_metallic_roughness_texture",
    ] {
        assert!(!few_bindings.contains(name) && all_bindings.contains(name), "{name}");
    }
}

/// What is said where a scene needs more.
fn refusal(package: &Package, settings: &Settings, scene: &Scene) -> Option<(bool, Vec<String>)> {
    match Renderer::new(gpu(), package, scene, settings, 0) {
        Ok(_) => None,
        Err(FrameError::NeedsMore { package, missing, .. }) => {
            Some((package, missing.into_iter().map(|need| need.fact).collect()))
        }
        Err(error) => panic!("{error}"),
    }
}

/// Scenes that need one thing more than the plain one, and the facts that say so.
fn one_more() -> [(&'static str, Needs); 7] {
    [
        ("specular", Needs { specular: true, ..PLAIN }),
        ("occluders", Needs { occluders: true, ..PLAIN }),
        ("textured", Needs { textured: true, ..PLAIN }),
        ("cutout", Needs { textured: true, cutout: true, ..PLAIN }),
        ("emissive", Needs { emissive: true, ..PLAIN }),
        ("directional_light", Needs { light: KINDS[1], ..PLAIN }),
        ("point_light", Needs { light: KINDS[2], ..PLAIN }),
    ]
}

#[test]
fn settings_that_were_derived_refuse_a_scene_that_needs_more() {
    let plain = scene(PLAIN);
    let settings = pruned(&plain);
    let refused = |settings: &Settings, needs| refusal(whole_space(), settings, &scene(needs));
    assert_eq!(refused(&settings, PLAIN), None);
    for (fact, needs) in one_more() {
        // Surfaces are drawn with what each of them needs, whatever the settings are.
        let of_surfaces = ["textured", "cutout", "emissive"].contains(&fact);
        let expected = (!of_surfaces).then(|| (false, vec![fact.to_owned()]));
        assert_eq!(refused(&settings, needs), expected, "{fact}");
        // Negative control: who chooses by hand is taken at his word.
        let by_hand = Settings { assumed: Vec::new(), ..settings.clone() };
        assert_eq!(refused(&by_hand, needs), None, "{fact}");
    }
    let all = Needs { specular: true, occluders: true, light: KINDS[2], ..PLAIN };
    let (_, mut facts) = refused(&settings, all).unwrap();
    facts.sort();
    assert_eq!(facts, ["occluders", "point_light", "specular"]);
}

#[test]
fn a_package_for_a_scene_refuses_one_that_needs_more_and_says_what_left_a_variant_out() {
    let plain = scene(PLAIN);
    let settings = Settings { assumed: Vec::new(), ..pruned(&plain) };
    let library = library();
    let needed = library.needed(&plain.facts().known()).unwrap();
    let facts = plain.facts();
    let rules: BTreeSet<_> =
        needed.values().flat_map(|allowed| &allowed.because).map(|rule| &rule.need).collect();
    let rules = || library.need.iter().filter(|need| rules.contains(&need.name));
    let assumed = rules().flat_map(|rule| {
        rule.when.iter().map(|(fact, &holds)| Assumed {
            fact: fact.clone(),
            holds,
            evidence: facts.get(fact).unwrap().evidence.clone(),
            rule: rule.name.clone(),
        })
    });
    let left_out = rules().map(|rule| LeftOut {
        rule: rule.name.clone(),
        reason: rule.reason.clone(),
        values: needed
            .iter()
            .filter_map(|(axis, allowed)| {
                let removed = allowed.because.iter().find(|because| because.need == rule.name)?;
                Some((axis.clone(), removed.removed.clone()))
            })
            .collect(),
        variants: Vec::new(),
        against: String::new(),
        saved: Saved::default(),
    });
    let purpose = Purpose {
        made_for: MadeFor {
            input: "needs".to_owned(),
            assumed: assumed.collect(),
            chosen: BTreeMap::new(),
            saved: Saved::default(),
        },
        left_out: left_out.collect(),
    };
    let plan = plan(&settings, &plain);
    let mut variants = library.variants();
    variants.retain(|variant| plan.variants.contains(&variant.id()));
    let folder = tempfile::tempdir().unwrap();
    let options =
        Options { variants: Some(variants), purpose: Some(purpose), ..Options::new(folder.path()) };
    let shaders = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders");
    generate(shaders.as_ref(), &options, &mut |_| ()).unwrap();
    let package = Package::load(folder.path()).unwrap();

    assert_eq!(refusal(&package, &settings, &plain), None);
    for (fact, needs) in one_more() {
        let (of_package, facts) = refusal(&package, &settings, &scene(needs)).unwrap();
        assert!(of_package && facts.contains(&fact.to_owned()), "{fact}: {facts:?}");
    }
    let specular = scene(Needs { specular: true, ..PLAIN });
    let error = Renderer::new(gpu(), &package, &specular, &settings, 0).err().unwrap().to_string();
    for part in
        ["needs", "`specular`", "no-specular-surface", "material `floor`", "gen-shaders --scene"]
    {
        assert!(error.contains(part), "{part}: {error}");
    }
    // A variant that is not there, and the rule that left it out.
    let missing = Settings { specular: Specular::Sg, ndf: sglow_shaders::Ndf::Ggx, ..settings };
    let error = Renderer::new(gpu(), &package, &plain, &missing, 0).err().unwrap().to_string();
    for part in [missing.shade().id().as_str(), "'no-specular-surface'", "specular sg"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    assert!(!error.contains("no-occluder"), "{error}");
    // A manifest of another format is not read as if it were of this one.
    let manifest = folder.path().join("manifest.json");
    let text = std::fs::read_to_string(&manifest).unwrap();
    let other = text.replacen("\"schema_version\": 7", "\"schema_version\": 6", 1);
    assert_ne!(text, other);
    // Whether the rest can be read as this format or not.
    for other in [other.as_str(), r#"{"schema_version": 6, "variants": [{"id": "mip"}]}"#] {
        std::fs::write(&manifest, other).unwrap();
        reseal(folder.path());
        let error = Package::load(folder.path()).unwrap_err()[0].to_string();
        for part in ["is of format 6", "reads format 7", "`cargo xtask gen-shaders`"] {
            assert!(error.contains(part), "{part}: {error}");
        }
    }
    // A key that nothing has is named with its variant.
    let (key, no_key) = ("\"sglow_shade_parameters\": {", "\"sglow_parameters\": {");
    let other = text.replacen(key, no_key, 1);
    assert_ne!(text, other);
    std::fs::write(&manifest, other).unwrap();
    reseal(folder.path());
    let error = Package::load(folder.path()).unwrap_err()[0].to_string();
    assert!(error.contains("'sglow_shade_parameters', which `shared` lacks"), "{error}");
}

#[test]
fn a_variant_that_prunes_too_much_is_noticed() {
    let needs = PLAIN;
    let scene = scene(needs);
    let settings = pruned(&scene);
    let complete = render(&scene, &Settings { complete: true, ..base() }, &Package::embedded());
    let package = broken(&settings.shade().id(), "reflected.diffuse *= surface.diffuse;", "");
    assert_eq!(difference(&render(&scene, &settings, &package), &complete), Some("radiance"));

    // A specular scene without its specular lobe.
    let scene = self::scene(Needs { specular: true, ..needs });
    let settings = Settings { assumed: Vec::new(), ..settings };
    let complete = render(&scene, &Settings { complete: true, ..base() }, &Package::embedded());
    assert!(difference(&render(&scene, &settings, &Package::embedded()), &complete).is_some());
}

//! Frames that are data against frames of today: the same bits in every output, times by the same names.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use sglow_graph::formula::evaluated;
use sglow_runtime::execute::Executor;
use sglow_runtime::frame::{Pixels, Renderer};
use sglow_runtime::package::Package;
use sglow_runtime::readback;
use sglow_runtime::timing::{Clock, Timer};

use super::list::{Case, list};
use super::package;
use crate::common::gpu;
use crate::execute::{Subject, buffer, submit};

/// What one frame came to: bytes by name.
type Outputs = BTreeMap<&'static str, Vec<u8>>;

fn texture(texture: &wgpu::Texture) -> Vec<u8> {
    bytemuck::cast_slice(&readback::texture(gpu(), texture, 0).unwrap()).to_vec()
}

fn expected(renderer: &Renderer<'_>) -> Outputs {
    let indirect = renderer.indirect();
    let pixels = |pixels: &Pixels| bytemuck::cast_slice(pixels).to_vec();
    let frame = renderer.read().unwrap();
    let rsm = renderer.read_rsm().unwrap();
    let mut outputs = Outputs::from([
        ("vsgls", buffer(indirect.vsgls())),
        ("density", texture(indirect.density())),
        ("rsm_position", pixels(&rsm.position)),
        ("rsm_normal", pixels(&rsm.normal)),
        ("rsm_base_color", pixels(&rsm.base_color)),
        ("gbuffer_position", pixels(&frame.gbuffer.position)),
        ("gbuffer_normal", pixels(&frame.gbuffer.normal)),
        ("gbuffer_base_color", pixels(&frame.gbuffer.base_color)),
        ("shadow_map", pixels(&renderer.read_shadow_map().unwrap())),
        ("direct", pixels(&frame.direct)),
        ("radiance", pixels(&frame.radiance)),
    ]);
    outputs.extend(indirect.chains().map(|chains| ("chains", buffer(chains))));
    outputs.extend(indirect.kernels().map(|kernels| ("kernels", buffer(kernels))));
    outputs.extend(indirect.camera_vsgls().map(|lights| ("camera_vsgls", buffer(lights))));
    outputs.extend(renderer.visibility().map(|maps| ("light_maps", texture(maps.atlas()))));
    let pictures = [
        ("diffuse", &frame.indirect_diffuse),
        ("specular", &frame.indirect_specular),
        ("emission", &frame.emission),
    ];
    for (name, picture) in pictures {
        outputs.extend(picture.as_ref().map(|picture| (name, pixels(picture))));
    }
    outputs
}

/// Whether a frame by the executor is that of the renderer, where the executor's package may be another one.
fn is_same(case: &Case, package: &Package, other: Package) -> bool {
    let subject = Subject::new(case.scene(), case.settled(), package.clone());
    let renderer = subject.renderer();
    renderer.render().unwrap();
    let frame = subject.frame(&renderer);
    let subject = Subject::new(case.scene(), case.settled(), other);
    let mut executor = subject.executor(&renderer, &frame);
    let (surfaces, emitters) = (renderer.raster().surfaces(), renderer.raster().emitters());
    let mut inputs = subject.inputs(&renderer);
    inputs.draws("surfaces", &surfaces).draws("emitters", &emitters);
    submit(|encoder| executor.encode(encoder, &inputs, None).unwrap());
    let expected = expected(&renderer);
    found(&executor, &expected) == expected
}

#[test]
fn other_bits_of_an_executed_frame_are_noticed() {
    let mut cases = list();
    cases.retain(|case| case.name == "base");
    let package = package(&cases);
    assert!(is_same(&cases[0], &package, package.clone()));
    // Some units in the last place.
    let (id, from) = ("shade-cosine-fitted-asg-ggx-both-f32-none", "diffuse *= surface.diffuse;");
    let text = package.text(id).unwrap();
    assert!(text.contains(from));
    let text = text.replace(from, "diffuse *= 1.000001 * surface.diffuse;");
    assert!(!is_same(&cases[0], &package, package.clone().with_text(id, text)));
}

fn found(executor: &Executor, names: &Outputs) -> Outputs {
    let read = |name: &&'static str| {
        let bytes = executor.buffer(name).map(buffer);
        (*name, bytes.or_else(|| executor.texture(name).map(texture)).unwrap_or_default())
    };
    names.keys().map(read).collect()
}

#[test]
fn frames_from_data_are_those_of_today() {
    let mut compared = BTreeMap::new();
    let cases = list();
    let package = package(&cases);
    for case in &cases {
        let package = package.clone();
        let subject = Subject::new(case.scene(), case.settled(), package);
        let mut renderer = subject.renderer();
        let frame = subject.frame(&renderer);
        let variants: BTreeSet<_> = frame.variants().into_iter().map(ToString::to_string).collect();
        let mut executor = subject.executor(&renderer, &frame);
        let mut made = None;
        for number in 0..case.frames {
            renderer.move_light(&case.light(number)).unwrap();
            let times = renderer.render().unwrap();
            let (surfaces, emitters) = (renderer.raster().surfaces(), renderer.raster().emitters());
            let mut inputs = subject.inputs(&renderer);
            inputs.draws("surfaces", &surfaces).draws("emitters", &emitters);
            let mut timer = Timer::with(gpu(), Clock::Wall);
            let formulas = evaluated();
            submit(|encoder| executor.encode(encoder, &inputs, Some(&mut timer)).unwrap());
            // What depends on the host's resources is bound in the first frame; then nothing is made any more.
            let now = executor.made();
            assert!(made.is_none_or(|made| made == now), "{}: {made:?}, {now:?}", case.name);
            assert_eq!(evaluated(), formulas, "{}", case.name);
            made = Some(now);

            // Neighbours of one name count as one; the camera's own are not all called so today; and a chain of one level,
            // which takes no dispatch, has no time.
            let single = case.settings.rsm_size == 1 || case.settings.size == [1, 1];
            let labels = |passes: Vec<(String, _)>| -> Vec<String> {
                let names = passes.into_iter().map(|pass: (String, Duration)| pass.0);
                let names = names.map(|name| name.trim_start_matches("camera ").to_owned());
                let mut names: Vec<_> =
                    names.filter(|name| !(single && name.starts_with("mip"))).collect();
                names.dedup();
                names
            };
            assert_eq!(labels(timer.finish().unwrap()), labels(times.passes), "{}", case.name);
            let expected = expected(&renderer);
            let found = found(&executor, &expected);
            for (name, expected) in &expected {
                let same = found[name] == *expected;
                assert!(same, "{}: {name} of frame {number} differs", case.name);
                *compared.entry(*name).or_insert(0) += 1;
            }
        }
        // The frame runs what the renderer does.
        let planned = case.variants();
        // The renderer has passes for chains of every length, for emission where nothing emits if it draws everything with
        // what can do everything, and the case may have some of its own.
        let others = ["mip-", "emission-", "check-", "metropolis"];
        let other = |id: &String| others.iter().any(|other| id.starts_with(other));
        assert!(variants.is_subset(&planned), "{}", case.name);
        assert!(planned.difference(&variants).all(other), "{}", case.name);
    }
    println!("{} configurations: {compared:#?}", cases.len());
}

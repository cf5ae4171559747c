//! Shading by a cut of the tree for each tile of pixels: `shaders/src/shade/tile.wesl`, `shaders/src/cut/nodes.wesl`.

use sglow_oracle::cut::LightTree;
use sglow_oracle::cut::estimate::SLACK;
use sglow_oracle::cut::tile::{self, Entry, How, SIDE};
use sglow_oracle::shade::{shade, shade_visible};
use sglow_oracle::surface::SurfaceTexel;
use sglow_oracle::visibility::{Maps, Seen, visible};
use sglow_oracle::vsgl::Vsgl;
use sglow_oracle::{Bounded, Vector3};
use sglow_renderer::frame::Renderer;
use sglow_renderer::reference::tree::TreeBuffers;
use sglow_renderer::stages::Stages as _;
use sglow_renderer::variants::Variants as _;
use sglow_renderer::{readback, reference};
use sglow_runtime::host;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_shaders::{Cut, Diffuse, Emitter, Lobes, Ndf, Precision, Space, Specular, Visibility};

use crate::common::{Comparison, KINDS, Run, broken, gpu, small, whole_space};

fn settings() -> Settings {
    Settings {
        space: Space::Tree,
        cut: Cut::Tile,
        emitter: Emitter::Disc,
        lights: 16,
        tolerance: 0.02,
        size: [20, 12],
        ..small()
    }
}

/// The tree, read back from the device.
fn tree_of(run: &Run) -> TreeBuffers {
    TreeBuffers::read(gpu(), &run.indirect).unwrap().unwrap()
}

/// Whether each node's children share its leaves between them, and the roots all leaves.
fn is_linked(read: &TreeBuffers) -> bool {
    let joined = |node: usize| {
        let [left, right] = read.children[node].map(|child| child as usize);
        if node >= read.places {
            return left == node && right == node;
        }
        let [[first, middle], [next, last]] = [left, right].map(|child| read.range(child));
        [first, last] == read.range(node) && middle == node && next == node + 1
    };
    let roots = read.roots[..read.roots.len() - 1].iter().filter(|&&root| root != u32::MAX);
    let mut ranges: Vec<_> = roots.map(|&root| read.range(root as usize)).collect();
    ranges.sort_unstable();
    let mut next = 0;
    for [first, last] in ranges {
        if first != next {
            return false;
        }
        next = last + 1;
    }
    next == read.leaves
        && read.all().all(joined)
        && read.range(*read.roots.last().unwrap() as usize) == [0, read.leaves - 1]
}

/// How far lights are from the means of their leaves: powers, positions, variances.
fn apart_from_leaves(read: &TreeBuffers) -> f64 {
    let mut worst = 0.0_f64;
    for node in read.all() {
        let [first, last] = read.range(node);
        let leaves = &read.lights[read.places + first..=read.places + last];
        let sum = |of: &dyn Fn(&Vsgl) -> Vector3| {
            leaves.iter().fold(Vector3::zero(), |sum, leaf| sum + of(leaf))
        };
        let weight = |leaf: &Vsgl| leaf.power().luminance();
        let light = &read.lights[node];
        let power = sum(&Vsgl::power);
        let mean = sum(&|leaf| leaf.position * weight(leaf)) * (1.0 / power.luminance());
        let squares = leaves
            .iter()
            .map(|leaf| weight(leaf) * (leaf.variance + (leaf.position - mean).length_squared()));
        let variance = squares.sum::<f64>() / power.luminance();
        let apart = [
            (light.power() - power).length() / power.length(),
            (light.position - mean).length(),
            light.variance / variance - 1.0,
        ];
        worst = apart.into_iter().map(f64::abs).fold(worst, f64::max);
    }
    worst
}

/// How far the corners of boxes are from those around the positions of their leaves, in parts of the whole box's widest
/// side.
fn boxes_apart(read: &TreeBuffers) -> f64 {
    let corners = |leaves: &[Vsgl]| {
        let of = |axis: usize, choose: fn(f64, f64) -> f64| {
            leaves.iter().map(|leaf| leaf.position.to_array()[axis]).reduce(choose).unwrap()
        };
        [0, 1, 2].map(|axis| [of(axis, f64::min), of(axis, f64::max)])
    };
    let whole = corners(&read.lights[read.places..read.places + read.leaves]);
    let widest = whole.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
    let mut worst = 0.0_f64;
    for node in read.all() {
        let [first, last] = read.range(node);
        let expected = corners(&read.lights[read.places + first..=read.places + last]);
        let at = read.lights[node].position.to_array();
        for (corner, bound) in read.bounds[node].map(Vector3::to_array).iter().enumerate() {
            for axis in 0..3 {
                worst = worst.max((at[axis] + bound[axis] - expected[axis][corner]).abs());
            }
        }
    }
    worst / widest
}

fn picture(run: &Run) -> Vec<[f64; 3]> {
    let mut sum = vec![[0.0; 3]; run.gbuffer.position.len()];
    for texture in [run.indirect.diffuse(), run.indirect.specular()].into_iter().flatten() {
        for (sum, texel) in sum.iter_mut().zip(readback::texture(gpu(), &texture, 0).unwrap()) {
            sum.iter_mut().zip(texel).for_each(|(sum, part)| *sum += f64::from(part));
        }
    }
    sum
}

/// Root mean square difference over the mean.
fn apart(one: &[[f64; 3]], other: &[[f64; 3]]) -> f64 {
    let pairs = || one.iter().flatten().zip(other.iter().flatten());
    let square = pairs().map(|(one, other)| (one - other).powi(2)).sum::<f64>();
    let count = pairs().count() as f64;
    (square / count).sqrt() / (pairs().map(|(_, other)| other).sum::<f64>() / count)
}

#[test]
fn nodes_are_linked_and_their_lights_are_those_of_their_leaves() {
    for lobes in Lobes::ALL {
        for (map, lights) in [(32, 16), (8, 1), (8, 300)] {
            let mut own = Settings { lobes, map, lights, ..settings() };
            if lobes == Lobes::Diffuse {
                (own.specular, own.ndf) = (Specular::None, Ndf::None);
            }
            let read = tree_of(&Run::new(&own, KINDS[0], whole_space(), 3));
            assert!(read.leaves > 20 && is_linked(&read), "{lobes} {map} {lights}");
            let off = apart_from_leaves(&read);
            println!("{lobes}, {map}, {lights} lights: off by {off:e}");
            // Thirty roundings of f32: sums in pairs of at most 2^10 leaves, then a coefficient and its integral.
            assert!(off < 15.0 * f64::from(f32::EPSILON), "{lobes} {map} {lights}: {off:e}");
            // Half a cell, of which the widest side has at least 2^14, since the grid may be four times as wide; and
            // roundings of f32.
            let off = boxes_apart(&read);
            assert!(off < 0.5 / 16384.0 + 1e-5, "{lobes} {map} {lights}: {off:e}");
        }
    }
    let breaks = [
        ("at <= parent, is_leaf", "at < parent, is_leaf"),
        ("branches[parent].right = id.x", "branches[parent].right = parent"),
        ("sglow_cut_sum(places, at + 1u, last + 1u)", "sglow_cut_sum(places, at + 1u, last)"),
        ("(first + high) * width", "(first + low) * width"),
    ];
    for (from, to) in breaks {
        let id = "cut_nodes-trace-exact-both-f32";
        let read = tree_of(&Run::new(&settings(), KINDS[0], &broken(id, from, to), 3));
        assert!(
            !is_linked(&read) || apart_from_leaves(&read) > 1e-2 || boxes_apart(&read) > 1e-2,
            "{from} as {to} goes unnoticed"
        );
    }
}

/// Without a tolerance there are all leaves, with an infinite one the lights of the global cut.
#[test]
fn tolerances_at_their_ends_are_all_leaves_and_the_global_cut() {
    for precision in Precision::ALL {
        let all = Settings { map: 20, lights: 400, precision, cut: Cut::None, ..settings() };
        let own = Settings { map: 20, precision, ..settings() };
        let of = |settings: &Settings| picture(&Run::new(settings, KINDS[0], whole_space(), 5));
        let all = of(&all);
        let few = of(&Settings { cut: Cut::None, ..own.clone() });
        let coarsest = of(&Settings { tolerance: 1e30, ..own.clone() });
        let finest = of(&Settings { tolerance: 0.0, ..own.clone() });
        let found = [apart(&coarsest, &few), apart(&finest, &all), apart(&few, &all)];
        println!("{precision}: {found:?}");
        assert!(found[0] < 2e-6 && found[1] < 2e-6 && found[2] > 0.05, "{found:?}");
    }
}

/// The lights' maps are those of the global cut, whose nodes' light they let through or not.
#[test]
fn maps_hide_what_is_below_their_lights() {
    let scene = sglow_scene::Scene::builtin("cornell").unwrap();
    let matt =
        Settings { lobes: Lobes::Diffuse, specular: Specular::None, ndf: Ndf::None, ..settings() };
    let shadows = Visibility::ShadowMap;
    // As many as there are leaves, each of which is its own map's place.
    let own = Settings { visibility: shadows, tolerance: 1e30, map: 20, lights: 400, ..matt };
    let of = |settings: &Settings| {
        let renderer = Renderer::new(gpu(), whole_space(), &scene, settings, 0).unwrap();
        renderer.render().unwrap();
        let diffuse = renderer.read().unwrap().indirect_diffuse.unwrap();
        diffuse.into_iter().map(|[r, g, b, _]| [r, g, b].map(f64::from)).collect::<Vec<_>>()
    };
    let cut = of(&own);
    let flat = of(&Settings { cut: Cut::None, ..own.clone() });
    let free = of(&Settings { visibility: Visibility::None, ..own });
    assert!(apart(&cut, &flat) < 1e-6, "{}", apart(&cut, &flat));
    assert!(apart(&cut, &free) > 1e-2, "light that is let through goes unnoticed");
}

/// Compares the lights of roots, each seen or not by the oracle through the device's maps, with the picture.
fn behind_maps(package: &Package) -> (Comparison, usize) {
    let scene = sglow_scene::Scene::builtin("cornell").unwrap();
    let settings = Settings {
        lobes: Lobes::Diffuse,
        specular: Specular::None,
        ndf: Ndf::None,
        visibility: Visibility::ShadowMap,
        tolerance: 1e30,
        map: 32,
        near_scale: 0.75,
        ..settings()
    };
    let renderer = Renderer::new(gpu(), package, &scene, &settings, 0).unwrap();
    renderer.render().unwrap();
    let indirect = renderer.indirect();
    let buffer = |name: &str| indirect.buffer(name).unwrap();
    let Settings { lobes, precision, tile, lights: count, near_scale, bias_scale, .. } =
        *indirect.settings();
    let lights = |name: &str| -> Vec<Vsgl<Bounded>> {
        reference::lights_of(gpu(), &buffer(name), lobes, precision).unwrap()
    };
    let (maps_of, nodes) = (lights("vsgls"), lights("cut_vsgls"));
    let roots: Vec<u32> = readback::buffer(gpu(), &buffer("roots")).unwrap();
    let atlas = readback::texture(gpu(), &indirect.light_maps().unwrap(), 0).unwrap();
    let atlas: Vec<f32> = atlas.into_iter().map(|texel| texel[0]).collect();
    let maps = Maps {
        tile: tile as usize,
        columns: 1 << count.next_power_of_two().ilog2().div_ceil(2),
        near_scale: near_scale.into(),
        least_near: renderer.inputs().light.least_near.into(),
        bias: host::bias(bias_scale, tile).into(),
    };
    let model = reference::model(indirect.settings());
    let eye = Vector3::constant(reference::vector(renderer.eye()));
    let surfaces: Vec<SurfaceTexel<Bounded>> = reference::texels(&renderer.read_gbuffer().unwrap());
    let found = renderer.read().unwrap().indirect_diffuse.unwrap();
    let (mut comparison, mut hidden) = (Comparison::default(), 0);
    for (index, (surface, [r, g, b, _])) in surfaces.iter().zip(found).enumerate() {
        if !surface.present {
            continue;
        }
        let of_roots =
            roots[..count as usize].iter().enumerate().filter(|(_, node)| **node != u32::MAX);
        let seen: Vec<(Vsgl<Bounded>, Seen)> = of_roots
            .map(|(root, &node)| {
                let map = &maps_of[root];
                let seen = visible(root, map, surface.position, surface.normal, &maps, &atlas);
                hidden += usize::from(seen == Seen::No);
                (nodes[node as usize], seen)
            })
            .collect();
        let expected = shade_visible(surface, eye, seen, &model).diffuse;
        comparison.vector(&format!("pixel {index}"), [r, g, b], expected);
    }
    (comparison, hidden)
}

#[test]
fn roots_are_seen_through_their_own_maps() {
    let (comparison, hidden) = behind_maps(whole_space());
    comparison.assert_holds("roots behind maps");
    assert!(hidden > 100, "{hidden} hidden");
    let settings = Settings {
        lobes: Lobes::Diffuse,
        specular: Specular::None,
        ndf: Ndf::None,
        visibility: Visibility::ShadowMap,
        ..settings()
    };
    let id = settings.shade().id();
    let breaks = [
        // Seen from the mean of the node, and through another's map.
        (
            "sglow_reaches(root, sglow_vsgl(root), point",
            "sglow_reaches(root, sglow_cut_vsgl(node.node), point",
        ),
        (
            "sglow_reaches(root, sglow_vsgl(root), point",
            "sglow_reaches(root ^ 1u, sglow_vsgl(root), point",
        ),
    ];
    for (from, to) in breaks {
        behind_maps(&broken(&id, from, to)).0.assert_fails(to);
    }
}

/// A root's map is seen from the leaf nearest to the mean of its leaves.
#[test]
fn maps_are_seen_from_leaves() {
    let run = Run::new(&settings(), KINDS[0], whole_space(), 5);
    let Settings { lobes, precision, .. } = *run.indirect.settings();
    let vsgls = run.indirect.buffer("vsgls").unwrap();
    let seen = reference::lights_of(gpu(), &vsgls, lobes, precision).unwrap();
    let read = tree_of(&run);
    let mut moved = 0;
    for (light, &root) in seen.iter().zip(&read.roots) {
        let [first, last] = read.range(root as usize);
        let mean = read.lights[root as usize].position;
        let leaves = &read.lights[read.places + first..=read.places + last];
        let nearest = leaves.iter().map(|leaf| (leaf.position - mean).length());
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        assert!(leaves.iter().any(|leaf| (leaf.position - light.position).length() < 1e-6));
        assert!(((light.position - mean).length() - nearest).abs() < 1e-6, "root {root}");
        moved += usize::from(nearest > 1e-3);
    }
    assert!(moved > 0, "every mean is a leaf's");
}

/// Compares the picture with that of the oracle's cut through the device's tree.
fn compare(run: &Run) -> (Comparison, usize) {
    let settings = run.indirect.settings();
    let tree = tree_of(run).tree();
    let model = reference::model(settings);
    let eye = reference::vector(run.eye);
    let surfaces: Vec<SurfaceTexel> = reference::texels(&run.gbuffer);
    let how = How { tolerance: settings.tolerance.into(), slack: SLACK, model: &model, eye };
    let size = settings.size.map(|side| side as usize);
    let read = |texture: Option<wgpu::Texture>| {
        texture.map(|texture| readback::texture(gpu(), &texture, 0).unwrap())
    };
    let found = [read(run.indirect.diffuse()), read(run.indirect.specular())];
    let mut comparison = Comparison::default();
    let mut nodes = 0;
    for y in 0..size[1].div_ceil(SIDE) {
        for x in 0..size[0].div_ceil(SIDE) {
            let at = tile::voters([x, y], size, &|pixel| surfaces[pixel].present);
            let votes = at.map(|pixel| surfaces[pixel]);
            let entries = tile::list(&tree, &votes, &how);
            nodes += entries.len();
            for at in 0..SIDE * SIDE {
                let at = [at % SIDE, at / SIDE];
                let [column, row] = [SIDE * x + at[0], SIDE * y + at[1]];
                if column >= size[0] || row >= size[1] {
                    continue;
                }
                let pixel = row * size[0] + column;
                let shares = tile::shares(at, &surfaces[pixel], &votes);
                let expected = expected(&tree, &entries, &shares, &surfaces[pixel], &how);
                for ((name, found), expected) in
                    ["diffuse", "specular"].into_iter().zip(&found).zip(expected)
                {
                    let Some(found) = found else { continue };
                    let [r, g, b, _] = found[pixel];
                    comparison.vector(&format!("{name} of pixel {pixel}"), [r, g, b], expected);
                }
            }
        }
    }
    (comparison, nodes)
}

/// Diffuse and specular reflection of a pixel. A vote is a whole number of 255 parts, which rounding may shift by one where it
/// is between two: the error has as much of what each node and its children differ by.
fn expected(
    tree: &LightTree,
    entries: &[Entry],
    shares: &[f64; 6],
    surface: &SurfaceTexel,
    how: &How<'_>,
) -> [Vector3<Bounded>; 2] {
    let mut sums = [Vector3::zero(), Vector3::zero()];
    let mut steps = [Vector3::zero(), Vector3::zero()];
    let exact = |node: usize| {
        let found = shade(surface, how.eye, core::iter::once(tree.lights[node]), how.model);
        [found.diffuse, found.specular]
    };
    for entry in entries {
        let own = exact(entry.node);
        let children = tree.branches[entry.node].children.map(|children| children.map(exact));
        for part in 0..2 {
            sums[part] = sums[part] + own[part] * entry.weight(shares);
            if let Some([one, other]) = children.as_ref().filter(|_| entry.blends()) {
                let step = (own[part] - one[part] - other[part]) * (1.0 / 255.0);
                steps[part] = steps[part] + step.map(f64::abs);
            }
        }
    }
    [0, 1].map(|part| {
        let [value, step] = [sums[part].to_array(), steps[part].to_array()];
        // Shading itself is compared elsewhere, with bounds of its own: here to two parts in ten thousand.
        let of = |at: usize| Bounded::with_error(value[at], step[at] + 2e-4 * value[at] + 1e-12);
        Vector3::new(of(0), of(1), of(2))
    })
}

#[test]
fn agrees_with_the_oracle() {
    let mut all = Vec::new();
    for lobes in Lobes::ALL {
        for specular in [Specular::None, Specular::Asg, Specular::NdfFiltered] {
            let ndf = if specular == Specular::None { Ndf::None } else { Ndf::Ggx };
            all.push(Settings { lobes, specular, ndf, ..settings() });
        }
    }
    all.push(Settings { diffuse: Diffuse::None, ..settings() });
    all.extend(Emitter::ALL.map(|emitter| Settings { emitter, ..settings() }));
    all.push(Settings { precision: Precision::F16, ..settings() });
    all.push(Settings { lights: 3, tolerance: 0.2, ..settings() });
    all.push(crowded(16));
    for settings in all {
        let run = Run::new(&settings, KINDS[0], whole_space(), 7);
        let (comparison, nodes) = compare(&run);
        println!("{nodes} nodes");
        comparison.assert_holds(&settings.shade().id());
    }
}

/// A cut through more leaves than a list has room for.
fn crowded(lights: u32) -> Settings {
    Settings { tolerance: 1e-4, map: 64, lights, ..settings() }
}

/// Nodes that have no room are not refined, and their light stays. With 1024 roots the queue moves.
#[test]
fn a_full_list_loses_no_light() {
    let settings = crowded(tile::MAX_ROOTS as u32);
    let id = settings.shade().id();
    let (comparison, nodes) = compare(&Run::new(&settings, KINDS[0], whole_space(), 7));
    comparison.assert_holds(&id);
    assert!(nodes > 3 * tile::NODES, "no list is full: {nodes}");
    for (from, to) in [
        ("kept |= refined & ~first;", ""),
        ("sglow_tile_nodes[start + moved + lane] = node", "sglow_tile_nodes[start + moved] = node"),
    ] {
        let run = Run::new(&settings, KINDS[0], &broken(&id, from, to), 7);
        compare(&run).0.assert_fails(&format!("{from} as {to}"));
    }
}

#[test]
fn a_broken_shader_is_noticed() {
    let id = settings().shade().id();
    let breaks = [
        ("inverse + branch.spread, 1.0", "inverse, 0.5"),
        ("* inverseSqrt(1.0 + extent)", "* inverseSqrt(1.0 + 4.0 * extent)"),
        ("clamp(-offset, branch.low, branch.high)", "vec3<f32>(0.0)"),
        ("vote < SGLOW_TILE_VOTES", "vote < 2u"),
        ("step * step * (3.0 - 2.0 * step)", "step"),
        ("node.corners - corners,", "node.corners,"),
        ("vec4<u32>(0u, 8u, 16u, 24u)", "vec4<u32>(8u, 0u, 16u, 24u)"),
        ("branch.left, corners, passed", "branch.right, corners, passed"),
    ];
    for (from, to) in breaks {
        let run = Run::new(&settings(), KINDS[0], &broken(&id, from, to), 7);
        compare(&run).0.assert_fails(&format!("{from} as {to}"));
    }
}

#[test]
fn a_picture_is_the_same_from_run_to_run() {
    let of = || {
        let run = Run::new(&settings(), KINDS[0], whole_space(), 9);
        picture(&run).into_iter().flatten().map(f64::to_bits).collect::<Vec<_>>()
    };
    assert_eq!(of(), of());
}

#[test]
fn a_map_without_power_lights_nothing_and_one_texel_is_one_light() {
    let mut none = Run::new(&settings(), KINDS[0], &Package::embedded(), 9);
    none.light.uniform.intensity = [0.0; 3];
    let redone = |run: &Run| {
        let Settings { map, size, .. } = *run.indirect.settings();
        let rsm = crate::common::Uploaded::new(&run.rsm, [map; 2]);
        let gbuffer = crate::common::Uploaded::new(&run.gbuffer, size);
        let inputs = sglow_runtime::indirect::Inputs {
            rsm: rsm.views(),
            gbuffer: gbuffer.views(),
            light: &run.light,
            eye: run.eye,
        };
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        run.indirect.encode(&mut encoder, &inputs, None).unwrap();
        gpu().queue.submit([encoder.finish()]);
        gpu().finish().unwrap();
        picture(run)
    };
    assert!(redone(&none).iter().flatten().all(|part| *part == 0.0));
    let mut one = Run::new(&settings(), KINDS[0], &Package::embedded(), 9);
    // The middle of the map, where a spot is bright.
    let lit = (16 * 32 + 16..).find(|&at| one.rsm.position[at][3] >= 0.0).unwrap();
    for (at, position) in one.rsm.position.iter_mut().enumerate() {
        position[3] = if at == lit { position[3] } else { -1.0 };
    }
    let found = redone(&one);
    assert!(found.iter().flatten().all(|part| part.is_finite() && *part >= 0.0));
    assert!(found.iter().flatten().any(|part| *part > 0.0), "one texel lights nothing");
    compare(&one).0.assert_holds("one texel");
}

#[test]
fn settings_that_cannot_be_are_named() {
    let error = |settings: Settings| {
        sglow_runtime::indirect::Indirect::of_parts(
            gpu().source(whole_space()),
            &settings,
            &sglow_runtime::indirect::PARTS,
            &sglow_runtime::occluders::Occluders::default(),
        )
        .err()
        .map(|error| error.to_string())
        .unwrap_or_default()
    };
    assert_eq!(error(settings()), "");
    let many = error(Settings { lights: 1500, ..settings() });
    assert!(many.contains("lights: at most 1024"), "{many}");
    let space = error(Settings { space: Space::None, ..settings() });
    assert!(space.contains("cut: none without a tree"), "{space}");
    assert!(!error(Settings { tolerance: -1.0, ..settings() }).is_empty());
}

//! The cut against constructions that share no code with it, on degenerate maps, and its error beside kernels'.

use core::ops::Range;

use super::global::{DIRECTIONS, cost, cut_by, effective, ranges};
use super::key::{Grid, Key};
use super::room::Room;
use super::*;
use crate::cluster::Map;
use crate::fis::stress::Random;
use crate::metrics::Metrics;
use crate::rsm::{Emission, Lobes, SpecularPower};
use crate::scenery::{diffuse, glossy, texel};
use crate::shade::Emitter;
use crate::surface::SurfaceTexel;
use crate::{Bounded, Real, Vector3};

/// Power of the diffuse and of the specular lobes of all lights.
fn power(lights: &[crate::vsgl::Vsgl]) -> Vector3 {
    lights.iter().fold(Vector3::zero(), |sum, light| sum + light.power())
}

/// The power of the photon of a texel.
fn power_at(map: &Map<'_, f64>, texel: [usize; 2]) -> Vector3 {
    map.light
        .at(texel, map.size)
        .map_or(Vector3::zero(), |of| of.light.photon_power(of.texel, of.size))
}

/// The power that a map's texels reflect, one by one.
fn power_of_map(map: &Map<'_, f64>) -> Vector3 {
    let of = |(index, surface): (usize, &SurfaceTexel)| {
        if !surface.present {
            return Vector3::zero();
        }
        let at = [index % map.size[0], index / map.size[0]];
        let reflectance = match map.emission.lobes {
            Lobes::Diffuse => surface.material.diffuse,
            Lobes::Both => surface.material.diffuse + surface.material.specular,
        };
        power_at(map, at).times(reflectance)
    };
    map.texels.iter().enumerate().map(of).fold(Vector3::zero(), |sum, power| sum + power)
}

/// Each leaf is in one node, and each lit texel is a leaf.
fn is_partition(cut: &Cut, lit: usize) -> bool {
    let mut texels = cut.texels.clone();
    texels.sort_unstable();
    texels.dedup();
    let mut next = 0;
    for node in &cut.nodes {
        if node.start != next || node.end <= node.start {
            return false;
        }
        next = node.end;
    }
    texels.len() == lit && cut.texels.len() == lit && next == lit
}

fn lit_texels(map: &Map<'_, f64>) -> usize {
    let of = |index: &usize| {
        let at = [index % map.size[0], index / map.size[0]];
        map.texels[*index].present && power_at(map, at).luminance() > 1e-30
    };
    (0..map.texels.len()).filter(of).count()
}

#[test]
fn a_cut_is_a_partition_that_keeps_the_power() {
    for room in [Room::boxes(64), Room::columns(64)] {
        let map = room.map();
        let (whole, lit) = (power_of_map(&map), lit_texels(&map));
        for count in [1, 2, 3, 64, 1000, 5000] {
            let cut = cut(&map, count);
            assert_eq!(cut.nodes.len(), count.min(lit));
            assert!(is_partition(&cut, lit));
            let lights = lights(&map, count);
            assert_eq!(lights.len(), count);
            let apart = (power(&lights) - whole).length() / whole.length();
            assert!(apart < 1e-12, "{count} lights: {apart:e}");
        }
        // Negative controls: a node less, and a node twice.
        let lights = lights(&map, 64);
        assert!((power(&lights[1..]) - whole).length() > 1e-4 * whole.length());
        let mut broken = cut(&map, 64);
        broken.nodes.remove(5);
        assert!(!is_partition(&broken, lit));
    }
}

/// A tree of lists of texels, split from the top by looking at every key, with moments of two passes over each list.
struct Plain {
    leaves: Vec<usize>,
    first: usize,
    level: u32,
    cost: f64,
    children: Vec<Plain>,
}

struct PlainTexel {
    weight: f64,
    position: Vector3,
    normal: Vector3,
    variance: f64,
}

/// Mean, variance and length of the mean normal.
fn plain_moments(texels: &[PlainTexel], leaves: &[usize]) -> (f64, f64, f64) {
    let weight: f64 = leaves.iter().map(|&leaf| texels[leaf].weight).sum();
    let mean = |of: &dyn Fn(&PlainTexel) -> Vector3| {
        let sum = leaves.iter().map(|&leaf| of(&texels[leaf]) * texels[leaf].weight);
        sum.fold(Vector3::zero(), |sum, part| sum + part) * (1.0 / weight)
    };
    let position = mean(&|texel| texel.position);
    let squares = leaves.iter().map(|&leaf| {
        let texel = &texels[leaf];
        texel.weight * ((texel.position - position).length_squared() + texel.variance)
    });
    (weight, squares.sum::<f64>() / weight, mean(&|texel| texel.normal).length())
}

fn plain(
    texels: &[PlainTexel],
    keys: &[u64],
    leaves: Vec<usize>,
    first: usize,
    all: (f64, f64),
) -> Plain {
    let (weight, variance, coherence) = plain_moments(texels, &leaves);
    let share = weight / all.0;
    let cost = share * (variance / all.1 + 0.2 * (1.0 - coherence * coherence));
    let mut node = Plain { leaves, first, level: 64, cost, children: Vec::new() };
    for bit in (0..64).rev() {
        let (zeros, ones): (Vec<usize>, Vec<usize>) =
            node.leaves.iter().partition(|&&leaf| keys[leaf] >> bit & 1 == 0);
        if !zeros.is_empty() && !ones.is_empty() {
            node.level = 63 - bit;
            let second = first + zeros.len();
            node.children = vec![
                plain(texels, keys, zeros, first, all),
                plain(texels, keys, ones, second, all),
            ];
            break;
        }
    }
    node
}

/// Refines the node of the greatest cost until there are `count`; the costs in the order of the refinements.
fn greedy(root: &Plain, count: usize) -> (Vec<Range<usize>>, Vec<f64>) {
    let (mut nodes, mut costs) = (vec![root], Vec::new());
    while nodes.len() < count {
        let inner = (0..nodes.len()).filter(|&at| !nodes[at].children.is_empty());
        let Some(chosen) = inner.max_by(|&a, &b| {
            let order = nodes[a].cost.total_cmp(&nodes[b].cost);
            order.then(nodes[b].level.cmp(&nodes[a].level))
        }) else {
            break;
        };
        let node = nodes.swap_remove(chosen);
        costs.push(if nodes.is_empty() { f64::INFINITY } else { node.cost });
        nodes.extend(&node.children);
    }
    let mut ranges: Vec<Range<usize>> =
        nodes.iter().map(|node| node.first..node.first + node.leaves.len()).collect();
    ranges.sort_by_key(|range| range.start);
    (ranges, costs)
}

/// Where the next refinement is cheaper than all before it, the cut of the threshold is the greedy one; with a heap or
/// without.
#[test]
fn is_the_greedy_refinement() {
    for room in [Room::boxes(32), Room::columns(32)] {
        let map = room.map();
        let cut_of_all = cut(&map, 1);
        let texels: Vec<PlainTexel> = cut_of_all
            .texels
            .iter()
            .map(|&index| {
                let at = [index % map.size[0], index / map.size[0]];
                let surface = map.texels[index];
                let light = map.light.at(at, map.size).unwrap().light;
                let (towards, squared) = light.towards(surface.position);
                let area = light.footprint(at, map.size, squared, towards.dot(surface.normal));
                let power = power_at(&map, at);
                PlainTexel {
                    weight: power.times(surface.material.diffuse).luminance(),
                    position: surface.position,
                    normal: surface.normal,
                    variance: 2.0 * area / 12.0,
                }
            })
            .collect();
        let low = [0, 1, 2].map(|axis| {
            let parts =
                texels.iter().map(|texel| (texel.position - map.origin).to_array()[axis] as f32);
            parts.fold(f32::INFINITY, f32::min)
        });
        let high = [0, 1, 2].map(|axis| {
            let parts =
                texels.iter().map(|texel| (texel.position - map.origin).to_array()[axis] as f32);
            parts.fold(f32::NEG_INFINITY, f32::max)
        });
        let grid = Grid::around(low, high);
        let keys: Vec<u64> = (0..)
            .zip(&texels)
            .map(|(at, texel): (u64, &PlainTexel)| {
                u64::from(Key::of::<f64>(texel.position - map.origin, texel.normal, &grid).key)
                    << 32
                    | at
            })
            .collect();
        assert!(keys.is_sorted(), "the leaves are in the order of their keys");
        let all: Vec<usize> = (0..texels.len()).collect();
        let (weight, variance, _) = plain_moments(&texels, &all);
        let root = plain(&texels, &keys, all, 0, (weight, variance));
        let (_, costs) = greedy(&root, texels.len());
        let mut compared = 0;
        let mut least = f64::INFINITY;
        for count in 1..costs.len().min(600) {
            // The next refinement is that of a cost that is clearly lower.
            let next = costs[count - 1];
            let lower = next < least * (1.0 - 1e-4);
            least = least.min(next);
            if !lower {
                continue;
            }
            assert_eq!(cut(&map, count).nodes, greedy(&root, count).0, "{count} nodes");
            compared += 1;
        }
        println!("{compared} cuts compared");
        assert!(compared > 30, "{compared}");
    }
}

/// Whatever the costs are, a parent is refined before its children.
#[test]
fn every_cut_of_any_costs_is_one_of_the_tree() {
    let mut random = Random::new(5);
    for case in 0..200 {
        let length = 2 + random.bits() as usize % 60;
        let mut keys: Vec<u32> = (0..length).map(|_| random.bits() >> (case % 32)).collect();
        keys.sort_unstable();
        let tree = Tree::of_keys(&keys);
        let costs: Vec<f32> = (0..length - 1)
            .map(|_| [0.0, 1e-45, 1.0, 1.000001, 3e38][random.bits() as usize % 5])
            .collect();
        let effective = effective(&tree, &costs);
        for count in 1..=length + 2 {
            let ranges = ranges(&tree, &effective, count);
            assert_eq!(ranges.len(), count.min(length));
            let node = |range: &Range<usize>| {
                range.len() == 1 || tree.nodes.iter().any(|node| node.leaves == *range)
            };
            assert!(ranges.iter().all(node), "{ranges:?}");
        }
        // Negative control: costs themselves do not keep parents before children.
        if case == 7 {
            let broken = (1..length).any(|count| {
                let ranges = ranges(&tree, &costs, count);
                let node = |range: &Range<usize>| {
                    range.len() == 1 || tree.nodes.iter().any(|node| node.leaves == *range)
                };
                !ranges.iter().all(node)
            });
            assert!(broken, "costs that do not fall go unnoticed");
        }
    }
}

/// Without specular lobes a node costs more than both its children together: sums of squares about means.
#[test]
fn costs_fall_from_a_node_to_its_children() {
    for room in [Room::boxes(32), Room::columns(32)] {
        let sums = cut(&room.map(), 1).sums;
        for block in 1..sums.blocks().len() / 2 {
            let of = |block: usize| cost(&sums.blocks()[block], &sums.all(), DIRECTIONS);
            let children = of(2 * block) + of(2 * block + 1);
            assert!(children <= of(block) * (1.0 + 1e-9), "{block}: {children} {}", of(block));
        }
    }
}

/// A map of texels that are given.
fn map_of<'a, R: Real>(
    texels: &'a [SurfaceTexel<R>],
    size: [usize; 2],
    light: &'a crate::light::Light,
) -> Map<'a, R> {
    Map {
        texels,
        size,
        light: light.into(),
        origin: Vector3::zero(),
        minimum_variance: sum::LEAST_VARIANCE,
        emission: Emission::of_normals(Lobes::Both),
        specular_power: SpecularPower::F0,
    }
}

#[test]
fn degenerate_maps_have_lights() {
    let up = Vector3::new(0.0, 0.0, 1.0);
    let light =
        crate::scenery::light(crate::light::LightKind::Directional { half_extent: 1.0 }, up * 3.0);
    let strong = crate::light::Light { intensity: Vector3::splat(1e15), ..light };
    let plane = |x: usize, y: usize| Vector3::new(x as f64, y as f64, 0.0) * 0.25;
    type At = dyn Fn(usize, usize) -> Vector3;
    let cases: [(&str, &At, Vector3, bool, &crate::light::Light); 6] = [
        ("a plane", &plane, Vector3::zero(), true, &light),
        ("one place", &|_, _| Vector3::splat(0.5), Vector3::zero(), true, &light),
        ("one texel", &plane, Vector3::zero(), false, &light),
        ("power over 1e12", &plane, Vector3::zero(), true, &strong),
        ("far away", &plane, Vector3::splat(1e6), true, &light),
        ("a line", &|x, _| Vector3::new(x as f64, 0.0, 0.0), Vector3::zero(), true, &light),
    ];
    for (name, at, offset, all, light) in cases {
        let texels: Vec<SurfaceTexel> = (0..64)
            .map(|index| {
                let mut texel = texel(at(index % 8, index / 8) + offset, up, glossy(0.1, 0.3));
                texel.present = all || index == 37;
                texel
            })
            .collect();
        let map = Map { origin: offset, ..map_of(&texels, [8, 8], light) };
        let lit = if all { 64 } else { 1 };
        for count in [1, 7, 64, 100] {
            assert!(is_partition(&cut(&map, count), lit), "{name}");
            let lights = lights(&map, count);
            let whole = power_of_map(&map);
            assert!((power(&lights) - whole).length() < 1e-9 * whole.length(), "{name}");
            for light in &lights {
                let numbers = light
                    .position
                    .to_array()
                    .into_iter()
                    .chain([light.variance, light.diffuse.sharpness]);
                assert!(
                    numbers.into_iter().all(f64::is_finite) && light.variance > 0.0,
                    "{name}: {light:?}"
                );
            }
        }
        // A cut of the plane is one of squares: the variance falls with the number of lights.
        if name == "a plane" {
            let worst =
                |count| lights(&map, count).iter().map(|light| light.variance).fold(0.0, f64::max);
            assert!(worst(16) < 0.1 * worst(1), "{} {}", worst(16), worst(1));
        }
    }
    let dark = vec![SurfaceTexel { present: false, ..texel(up, up, diffuse(0.5)) }; 64];
    let map = map_of(&dark, [8, 8], &light);
    assert_eq!(cut(&map, 10).nodes, []);
    assert!(
        lights(&map, 10)
            .iter()
            .all(|light| light.power() == Vector3::zero() && light.variance > 0.0)
    );
    // Not finite: left out, and the rest stays.
    let mut odd = vec![texel(plane(1, 1), up, diffuse(0.5)); 64];
    odd[5].position.x = f64::NAN;
    odd[6].position.y = f64::INFINITY;
    odd[7].normal.z = f64::NAN;
    let map = map_of(&odd, [8, 8], &light);
    let cut = cut(&map, 3);
    assert!(is_partition(&cut, 61));
    assert!(power(&lights(&map, 3)).length().is_finite());
}

/// The cost of a node that is one place with one normal is that of its texels' own extent; spreads of positions, normals
/// and reflections each raise it.
#[test]
fn what_is_spread_costs() {
    let leaf = |mean: Vector3, normal: Vector3, axis: Vector3| CentralMoments {
        weight: 1.0,
        mean,
        variance: 0.0,
        diffuse_power: Vector3::splat(0.5),
        diffuse_direction: normal * 0.5,
        diffuse_weight: 0.5,
        specular_power: Vector3::splat(0.5),
        specular_direction: axis * 0.2,
        specular_length: 0.2,
        bounds: [mean; 2],
    };
    let [x, y] = [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0)];
    let all = leaf(x, x, x).merged(leaf(-x, y, y));
    let of = |other: CentralMoments| cost(&leaf(x, x, x).merged(other), &all, 0.2);
    assert!(of(leaf(x, x, x)).abs() < 1e-15);
    assert!((of(leaf(-x, x, x)) - 1.0).abs() < 1e-12);
    // At right angles the mean length is squared a half, of half of the power each.
    assert!((of(leaf(x, y, x)) - 0.2 * 0.25).abs() < 1e-12);
    assert!((of(leaf(x, x, y)) - 0.2 * 0.25).abs() < 1e-12);
    assert!((of(leaf(x, y, y)) - 0.2 * 0.5).abs() < 1e-12);
    assert_eq!(cost::<f64>(&CentralMoments::nothing(), &CentralMoments::nothing(), 0.2), 0.0);
}

#[test]
fn tolerances_are_useful() {
    let room = Room::boxes(32);
    let texels: Vec<SurfaceTexel<Bounded>> = room
        .texels
        .iter()
        .map(|surface| {
            let vector = |vector: Vector3| Vector3::<Bounded>::constant(vector);
            let material = crate::brdf::Material {
                diffuse: vector(surface.material.diffuse),
                specular: vector(surface.material.specular),
                alpha: Bounded::constant(surface.material.alpha),
            };
            SurfaceTexel {
                position: vector(surface.position),
                normal: vector(surface.normal),
                material,
                present: surface.present,
            }
        })
        .collect();
    let map = room.map();
    let map = Map {
        texels: &texels,
        size: map.size,
        light: map.light,
        origin: map.origin,
        minimum_variance: map.minimum_variance,
        emission: map.emission,
        specular_power: map.specular_power,
    };
    for light in lights(&map, 64) {
        let loose = light.variance.error / light.variance.value;
        assert!(loose < 1e-3, "variance {:?}", light.variance);
        let position = light.position.x;
        assert!(position.error < 1e-3, "position {position:?}");
    }
}

fn show(name: &str, count: usize, metrics: &Metrics) {
    println!(
        "{name:24} {count:5}: RMSE {:6.2} %  relative MSE {:8.5}  median {:6.2} %  95 % {:6.2} %  bias {:6.2} %",
        100.0 * metrics.rmse_over_mean().value,
        metrics.relative_mse.value,
        100.0 * metrics.median.value,
        100.0 * metrics.quantile_95.value,
        100.0 * metrics.bias.value
    );
}

/// A cut with discs over kernels at their best K with cosines; mean of three places of the grid in the room.
///
/// The room of columns has 86 surfaces. With 64 and 256 lights some are of two surfaces that face each other, and the few
/// receivers between these, which are dark, get several times their light: there the relative MSE is not below that of
/// kernels, which are broad. All other errors are.
#[test]
fn a_cut_of_discs_is_better_than_kernels() {
    let mut failed = Vec::new();
    let mut check = |name: String, ratio: f64, most: f64| {
        println!("{name}: {ratio:.3} of kernels', at most {most}");
        if ratio >= most {
            failed.push(format!("{name}: {ratio}"));
        }
    };
    for (name, room) in [("boxes", Room::boxes(256)), ("columns", Room::columns(256))] {
        let reference = room.reference();
        for (count, most) in [(64, 0.6), (256, 0.5), (1024, 0.4), (4096, 0.6)] {
            if name == "columns" && ![64, 1024].contains(&count) {
                continue;
            }
            let best = [1.0, 0.25, 0.125]
                .map(|scale| room.errors(&room.kernels(count, scale), Emitter::Cosine, &reference))
                .into_iter()
                .min_by(|a, b| a.relative_mse.value.total_cmp(&b.relative_mse.value))
                .unwrap();
            show(&format!("{name}: kernels, cosine"), count, &best);
            let of = |at: f64, emitter| {
                let map = room.map();
                // The grid is about the origin.
                let moved = Map { origin: map.origin + Vector3::new(0.31, 0.17, 0.23) * at, ..map };
                let found = room.errors(&lights(&moved, count), emitter, &reference);
                show(&format!("{name}: cut, {emitter:?}"), count, &found);
                found
            };
            let found = [0.0, 1.0, 2.0].map(|at| of(at, Emitter::Disc));
            of(0.0, Emitter::Cosine);
            let ratio = |error: &dyn Fn(&Metrics) -> f64| {
                found.iter().map(error).sum::<f64>() / 3.0 / error(&best)
            };
            if name == "boxes" || count >= 1024 {
                let name = format!("{name} {count}, relative MSE");
                check(name, ratio(&|one| one.relative_mse.value), most);
            }
            check(format!("{name} {count}, RMSE"), ratio(&|one| one.rmse.value), 0.95);
            check(format!("{name} {count}, median"), ratio(&|one| one.median.value), 0.7);
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

/// Relative MSE of a cut by what directions count, mean of three places of the room.
#[test]
fn what_directions_count_is_near_the_best() {
    let weights = [0.0, DIRECTIONS, 1.0, 5.0];
    let mut logs = [0.0; 4];
    for (name, room) in [("boxes", Room::boxes(128)), ("columns", Room::columns(128))] {
        let reference = room.reference();
        for count in [128, 512] {
            let errors = weights.map(|weight| {
                let of = |at: f64| {
                    let map = room.map();
                    let moved =
                        Map { origin: map.origin + Vector3::new(0.31, 0.17, 0.23) * at, ..map };
                    let lights = cut_by(&moved, count, weight).lights(&moved);
                    room.errors(&lights, Emitter::Disc, &reference).relative_mse.value
                };
                [0.0, 1.0, 2.0].map(of).iter().sum::<f64>() / 3.0
            });
            println!("{name} {count}: {errors:.5?}");
            for (log, error) in logs.iter_mut().zip(errors) {
                *log += error.ln() / 4.0;
            }
        }
    }
    let means = logs.map(f64::exp);
    println!("geometric means for {weights:?}: {means:.5?}");
    let best = means.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(means[1] < 1.25 * best, "{means:?}");
}

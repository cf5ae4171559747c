//! The error of a cut per tile, against all texels as lights and against facets, and what it must not lose.

use rayon::prelude::*;

use super::estimate::{Receiver, SLACK, estimate};
use super::room::Room;
use super::tile::{Entry, How, NODES, SIDE, list, list_and_unrefined, shares, voters};
use super::{Branch, CentralMoments, LightTree, cut};
use crate::Vector3;
use crate::brdf::{Material, Ndf};
use crate::metrics::{Metrics, compare_exact};
use crate::rsm::{Emission, Lobes};
use crate::shade::{Diffuse, Emitter, Model, shade};
use crate::surface::SurfaceTexel;

/// The tolerance that is the default.
const TOLERANCE: f64 = 0.006;

const MODEL: Model =
    Model { emitter: Emitter::Disc, diffuse: Some(Diffuse::Fitted), specular: None, ndf: Ndf::Ggx };

/// Who votes.
#[derive(Clone, Copy, PartialEq)]
enum Voting {
    All,
    Middle,
}

/// The pixels of some tiles.
struct Shaded {
    pixels: Vec<usize>,
    picture: Vec<[f64; 3]>,
    /// Mean number of nodes in a tile's list.
    nodes: f64,
    /// Mean number of those that a pixel takes something of.
    taken: f64,
    most: usize,
}

/// One tile in `every` along each axis by a cut.
fn shaded(
    room: &Room,
    tree: &LightTree,
    [tolerance, slack]: [f64; 2],
    voting: Voting,
    every: usize,
) -> Shaded {
    let [width, height] = room.image;
    let how = How { tolerance, slack, model: &MODEL, eye: room.eye };
    let tiles: Vec<[usize; 2]> = (0..height / SIDE)
        .step_by(every)
        .flat_map(|y| (0..width / SIDE).step_by(every).map(move |x| [x, y]))
        .collect();
    let present = |pixel: usize| room.receivers[pixel].present;
    let of_tile = |tile: &[usize; 2]| {
        let at = voters(*tile, [width, height], &present);
        let mut votes = at.map(|pixel| room.receivers[pixel]);
        if voting == Voting::Middle {
            votes = [votes[4]; 5];
        }
        let entries = list(tree, &votes, &how);
        let pixel = |at: usize| {
            let at = [at % SIDE, at / SIDE];
            let pixel = (SIDE * tile[1] + at[1]) * width + SIDE * tile[0] + at[0];
            let reflected = reflected(tree, &entries, &room.receivers[pixel], &votes, at, room.eye);
            (pixel, reflected.to_array())
        };
        let taken = (0..SIDE * SIDE).map(|at| {
            let at = [at % SIDE, at / SIDE];
            let pixel = (SIDE * tile[1] + at[1]) * width + SIDE * tile[0] + at[0];
            let shares = shares(at, &room.receivers[pixel], &votes);
            entries.iter().filter(|entry| entry.weight(&shares) > 0.0).count()
        });
        let taken = taken.sum::<usize>() as f64 / (SIDE * SIDE) as f64;
        (entries.len(), taken, (0..SIDE * SIDE).map(pixel).collect::<Vec<_>>())
    };
    let done: Vec<_> = tiles.par_iter().map(of_tile).collect();
    let nodes = done.iter().map(|tile| tile.0 as f64).sum::<f64>() / tiles.len() as f64;
    let taken = done.iter().map(|tile| tile.1).sum::<f64>() / tiles.len() as f64;
    let most = done.iter().map(|tile| tile.0).max().unwrap();
    let (pixels, picture) = done.into_iter().flat_map(|tile| tile.2).unzip();
    Shaded { pixels, picture, nodes, taken, most }
}

/// The picture of lights at some pixels.
fn lit(room: &Room, lights: &[crate::vsgl::Vsgl], pixels: &[usize]) -> Vec<[f64; 3]> {
    let of = |&pixel: &usize| {
        let surface = &room.receivers[pixel];
        shade(surface, room.eye, lights.iter().copied(), &MODEL).diffuse.to_array()
    };
    pixels.par_iter().map(of).collect()
}

fn reflected(
    tree: &LightTree,
    entries: &[Entry],
    surface: &SurfaceTexel,
    votes: &[SurfaceTexel; 5],
    at: [usize; 2],
    eye: Vector3,
) -> Vector3 {
    let shares = shares(at, surface, votes);
    let of = |entry: &Entry| {
        let lights = core::iter::once(tree.lights[entry.node]);
        shade(surface, eye, lights, &MODEL).diffuse * entry.weight(&shares)
    };
    entries.iter().map(of).fold(Vector3::zero(), |sum, one| sum + one)
}

fn tree(room: &Room, roots: usize) -> LightTree {
    let map = room.map();
    LightTree::of(&cut(&map, roots), &map)
}

/// The lights of all leaves.
fn all_leaves(tree: &LightTree) -> Vec<crate::vsgl::Vsgl> {
    let leaves = |at: &usize| tree.branches[*at].children.is_none();
    (0..tree.lights.len()).filter(leaves).map(|at| tree.lights[at]).collect()
}

/// Root mean square over the mean.
fn apart(one: &[[f64; 3]], other: &[[f64; 3]]) -> f64 {
    let sum = |of: &dyn Fn(usize) -> f64| (0..one.len()).map(of).sum::<f64>();
    let square = sum(&|at| (0..3).map(|of| (one[at][of] - other[at][of]).powi(2)).sum());
    let mean = sum(&|at| other[at].iter().sum()) / (3 * one.len()) as f64;
    (square / (3 * one.len()) as f64).sqrt() / mean
}

fn show(name: &str, shaded: &Shaded, reference: &[[f64; 3]]) -> Metrics {
    let found = compare_exact(&shaded.picture, reference).unwrap();
    println!(
        "{name}: {:.0} nodes ({:.0} a pixel), at most {}: RMSE {:.2} %, relative MSE {:.6}, median {:.3} %, 95 % {:.2} %, bias {:.3} %",
        shaded.nodes,
        shaded.taken,
        shaded.most,
        100.0 * apart(&shaded.picture, reference),
        found.relative_mse.value,
        100.0 * found.median.value,
        100.0 * found.quantile_95.value,
        100.0 * found.bias.value,
    );
    found
}

/// Whatever the votes, what a pixel takes of a leaf by itself and by the nodes above it is all of it.
#[test]
fn the_weights_on_each_path_add_up_to_one() {
    for room in [Room::boxes(64), Room::columns(64)] {
        let tree = tree(&room, 16);
        let how = How { tolerance: 0.02, slack: SLACK, model: &MODEL, eye: room.eye };
        for tile in [[0, 0], [2, 1], [5, 3]] {
            let at = voters(tile, room.image, &|pixel| room.receivers[pixel].present);
            let votes = at.map(|pixel| room.receivers[pixel]);
            let entries = list(&tree, &votes, &how);
            assert!(entries.iter().any(Entry::blends));
            let shares = shares([3, 6], &votes[4], &votes);
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let sums = |entries: &[Entry]| {
                let mut sums = vec![0.0; tree.lights.len()];
                for entry in entries {
                    for leaf in tree.leaves(entry.node) {
                        sums[leaf] += entry.weight(&shares);
                    }
                }
                let leaves = tree.leaves(tree.top.unwrap());
                leaves.iter().map(|&leaf| (sums[leaf] - 1.0).abs()).fold(0.0, f64::max)
            };
            assert!(sums(&entries) < 1e-12);
            // Negative control: without the entry that counts most.
            let most = |one: &&Entry, other: &&Entry| {
                one.weight(&shares).total_cmp(&other.weight(&shares))
            };
            let most = *entries.iter().max_by(most).unwrap();
            let rest: Vec<Entry> = entries.into_iter().filter(|one| *one != most).collect();
            assert!(sums(&rest) > 0.5);
        }
    }
}

/// A tolerance of 0 is all leaves, as many as fit; an infinite one the global cut.
#[test]
fn tolerances_at_their_ends_are_all_leaves_and_the_global_cut() {
    let room = Room::boxes(16);
    let tree = tree(&room, 8);
    let finest = shaded(&room, &tree, [0.0, SLACK], Voting::All, 1);
    let all = lit(&room, &all_leaves(&tree), &finest.pixels);
    let roots: Vec<_> = tree.roots.iter().flatten().map(|&node| tree.lights[node]).collect();
    let coarsest = shaded(&room, &tree, [f64::INFINITY, SLACK], Voting::All, 1);
    assert!(apart(&coarsest.picture, &lit(&room, &roots, &coarsest.pixels)) < 1e-12);
    assert_eq!(coarsest.most, 8);
    assert!(apart(&finest.picture, &all) < 1e-12, "{}", apart(&finest.picture, &all));
    assert!(apart(&coarsest.picture, &all) > 0.02);
}

/// A tolerance of 0 refines until the list has no more room; what was left is counted.
#[test]
fn what_has_no_room_is_counted() {
    let counted = |map: usize| {
        let room = Room::boxes(map);
        let tree = tree(&room, 8);
        let how = How { tolerance: 0.0, slack: SLACK, model: &MODEL, eye: room.eye };
        let at = voters([2, 1], room.image, &|pixel| room.receivers[pixel].present);
        let votes = at.map(|pixel| room.receivers[pixel]);
        let (entries, unrefined) = list_and_unrefined(&tree, &votes, &how);
        let inner = entries.iter().filter(|one| tree.branches[one.node].children.is_some()).count();
        (all_leaves(&tree).len(), entries.len(), inner, unrefined)
    };
    let (leaves, length, inner, unrefined) = counted(64);
    assert!(leaves > NODES && length <= NODES && unrefined > 0, "{leaves} {length} {unrefined}");
    assert_eq!(unrefined, inner);
    // Negative control: fewer leaves than the list has room for.
    let (leaves, length, inner, unrefined) = counted(16);
    assert!(leaves < NODES / 2, "{leaves}");
    assert_eq!((length, inner, unrefined), (leaves, 0, 0));
}

/// By how much the worst pixel is wrong, in parts of the mean.
fn worst(one: &[[f64; 3]], other: &[[f64; 3]]) -> f64 {
    let mean = other.iter().flatten().sum::<f64>() / (3 * other.len()) as f64;
    let pairs = one.iter().flatten().zip(other.iter().flatten());
    pairs.map(|(one, other)| (one - other).abs() / mean).fold(0.0, f64::max)
}

/// A tree whose nodes have no box.
fn at_their_means(tree: &LightTree) -> LightTree {
    let mut tree = tree.clone();
    tree.branches.iter_mut().for_each(|branch| branch.bounds = [Vector3::zero(); 2]);
    tree
}

/// The error goes down with the tolerance; without boxes around nodes and slack light is lost in corners.
#[test]
fn a_few_nodes_are_as_good_as_all_texels() {
    for (name, room, most) in
        [("boxes", Room::boxes(128), 140.0), ("columns", Room::columns(128), 200.0)]
    {
        // As many pixels as 1344 by 896.
        let room = room.finely(32);
        let tree = tree(&room, 16);
        let of = |tolerance, voting| shaded(&room, &tree, [tolerance, SLACK], voting, 24);
        let usual = of(TOLERANCE, Voting::All);
        let all = lit(&room, &all_leaves(&tree), &usual.pixels);
        for tolerance in [4.0, 2.0, 0.5] {
            show(
                &format!("{name}, {tolerance} times"),
                &of(tolerance * TOLERANCE, Voting::All),
                &all,
            );
        }
        let errors = show(&format!("{name}, default"), &usual, &all);
        assert!(usual.nodes <= most, "{name}: {} nodes", usual.nodes);
        assert!(errors.relative_mse.value <= 4e-4, "{name}");
        assert!(errors.median.value <= 0.01 && errors.bias.value.abs() <= 0.006, "{name}");
        if name == "columns" {
            let lost = shaded(&room, &at_their_means(&tree), [TOLERANCE, 0.0], Voting::All, 24);
            let errors = show("columns, nodes at their means", &lost, &all);
            assert!(errors.relative_mse.value > 2e-3, "light that is lost goes unnoticed");
            let middle = of(TOLERANCE, Voting::Middle);
            show("columns, the middle's vote", &middle, &all);
            let [usual, middle] = [&usual, &middle].map(|one| worst(&one.picture, &all));
            println!("worst pixels: {usual:.3}, by the middle's vote {middle:.3}");
            assert!(middle > 3.0 * usual, "an edge that the middle does not see goes unnoticed");
        }
    }
}

/// A few texels beside the receiver, in a node whose others are far away: an estimate by moments alone does not see them.
#[test]
fn few_texels_far_from_all_others_are_seen() {
    let (out, emission) = (Vector3::new(-1.0, 0.0, 0.0), Emission::of_normals(Lobes::Diffuse));
    let leaf = |x: f64, y: f64, z: f64| CentralMoments {
        weight: 1.0,
        mean: Vector3::new(x, y, z),
        variance: 0.01,
        diffuse_power: Vector3::splat(1.0),
        diffuse_direction: out,
        diffuse_weight: 1.0,
        bounds: [Vector3::new(x, y, z); 2],
        ..CentralMoments::nothing()
    };
    let far = (0..400).map(|at| leaf(10.0, f64::from(at % 20) * 0.2, f64::from(at / 20) * 0.2));
    let near = (0..4).map(|at| leaf(0.5, f64::from(at) * 0.2, 0.0));
    let leaves: Vec<CentralMoments> = far.chain(near).collect();
    let node = leaves.iter().fold(CentralMoments::nothing(), |sum, leaf| sum.merged(*leaf));
    let surface = SurfaceTexel {
        position: Vector3::zero(),
        normal: -out,
        material: Material { diffuse: Vector3::splat(0.5), specular: Vector3::zero(), alpha: 1.0 },
        present: true,
    };
    let lit = |of: &CentralMoments| {
        let light = of.light(Vector3::zero(), &emission);
        shade(&surface, surface.normal, core::iter::once(light), &MODEL).diffuse.luminance()
    };
    let error = (leaves.iter().map(&lit).sum::<f64>() - lit(&node)).abs();
    let light = node.light(Vector3::zero(), &emission);
    let receiver = Receiver::of(&surface, surface.normal, true, false);
    let estimated = |bounds| {
        let power = node.diffuse_power.luminance();
        let branch = Branch { children: None, power, specular_power: 0.0, spread: 0.0, bounds };
        estimate(&light, &branch, &receiver, SLACK)
    };
    let found = estimated(node.bounds.map(|corner| corner - node.mean));
    assert!(found > error, "{found} {error}");
    // Negative control: a node at its mean position.
    assert!(estimated([Vector3::zero(); 2]) < 0.1 * error);
}

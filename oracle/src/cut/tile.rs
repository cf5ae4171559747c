//! A cut for a tile of pixels: the votes of five pixels refine nodes, and each pixel blends by them.

use crate::Vector3;
use crate::cut::LightTree;
use crate::cut::estimate::{Receiver, estimate};
use crate::shade::{Model, shade};
use crate::surface::SurfaceTexel;

/// Width and height of a tile in pixels.
pub const SIDE: usize = 8;
/// Maximum number of nodes in the list of a tile, with those still to be estimated.
pub const NODES: usize = 1152;
/// Maximum number of roots, below [`NODES`] so that some can be refined.
pub const MAX_ROOTS: usize = 1024;
/// Number of nodes that are estimated before any of their children.
pub const BATCH: usize = 64;
/// A node is refined from 1/1.5 of the limit on, and its children alone are left at the limit.
pub const BAND: f64 = 1.5;
/// The vote for a node's children alone.
pub const ALL: u8 = 255;

/// How far each vote refines a node: of the four corners, of the middle, and the maximum of these.
pub type Votes = [u8; 6];

/// A node in the list of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The node.
    pub node: usize,
    /// The root above it: its place in the global cut.
    pub root: usize,
    /// How far its parent is refined.
    pub above: Votes,
    /// How far it is refined itself.
    pub own: Votes,
}

/// How a tile is cut.
#[derive(Clone, Copy, Debug)]
pub struct How<'a> {
    /// By how much a node may be wrong, in parts of the radiance.
    pub tolerance: f64,
    /// [`SLACK`](crate::cut::estimate::SLACK).
    pub slack: f64,
    /// The reflections.
    pub model: &'a Model,
    /// The camera's position.
    pub eye: Vector3,
}

/// How far a vote refines a node of an estimated error.
fn refinement(error: f64, limit: f64) -> f64 {
    let ratio = BAND * error / limit.max(1e-37);
    let step = (ratio.max(1e-30).ln() / BAND.ln()).clamp(0.0, 1.0);
    step * step * (3.0 - 2.0 * step)
}

/// The pixels that vote in a tile of an image: corners, the middle. A corner to the right or below is the next tile's
/// first pixel. Where the middle has no surface the first pixel that has one votes for it.
#[must_use]
pub fn voters(tile: [usize; 2], size: [usize; 2], present: &dyn Fn(usize) -> bool) -> [usize; 5] {
    let pixel = |at: [usize; 2]| {
        let [x, y] = [0, 1].map(|axis| (SIDE * tile[axis] + at[axis]).min(size[axis] - 1));
        y * size[0] + x
    };
    let inside = |at: [usize; 2]| (0..2).all(|axis| SIDE * tile[axis] + at[axis] < size[axis]);
    let all = (0..SIDE * SIDE).map(|at| [at % SIDE, at / SIDE]);
    let shown = |at: &[usize; 2]| inside(*at) && present(pixel(*at));
    let half = SIDE / 2;
    let middle = [half, half];
    let middle =
        if shown(&middle) { middle } else { all.into_iter().find(shown).unwrap_or(middle) };
    let corners = [[0, 0], [SIDE, 0], [0, SIDE], [SIDE, SIDE]].map(pixel);
    [corners[0], corners[1], corners[2], corners[3], pixel(middle)]
}

/// The limit of each voter: the tolerance times the radiance of the global cut, or of a hundredth of what all lights would
/// send to a sphere as wide as they are. None without a surface.
fn limits(tree: &LightTree, votes: &[SurfaceTexel; 5], how: &How<'_>) -> [Option<f64>; 5] {
    let lights = tree.roots.iter().flatten().map(|&node| tree.lights[node]);
    let least = tree.top.map_or(0.0, |top| {
        let (branch, light) = (&tree.branches[top], &tree.lights[top]);
        0.01 * branch.power / (2.0 * core::f64::consts::TAU * light.variance)
    });
    votes.each_ref().map(|surface| {
        if !surface.present {
            return None;
        }
        let radiance = shade(surface, how.eye, lights.clone(), how.model).total().luminance();
        let receiver = receiver(surface, how);
        let glossy = receiver.glossy.map_or(0.0, |glossy| glossy.reflectance);
        let reflectance = receiver.diffuse + glossy / core::f64::consts::PI;
        Some(how.tolerance * radiance.max(least * reflectance))
    })
}

fn receiver(surface: &SurfaceTexel, how: &How<'_>) -> Receiver {
    Receiver::of(surface, how.eye, how.model.diffuse.is_some(), how.model.specular.is_some())
}

/// The list of a tile's nodes: breadth first, in the order in which they are looked at.
#[must_use]
pub fn list(tree: &LightTree, votes: &[SurfaceTexel; 5], how: &How<'_>) -> Vec<Entry> {
    list_and_unrefined(tree, votes, how).0
}

/// The list of a tile's nodes, and how many of them the votes would refine, had the list room for their children.
#[must_use]
pub fn list_and_unrefined(
    tree: &LightTree,
    votes: &[SurfaceTexel; 5],
    how: &How<'_>,
) -> (Vec<Entry>, usize) {
    let limits = limits(tree, votes, how);
    let receivers = votes.each_ref().map(|surface| receiver(surface, how));
    let mut queue: std::collections::VecDeque<(usize, usize, Votes)> = (0..)
        .zip(&tree.roots)
        .filter_map(|(root, node)| Some((node.as_ref().copied()?, root, [ALL; 6])))
        .collect();
    let (mut list, mut unrefined) = (Vec::new(), 0);
    while !queue.is_empty() {
        let batch: Vec<_> = queue.drain(..queue.len().min(BATCH)).collect();
        let own: Vec<Votes> = batch
            .iter()
            .map(|&(node, _, above)| {
                let mut own = [0; 6];
                if tree.branches[node].children.is_none() {
                    return own;
                }
                for vote in 0..5 {
                    let Some(limit) = limits[vote] else { continue };
                    let (light, branch) = (&tree.lights[node], &tree.branches[node]);
                    let error = estimate(light, branch, &receivers[vote], how.slack);
                    // A tolerance of 0 refines to the leaves, also where the estimate is 0.
                    let refined = if how.tolerance > 0.0 { refinement(error, limit) } else { 1.0 };
                    own[vote] = above[vote].min(quantised(refined));
                    own[5] = own[5].max(own[vote]);
                }
                own
            })
            .collect();
        // The list has room for all that is in the queue, so that no light is lost: the last ones are not refined.
        let mut room = (NODES - queue.len() - batch.len() - list.len()) / 2;
        for ((node, root, above), mut own) in batch.into_iter().zip(own) {
            if own[5] > 0 {
                unrefined += usize::from(room == 0);
                own = if room > 0 { own } else { [0; 6] };
                room = room.saturating_sub(1);
            }
            if above != own {
                list.push(Entry { node, root, above, own });
            }
            if own[5] > 0
                && let Some(children) = tree.branches[node].children
            {
                queue.extend(children.map(|child| (child, root, own)));
            }
        }
    }
    (list, unrefined)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
fn quantised(share: f64) -> u8 {
    (share * f64::from(ALL) + 0.5) as u8
}

/// The weights of the votes and of their maximum at a pixel of a tile; their sum is 1.
///
/// Votes are interpolated over four triangles about the middle, by similarity; the maximum has the rest of the weight.
#[must_use]
pub fn shares(at: [usize; 2], surface: &SurfaceTexel, votes: &[SurfaceTexel; 5]) -> [f64; 6] {
    let [x, y] = at.map(|at| at as f64 / SIDE as f64);
    let middle = 2.0 * x.min(1.0 - x).min(y.min(1.0 - y));
    let along = |at: f64| ((at - 0.5 * middle) / (1.0 - middle).max(1e-6)).clamp(0.0, 1.0);
    let (u, v) = (along(x), along(y));
    let edge = 1.0 - middle;
    let mut shares = [
        edge * (1.0 - u) * (1.0 - v),
        edge * u * (1.0 - v),
        edge * (1.0 - u) * v,
        edge * u * v,
        middle,
        0.0,
    ];
    for (share, vote) in shares.iter_mut().zip(votes) {
        *share *= similarity(surface, vote);
    }
    shares[5] = (1.0 - shares.iter().sum::<f64>()).max(0.0);
    shares
}

/// How similar two surfaces are: 1 on a plane, 0 across an edge of normals or of depth.
fn similarity(surface: &SurfaceTexel, vote: &SurfaceTexel) -> f64 {
    if !vote.present {
        return 0.0;
    }
    let apart = surface.position - vote.position;
    let rise = apart.dot(vote.normal).abs() + apart.dot(surface.normal).abs();
    let slope = rise / apart.length().max(1e-30);
    let cosine = surface.normal.dot(vote.normal);
    (2.0 - 8.0 * slope).clamp(0.0, 1.0) * (10.0 * cosine - 8.0).clamp(0.0, 1.0)
}

impl Entry {
    /// The share of the node's light that a pixel takes.
    #[must_use]
    pub fn weight(&self, shares: &[f64; 6]) -> f64 {
        let of = |vote: usize| f64::from(self.above[vote] - self.own[vote]) / f64::from(ALL);
        (0..6).map(|vote| of(vote) * shares[vote]).sum()
    }

    /// Whether a pixel takes some of the node and some of its children.
    #[must_use]
    pub fn blends(&self) -> bool {
        self.own.iter().any(|&own| own > 0 && own < ALL)
    }
}

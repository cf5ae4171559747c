//! A tree over a map's lit texels, and a cut of it as the lights of a frame.
//!
//! Texels are sorted by a key of the face that their normal looks through and of their position; the keys' highest
//! differing bits make a binary tree ([`tree`]), whose nodes are ranges of sorted texels. Moments of a node are the sums of
//! its texels' ([`sum`]), so that each node is a light. A global cut ([`global`]) takes as many nodes as there are to be
//! lights, without any receiver: an exact partition of the map in which nothing is sampled. A cut per tile ([`tile`]) refines
//! these nodes for the pixels of a tile, as far as their estimated error ([`estimate`]) is too large.

pub mod estimate;
pub mod global;
pub mod key;
pub mod nodes;
pub mod sum;
pub mod tile;
pub mod tree;

pub use estimate::Branch;
pub use global::{Cut, cut, lights};
pub use key::{Grid, Key};
pub use nodes::LightTree;
pub use sum::{CentralMoments, Sums};
pub use tree::{Node, Tree};

#[cfg(test)]
mod flicker;
#[cfg(test)]
mod room;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tile_error;

//! Clusters of texels: the closest centre of each, and the light of what has the same.

pub mod assign;
pub mod sort;
pub mod sum;

pub use assign::{Closest, closest};
pub use sort::{order, starts};
pub use sum::{Map, lights};

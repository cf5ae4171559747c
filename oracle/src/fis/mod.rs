//! Filtered importance sampling: where the filtering kernels lie and how large they are.

pub mod bracketed;
pub mod coverage;
pub mod filter;
pub mod footprint;
pub mod hash;
pub mod kernel;
pub mod lattice;
pub mod metropolis;
pub mod spread;
pub mod stress;
pub mod warp;

pub use bracketed::{Bracketed, bracketed_level};
pub use coverage::{Coverage, Evenness};
pub use filter::{bilinear, trilinear};
pub use footprint::Footprints;
pub use kernel::{
    Level, all_roots, kernel_mass, modified_factor, modified_level, previous_factor, previous_level,
};
pub use spread::{Spread, Square};
pub use warp::{Warped, warp};

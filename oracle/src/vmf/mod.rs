//! Von Mises-Fisher distributions: spherical Gaussians by the mean length of their directions.

pub mod sharpness;

pub use sharpness::{
    Sharpness, banerjee, exact, kroeger, mean_length, mean_length_complement, mean_length_toksvig,
    toksvig,
};

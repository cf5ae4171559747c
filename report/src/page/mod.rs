//! What a person sees of a long run: one HTML file with all that it needs in it, readable without scripts, on a phone,
//! in the dark, on paper, and by who sees no colours.

pub mod frame;
pub mod graph;
pub mod number;
pub mod plot;
pub mod report;
pub mod reproduce;
pub mod scale;
pub mod stability;
pub mod table;

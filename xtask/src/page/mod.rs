//! What a person sees of a long run: one HTML file with all that it needs in it, readable without scripts, on a phone,
//! in the dark, on paper, and by who sees no colours.

pub(crate) mod frame;
pub(crate) mod graph;
pub(crate) mod number;
pub(crate) mod plot;
pub(crate) mod report;
pub(crate) mod reproduce;
pub(crate) mod scale;
pub(crate) mod stability;
pub(crate) mod table;

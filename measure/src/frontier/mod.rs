//! Error against time: every way to a scene's indirect light, which of them no other beats, and where more of a number
//! stops paying.

pub mod document;
pub mod rank;
pub mod subject;
pub mod way;

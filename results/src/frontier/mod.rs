//! Error against time of the configurations of scenes.

pub mod choose;
pub mod document;
pub mod equal;
pub mod points;
pub mod promise;
pub mod rank;

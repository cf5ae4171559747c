//! One file per command.

pub(crate) mod choose;
pub(crate) mod compare;
pub(crate) mod cost;
pub(crate) mod docs;
pub(crate) mod doctor;
pub(crate) mod fuzz;
pub(crate) mod gen_shaders;
pub(crate) mod graph;
pub(crate) mod kernels;
pub(crate) mod render;
pub(crate) mod report;
pub(crate) mod reproduce;
pub(crate) mod stability;
pub(crate) mod test;
pub(crate) mod variants;
pub(crate) mod verify;

//! Typed results to what a person sees and a machine reads: pages, plots, pictures, tables and JSON. It opens no device.

#[cfg(test)]
extern crate self as sglow_report;

pub mod compare;
pub mod docs;
pub mod document;
pub mod failure;
pub mod json;
pub mod page;
pub mod parse;
pub mod picture;
pub mod picture_error;
pub mod presets;
pub mod scene;
pub mod table;
pub mod terminal;
pub mod write;

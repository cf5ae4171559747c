//! Composes a library of WESL modules into specialised, pruned and validated shader variants.
//!
//! Modules stand in pipeline order: a library is read ([`library`], [`source`], [`token`], [`parse`]), its space of
//! variants is spanned ([`matrix`]), each variant is put together ([`assemble`], [`prune`], [`validate`], all of it
//! driven by [`generate`]) and written ([`emit`], [`manifest`], [`bindings`], [`package`]).
//!
//! Nothing here knows what the shaders are for, and no GPU device is ever opened.

pub mod assemble;
pub mod condition;
mod deep;
pub mod error;
pub mod frame;
pub mod functions;
pub mod generate;
pub mod library;
mod link;
pub mod matrix;
pub mod name;
mod order;
pub mod parse;
pub mod prune;
mod resolve;
pub mod source;
pub mod token;
pub mod validate;

pub mod bindings;
pub mod emit;
pub mod hash;
pub mod manifest;
pub mod package;

//! Composes a library of WESL modules into specialised, pruned and validated shader variants.
//!
//! Modules stand in pipeline order: a library is read ([`library`], [`source`], [`token`], [`parse`]), its space of
//! variants is spanned ([`matrix`]), each variant is put together ([`assemble`], [`prune`], [`validate`], all of it
//! driven by [`generate`]) and written ([`emit`], [`manifest`], [`bindings`], [`package`]).
//!
//! Nothing here knows what the shaders are for, and no GPU device is ever opened.

pub mod library;
pub mod matrix;
pub mod validate;

pub mod bindings;
pub mod emit;
pub mod hash;
pub mod manifest;
pub mod package;

//! Rust bindings generated from a library: its axes as types, its structs and variants.

//! Places in `library.toml` and the other TOML files of a library.

pub(crate) use super::document::Document as Places;

//! SHA-256 of sources and files.

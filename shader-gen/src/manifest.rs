//! The manifest of a package: what each variant is, needs and promises.

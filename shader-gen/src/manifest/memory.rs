//! What a host has to know to run variants that were generated in memory.

use rayon::prelude::*;
use serde_json::json;

use super::{Described, Error, SCHEMA_VERSION, Shared, reflect, variant};
use crate::frame;
use crate::library::Library;
use crate::validate::Validated;

/// A manifest, as JSON, of variants that lie in no file: what they bind, and the frame.
///
/// # Errors
///
/// When a variant binds a resource of a kind that the manifest cannot describe.
pub fn in_memory(library: &Library, validated: &[Validated]) -> Result<String, Error> {
    let one = |one: &Validated| -> Result<Described, Error> {
        let reflection = reflect(&one.text, &one.module, &one.info)?;
        Ok(variant(library, one, &reflection, Vec::new()))
    };
    let described: Result<Vec<_>, _> = validated.par_iter().map(one).collect();
    let mut shared = Shared::default();
    let variants: Vec<_> = described?.into_iter().map(|one| shared.intern(one)).collect();
    let manifest = json!({
        "schema_version": SCHEMA_VERSION,
        "shared": shared,
        "variants": variants,
        "graph": library.frame().map(|of| frame::json(&of.description)),
    });
    Ok(manifest.to_string())
}

//! What a host has to know to run variants that were generated in memory.

use rayon::prelude::*;
use serde_json::{Value, json};

use super::{Error, Variant, reflect, variant};
use crate::frame;
use crate::library::Library;
use crate::validate::Validated;

/// The parts of a manifest by which variants are run, as JSON: of `variants` what they bind, and the frame as `graph`.
///
/// # Errors
///
/// When a variant binds a resource of a kind that the manifest cannot describe.
pub fn in_memory(library: &Library, validated: &[Validated]) -> Result<String, Error> {
    let one = |one: &Validated| -> Result<Value, Error> {
        let reflection = reflect(&one.text, &one.module, &one.info)?;
        let Variant { id, entry_points, bindings, structs, overrides, .. } =
            variant(library, one, &reflection, Vec::new());
        Ok(json!({
            "id": id,
            "entry_points": entry_points,
            "bindings": bindings,
            "structs": structs,
            "overrides": overrides,
        }))
    };
    let variants: Result<Vec<_>, _> = validated.par_iter().map(one).collect();
    let graph = library.frame().map(|of| frame::json(&of.description));
    Ok(json!({ "variants": variants?, "graph": graph }).to_string())
}

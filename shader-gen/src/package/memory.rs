//! Variants that are generated for this process alone, with what a host has to know to run them.

use rayon::prelude::*;
use serde_json::json;

use super::{Cause, Error, VariantError};
use crate::frame;
use crate::generate;
use crate::library::Library;
use crate::manifest::{SCHEMA_VERSION, Shared, reflect, variant};
use crate::matrix::Variant;
use crate::validate::Validated;

/// Variants that are in memory as modules at once: each takes half a megabyte, and a library has tens of thousands.
const AT_ONCE: usize = 512;

/// Variants that lie in no file.
#[derive(Clone, Debug)]
pub struct InMemory {
    /// Identifier and WGSL of each.
    pub texts: Vec<(String, String)>,
    /// A manifest, as JSON: what they bind, and the frame.
    pub manifest: String,
}

/// Generates `variants`.
///
/// # Errors
///
/// Everything that is wrong with the library or any of them.
pub fn in_memory(library: &Library, variants: &[Variant]) -> Result<InMemory, Error> {
    let described = |one: &Validated| {
        let reflection = reflect(&one.text, &one.module, &one.info);
        let reflection = reflection.map_err(|cause| VariantError {
            variant: one.variant.id(),
            cause: Cause::Reflection(cause),
        })?;
        Ok(variant(library, one, &reflection, Vec::new()))
    };
    let mut shared = Shared::default();
    let (mut texts, mut interned, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    for variants in variants.chunks(AT_ONCE) {
        let validated = generate::variants(library, variants)?;
        for one in validated.par_iter().map(described).collect::<Vec<_>>() {
            match one {
                Ok(one) => interned.push(shared.intern(one)),
                Err(error) => wrong.push(error),
            }
        }
        texts.extend(validated.into_iter().map(|one| (one.variant.id(), one.text)));
    }
    if !wrong.is_empty() {
        return Err(Error::Variants(wrong));
    }
    let manifest = json!({
        "schema_version": SCHEMA_VERSION,
        "shared": shared,
        "variants": interned,
        "graph": library.frame().map(|of| frame::json(&of.description)),
    });
    Ok(InMemory { texts, manifest: manifest.to_string() })
}

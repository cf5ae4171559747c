//! SHA-256 of sources and files.

use std::collections::BTreeMap;

use base16ct::lower::encode_string;
pub use sglow_seal::{sha256, sums};
use sha2::{Digest, Sha256};

/// Changes whenever the sources of this crate, or the versions of the crates that print, change.
pub const GENERATOR: &str = env!("SGLOW_GENERATOR_FINGERPRINT");

/// The version of naga that this crate is built with.
pub const NAGA: &str = env!("SGLOW_NAGA_VERSION");

/// SHA-256 of named parts, whatever their order; a part's name and its text cannot be confused.
#[must_use]
pub fn of_parts<'a>(parts: impl IntoIterator<Item = (&'a str, &'a str)>) -> String {
    let sorted: BTreeMap<_, _> = parts.into_iter().collect();
    let mut digest = Sha256::new();
    for (name, text) in sorted {
        for part in [name, text] {
            digest.update((part.len() as u64).to_le_bytes());
            digest.update(part);
        }
    }
    encode_string(&digest.finalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_count_with_their_names_and_without_their_order() {
        let hash = of_parts([("a", "1"), ("b", "2")]);
        assert_eq!(hash, of_parts([("b", "2"), ("a", "1")]));
        for other in [[("a", "1"), ("b", "3")], [("a", "1b"), ("", "2")], [("a1", ""), ("b", "2")]]
        {
            assert_ne!(hash, of_parts(other));
        }
    }
}

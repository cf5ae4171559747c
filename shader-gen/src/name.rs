//! The names of a variant's files.
//!
//! A file says of a variant what differs from the defaults: `scan.wgsl`, `scan-order_exclusive.wgsl`. Within a pass no two
//! variants have the same name: one value of an axis is left out, the others are named with their axis, in the order of the
//! axes, and `-` stands in no name of an axis or a value.

use crate::hash;
use crate::library::Library;
use crate::matrix::Variant;

/// No name is longer in bytes, the longest extension included: file systems take 255.
pub const LONGEST: usize = 200;

/// The name of the files of `variant`, without extension.
#[must_use]
pub fn stem(library: &Library, variant: &Variant) -> String {
    let mut stem = variant.pass.clone();
    for (axis, value) in &variant.values {
        if library.axis.get(axis).is_none_or(|axis| axis.default != *value) {
            stem.push_str(&format!("-{axis}_{value}"));
        }
    }
    bounded(stem)
}

/// A name that would be too long keeps its beginning, with the hash of all of it.
fn bounded(name: String) -> String {
    const EXTENSION: usize = 16;
    const DIGITS: usize = 32;
    if name.len() + EXTENSION <= LONGEST {
        return name;
    }
    let hash = hash::sha256(name.as_bytes());
    // Names are in ASCII.
    let start: String = name.chars().take(LONGEST - EXTENSION - DIGITS - 1).collect();
    format!("{start}-{}", &hash[..DIGITS])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_and_stay_different() {
        let short = "a".repeat(LONGEST - 16);
        assert_eq!(bounded(short.clone()), short);
        let long = ["x", "y"].map(|end| bounded(short.clone() + end));
        assert_ne!(long[0], long[1]);
        assert!(long.iter().all(|name| name.len() + 16 <= LONGEST), "{long:?}");
        assert_eq!(long[0], bounded(short + "x"));
    }
}

//! SHA-256 of sources and files.

use std::collections::BTreeMap;

use base16ct::lower::encode_string;
use sha2::{Digest, Sha256};

/// Changes whenever the sources of this crate, or the versions of the crates that print, change.
pub const GENERATOR: &str = env!("SGLOW_GENERATOR_FINGERPRINT");

/// The version of naga that this crate is built with.
pub const NAGA: &str = env!("SGLOW_NAGA_VERSION");

/// SHA-256 in hexadecimal.
#[must_use]
pub fn sha256(bytes: &[u8]) -> String {
    encode_string(&Sha256::digest(bytes))
}

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

/// The lines of `SHA256SUMS`, as `sha256sum` writes and checks them.
#[must_use]
pub fn sums(files: &BTreeMap<String, Vec<u8>>) -> String {
    files.iter().map(|(path, bytes)| format!("{}  {path}\n", sha256(bytes))).collect()
}

/// The hashes in `SHA256SUMS` by path; lines of another form are left out.
#[must_use]
pub fn read_sums(text: &str) -> BTreeMap<&str, &str> {
    text.lines().filter_map(|line| line.split_once("  ")).map(|(hash, path)| (path, hash)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sha256_of_the_standard_example() {
        // [FIPS 180-4, Appendix B.1]
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(b"abc"), expected);
    }

    #[test]
    fn parts_count_with_their_names_and_without_their_order() {
        let hash = of_parts([("a", "1"), ("b", "2")]);
        assert_eq!(hash, of_parts([("b", "2"), ("a", "1")]));
        for other in [[("a", "1"), ("b", "3")], [("a", "1b"), ("", "2")], [("a1", ""), ("b", "2")]]
        {
            assert_ne!(hash, of_parts(other));
        }
    }

    #[test]
    fn sums_can_be_read_back() {
        let files = BTreeMap::from([("a/b.txt".to_owned(), b"abc".to_vec())]);
        let text = sums(&files);
        assert_eq!(read_sums(&text), BTreeMap::from([("a/b.txt", sha256(b"abc").as_str())]));
    }
}

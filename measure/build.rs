//! A hash of all the code that a measured result depends on beside shaders: cached results of other code are not trusted.
//! Comments, documentation and tests are no part of it.

use std::fs;
use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};

#[path = "src/tokens.rs"]
mod tokens;

/// What takes part in measuring, seen from this crate.
const CODE: [&str; 9] = [
    "src",
    "../graph/src",
    "../oracle/src",
    "../results/src",
    "../runtime/src",
    "../scene/src",
    "../renderer/src",
    "../shaders/packages/sglow/rust",
    "../Cargo.lock",
];

fn files(path: &Path, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    if path.is_dir() {
        for entry in fs::read_dir(path)? {
            files(&entry?.path(), found)?;
        }
    } else {
        found.push(path.to_owned());
    }
    Ok(())
}

fn main() -> std::io::Result<()> {
    let mut hash = Sha256::new();
    for place in CODE {
        println!("cargo::rerun-if-changed={place}");
        let mut found = Vec::new();
        files(Path::new(place), &mut found)?;
        found.sort();
        for file in found {
            let mut bytes = fs::read(&file)?;
            if file.extension().is_some_and(|extension| extension == "rs")
                && let Ok(text) = str::from_utf8(&bytes)
            {
                bytes = tokens::tokens(text).into_bytes();
            }
            hash.update(file.to_string_lossy().as_bytes());
            hash.update((bytes.len() as u64).to_le_bytes());
            hash.update(bytes);
        }
    }
    // What the CPU does between passes is inside the wall's clock.
    hash.update(std::env::var("OPT_LEVEL").unwrap_or_default());
    let hash = base16ct::lower::encode_string(&hash.finalize());
    println!("cargo::rustc-env=SGLOW_CODE={hash}");
    Ok(())
}

//! SPIR-V files in, verdicts out: the validator of SPIRV-Tools for Vulkan 1.1.
//!
//! `spirv-val FILE…` prints `ok FILE` or `invalid FILE: reason` per file and exits with 1 unless all are valid.
//! `spirv-val --version` prints what it was made of.

use std::process::ExitCode;

use spirv_tools::TargetEnv;
use spirv_tools::val::{Validator as _, create};

/// The crate that `Cargo.toml` pins, and the release of SPIRV-Tools inside.
const VERSION: &str = "SPIRV-Tools v2025.3, from the crate spirv-tools 0.13.3";

fn main() -> ExitCode {
    if std::env::args().nth(1).as_deref() == Some("--version") {
        println!("{VERSION}");
        return ExitCode::SUCCESS;
    }
    let validator = create(Some(TargetEnv::Vulkan_1_1));
    let mut all_valid = true;
    for file in std::env::args().skip(1) {
        let verdict = std::fs::read(&file)
            .map_err(|error| error.to_string())
            .and_then(|bytes| words(&bytes))
            .and_then(|words| {
                let verdict = validator.validate(words, None);
                verdict.map_err(|error| error.to_string())
            });
        match verdict {
            Ok(()) => println!("ok {file}"),
            Err(reason) => {
                all_valid = false;
                println!("invalid {file}: {}", reason.replace('\n', " "));
            }
        }
    }
    if all_valid { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The words of a little-endian file.
fn words(bytes: &[u8]) -> Result<Vec<u32>, String> {
    let (words, rest) = bytes.as_chunks::<4>();
    if rest.is_empty() {
        Ok(words.iter().copied().map(u32::from_le_bytes).collect())
    } else {
        Err(format!("{} bytes are no whole number of words", bytes.len()))
    }
}

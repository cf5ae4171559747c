//! Packages with seeded mutations of manifests, sealed again, and settings: none may panic, overflow the stack, run long or take
//! much memory.

#![allow(clippy::unwrap_used, reason = "helpers of tests are tests, too")]

use std::alloc::System;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use cap::Cap;
use sglow_fuzz::{Case, MAXIMUM_MEMORY, Target, corpus};
use sglow_graph::Configuration;
use sglow_runtime::package::Package;
use sglow_runtime::settings::Settings;
use sglow_seal::{MANIFEST, SUMS};
use sglow_shader_gen::package::{Options, generate};

/// Beyond this limit allocation fails, and the process ends.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MAXIMUM_MEMORY);

const WORDS: [&[u8]; 24] = [
    b"../",
    b"/etc/hostname",
    b"\"path\": \"",
    b"\"id\": \"scan\"",
    b"\"name\": \"",
    b"\"+\": [",
    b"{ \"<<\": [1, 63] }",
    b"{ \"/\": [1, 0] }",
    b"{ \"-\": [0, 1] }",
    b"{ \"is\": [\"channel\", \"mean\"] }",
    b"{ \"pow2_ceil\": [18446744073709551615] }",
    b"\"repeat\": 18446744073709551615,",
    b"\"when\": ",
    b"\"value\": ",
    b"\"step\": [",
    b"\"steps\": [",
    b"\"schema_version\": 7",
    b"\"kind\": \"uniform\"",
    b"\"type\": \"array<array<array<f32, 60000>, 60000>, 60000>\"",
    b"\"min_size\": 18446744073709551615",
    b"\"group\": 4294967295",
    b"\\ud800",
    b"  ",
    b"0000000000000000000000000000000000000000000000000000000000000000",
];

/// Whether a package can be read, and its frame evaluated.
fn read(folder: &Path) -> bool {
    let package = match Package::load(folder) {
        Ok(package) => package,
        Err(errors) => {
            assert!(!errors.is_empty());
            return false;
        }
    };
    for id in package.variants() {
        let _ = (package.text(id).unwrap(), package.interface(id));
    }
    package.description().is_some_and(|of| {
        for occluders in [false, true] {
            let facts = BTreeMap::from([("occluders".to_owned(), occluders)]);
            let _ = Settings::advised(of, &facts, None);
        }
        of.evaluate(&Configuration::default()).is_ok()
    })
}

#[test]
fn no_mutated_package_panics_runs_long_or_takes_much_memory() {
    let folder = tempfile::tempdir().unwrap();
    let library = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shader-gen/tests/foreign");
    generate(&library, &Options::new(folder.path()), &mut |_| ()).unwrap();
    let whole = corpus(folder.path());
    let files: BTreeMap<String, Vec<u8>> =
        whole.iter().map(|case| (case.name.clone(), case.bytes.clone())).collect();
    let wanted = [MANIFEST, SUMS, "wgsl/scan.wgsl"];
    let cases: Vec<Case> =
        whole.into_iter().filter(|case| wanted.contains(&case.name.as_str())).collect();
    assert_eq!(cases.len(), wanted.len());
    let tried = Target::new("package", 400).run(&cases, &WORDS, |case| {
        let mut files = files.clone();
        let sums = files.remove(SUMS).unwrap();
        let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
        if case.name == SUMS {
            write(SUMS, &case.bytes);
        } else {
            files.insert(case.name.clone(), case.bytes.clone());
            write(&case.name, &case.bytes);
            write(SUMS, sglow_seal::sums(&files).as_bytes());
        }
        let read = read(folder.path());
        write(SUMS, &sums);
        let original = cases.iter().find(|one| one.name == case.name).unwrap();
        write(&case.name, &original.bytes);
        read
    });
    // Both happen, or the mutations are no test.
    assert!(tried.refused > 10 && tried.taken > 10, "{tried:?}");
}

#[test]
fn no_mutated_setting_panics() {
    let lines = ["kernel=previous", "lights=1024", "size_factor=0.25", "space=world", "map=256"];
    let case = |line: &&str| Case { name: (*line).to_owned(), bytes: line.as_bytes().to_vec() };
    let cases: Vec<Case> = lines.iter().map(case).collect();
    let package = Package::embedded();
    let description = package.description().unwrap();
    let tried = Target::new("setting", 400).run(&cases, &[b"=", b"-", b"e"], |case| {
        let text = String::from_utf8_lossy(&case.bytes).into_owned();
        let (name, value) = text.split_once('=').unwrap_or((&text, ""));
        let mut settings = Settings::default();
        let set = settings.set(name, value).is_ok();
        let _ = description.evaluate(&settings.configuration());
        set
    });
    assert!(tried.refused > 10 && tried.taken > 10, "{tried:?}");
}

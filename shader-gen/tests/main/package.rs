//! Packages: what they say, that they are the same each time, and that nothing changed by hand goes unseen.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use sglow_shader_gen::functions::functions;
use sglow_shader_gen::generate;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::manifest::{Assumed, LeftOut, MadeFor, Manifest, Saved};
use sglow_shader_gen::matrix::Variant;
use sglow_shader_gen::package::{
    self, Change, Difference, Error, Options, Outcome, Parts, Progress, Purpose, Target,
};

use crate::{foreign_library, foreign_root};

fn build(library: &Library, variants: &[Variant], targets: &[Target]) -> BTreeMap<String, Vec<u8>> {
    let validated =
        generate::variants(library, variants).unwrap_or_else(|report| panic!("{report}"));
    let functions = functions(library).unwrap_or_else(|report| panic!("{report}"));
    let parts = Parts {
        library,
        variants: &validated,
        functions: functions.as_ref(),
        changelog: None,
        source_hash: "the hash of the sources",
        purpose: None,
    };
    let targets = targets.iter().copied().collect();
    package::build(&parts, &targets).unwrap_or_else(|error| panic!("{error}"))
}

fn text(files: &BTreeMap<String, Vec<u8>>, path: &str) -> String {
    // Hashes follow from everything else and would hide what has changed.
    let text = String::from_utf8(files[path].clone()).unwrap();
    let hexadecimal = |word: &str| word.len() == 64 && word.bytes().all(|b| b.is_ascii_hexdigit());
    let words = text.split_inclusive(|c: char| !c.is_ascii_alphanumeric());
    let hide = |word: &str| match word.get(..64) {
        Some(hash) if hexadecimal(hash) && word.len() <= 65 => format!("SHA-256{}", &word[64..]),
        _ => word.to_owned(),
    };
    words.map(hide).collect()
}

/// Compares with `snapshots/NAME.snap`.
fn snapshot(name: &str, text: &str) {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, text));
}

fn generate_into(out: &Path, cache: Option<&Path>) -> (Outcome, Vec<Progress>) {
    let mut steps = Vec::new();
    let options = Options { cache: cache.map(Path::to_owned), ..Options::new(out) };
    let outcome = package::generate(&foreign_root(), &options, &mut |step| steps.push(step));
    (outcome.unwrap_or_else(|error| panic!("{error}")), steps)
}

fn differences(out: &Path) -> Vec<(String, Change)> {
    let options = Options { check: true, ..Options::new(out) };
    match package::generate(&foreign_root(), &options, &mut |_| ()) {
        Ok(_) => Vec::new(),
        Err(Error::Differs(found)) => found.into_iter().map(|of| (of.path, of.change)).collect(),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn the_package_says_what_it_has() {
    let library = foreign_library();
    let files = build(&library, &library.selected(), &Target::ALL);
    let paths: Vec<_> = files.keys().map(String::as_str).collect();
    snapshot("package/files", &paths.join("\n"));
    for path in ["manifest.json", "README.md", "rust/lib.rs", "wgsl/count.wgsl"] {
        snapshot(&format!("package/{path}"), &text(&files, path));
    }
}

#[test]
fn the_manifest_has_the_form_of_its_schema() {
    let library = foreign_library();
    let files = build(&library, &library.selected(), &Target::ALL);
    let read = |path: &str| -> serde_json::Value { serde_json::from_slice(&files[path]).unwrap() };
    let schema = jsonschema::validator_for(&read("manifest.schema.json")).unwrap();
    let manifest = read("manifest.json");
    let errors: Vec<_> = schema.iter_errors(&manifest).map(|error| error.to_string()).collect();
    assert_eq!(errors, Vec::<String>::new());

    // Negative controls: each breaks one thing.
    type Breakage = fn(&mut serde_json::Value);
    fn binding(of: &mut serde_json::Value) -> &mut serde_json::Value {
        of["shared"]["bindings"].as_object_mut().unwrap().values_mut().next().unwrap()
    }
    let breakages: [(&str, Breakage); 4] = [
        ("a field less", |of| drop(of.as_object_mut().unwrap().remove("naga"))),
        ("a field more", |of| of["surprise"] = 1.into()),
        ("another type", |of| binding(of)["group"] = "zero".into()),
        ("an unknown kind", |of| binding(of)["kind"] = "tape".into()),
    ];
    for (what, breakage) in breakages {
        let mut broken = manifest.clone();
        breakage(&mut broken);
        assert!(!schema.is_valid(&broken), "{what}");
    }
}

#[test]
fn the_manifest_can_be_read_back() {
    let library = foreign_library();
    let files = build(&library, &library.variants(), &[Target::Spirv]);
    let manifest: Manifest = serde_json::from_slice(&files["manifest.json"]).unwrap();
    assert!(package::json(&manifest).unwrap() == files["manifest.json"]);
    assert_eq!(manifest.variants.len(), library.variants().len());
    for file in manifest.variants.iter().flat_map(|variant| &variant.files) {
        assert_eq!(
            file.sha256,
            sglow_shader_gen::hash::sha256(&files[&file.path]),
            "{}",
            file.path
        );
    }
}

#[test]
fn a_package_is_the_same_to_the_byte_in_whatever_order_it_is_made() {
    let library = foreign_library();
    let mut variants = library.selected();
    let files = build(&library, &variants, &Target::ALL);
    variants.reverse();
    assert!(files == build(&foreign_library(), &variants, &Target::ALL));
    // Negative control: another selection is another package.
    variants.pop();
    assert!(files != build(&library, &variants, &Target::ALL));
}

#[test]
fn the_manifest_says_what_it_was_made_for_and_what_that_left_out() {
    let library = foreign_library();
    let validated = generate::variants(&library, &library.selected()).unwrap();
    let saved =
        Saved { bindings: 2, texture_bytes: -16, milliseconds: Some(0.5), ..Saved::default() };
    let purpose = Purpose {
        made_for: MadeFor {
            input: "a grey image".to_owned(),
            assumed: vec![Assumed {
                fact: "coloured".to_owned(),
                holds: false,
                evidence: "it has one channel".to_owned(),
                rule: "one-channel".to_owned(),
            }],
            chosen: BTreeMap::from([("order".to_owned(), "inclusive".to_owned())]),
            saved,
        },
        left_out: vec![LeftOut {
            rule: "one-channel".to_owned(),
            reason: "the image has one channel only".to_owned(),
            values: BTreeMap::from([("channel".to_owned(), vec!["mean".to_owned()])]),
            variants: Vec::new(),
            against: "channel=mean".to_owned(),
            saved,
        }],
    };
    let files = |purpose| {
        let parts = Parts {
            library: &library,
            variants: &validated,
            functions: None,
            changelog: None,
            source_hash: "",
            purpose,
        };
        package::build(&parts, &BTreeSet::new()).unwrap()
    };
    let made = files(Some(&purpose));
    let read = |bytes: &[u8]| -> serde_json::Value { serde_json::from_slice(bytes).unwrap() };
    let manifest: Manifest = serde_json::from_slice(&made["manifest.json"]).unwrap();
    assert_eq!(manifest.made_for, Some(purpose.made_for.clone()));
    assert_eq!(manifest.left_out, purpose.left_out);
    let schema = jsonschema::validator_for(&read(&made["manifest.schema.json"])).unwrap();
    assert!(schema.is_valid(&read(&made["manifest.json"])));
    let readme = text(&made, "README.md");
    assert!(readme.contains("Made for a grey image") && readme.contains("it has one channel"));
    // Negative controls: a package for any input says nothing of the kind, and a rule needs its reason.
    let any = files(None);
    let manifest: Manifest = serde_json::from_slice(&any["manifest.json"]).unwrap();
    assert_eq!((manifest.made_for, manifest.left_out), (None, Vec::new()));
    assert!(!text(&any, "README.md").contains("Made for"));
    let mut broken = read(&made["manifest.json"]);
    drop(broken["left_out"][0].as_object_mut().unwrap().remove("reason"));
    assert!(!schema.is_valid(&broken));
}

#[test]
fn what_a_variant_weighs_is_what_the_package_says_of_it() {
    let library = foreign_library();
    let files = build(&library, &library.selected(), &[]);
    let manifest: Manifest = serde_json::from_slice(&files["manifest.json"]).unwrap();
    let weights = package::weigh(&library, &library.selected()).unwrap();
    assert_eq!(weights.len(), manifest.variants.len());
    for variant in &manifest.variants {
        let weight = weights[&variant.id];
        assert_eq!(weight.bindings, variant.bindings.len() as u64);
        assert_eq!(weight.shader_bytes, files[&variant.files[0].path].len() as u64);
        let operations: u64 = variant.cost.values().map(|cost| cost.text().scalars()).sum();
        assert!(operations > 0 && weight.static_operations == operations, "{}", variant.id);
    }
}

#[test]
fn bindings_know_every_exclusion() {
    // The generated rules decide as `Library::excluded` does; their text is Rust that `syn` reads.
    let library = foreign_library();
    let files = build(&library, &library.selected(), &[Target::Rust]);
    let bindings = String::from_utf8(files["rust/lib.rs"].clone()).unwrap();
    assert!(syn::parse_file(&bindings).is_ok());
    assert!(syn::parse_file(&bindings.replacen("pub enum", "pub enumeration", 1)).is_err());
    for excluded in library.excluded() {
        assert!(bindings.contains(&format!("name: \"{}\"", excluded.exclusion)));
    }
}

#[test]
fn what_is_written_is_written_once() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("deep/package");
    let (first, _) = generate_into(&out, None);
    assert!(first.unchanged.is_empty() && first.removed.is_empty());
    assert_eq!(differences(&out), []);
    let (second, _) = generate_into(&out, None);
    assert_eq!(second, Outcome { unchanged: first.written, ..Outcome::default() });
    // Nothing is left beside the package.
    assert_eq!(fs::read_dir(out.parent().unwrap()).unwrap().count(), 1);
}

#[test]
fn every_difference_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    generate_into(out, None);
    let shader = "wgsl/count-counter_direct.wgsl";
    let mut bytes = fs::read(out.join(shader)).unwrap();
    bytes[100] ^= 1;
    fs::write(out.join(shader), bytes).unwrap();
    fs::remove_file(out.join("README.md")).unwrap();
    fs::write(out.join("notes.txt"), "mine").unwrap();
    let expected =
        [("README.md", Change::Missing), ("notes.txt", Change::Extra), (shader, Change::ByHand)]
            .map(|(path, change)| (path.to_owned(), change));
    assert_eq!(differences(out), expected);
    let found = package::verify_hashes(out).unwrap();
    let of = |difference: Difference| (difference.path, difference.change);
    assert_eq!(found.into_iter().map(of).collect::<Vec<_>>(), expected);

    // Writing repairs what belongs to the package and leaves alone what does not.
    let (outcome, _) = generate_into(out, None);
    assert_eq!(outcome.written, ["README.md", shader]);
    assert_eq!(outcome.removed, Vec::<String>::new());
    assert_eq!(differences(out), [("notes.txt".to_owned(), Change::Extra)]);
}

/// Why a package may not be written to a folder.
fn refusal(options: &Options) -> String {
    match package::generate(&foreign_root(), options, &mut |_| ()) {
        Err(error @ (Error::NotOurs { .. } | Error::Committed { .. })) => error.to_string(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_folder_that_is_no_package_is_left_alone() {
    let (folder, own) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let out = folder.path();
    generate_into(own.path(), None);
    let manifest = fs::read_to_string(own.path().join("manifest.json")).unwrap();
    let sums = fs::read_to_string(own.path().join("SHA256SUMS")).unwrap();
    let sealed = |text: &str| {
        format!("{}  manifest.json\n", sglow_shader_gen::hash::sha256(text.as_bytes()))
    };
    let extension = r#"{ "manifest_version": 3, "name": "tabs", "version": "1.0" }"#;
    let other = manifest.replacen("\"name\": \"sglow-shader-gen\"", "\"name\": \"webpack\"", 1);
    assert_ne!(manifest, other);
    let changed = manifest.replacen("\"package\"", "\"parcel\"", 1);
    for (manifest, sums, why) in [
        (None, None, "no `manifest.json`"),
        (None, Some(sums.as_str()), "no `manifest.json`"),
        (Some(extension), None, "no `SHA256SUMS`"),
        (Some(extension), Some(sums.as_str()), "is not the one that its `SHA256SUMS` names"),
        (Some(extension), Some(&*sealed(extension)), "another program's"),
        (Some(&*other), Some(&*sealed(&other)), "another program's"),
        (Some(&*changed), Some(sums.as_str()), "is not the one that its `SHA256SUMS` names"),
        (Some(&*manifest), Some(&*sums.to_uppercase()), "none of a package"),
        (Some(&*manifest), Some(&*(sums.clone() + &sums)), "none of a package"),
        (
            Some(&*manifest),
            Some(&*format!("{sums}{}  ../b\n", "0".repeat(64))),
            "none of a package",
        ),
    ] {
        fs::write(out.join("README.md"), "mine").unwrap();
        for (name, text) in [("manifest.json", manifest), ("SHA256SUMS", sums)] {
            let _ = fs::remove_file(out.join(name));
            if let Some(text) = text {
                fs::write(out.join(name), text).unwrap();
            }
        }
        let text = refusal(&Options::new(out));
        assert!(text.contains(why), "{text}");
        assert_eq!(fs::read_to_string(out.join("README.md")).unwrap(), "mine");
        assert!(!out.join("wgsl").exists(), "{why}");
    }
    // Negative control: manifest and hashes that fit each other make it ours, whatever has become of the rest.
    for (name, text) in [("manifest.json", &manifest), ("SHA256SUMS", &sums)] {
        fs::write(out.join(name), text).unwrap();
    }
    generate_into(out, None);
    assert_eq!(differences(out), []);
}

#[test]
fn the_committed_package_takes_no_other_and_is_mended_whatever_it_is() {
    let folder = crate::edited(&[]);
    let out = folder.path().join("packages/tally");
    let write = |options: &Options| package::generate(folder.path(), options, &mut |_| ());
    let usual = Options::new(&out);
    write(&usual).unwrap();
    // As a merge leaves it.
    fs::write(out.join("manifest.json"), "<<<<<<< ours\n").unwrap();
    fs::write(out.join("SHA256SUMS"), "<<<<<<< ours\n").unwrap();
    write(&usual).unwrap();
    assert!(package::verify_hashes(&out).unwrap().is_empty());
    let sums = fs::read(out.join("SHA256SUMS")).unwrap();
    let another = [
        Options { variants: Some(Vec::new()), ..usual.clone() },
        Options { targets: BTreeSet::from(Target::ALL), ..usual.clone() },
        Options {
            out: folder.path().join("packages/../packages/tally"),
            targets: BTreeSet::new(),
            ..usual
        },
    ];
    for options in another {
        let refused = write(&options);
        assert!(matches!(refused, Err(Error::Committed { .. })), "{refused:?}");
        assert_eq!(fs::read(out.join("SHA256SUMS")).unwrap(), sums);
    }
}

#[test]
fn names_and_paths_of_a_library_stay_in_its_folder() {
    let load = |edits: &[(&str, &str, &str)]| Library::load(crate::edited(edits).path());
    for name in ["../../x", "/x", "", "a/b", "..", ".git"] {
        for table in ["library", "package"] {
            let text = load(&[(
                "library.toml",
                &format!("[{table}]\nname = \"tally\""),
                &format!("[{table}]\nname = \"{name}\""),
            )]);
            let text = text.unwrap_err().to_string();
            assert!(text.contains(&format!("no name for a {table}")), "{text}");
        }
    }
    for source in ["../../..", "/", "src/../..", ""] {
        let text = load(&[("library.toml", "source = \"src\"", &format!("source = \"{source}\""))]);
        let text = text.unwrap_err().to_string();
        assert!(text.contains("leads out of the library's folder"), "{text}");
    }
    for (name, file) in [("frame", "frame.toml"), ("presets", "none.toml"), ("inputs", "none.toml")]
    {
        let given = format!("source = \"src\"\n{name} = \"../{file}\"");
        let known = format!("frame = \"{file}\"\n");
        let without = if name == "frame" { known.as_str() } else { "" };
        let text =
            load(&[("library.toml", without, ""), ("library.toml", "source = \"src\"", &given)]);
        let text = text.unwrap_err().to_string();
        assert!(text.contains("leads out of the library's folder"), "{name}: {text}");
    }
}

#[test]
fn spaces_of_variants_are_bounded() {
    let values: String = (0..40)
        .map(|n| format!("[[axis.more.value]]\nname = \"v{n}\"\ndescription = \"d\"\n"))
        .collect();
    let axis = |n: usize| {
        format!(
            "[axis.a{n}]\ndescription = \"d\"\ndefault = \"v0\"\n{}",
            values.replace("more", &format!("a{n}"))
        )
    };
    let axes: String = (0..5).map(axis).collect();
    let names: String = (0..5).map(|n| format!("\"a{n}\", ")).collect();
    let library = crate::edited(&[
        ("library.toml", "[package]", &format!("{axes}\n[package]")),
        ("library.toml", "axes = [\"channel\"", &format!("axes = [{names}\"channel\"")),
    ]);
    let text = Library::load(library.path()).unwrap_err().to_string();
    assert!(text.contains("combinations of values"), "{text}");
}

#[test]
fn what_is_no_longer_generated_is_removed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let mut options = Options::new(out);
    options.targets.insert(Target::Spirv);
    package::generate(&foreign_root(), &options, &mut |_| ()).unwrap();
    let found = differences(out);
    assert!(found.contains(&("spirv/scan.spv".to_owned(), Change::Stale)), "{found:?}");
    assert!(found.contains(&("manifest.json".to_owned(), Change::Outdated)), "{found:?}");
    fs::write(out.join("notes.txt"), "mine").unwrap();
    let (outcome, _) = generate_into(out, None);
    assert!(outcome.removed.contains(&"spirv/scan.spv".to_owned()));
    assert!(!out.join("spirv").exists());
    assert!(out.join("notes.txt").exists());
}

#[test]
fn nothing_is_generated_when_nothing_has_changed() {
    let folder = tempfile::tempdir().unwrap();
    let (out, cache) = (folder.path().join("package"), folder.path().join("cache"));
    let (first, steps) = generate_into(&out, Some(&cache));
    assert!(!steps.contains(&Progress::Unchanged));
    let (second, steps) = generate_into(&out, Some(&cache));
    assert_eq!(steps, [Progress::Unchanged]);
    assert_eq!(second.unchanged, first.written);
    // Negative control: one byte of the package, and everything is looked at again.
    fs::write(out.join("CHANGELOG.md"), "# Changed\n").unwrap();
    let (third, steps) = generate_into(&out, Some(&cache));
    assert!(!steps.contains(&Progress::Unchanged));
    assert_eq!(third.written, ["CHANGELOG.md"]);
}

#[test]
fn the_source_hash_knows_sources_selection_and_targets() {
    let library = foreign_library();
    let all = BTreeSet::from(Target::ALL);
    let variants = library.selected();
    let hash = package::source_hash(&library, &variants, None, &all);
    assert_eq!(hash, package::source_hash(&foreign_library(), &variants, None, &all));
    let others = [
        package::source_hash(&library, &variants[1..], None, &all),
        package::source_hash(&library, &variants, Some("# Changelog\n"), &all),
        package::source_hash(&library, &variants, None, &BTreeSet::from([Target::Wgsl])),
        package::source_hash(&zoo("a: f32"), &variants, None, &all),
    ];
    for other in others {
        assert_ne!(hash, other);
    }
}

/// A library of one pass that reads a struct with these fields from a buffer.
fn zoo(fields: &str) -> Library {
    zoo_with(fields, "size")
}

/// The same; its one axis is called `axis`.
fn zoo_with(fields: &str, axis: &str) -> Library {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("src")).unwrap();
    fs::write(
        folder.path().join("library.toml"),
        r#"
[axis.AXIS]
description = "a choice"
default = "type"
[[axis.AXIS.value]]
name = "type"
description = "a keyword"
[[axis.AXIS.value]]
name = "2d"
description = "a digit first"
[library]
name = "zoo"
version = "0.1.0"
description = "Layouts"
license = "MIT"
prefix = "zoo_"
source = "src"
[[pass]]
name = "look"
description = "looks"
source = "look.wesl"
entry_points = ["zoo_look"]
axes = ["AXIS"]
[package]
name = "zoo"
select = [{ pass = "look" }]
"#
        .replace("AXIS", axis),
    )
    .unwrap();
    let source = format!(
        "/// Within another.
struct ZooInner {{
    /// Unit.
    axis: vec3<f32>,
    @size(16) weight: f32,
}}
struct ZooOuter {{
    {fields}
}}
@group(0) @binding(1) var<storage, read_write> zoo_outer: ZooOuter;
@group(2) @binding(0) var<uniform> zoo_inner: ZooInner;
@compute @workgroup_size(1)
fn zoo_look() {{
    zoo_outer.a = zoo_inner.weight;
}}
"
    );
    fs::write(folder.path().join("src/look.wesl"), source).unwrap();
    Library::load(folder.path()).unwrap_or_else(|report| panic!("{report}"))
}

#[test]
fn structs_have_the_layout_of_the_shaders() {
    let fields = "a: f32,
    /// A direction.
    b: vec3<f32>,
    c: vec2<i32>,
    d: array<vec3<f32>, 2>,
    e: mat3x3<f32>,
    f: mat2x2<f32>,
    g: ZooInner,
    h: array<ZooInner, 3>,
    i: atomic<u32>,
    j: array<atomic<i32>, 5>,
    k: vec4<u32>,
    type_: u32,
    rest: array<ZooInner>,";
    let library = zoo(fields);
    let files = build(&library, &library.selected(), &[Target::Rust]);
    let bindings = String::from_utf8(files["rust/lib.rs"].clone()).unwrap();
    let structs = &bindings[bindings.find("/// Does not compile where").unwrap()..];
    snapshot("package/layouts.rs", structs);
}

#[test]
fn names_that_collide_in_rust_are_refused() {
    let failure = |axis: &str| {
        let library = zoo_with("a: f32", axis);
        let validated = generate::variants(&library, &library.selected()).unwrap();
        let parts = Parts {
            library: &library,
            variants: &validated,
            functions: None,
            changelog: None,
            source_hash: "",
            purpose: None,
        };
        let built = package::build(&parts, &BTreeSet::from([Target::Rust]));
        built.err().map(|error| error.to_string())
    };
    assert_eq!(failure("type"), None);
    for axis in ["variant", "zoo_inner"] {
        let error = failure(axis).unwrap();
        assert!(error.contains(&format!("the axis `{axis}`")), "{error}");
    }
}

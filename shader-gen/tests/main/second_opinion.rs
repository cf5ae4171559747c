//! The same sources through the `wesl` crate, an independent reader of WESL.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use sglow_shader_gen::generate;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::matrix::Variant;
use sglow_shader_gen::parse::parse;
use sglow_shader_gen::prune::prove;
use sglow_shader_gen::validate::{Validated, validator};
use wesl::syntax::{ModulePath, PathOrigin};
use wesl::{CompileOptions, Feature, ManglerKind, Wesl};

use crate::foreign_root;

/// WGSL of all modules that a variant imports, by the `wesl` crate with the flags `holds`.
fn compile(root: &Path, library: &Library, variant: &Variant, holds: &BTreeSet<&str>) -> String {
    let pass = library.find_pass(&variant.pass).unwrap();
    let path = pass.source.trim_end_matches(".wesl").split('/').map(str::to_owned).collect();
    let mut compiler = Wesl::new(root.join(&library.library.source));
    compiler.set_options(CompileOptions { strip: false, lazy: false, ..CompileOptions::default() });
    compiler.set_mangler(ManglerKind::None);
    compiler.set_missing_feature_behavior(Feature::Error);
    for flag in library.flags() {
        compiler.set_feature(flag, holds.contains(flag));
    }
    let path = ModulePath { origin: PathOrigin::Absolute, components: path };
    compiler.compile(&path).unwrap_or_else(|error| panic!("{variant}: {error}")).to_string()
}

/// `other` with its declarations in the order of `text`, so that naga numbers both alike.
fn in_the_order_of(text: &str, other: &str) -> String {
    let names = |text: &str| -> Vec<(String, String)> {
        let mut errors = Vec::new();
        let module = parse(0, "", text, &mut errors);
        assert_eq!(errors, []);
        let directives = module.directives.iter().map(|item| (String::new(), item.whole.clone()));
        let declarations = module.declarations.iter().map(|declaration| {
            let name = declaration.name.as_ref().map(|(name, _)| name.clone());
            (name.unwrap_or_default(), declaration.item.whole.clone())
        });
        directives.chain(declarations).map(|(name, range)| (name, text[range].to_owned())).collect()
    };
    let order: HashMap<String, usize> =
        names(text).into_iter().enumerate().map(|(index, (name, _))| (name, index)).collect();
    let mut declarations = names(other);
    declarations.sort_by_key(|(name, _)| {
        if name.is_empty() { 0 } else { order.get(name).map_or(usize::MAX, |index| index + 1) }
    });
    declarations.into_iter().map(|(_, text)| text + "\n").collect()
}

/// Whether the `wesl` crate makes the same of a variant's sources when the flags `holds` hold.
fn agrees(
    root: &Path,
    library: &Library,
    validated: &Validated,
    holds: &BTreeSet<&str>,
) -> Result<(), String> {
    let variant = &validated.variant;
    let text = in_the_order_of(&validated.text, &compile(root, library, variant, holds));
    let read = |text: &str| {
        let module = naga::front::wgsl::parse_str(text)
            .map_err(|error| format!("{variant}: {}\n{text}", error.emit_to_string(text)))?;
        validator(&library.requires(variant))
            .validate(&module)
            .map_err(|error| format!("{variant}: {}", error.emit_to_string(text)))?;
        Ok::<_, String>(module)
    };
    let entry_points = &library.find_pass(&variant.pass).unwrap().entry_points;
    prove(&validated.module, Some(read(&text)?), entry_points)
        .map_err(|error| format!("{variant}: {error}"))
}

/// Variants that have every legal pair of values of two axes of their pass, the first ones that have it: conditions in
/// the sources join two axes at the most.
fn with_every_pair(variants: Vec<Variant>) -> Vec<Variant> {
    let mut seen = BTreeSet::new();
    let mut adds = |variant: &Variant| {
        let values = &variant.values;
        let mut new = seen.insert((variant.pass.clone(), String::new(), String::new()));
        for (at, one) in values.iter().enumerate() {
            for other in &values[at..] {
                let pair = [one, other].map(|(axis, value)| format!("{axis}={value}"));
                let [one, other] = pair;
                new |= seen.insert((variant.pass.clone(), one, other));
            }
        }
        new
    };
    variants.into_iter().filter(|variant| adds(variant)).collect()
}

/// Compares variants of the library at `root` that have every pair of values.
fn compare(root: &Path) {
    let library = Library::load(root).unwrap_or_else(|report| panic!("{report}"));
    let variants = with_every_pair(library.variants());
    assert!(!variants.is_empty());
    let validated =
        generate::variants(&library, &variants).unwrap_or_else(|report| panic!("{report}"));
    let differences: Vec<_> = validated
        .iter()
        .filter_map(|one| agrees(root, &library, one, &library.flags_of(&one.variant)).err())
        .collect();
    assert!(differences.is_empty(), "{}", differences.join("\n"));
}

#[test]
fn the_foreign_library_is_read_alike() {
    compare(&foreign_root());
}

#[test]
fn our_own_library_is_read_alike() {
    compare(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders"));
}

#[test]
fn other_flags_are_noticed() {
    let library = Library::load(&foreign_root()).unwrap();
    let variant = library.variant("scan", &[("order", "inclusive")]).unwrap();
    let validated = generate::variants(&library, &[variant]).unwrap().remove(0);
    let none = BTreeSet::new();
    assert!(agrees(&foreign_root(), &library, &validated, &none).is_err());
}

//! The same sources through the `wesl` crate, an independent reader of WESL.

use std::collections::{BTreeSet, HashMap};
use std::fs;
use std::path::Path;

use naga::{Block, Module, Statement};
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
    // What has no name: a directive, or an assertion.
    const DIRECTIVE: &str = "directive";
    const ASSERTION: &str = "const_assert";
    let names = |text: &str| -> Vec<(String, String)> {
        let mut errors = Vec::new();
        let module = parse(0, "", text, &mut errors);
        assert_eq!(errors, []);
        let directives =
            module.directives.iter().map(|item| (DIRECTIVE.to_owned(), item.whole.clone()));
        let declarations = module.declarations.iter().map(|declaration| {
            let name = declaration.name.as_ref().map(|(name, _)| name.clone());
            (name.unwrap_or_else(|| ASSERTION.to_owned()), declaration.item.whole.clone())
        });
        directives.chain(declarations).map(|(name, range)| (name, text[range].to_owned())).collect()
    };
    let order: HashMap<String, usize> =
        names(text).into_iter().enumerate().map(|(index, (name, _))| (name, index)).collect();
    let mut declarations = names(other);
    declarations.sort_by_key(|(name, _)| {
        if name == DIRECTIVE { 0 } else { order.get(name).map_or(usize::MAX, |index| index + 1) }
    });
    declarations.into_iter().map(|(_, text)| text + "\n").collect()
}

/// The statements of blocks that stand by themselves in the place of these: the generator unwraps the block of a condition
/// that holds, the `wesl` crate does not. Names are resolved by now, so that a block is no scope any more.
fn unwrap_blocks(module: &mut Module) {
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    let entry_points = module.entry_points.iter_mut().map(|entry_point| &mut entry_point.function);
    for function in functions.chain(entry_points) {
        unwrap_blocks_in(&mut function.body);
    }
}

fn unwrap_blocks_in(block: &mut Block) {
    let mut unwrapped = Block::new();
    for (statement, span) in std::mem::take(block).span_into_iter() {
        let mut statement = statement;
        match &mut statement {
            Statement::Block(inner) => {
                unwrap_blocks_in(inner);
                unwrapped.append(inner);
                continue;
            }
            Statement::If { accept, reject, .. } => {
                unwrap_blocks_in(accept);
                unwrap_blocks_in(reject);
            }
            Statement::Switch { cases, .. } => {
                cases.iter_mut().for_each(|case| unwrap_blocks_in(&mut case.body));
            }
            Statement::Loop { body, continuing, .. } => {
                unwrap_blocks_in(body);
                unwrap_blocks_in(continuing);
            }
            _ => {}
        }
        unwrapped.push(statement, span);
    }
    *block = unwrapped;
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
    let (mut ours, mut theirs) = (validated.module.clone(), read(&text)?);
    unwrap_blocks(&mut ours);
    unwrap_blocks(&mut theirs);
    prove(&ours, Some(theirs), entry_points).map_err(|error| format!("{variant}: {error}"))
}

/// Variants that have every legal pair of values of two axes of their pass, the first ones that have it: conditions in
/// the sources join two axes at the most.
pub(crate) fn with_every_pair(variants: Vec<Variant>) -> Vec<Variant> {
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

/// The modules of a library as files below a folder, those included that no file of its own holds.
fn written(library: &Library) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let files = library.sources().files().iter();
    for file in files.filter(|file| file.path.ends_with(".wesl")) {
        let path = folder.path().join(&file.path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, &file.text).unwrap();
    }
    folder
}

/// Compares variants of the library at `root` that have every pair of values.
fn compare(root: &Path) {
    let library = Library::load(root).unwrap_or_else(|report| panic!("{report}"));
    let folder = written(&library);
    let variants = with_every_pair(library.variants());
    assert!(!variants.is_empty());
    let validated =
        generate::variants(&library, &variants).unwrap_or_else(|report| panic!("{report}"));
    let differences: Vec<_> = validated
        .iter()
        .filter_map(|one| {
            agrees(folder.path(), &library, one, &library.flags_of(&one.variant)).err()
        })
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

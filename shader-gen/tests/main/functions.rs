//! The functions of a package: each once in the text of all, and once in the modules, which the `wesl` crate reads alike.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use sglow_shader_gen::emit::wgsl;
use sglow_shader_gen::functions::functions;
use sglow_shader_gen::library::Library;
use sglow_shader_gen::parse::parse;
use wesl::syntax::{ModulePath, PathOrigin};
use wesl::{CompileOptions, ManglerKind, Wesl};

/// The declarations of some texts by name; one that stands twice is an error.
fn declarations<'a>(
    texts: impl IntoIterator<Item = &'a str>,
) -> Result<BTreeMap<String, String>, String> {
    let mut found = BTreeMap::new();
    for text in texts {
        // Imports of neighbours are WESL that libraries themselves do not use.
        let start =
            text.rfind("};\n\n").filter(|_| text.starts_with("import")).map_or(0, |end| end + 4);
        let text = &text[start..];
        let mut errors = Vec::new();
        let module = parse(0, "", text, &mut errors);
        assert_eq!(errors, []);
        for declaration in module.declarations {
            let Some((name, _)) = declaration.name else { continue };
            if found.insert(name.clone(), text[declaration.item.whole].to_owned()).is_some() {
                return Err(name);
            }
        }
    }
    Ok(found)
}

#[test]
fn our_functions_stand_once_in_either_form() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let library = Library::load(&root).unwrap_or_else(|report| panic!("{report}"));
    let functions = functions(&library).unwrap_or_else(|report| panic!("{report}")).unwrap();
    let whole = declarations([&*functions.whole]).unwrap();
    let modules = || functions.modules.iter().map(|module| &*module.text);
    assert_eq!(declarations(modules()).unwrap(), whole);
    assert!(whole.contains_key("sglow_D_GGX") && whole.contains_key("SGLOW_PI"));
    // Negative control: what stands in two modules is named.
    let twice = modules().chain(["const SGLOW_PI: f32 = 3.0;"]);
    assert_eq!(declarations(twice), Err("SGLOW_PI".to_owned()));
}

#[test]
fn another_reader_of_wesl_links_the_modules() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let library = Library::load(&root).unwrap_or_else(|report| panic!("{report}"));
    let functions = functions(&library).unwrap_or_else(|report| panic!("{report}")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let files = wgsl::functions(&library, &functions);
    for (_, path, text) in files.iter().filter(|(_, path, _)| path.ends_with(".wesl")) {
        fs::write(folder.path().join(Path::new(path).file_name().unwrap()), text).unwrap();
    }
    let compile = |module: &str| {
        let mut compiler = Wesl::new(folder.path());
        compiler.set_options(CompileOptions {
            strip: false,
            lazy: false,
            ..CompileOptions::default()
        });
        compiler.set_mangler(ManglerKind::None);
        let path = ModulePath { origin: PathOrigin::Absolute, components: vec![module.to_owned()] };
        compiler.compile(&path).map(|compiled| compiled.to_string())
    };
    assert_eq!(functions.modules.len(), library.package.lib.len());
    for module in &functions.modules {
        let text = compile(&module.name).unwrap_or_else(|error| panic!("{}: {error}", module.name));
        let read = naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
        let own = declarations([&*module.text]).unwrap();
        let names: Vec<_> =
            read.functions.iter().filter_map(|(_, function)| function.name.clone()).collect();
        let is_function = |text: &str| text.lines().any(|line| line.starts_with("fn "));
        for (name, _) in own.iter().filter(|(_, text)| is_function(text)) {
            assert!(names.contains(name), "{}: {name}", module.name);
        }
    }
    // Negative control: without a neighbour there is nothing to link.
    fs::remove_file(folder.path().join("math.wesl")).unwrap();
    assert!(compile("sg").is_err());
}

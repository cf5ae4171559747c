//! The final WGSL file: a head that says what the text is, and the text itself, byte for byte.

use crate::functions::Functions;
use crate::library::{Library, Pass};
use crate::matrix::Variant;

/// The name and version of what writes the text, for the manifest.
pub const TOOL: &str = concat!("sglow shader-gen ", env!("CARGO_PKG_VERSION"));

/// The file of a variant whose pruned text is `text`.
#[must_use]
pub fn variant(library: &Library, variant: &Variant, text: &str) -> String {
    let pass = library.find_pass(&variant.pass);
    let description = pass.map_or("", |pass| pass.description.as_str());
    let mut head = vec![format!("{}: {description}", variant.pass), String::new()];
    for (axis, value) in variant.named() {
        let known = library.axis.get(axis);
        let known = known.and_then(|axis| axis.value.iter().find(|known| known.name == *value));
        let meaning = known.map_or("", |known| known.description.as_str());
        head.push(format!("{axis} = {value}: {meaning}"));
    }
    let contract = library.contract_of(variant);
    if !contract.is_empty() {
        if !variant.values.is_empty() {
            head.push(String::new());
        }
        head.push("Contract:".to_owned());
        head.extend(contract.iter().map(|line| format!("- {line}")));
    }
    if head.last().is_some_and(|last| !last.is_empty()) {
        head.push(String::new());
    }
    file(
        library,
        &head,
        &format!("Variant {}, generated", variant.id()),
        &sources(library, pass),
        text,
    )
}

/// The files of functions for hosts that bring their own passes, each with its name and its path: one that has all of them
/// as WGSL, and for each module one that imports its neighbours as WESL.
#[must_use]
pub fn functions(library: &Library, functions: &Functions) -> Vec<(String, String, String)> {
    let name = &library.library.name;
    let modules: Vec<_> = library.package.lib.iter().flat_map(|lib| &lib.modules).collect();
    let head = [
        format!("{name}: all functions for passes of your own; no bindings, no entry points"),
        String::new(),
    ];
    let whole = file(library, &head, "Generated", &sources_of(library, modules), &functions.whole);
    let mut files = vec![(name.clone(), format!("wgsl/{name}.wgsl"), whole)];
    for module in &functions.modules {
        let declared = library.package.lib.iter().find(|lib| lib.name == module.name);
        let modules: Vec<_> = declared.iter().flat_map(|lib| &lib.modules).collect();
        let head = [
            format!(
                "{}: functions of {name} as a module of WESL, beside those that it imports",
                module.name
            ),
            String::new(),
        ];
        let text = file(library, &head, "Generated", &sources_of(library, modules), &module.text);
        files.push((module.name.clone(), format!("wgsl/lib/{}.wesl", module.name), text));
    }
    files
}

fn sources_of(library: &Library, modules: Vec<&String>) -> String {
    modules.into_iter().map(|module| path(library, module)).collect::<Vec<_>>().join(", ")
}

fn path(library: &Library, module: &str) -> String {
    format!("{}/{module}", library.library.source)
}

fn sources(library: &Library, pass: Option<&Pass>) -> String {
    pass.map_or_else(|| library.library.name.clone(), |pass| path(library, &pass.source))
}

/// A line of a comment in lines of at most [`WIDTH`] characters; those that continue it are indented.
fn wrapped(line: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in line.split(' ') {
        let Some(last) = lines.last_mut() else { continue };
        let length = last.chars().count() + 1 + word.chars().count();
        if !last.trim().is_empty() && length > WIDTH {
            lines.push(format!("  {word}"));
        } else {
            if !last.is_empty() {
                last.push(' ');
            }
            last.push_str(word);
        }
    }
    lines
}

/// How many characters of a comment stand in a line, without its slashes.
const WIDTH: usize = 117;

fn file(library: &Library, head: &[String], what: &str, sources: &str, text: &str) -> String {
    let generated = format!(
        "{what} by {TOOL} from {sources} of {} {}.",
        library.library.name, library.library.version
    );
    let license = format!("SPDX-License-Identifier: {}", library.library.license);
    let lines = std::iter::once(license.as_str())
        .chain(head.iter().map(String::as_str))
        .chain([generated.as_str(), "Do not edit; regenerate with `cargo xtask gen-shaders`."]);
    let mut file = String::new();
    for line in lines {
        for part in wrapped(line) {
            file.push_str(format!("// {part}").trim_end());
            file.push('\n');
        }
    }
    file.push('\n');
    file.push_str(text.trim_start_matches('\n'));
    file
}

//! Functions that are evaluated over a buffer: from a call in the declaration to the function that reads its arguments and
//! stores its results.
//!
//! Each value with a `call` on the axis of `[calls]` gets such a function in a module that no file holds, under a flag of its
//! own; a pass imports it. What is called, and how its results become four numbers, follows from its signature.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use super::Library;
use super::place::Places;
use crate::error::{Code, Diagnostic};
use crate::parse::{Declaration, Kind, Module, parse};
use crate::source::Sources;
use crate::token::{Token, TokenKind, tokenize};

/// The `[calls]` table: where the functions are put that values with a `call` get.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calls {
    /// Name of the axis.
    pub axis: String,
    /// The module that they are put into, relative to [`super::Header::source`]; no file has its name.
    pub module: String,
    /// How each of them is called: it takes `arguments` and returns a `vec4<f32>`.
    pub function: String,
    /// The struct of arguments; a call names its members.
    pub arguments: String,
}

/// The modules of a library with their texts.
struct Known<'a> {
    modules: &'a [Module],
    sources: &'a Sources,
}

impl<'a> Known<'a> {
    /// The module that declares `name`, and the first declaration of it.
    fn find(&self, name: &str) -> Option<(&'a Module, &'a Declaration)> {
        let named = |declaration: &&Declaration| {
            declaration.name.as_ref().is_some_and(|(declared, _)| declared == name)
        };
        self.modules
            .iter()
            .find_map(|module| Some((module, module.declarations.iter().find(named)?)))
    }

    fn text(&self, module: &Module, declaration: &Declaration) -> &'a str {
        &self.sources.text(module.file)[declaration.item.whole.clone()]
    }

    /// The members of a struct with their types.
    fn members(&self, name: &str) -> BTreeMap<&'a str, String> {
        let found = self.find(name).filter(|(_, declaration)| declaration.kind == Kind::Struct);
        let Some((module, declaration)) = found else {
            return BTreeMap::new();
        };
        let text = self.text(module, declaration);
        let tokens = code(text);
        let mut members = BTreeMap::new();
        for (index, token) in tokens.iter().enumerate().filter(|(_, token)| token.is(b':')) {
            let Some(name) = index.checked_sub(1).map(|before| tokens[before]) else {
                continue;
            };
            let mut depth = 0usize;
            let end = tokens[index + 1..].iter().find(|token| {
                depth += usize::from(token.is(b'<'));
                let ends = depth == 0 && (token.is(b',') || token.is(b'}'));
                depth -= usize::from(token.is(b'>') && depth > 0);
                ends
            });
            let end = end.map_or(text.len(), |end| end.start);
            members.insert(&text[name.range()], text[token.end..end].trim().to_owned());
        }
        members
    }

    /// The type that a function returns, as it is written.
    fn returned(&self, name: &str) -> Option<String> {
        let (module, declaration) = self.find(name)?;
        if declaration.kind != Kind::Function {
            return None;
        }
        let (_, name) = declaration.name.as_ref()?;
        let head = &self.sources.text(module.file)[name.end..declaration.body];
        Some(head.rsplit_once("->")?.1.trim().to_owned())
    }
}

/// The tokens of `text` without its comments.
fn code(text: &str) -> Vec<Token> {
    let tokens = tokenize(0, text, &mut Vec::new()).into_iter();
    tokens.filter(|token| token.kind != TokenKind::Comment).collect()
}

/// How many numbers a type holds: those of floats alone are known.
fn width(ty: &str) -> Option<usize> {
    match ty.replace(' ', "").as_str() {
        "f32" => Some(1),
        "vec2<f32>" | "vec2f" => Some(2),
        "vec3<f32>" | "vec3f" => Some(3),
        "vec4<f32>" | "vec4f" => Some(4),
        _ => None,
    }
}

/// `parts`, which hold `held` numbers, as a `vec4<f32>`.
fn vector(parts: &[String], held: usize) -> String {
    match parts {
        [part] if held == 4 => part.clone(),
        _ => {
            let zeros = (held..4).map(|_| "0.0".to_owned());
            let parts: Vec<_> = parts.iter().cloned().chain(zeros).collect();
            format!("vec4<f32>({})", parts.join(", "))
        }
    }
}

impl Library {
    /// Each value with a call has a flag of its own.
    pub(super) fn flag_calls(&mut self) {
        let axis =
            self.calls.as_ref().and_then(|calls| Some((calls, self.axis.get_mut(&calls.axis)?)));
        let Some((calls, axis)) = axis else {
            return;
        };
        for value in axis.value.iter_mut().filter(|value| value.call.is_some()) {
            value.flags.push(format!("{}_{}", calls.axis, value.name));
        }
    }

    /// The module of the functions that calls get, if there are any.
    pub(super) fn call_module(
        &self,
        modules: &[Module],
        places: &Places<'_>,
        sources: &mut Sources,
        errors: &mut Vec<Diagnostic>,
    ) -> Option<Module> {
        let calls = self.calls.as_ref()?;
        let Some(axis) = self.axis.get(&calls.axis) else {
            let error =
                Diagnostic::unknown("axis", &calls.axis, self.axis.keys().map(String::as_str));
            errors.push(places.mark(error, &["calls", "axis"], "here"));
            return None;
        };
        let path = calls.module.trim_end_matches(".wesl");
        if modules.iter().any(|module| module.path == path) {
            let error = Diagnostic::new(Code::Duplicate, format!("`{path}` is a file, too"));
            errors.push(places.mark(error, &["calls", "module"], "here"));
            return None;
        }
        let known = Known { modules, sources };
        let arguments = known.members(&calls.arguments);
        let Some((home, _)) = known.find(&calls.arguments) else {
            let structs = modules.iter().flat_map(|module| &module.declarations);
            let structs = structs.filter(|declaration| declaration.kind == Kind::Struct);
            let names =
                structs.filter_map(|declaration| Some(declaration.name.as_ref()?.0.as_str()));
            let error = Diagnostic::unknown("struct", &calls.arguments, names);
            errors.push(places.mark(error, &["calls", "arguments"], "here"));
            return None;
        };
        let mut imports = vec![format!(
            "import package::{}::{{{}}};\n",
            home.path.replace('/', "::"),
            calls.arguments
        )];
        let mut functions = Vec::new();
        for (index, value) in axis.value.iter().enumerate() {
            let Some(call) = &value.call else {
                continue;
            };
            let flag = format!("{}_{}", calls.axis, value.name);
            match written(&known, call, &value.results, &arguments) {
                Ok((named, body)) => {
                    for (module, names) in named {
                        let names: Vec<_> = names.into_iter().collect();
                        let module = module.replace('/', "::");
                        imports.push(format!(
                            "@if({flag}) import package::{module}::{{{}}};\n",
                            names.join(", ")
                        ));
                    }
                    functions.push(format!(
                        "\n@if({flag})\nfn {}(arguments: {}) -> vec4<f32> {{\n{body}}}\n",
                        calls.function, calls.arguments
                    ));
                }
                Err(error) => {
                    let index = index.to_string();
                    let path = ["axis", &calls.axis, "value", &index, "call"];
                    errors.push(places.mark(error, &path, "here"));
                }
            }
        }
        let text = imports.concat() + &functions.concat();
        let file = sources.add(format!("{}/{path}.wesl", self.library.source), text.as_str());
        Some(parse(file, path, &text, errors))
    }
}

/// The names that a call needs by their module, and the statements that turn it into a `vec4<f32>`.
#[allow(clippy::type_complexity, reason = "two results of one reading")]
fn written<'a>(
    known: &Known<'a>,
    call: &str,
    results: &[String],
    arguments: &BTreeMap<&str, String>,
) -> Result<(BTreeMap<&'a str, BTreeSet<String>>, String), Diagnostic> {
    let wrong = |message: String| Diagnostic::new(Code::Declaration, message);
    let tokens = code(call);
    let mut named: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    let mut text = String::new();
    let mut at = 0;
    for (index, token) in tokens.iter().enumerate().filter(|(_, of)| of.kind == TokenKind::Word) {
        let word = &call[token.range()];
        if index > 0 && tokens[index - 1].is(b'.') {
            continue;
        }
        text.push_str(&call[at..token.start]);
        at = token.start;
        if arguments.contains_key(word) {
            text.push_str("arguments.");
        } else if let Some((module, _)) = known.find(word) {
            named.entry(&module.path).or_default().insert(word.to_owned());
        }
    }
    text.push_str(&call[at..]);
    let callee = tokens.first().map_or("", |token| &call[token.range()]);
    // What is no function of the library is a constructor of WGSL's.
    let returned = known.returned(callee);
    let ty = returned.unwrap_or_else(|| match call.split_once('(') {
        Some((constructor, _)) => constructor.trim().to_owned(),
        None => callee.to_owned(),
    });
    if let (Some(held), []) = (width(&ty), results) {
        return Ok((named, format!("    return {};\n", vector(&[text], held))));
    }
    let members = known.members(&ty);
    if members.is_empty() {
        return Err(wrong(format!(
            "`{callee}` is no function of the library with a result that is known"
        ))
        .help(
            "a call begins with a function that returns floats or a struct, or with `vec4<f32>(`",
        ));
    }
    if results.is_empty() {
        let known: Vec<_> = members.keys().copied().collect();
        return Err(wrong(format!("`{callee}` returns a struct"))
            .help(format!("name what is stored in `results`: {}", known.join(", "))));
    }
    let mut held = 0;
    let mut parts = Vec::new();
    for result in results {
        let (member, swizzle) = match result.split_once('.') {
            Some((member, swizzle)) => (member, Some(swizzle)),
            None => (result.as_str(), None),
        };
        let Some(ty) = members.get(member) else {
            return Err(Diagnostic::unknown("member", member, members.keys().copied()));
        };
        held += match swizzle {
            Some(swizzle) => swizzle.len(),
            None => width(ty).ok_or_else(|| wrong(format!("`{member}` holds no floats")))?,
        };
        parts.push(format!("result.{result}"));
    }
    if held > 4 {
        return Err(wrong(format!("{held} results, of at most 4")));
    }
    Ok((named, format!("    let result = {text};\n    return {};\n", vector(&parts, held))))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIBRARY: &str = "struct Arguments { a: vec4<f32>, b: vec4<f32> }
struct Lobe {
    /// Unit: of length 1.
    axis: vec3<f32>,
    sharpness: f32,
    @if(both) other: array<vec4<f32>, 2>,
}
fn square(x: f32) -> f32 { return x * x; }
fn lobe(axis: vec3<f32>, sharpness: f32) -> Lobe { return Lobe(axis, sharpness); }
fn nothing(a: f32) { }
";

    fn body(call: &str, results: &[&str]) -> Result<String, String> {
        let mut sources = Sources::default();
        let file = sources.add("math/all.wesl", LIBRARY);
        let mut errors = Vec::new();
        let modules = [parse(file, "math/all", LIBRARY, &mut errors)];
        assert_eq!(errors, []);
        let known = Known { modules: &modules, sources: &sources };
        let results: Vec<_> = results.iter().map(|&result| result.to_owned()).collect();
        let found = written(&known, call, &results, &known.members("Arguments"));
        let (named, body) = found.map_err(|error| error.message)?;
        assert!(named.keys().all(|module| *module == "math/all"));
        Ok(body)
    }

    #[test]
    fn results_become_four_numbers_by_the_signature() {
        let one = body("square(a.x)", &[]).unwrap();
        assert_eq!(one, "    return vec4<f32>(square(arguments.a.x), 0.0, 0.0, 0.0);\n");
        let many = body("lobe(a.xyz, square(b.a))", &["sharpness", "axis"]).unwrap();
        assert_eq!(
            many,
            "    let result = lobe(arguments.a.xyz, square(arguments.b.a));\n    \
             return vec4<f32>(result.sharpness, result.axis);\n"
        );
        let part = body("lobe(a.xyz, 1.0)", &["axis.xy"]).unwrap();
        assert!(part.ends_with("return vec4<f32>(result.axis.xy, 0.0, 0.0);\n"), "{part}");
        let whole = body("vec4<f32>(square(a.x), square(b.x), 0.0, 1.0)", &[]).unwrap();
        assert!(whole.starts_with("    return vec4<f32>(square(arguments.a.x), "), "{whole}");
    }

    #[test]
    fn a_call_without_a_result_that_is_known_is_refused() {
        for (call, results, message) in [
            ("cube(a.x)", &[][..], "`cube` is no function"),
            ("nothing(a.x)", &[], "`nothing` is no function"),
            ("lobe(a.xyz, 1.0)", &[], "`lobe` returns a struct"),
            ("lobe(a.xyz, 1.0)", &["width"], "`width` is no known member"),
            ("lobe(a.xyz, 1.0)", &["other"], "`other` holds no floats"),
            ("lobe(a.xyz, 1.0)", &["axis", "axis.xy"], "5 results"),
        ] {
            let error = body(call, results).unwrap_err();
            assert!(error.contains(message), "{call}: {error}");
        }
    }
}

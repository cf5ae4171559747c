//! What is wrong with modules as far as their declaration can tell.

use super::Library;
use super::place::Places;
use crate::condition::Condition;
use crate::error::{Code, Diagnostic};
use crate::parse::{Declaration, Kind, Module};

impl Library {
    pub(super) fn check_modules(
        &self,
        modules: &[Module],
        places: &Places<'_>,
        errors: &mut Vec<Diagnostic>,
    ) {
        let flags = self.flags();
        for module in modules {
            let mut check = |condition: &Option<Condition>| {
                if let Some(condition) = condition {
                    condition.flags(&mut |flag, range| {
                        if !flags.contains(flag) {
                            let error = Diagnostic::unknown("flag", flag, flags.iter().copied());
                            let error =
                                error.at(module.file, range.clone(), "no value of an axis sets it");
                            // An `@else` repeats the conditions before it.
                            if !errors.contains(&error) {
                                errors.push(error);
                            }
                        }
                    });
                }
            };
            module.imports.iter().for_each(|import| check(&import.condition));
            let declarations = module.declarations.iter().map(|declaration| &declaration.item);
            for item in module.directives.iter().chain(declarations) {
                check(&item.condition);
                item.edits.iter().for_each(|edit| check(&edit.keep_if));
            }
            for declaration in &module.declarations {
                self.check_name(module.file, declaration, errors);
            }
        }
        let known = || modules.iter().map(|module| module.path.as_str());
        let mut source = |name: &str, path: &[&str]| {
            let found =
                name.strip_suffix(".wesl").is_some_and(|name| known().any(|known| known == name));
            if !found {
                let known: Vec<_> = known().map(|known| format!("{known}.wesl")).collect();
                let error =
                    Diagnostic::unknown("source file", name, known.iter().map(String::as_str));
                errors.push(places.mark(error, path, "here"));
            }
        };
        for (index, pass) in self.pass.iter().enumerate() {
            source(&pass.source, &["pass", &index.to_string(), "source"]);
        }
        for (index, lib) in self.package.lib.iter().enumerate() {
            for (number, module) in lib.modules.iter().enumerate() {
                source(
                    module,
                    &["package", "lib", &index.to_string(), "modules", &number.to_string()],
                );
            }
        }
    }

    fn check_name(&self, file: usize, declaration: &Declaration, errors: &mut Vec<Diagnostic>) {
        let Some((name, range)) = &declaration.name else {
            return;
        };
        let form = |prefix: &&str| match declaration.kind {
            Kind::Struct | Kind::Alias => camel(prefix),
            Kind::Constant => prefix.to_uppercase(),
            _ => (*prefix).to_owned(),
        };
        let prefixes: Vec<String> = self.prefixes(file).iter().map(form).collect();
        let has = |prefix: &String| name.starts_with(prefix) && name.len() > prefix.len();
        if !prefixes.iter().any(has) {
            let (kind, prefixes) = (declaration.kind.name(), prefixes.join("` or `"));
            errors.push(
                Diagnostic::new(Code::Name, format!("{kind} `{name}` lacks the library's prefix"))
                    .at(file, range.clone(), "declared here")
                    .help(format!(
                        "names are not mangled, so that each {kind} starts with `{prefixes}`"
                    )),
            );
        }
    }

    pub(super) fn check_pass_names(
        &self,
        places: &Places<'_>,
        unread: bool,
        errors: &mut Vec<Diagnostic>,
    ) {
        if unread {
            return;
        }
        for (index, pass) in self.pass.iter().enumerate() {
            let Some(module) = self.graph.module(pass.source.trim_end_matches(".wesl")) else {
                continue;
            };
            let overrides = self.graph.overrides(module);
            for (number, item) in pass.overrides.iter().enumerate() {
                if !overrides.contains(item.name.as_str()) {
                    let kind = format!("override of pass `{}`", pass.name);
                    let error = Diagnostic::unknown(&kind, &item.name, overrides.iter().copied());
                    let path =
                        ["pass", &index.to_string(), "override", &number.to_string(), "name"];
                    errors.push(places.mark(error, &path, "here"));
                }
            }
            for (number, name) in pass.entry_points.iter().enumerate() {
                let known = self.graph.entry_points(module);
                if !known.contains(name.as_str()) {
                    let error = Diagnostic::unknown(
                        &format!("entry point of `{}`", pass.source),
                        name,
                        known,
                    );
                    let path = ["pass", &index.to_string(), "entry_points", &number.to_string()];
                    errors.push(places.mark(error, &path, "here"));
                }
            }
        }
    }
}

/// `ab_cd_` as `AbCd`.
fn camel(snake: &str) -> String {
    let capital = |word: &str| {
        let mut letters = word.chars();
        let first = letters.next().map(|c| c.to_ascii_uppercase());
        first.into_iter().chain(letters).collect::<String>()
    };
    snake.split('_').map(capital).collect()
}

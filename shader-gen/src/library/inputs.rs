//! Examples of what a host computes: arguments, and the results that it has to come to.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::Library;
use super::place::Places;
use crate::error::{Code, Diagnostic};
use crate::source::{Sources, find, read, relative};

/// A host input for some arguments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Example {
    /// The arguments, by the names that the input's description has for them.
    pub given: BTreeMap<String, serde_json::Value>,
    /// The result.
    pub result: f64,
}

impl Library {
    /// Reads the examples that the header names; each is of an input of the frame, or of a member of one.
    pub(super) fn read_inputs(
        &mut self,
        root: &Path,
        places: &Places<'_>,
        sources: &mut Sources,
        errors: &mut Vec<Diagnostic>,
    ) {
        let Some(name) = &self.library.inputs else { return };
        let path = root.join(name);
        let text = match find(root, name).and_then(|path| read(&path)) {
            Ok(text) => text,
            Err(error) => {
                let text = format!("{}: {error}", relative(root, &path));
                let error = Diagnostic::new(Code::Read, text);
                return errors.push(places.mark(error, &["library", "inputs"], "read from here"));
            }
        };
        let file = sources.add(relative(root, &path), text.as_str());
        self.examples = match toml::from_str(&text) {
            Ok(examples) => examples,
            Err(error) => {
                let diagnostic = Diagnostic::new(Code::Declaration, error.message());
                return errors.push(diagnostic.at(file, error.span().unwrap_or_default(), "here"));
            }
        };
        let Some(frame) = self.frame() else { return };
        let places = Places::of(&[(file, text.as_str())]);
        for name in self.examples.keys() {
            let (input, member) = name.split_once('.').unwrap_or((name, ""));
            let known = &frame.description.input;
            let unknown = match known.get(input) {
                None => Diagnostic::unknown("input", input, known.keys().map(String::as_str)),
                Some(of) if !member.is_empty() && !of.member.contains_key(member) => {
                    let known = of.member.keys().map(String::as_str);
                    Diagnostic::unknown(&format!("member of input `{input}`"), member, known)
                }
                Some(_) => continue,
            };
            errors.push(places.mark(unknown, &[name], "here"));
        }
    }
}

//! What the doc comments of a text say.

use std::collections::BTreeMap;

/// What the doc comments (`///`) of a text say of its structs, fields and variables.
///
/// Read line by line: naga 30 gives the comment of a struct's nth commented field to its nth field.
#[derive(Default)]
pub(super) struct Comments {
    pub(super) structs: BTreeMap<String, String>,
    /// By the names of struct and field.
    fields: BTreeMap<(String, String), String>,
    pub(super) variables: BTreeMap<String, String>,
}

impl Comments {
    pub(super) fn of(text: &str) -> Self {
        let mut comments = Self::default();
        let mut inside: Option<String> = None;
        let mut prose: Vec<&str> = Vec::new();
        for line in text.lines().map(str::trim) {
            if let Some(comment) = line.strip_prefix("///") {
                prose.push(comment.trim());
                continue;
            }
            let line = without_attributes(line);
            if line.is_empty() || line.starts_with("//") {
                continue;
            }
            let comment = std::mem::take(&mut prose).join(" ").trim().to_owned();
            if let Some(name) = &inside {
                if line.starts_with('}') {
                    inside = None;
                } else if let Some((field, _)) = line.split_once(':') {
                    comments.fields.insert((name.clone(), field.trim().to_owned()), comment);
                }
            } else if let Some(rest) = line.strip_prefix("struct ") {
                let name = leading_name(rest);
                comments.structs.insert(name.to_owned(), comment);
                inside = (!line.contains('}')).then(|| name.to_owned());
            } else if let Some(rest) = line.strip_prefix("var") {
                let (name, _) = rest.split_once(':').unwrap_or((rest, ""));
                let name = name.rsplit('>').next().unwrap_or(name).trim();
                comments.variables.insert(name.to_owned(), comment);
            }
        }
        comments
    }

    pub(super) fn field(&self, of: &str, field: &str) -> String {
        self.fields.get(&(of.to_owned(), field.to_owned())).cloned().unwrap_or_default()
    }
}

/// What comes after the attributes that a line starts with.
fn without_attributes(line: &str) -> &str {
    let mut rest = line;
    while let Some(attribute) = rest.strip_prefix('@') {
        let after = &attribute[leading_name(attribute).len()..];
        let after = after.trim_start();
        rest = match after.strip_prefix('(').and_then(|inside| inside.split_once(')')) {
            Some((_, after)) => after.trim_start(),
            None => after,
        };
    }
    rest
}

fn leading_name(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

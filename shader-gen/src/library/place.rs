//! Places in `library.toml` and the other TOML files of a library.

use toml::de::{DeTable, DeValue};

use crate::error::Diagnostic;

/// Index of `library.toml` in [`crate::source::Sources`].
pub(super) const DECLARATION: usize = 0;

/// Where things stand in a TOML file.
pub(crate) struct Places<'a> {
    file: usize,
    root: Option<toml::Spanned<DeValue<'a>>>,
}

impl<'a> Places<'a> {
    /// Those of `library.toml`.
    pub(super) fn new(text: &'a str) -> Self {
        Self::of(DECLARATION, text)
    }

    /// Those of the file of this index in [`crate::source::Sources`].
    pub(crate) fn of(file: usize, text: &'a str) -> Self {
        let root = DeTable::parse(text).ok().map(|table| {
            let range = table.span();
            toml::Spanned::new(range, DeValue::Table(table.into_inner()))
        });
        Self { file, root }
    }

    /// Adds the place of `path` to `diagnostic`: the deepest part of it that is there.
    pub(crate) fn mark(&self, diagnostic: Diagnostic, path: &[&str], label: &str) -> Diagnostic {
        let mut range = 0..0;
        let mut value = self.root.as_ref();
        for part in path {
            let Some(found) = value else { break };
            let (place, next) = match found.get_ref() {
                // A table's own range is that of its header or of nothing, and an unknown key is itself at fault.
                DeValue::Table(table) => {
                    match table.iter().find(|(key, _)| key.get_ref() == part) {
                        Some((_, next)) if is_leaf(next.get_ref()) => (next.span(), Some(next)),
                        Some((key, next)) => (key.span(), Some(next)),
                        None => break,
                    }
                }
                DeValue::Array(array) => {
                    match part.parse().ok().and_then(|index: usize| array.get(index)) {
                        Some(next) => (next.span(), Some(next)),
                        None => break,
                    }
                }
                _ => break,
            };
            range = place;
            value = next;
        }
        diagnostic.at(self.file, range, label)
    }
}

/// Whether the value rather than its key is what a label should point at.
fn is_leaf(value: &DeValue<'_>) -> bool {
    matches!(value, DeValue::String(_) | DeValue::Integer(_) | DeValue::Float(_))
}

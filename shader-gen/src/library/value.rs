//! Values of TOML files with their places, and what is wrong where one file is laid over another.

use std::borrow::Cow;
use std::ops::Range;

use toml::Spanned;
use toml::de::DeValue;

use crate::error::{Code, Diagnostic};

/// A value with its place.
pub(super) type Value<'a> = Spanned<DeValue<'a>>;

/// Where the texts of files begin.
#[derive(Clone, Debug, Default)]
pub(super) struct Files(pub(super) Vec<(usize, usize)>);

impl Files {
    /// The file that has a place, and the place in it.
    fn local(&self, range: Range<usize>) -> (usize, Range<usize>) {
        let found = self.0.iter().rfind(|(start, _)| *start <= range.start);
        let (start, file) = found.copied().unwrap_or_default();
        (file, range.start - start..range.end.max(range.start) - start)
    }

    /// Adds a place to what is said.
    pub(super) fn mark(
        &self,
        diagnostic: Diagnostic,
        range: Range<usize>,
        label: &str,
    ) -> Diagnostic {
        let (file, range) = self.local(range);
        diagnostic.at(file, range, label)
    }
}

/// Laying one file over another.
pub(super) struct Lay<'f> {
    pub(super) files: &'f Files,
    /// Steps that were laid behind others, with these, by their places.
    pub(super) behind: Vec<(Range<usize>, Range<usize>)>,
    pub(super) errors: Vec<Diagnostic>,
}

impl Lay<'_> {
    pub(super) fn wrong(
        &mut self,
        code: Code,
        text: impl Into<String>,
        places: &[(Range<usize>, &str)],
        help: &str,
    ) {
        let mut diagnostic = Diagnostic::new(code, text);
        for (range, label) in places {
            diagnostic = self.files.mark(diagnostic, range.clone(), label);
        }
        self.errors.push(if help.is_empty() { diagnostic } else { diagnostic.help(help) });
    }
}

/// A text at a place.
pub(super) fn text(text: String, range: Range<usize>) -> Value<'static> {
    Spanned::new(range, DeValue::String(Cow::Owned(text)))
}

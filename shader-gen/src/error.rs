//! What is wrong with a library, in the author's own files.

use std::collections::HashMap;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use codespan_reporting::diagnostic::{Diagnostic as Rendered, Label as RenderedLabel};
use codespan_reporting::term::{self, Config, DisplayStyle, termcolor};

use crate::source::{Sources, Span};

/// The kind of a [`Diagnostic`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Code {
    /// A file cannot be read.
    Read,
    /// `library.toml` does not have the form that is requested.
    Declaration,
    /// A name that nothing declares.
    Unknown,
    /// A name that is declared twice.
    Duplicate,
    /// A name that breaks the library's rule for names.
    Name,
    /// A source file is not what the subset of WESL allows.
    Syntax,
    /// An import, or the lack of one.
    Import,
    /// A combination of values that the library excludes.
    Excluded,
    /// The pruned text is not what it was pruned from.
    Pruning,
    /// naga cannot read the text of a variant.
    Wgsl,
    /// naga finds the text of a variant invalid.
    Invalid,
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Read => "read",
            Self::Declaration => "declaration",
            Self::Unknown => "unknown",
            Self::Duplicate => "duplicate",
            Self::Name => "name",
            Self::Syntax => "syntax",
            Self::Import => "import",
            Self::Excluded => "excluded",
            Self::Pruning => "pruning",
            Self::Wgsl => "wgsl",
            Self::Invalid => "invalid",
        })
    }
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Diagnostic {
    /// Its kind.
    pub code: Code,
    /// What is wrong.
    pub message: String,
    /// Where, the place at fault first, each with what there is to say about it.
    pub labels: Vec<(Span, String)>,
    /// What would be right, and whatever else helps.
    pub help: Vec<String>,
}

impl Diagnostic {
    pub(crate) fn new(code: Code, message: impl Into<String>) -> Self {
        Self { code, message: message.into(), labels: Vec::new(), help: Vec::new() }
    }

    pub(crate) fn at(mut self, file: usize, range: Range<usize>, label: impl Into<String>) -> Self {
        self.labels.push((Span::new(file, range), label.into()));
        self
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help.push(help.into());
        self
    }

    /// A name that is not among `known`.
    pub(crate) fn unknown<'a>(
        kind: &str,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let mut known: Vec<_> = known.into_iter().collect();
        known.sort_unstable();
        known.dedup();
        let help = if known.is_empty() {
            "none is known".to_owned()
        } else {
            format!("known: {}", known.join(", "))
        };
        Self::new(Code::Unknown, format!("`{name}` is no known {kind}")).help(help)
    }
}

/// Everything that is wrong, with the files it is wrong in.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{}", self.render(false))]
pub struct Report {
    /// Sorted by place; never empty.
    pub diagnostics: Vec<Diagnostic>,
    sources: Arc<Sources>,
}

impl Report {
    /// Sorts `diagnostics` by place and drops repetitions; what several variants share is reported once.
    pub(crate) fn new(mut diagnostics: Vec<Diagnostic>, sources: Arc<Sources>) -> Self {
        diagnostics
            .sort_by(|a, b| (&a.labels, a.code, &a.message).cmp(&(&b.labels, b.code, &b.message)));
        diagnostics.dedup();
        Self { diagnostics, sources }
    }

    /// The report as text: file, line, column and source line of each diagnostic; with terminal colours if `coloured`.
    #[must_use]
    pub fn render(&self, coloured: bool) -> String {
        let files = self.sources.for_report();
        let config = Config { display_style: DisplayStyle::Rich, ..Config::default() };
        let mut plain = termcolor::NoColor::new(Vec::new());
        let mut colours = termcolor::Ansi::new(Vec::new());
        for diagnostic in &self.diagnostics {
            let rendered = Rendered::error()
                .with_code(diagnostic.code.to_string())
                .with_message(&diagnostic.message)
                .with_labels(labels(diagnostic))
                .with_notes(diagnostic.help.clone());
            // Writing to memory cannot fail, and a place outside of its file is left unshown.
            let _ = if coloured {
                term::emit_to_write_style(&mut colours, &config, &files, &rendered)
            } else {
                term::emit_to_write_style(&mut plain, &config, &files, &rendered)
            };
        }
        let bytes = if coloured { colours.into_inner() } else { plain.into_inner() };
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

fn labels(diagnostic: &Diagnostic) -> Vec<RenderedLabel<usize>> {
    let label = |(index, (span, text)): (usize, &(Span, String))| {
        let range = span.start..span.end;
        let label = if index == 0 {
            RenderedLabel::primary(span.file, range)
        } else {
            RenderedLabel::secondary(span.file, range)
        };
        label.with_message(text)
    };
    diagnostic.labels.iter().enumerate().map(label).collect()
}

/// Merges what several variants have in common: one diagnostic, saying how many variants it concerns.
pub(crate) fn merge(found: Vec<(String, Diagnostic)>) -> Vec<Diagnostic> {
    type Key = (Code, String, Vec<(Span, String)>);
    let mut order: Vec<Key> = Vec::new();
    let mut merged: HashMap<Key, (Diagnostic, Vec<String>)> = HashMap::new();
    for (variant, diagnostic) in found {
        let key = (diagnostic.code, diagnostic.message.clone(), diagnostic.labels.clone());
        merged
            .entry(key)
            .or_insert_with_key(|key| {
                order.push(key.clone());
                (diagnostic, Vec::new())
            })
            .1
            .push(variant);
    }
    let finish = |key: &Key| {
        let (diagnostic, variants) = merged.remove(key)?;
        let first = variants.first()?;
        let others = variants.len() - 1;
        Some(diagnostic.help(match others {
            0 => format!("in variant {first}"),
            1 => format!("in variant {first} and one other"),
            _ => format!("in variant {first} and {others} others"),
        }))
    };
    order.iter().filter_map(finish).collect()
}

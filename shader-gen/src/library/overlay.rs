//! What is laid over a library: a folder with a `library.toml` of its own, and sources and a frame if it has any.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::Library;
use super::check::is_snake;
use super::place::Places;
use crate::error::{Code, Diagnostic};
use crate::parse::{Module, parse};
use crate::source::{Sources, find, modules_below, read, relative};

/// The `[library]` table of what is laid over a library.
///
/// A module adds to those of the library; one of the same name clashes, unless [`Self::replace`] names it.
///
/// # Laying over
/// A file is laid over another one key by key; the result is read as if it stood in one file, and every place in it is
/// known. What lies over *adds*: tables and keys that are not there yet, and entries of lists.
///
/// - A list of tables that have a `name` (a citation: a `key`) grows by those of new names.
/// - The lists of `require`, of `package.select` and of a template's steps grow.
/// - Whatever else is there in both *clashes*, and is an error that names both places; unless the table in which it stands, or
///   one around it, says `replace = true`. Then the keys that it gives take the place of those that are there, and the others
///   stay. In a list of named tables the entry says so. To replace what is not there is an error.
///
/// A step of a template that is there already may say where it stands, by the label of a step, or by its pass or the
/// template that it uses (with the prefix in front of it) where no step has such a label:
///
/// - `before = "label"` and `after = "label"`, of several steps before the first and behind the last one. Without either it
///   stands at the end. Steps behind the same one keep their order.
/// - `replace = "label"` or `replace = ["label", …]`: where the first of these steps is, and in its configurations, those of
///   its `when`, instead of them. Without `when` they are gone.
/// - `extend = "label"`: it is no step, but its keys are laid over those of the step, as those of any table are.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Overlay {
    /// Its name.
    pub name: String,
    /// One sentence.
    pub description: String,
    /// What its names may start with instead of the library's prefix, in the same form.
    #[serde(default)]
    pub prefix: Option<String>,
    /// Folder of its sources, relative to its `library.toml`; without it there are none.
    #[serde(default)]
    pub source: Option<String>,
    /// The library's modules that its own of the same name take the place of, relative to the sources of either.
    #[serde(default)]
    pub replace: Vec<String>,
    /// The file that is laid over the library's frame, relative to its `library.toml`.
    #[serde(default)]
    pub frame: Option<String>,
    /// Its folder.
    #[serde(skip)]
    pub(super) root: PathBuf,
    /// How files in it are called.
    #[serde(skip)]
    pub(super) called: String,
    /// Its modules, as files.
    #[serde(skip)]
    pub(super) files: BTreeSet<usize>,
}

/// A file that has the table, and nothing else.
#[derive(Deserialize)]
struct Alone {
    library: Overlay,
}

impl Overlay {
    /// What the table of a file says; `header` has that table alone.
    pub(super) fn new(
        header: &Places<'_>,
        root: &Path,
        file: usize,
        errors: &mut Vec<Diagnostic>,
    ) -> Option<Self> {
        let overlay = match header.parsed::<Alone>() {
            Ok(alone) => Self { root: root.to_owned(), called: called(root), ..alone.library },
            Err(error) if error.labels.iter().all(|(span, _)| span.start == span.end) => {
                let text = "what is laid over a library has a table `[library]` with `name` and `description`";
                errors.push(Diagnostic::new(Code::Declaration, text).at(file, 0..0, "not here"));
                return None;
            }
            Err(error) => {
                errors.push(error);
                return None;
            }
        };
        if let Some(prefix) = &overlay.prefix
            && (!prefix.ends_with('_') || !is_snake(prefix))
        {
            let error = Diagnostic::new(Code::Name, format!("`{prefix}` is no prefix"))
                .help("a prefix is in snake case and ends with `_`, as in `abc_`");
            errors.push(header.mark(error, &["library", "prefix"], "here"));
        }
        Some(overlay)
    }

    /// How a file is called in errors, and wherever the folder's place must not count.
    pub(super) fn shown(&self, path: &Path) -> String {
        format!("{}/{}", self.called, relative(&self.root, path))
    }

    /// Reads its modules, each beside the library's or in the place of one of them.
    pub(super) fn read_modules(
        &mut self,
        header: &Places<'_>,
        modules: &mut Vec<Module>,
        sources: &mut Sources,
        errors: &mut Vec<Diagnostic>,
    ) {
        let unreadable = |path: String, error: &std::io::Error| {
            let error = Diagnostic::new(Code::Read, format!("{path}: {error}"));
            header.mark(error, &["library", "source"], "read from here")
        };
        let mut replaced = BTreeSet::new();
        if let Some(source) = &self.source {
            let folder = self.root.join(source);
            let files = match find(&self.root, source).and_then(|folder| modules_below(&folder)) {
                Ok(files) => files,
                Err(error) => return errors.push(unreadable(self.shown(&folder), &error)),
            };
            for file in files {
                let shown = self.shown(&file);
                let text = match read(&file) {
                    Ok(text) => text,
                    Err(error) => {
                        errors.push(unreadable(shown, &error));
                        continue;
                    }
                };
                let path = relative(&folder, &file);
                let index = sources.add(shown, text.as_str());
                self.files.insert(index);
                let module = parse(index, path.trim_end_matches(".wesl"), &text, errors);
                match modules.iter_mut().find(|known| known.path == module.path) {
                    None => modules.push(module),
                    Some(known) if self.replace.contains(&path) => {
                        *known = module;
                        replaced.insert(path);
                    }
                    Some(known) => {
                        let text = format!("module `{path}` is there already");
                        let error = Diagnostic::new(Code::Duplicate, text)
                            .at(index, 0..0, "again here")
                            .at(known.file, 0..0, "first here");
                        let help = format!("what replaces it says so: `replace = [\"{path}\"]`");
                        errors.push(error.help(help));
                    }
                }
            }
        }
        for (index, name) in self.replace.iter().enumerate() {
            if !replaced.contains(name) {
                let text = format!("`{name}` is no module of both");
                let error = Diagnostic::new(Code::Unknown, text);
                let path = ["library", "replace", &index.to_string()];
                errors.push(header.mark(error, &path, "replaces nothing"));
            }
        }
    }
}

/// The last part of a folder's path.
pub(super) fn called(root: &Path) -> String {
    let whole = std::path::absolute(root).unwrap_or_else(|_| root.to_owned());
    let last = whole.file_name().map(|name| name.to_string_lossy().into_owned());
    last.unwrap_or_else(|| "overlay".to_owned())
}

impl Library {
    /// What is laid over it, in order.
    #[must_use]
    pub fn overlays(&self) -> &[Overlay] {
        &self.overlays
    }

    /// What names in a file may start with: the prefix of what it belongs to first.
    pub(super) fn prefixes(&self, file: usize) -> Vec<&str> {
        let own = self.overlays.iter().filter(|overlay| overlay.files.contains(&file));
        let own = own.filter_map(|overlay| overlay.prefix.as_deref());
        own.chain([self.library.prefix.as_str()]).collect()
    }
}

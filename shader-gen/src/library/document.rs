//! TOML files that are read as one: a library, and what is laid over it.
//!
//! By which rules, [`super::Overlay`] says.

use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer, Error};

use super::steps;
use super::value::{Files, Lay, Value};
use crate::error::{Code, Diagnostic};

/// Files that are read as one. Places in it are those in the texts, one after the other.
pub(crate) struct Document<'a> {
    root: Value<'a>,
    files: Files,
}

/// Files that were read and are not one yet.
pub(super) struct Read<'a> {
    roots: Vec<Value<'a>>,
    files: Files,
}

impl<'a> Read<'a> {
    /// Reads `files`: each is the index in [`crate::source::Sources`] with its text.
    ///
    /// # Errors
    ///
    /// What is no TOML.
    pub(super) fn new(files: &[(usize, &'a str)]) -> Result<Self, Vec<Diagnostic>> {
        let (mut starts, mut roots, mut errors) = (Files::default(), Vec::new(), Vec::new());
        let mut start = 0;
        for &(file, text) in files {
            starts.0.push((start, file));
            match DeTable::parse(text) {
                Ok(table) => {
                    let range = table.span();
                    let root = Spanned::new(range, DeValue::Table(table.into_inner()));
                    roots.push(moved(root, start));
                }
                Err(error) => {
                    let diagnostic = Diagnostic::new(Code::Declaration, error.message());
                    let range = error.span().unwrap_or_default();
                    errors.push(diagnostic.at(file, range, "here"));
                }
            }
            // Places at the end of one text are not those at the beginning of the next.
            start += text.len() + 1;
        }
        if errors.is_empty() { Ok(Self { roots, files: starts }) } else { Err(errors) }
    }

    /// Takes a table out of each file but the first one, as documents that have nothing else.
    pub(super) fn take(&mut self, table: &str) -> Vec<Document<'a>> {
        let files = &self.files;
        let take = |root: &mut Value<'a>| {
            let mut own = DeTable::new();
            let range = root.span();
            if let DeValue::Table(root) = root.get_mut()
                && let Some((key, value)) = root.remove_entry(table)
            {
                own.insert(key, value);
            }
            Document { root: Spanned::new(range, DeValue::Table(own)), files: files.clone() }
        };
        self.roots.iter_mut().skip(1).map(take).collect()
    }

    /// The first file, with the others laid over it in their order.
    ///
    /// # Errors
    ///
    /// All that clashes.
    pub(super) fn laid(self) -> Result<Document<'a>, Vec<Diagnostic>> {
        let mut roots = self.roots.into_iter();
        let empty = || Spanned::new(0..0, DeValue::Table(DeTable::new()));
        let mut root = roots.next().unwrap_or_else(empty);
        let mut lay = Lay { files: &self.files, behind: Vec::new(), errors: Vec::new() };
        for over in roots {
            if let (DeValue::Table(own), DeValue::Table(over)) = (root.get_mut(), over.into_inner())
            {
                lay.tables(own, over, &mut Vec::new(), false);
            }
        }
        let errors = lay.errors;
        if errors.is_empty() { Ok(Document { root, files: self.files }) } else { Err(errors) }
    }
}

impl<'a> Document<'a> {
    /// The first of `files`, with the others laid over it in their order; nothing if that was an error before.
    pub(crate) fn of(files: &[(usize, &'a str)]) -> Self {
        Read::new(files).and_then(Read::laid).unwrap_or_else(|_| {
            let root = Spanned::new(0..0, DeValue::Table(DeTable::new()));
            Self { root, files: Files::default() }
        })
    }

    /// The whole as what it declares.
    ///
    /// # Errors
    ///
    /// A value of another form than the key takes.
    pub(crate) fn parsed<T: DeserializeOwned>(&self) -> Result<T, Diagnostic> {
        let table = match self.root.get_ref() {
            DeValue::Table(table) => table.clone(),
            _ => DeTable::new(),
        };
        let table = Spanned::new(self.root.span(), table);
        T::deserialize(Deserializer::from(table)).map_err(|error: Error| {
            let diagnostic = Diagnostic::new(Code::Declaration, error.message());
            match error.span() {
                Some(range) => self.files.mark(diagnostic, range, "here"),
                None => diagnostic,
            }
        })
    }

    /// Adds the place of `path` to `diagnostic`: the deepest part of it that is there.
    pub(crate) fn mark(&self, diagnostic: Diagnostic, path: &[&str], label: &str) -> Diagnostic {
        let mut range = 0..0;
        let mut value = Some(&self.root);
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
        self.files.mark(diagnostic, range, label)
    }
}

/// Whether the value rather than its key is what a label should point at.
fn is_leaf(value: &DeValue<'_>) -> bool {
    matches!(value, DeValue::String(_) | DeValue::Integer(_) | DeValue::Float(_))
}

/// A value whose places are so many bytes further on.
fn moved(value: Value<'_>, by: usize) -> Value<'_> {
    let at = |range: Range<usize>| range.start + by..range.end + by;
    let range = at(value.span());
    let value = match value.into_inner() {
        DeValue::Array(list) => {
            DeValue::Array(list.into_iter().map(|one| moved(one, by)).collect())
        }
        DeValue::Table(table) => DeValue::Table(
            table
                .into_iter()
                .map(|(key, value)| {
                    let range = at(key.span());
                    (Spanned::new(range, key.into_inner()), moved(value, by))
                })
                .collect(),
        ),
        other => other,
    };
    Spanned::new(range, value)
}

impl Lay<'_> {
    /// Lays `over` over `own`; `path` is where they are. `replace`, or the key of `over` that is called so, lets its keys take
    /// the place of those that are there.
    pub(super) fn tables<'a>(
        &mut self,
        own: &mut DeTable<'a>,
        mut over: DeTable<'a>,
        path: &mut Vec<String>,
        replace: bool,
    ) {
        let replace = self.replaces(&mut over).unwrap_or(replace);
        let mut clashes: Vec<(String, Range<usize>, Range<usize>)> = Vec::new();
        for (key, value) in over {
            let name = key.get_ref().to_string();
            let there = own.iter().find(|(known, _)| known.get_ref() == key.get_ref());
            let there = there.map(|(known, _)| known.span());
            let Some((first, before)) = there.zip(own.get_mut(name.as_str())) else {
                self.nothing_to_replace(&value, &name);
                own.insert(key, value);
                continue;
            };
            path.push(name.clone());
            let (range, mut instead) = (value.span(), None);
            match (before.get_mut(), value.into_inner()) {
                (DeValue::Table(before), DeValue::Table(value)) => {
                    self.tables(before, value, path, replace);
                }
                (DeValue::Array(before), DeValue::Array(value)) if is_steps(path) => {
                    for step in value {
                        if let Some((target, part)) = steps::lay(self, before, step)
                            && let Some(DeValue::Table(target)) =
                                steps::at(before, &target).map(Value::get_mut)
                        {
                            self.tables(target, part, path, false);
                        }
                    }
                }
                (DeValue::Array(before), DeValue::Array(value)) if grows(path) => {
                    value.into_iter().for_each(|one| before.push(one));
                }
                (DeValue::Array(before), DeValue::Array(value))
                    if is_named(before) && is_named(&value) =>
                {
                    for entry in value {
                        self.entry(before, entry, path, replace);
                    }
                }
                (_, value) if replace => instead = Some(Spanned::new(range, value)),
                _ => clashes.push((name.clone(), key.span(), first)),
            }
            if let Some(value) = instead {
                // The key's place is that of the new one, too.
                own.remove(name.as_str());
                own.insert(key, value);
            }
            path.pop();
        }
        self.clash(&clashes, path);
    }

    /// What is there twice: one error for all of a table, since it is one declaration.
    fn clash(&mut self, keys: &[(String, Range<usize>, Range<usize>)], path: &[String]) {
        let Some((_, again, first)) = keys.first() else { return };
        let names: Vec<&str> = keys.iter().map(|(name, ..)| name.as_str()).collect();
        let of = if path.is_empty() { String::new() } else { format!(" of `{}`", path.join(".")) };
        let text = format!("`{}`{of} is declared already", names.join("`, `"));
        let places = [(again.clone(), "again here"), (first.clone(), "first here")];
        self.wrong(Code::Duplicate, text, &places, "what replaces it says `replace = true`");
    }

    /// Adds an entry to a list of named tables, or lays it over the one of its name.
    fn entry<'a>(
        &mut self,
        own: &mut toml::de::DeArray<'a>,
        mut entry: Value<'a>,
        path: &mut Vec<String>,
        replace: bool,
    ) {
        let Some((key, name)) = named(entry.get_ref()) else { return };
        let (name, place) = (name.get_ref().as_str().unwrap_or_default().to_owned(), name.span());
        let of = |value: &Value<'_>| {
            named(value.get_ref()).is_some_and(|(_, own)| own.get_ref().as_str() == Some(&*name))
        };
        let Some(before) = own.iter_mut().find(|value| of(value)) else {
            if let DeValue::Table(table) = entry.get_mut()
                && self.replaces(table) == Some(true)
            {
                let text = format!("there is no `{name}` in `{}` to replace", path.join("."));
                return self.wrong(Code::Unknown, text, &[(place, "here")], "");
            }
            own.push(entry);
            return;
        };
        let first = named(before.get_ref()).map(|(_, name)| name.span()).unwrap_or_default();
        let (DeValue::Table(before), DeValue::Table(mut table)) =
            (before.get_mut(), entry.into_inner())
        else {
            return;
        };
        if !self.replaces(&mut table).unwrap_or(replace) {
            let text = format!("`{name}` of `{}` is declared already", path.join("."));
            let places = [(place, "again here"), (first, "first here")];
            let help = "what replaces it says `replace = true`";
            return self.wrong(Code::Duplicate, text, &places, help);
        }
        table.remove(key);
        path.push(name);
        self.tables(before, table, path, true);
        path.pop();
    }

    /// Whether a table says that it replaces; the key is taken out of it.
    fn replaces(&mut self, table: &mut DeTable<'_>) -> Option<bool> {
        let is_flag = |value: &Value<'_>| matches!(value.get_ref(), DeValue::Boolean(_));
        if !table.get("replace").is_some_and(is_flag) {
            return None;
        }
        match table.remove("replace")?.into_inner() {
            DeValue::Boolean(replaces) => Some(replaces),
            _ => None,
        }
    }

    /// Complains of a new table that says it replaces something.
    fn nothing_to_replace(&mut self, value: &Value<'_>, name: &str) {
        let DeValue::Table(table) = value.get_ref() else { return };
        let flag = table.get("replace");
        if let Some(flag) = flag.filter(|flag| matches!(flag.get_ref(), DeValue::Boolean(true))) {
            let text = format!("there is no `{name}` to replace");
            self.wrong(Code::Unknown, text, &[(flag.span(), "here")], "");
        }
    }
}

/// The name of a table, with its key.
fn named<'v, 'a>(value: &'v DeValue<'a>) -> Option<(&'static str, &'v Value<'a>)> {
    let DeValue::Table(table) = value else { return None };
    let found = ["name", "key"].into_iter().find_map(|key| Some((key, table.get(key)?)))?;
    matches!(found.1.get_ref(), DeValue::String(_)).then_some(found)
}

fn is_named(list: &toml::de::DeArray<'_>) -> bool {
    list.iter().all(|value| named(value.get_ref()).is_some())
}

/// Whether a path is that of a list that grows whatever is in it.
fn grows(path: &[String]) -> bool {
    let path: Vec<&str> = path.iter().map(String::as_str).collect();
    matches!(path[..], ["require"] | ["package", "select"])
}

/// Whether a path is that of a template's steps.
fn is_steps(path: &[String]) -> bool {
    let path: Vec<&str> = path.iter().map(String::as_str).collect();
    matches!(path[..], ["template", _, "step"])
}

//! Notes to the user about a scene.

use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::path::Path;

/// Why there is a note.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum NoteKind {
    /// The file has something that the picture will not show.
    Ignored,
    /// The file leaves something open, or says it in other terms than ours.
    Assumed,
    /// The file lacks something that was made up from the rest.
    Derived,
}

/// One thing the user should know about how a scene was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// Ignored, assumed or derived.
    pub kind: NoteKind,
    /// What happened, for all subjects alike.
    pub text: String,
    /// The materials, meshes or lights it happened to; empty where it concerns the whole scene.
    pub subjects: Vec<String>,
}

impl fmt::Display for Note {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 4;
        let kind = match self.kind {
            NoteKind::Ignored => "ignored",
            NoteKind::Assumed => "assumed",
            NoteKind::Derived => "derived",
        };
        write!(out, "{kind}: {}", self.text)?;
        if !self.subjects.is_empty() {
            let shown = self.subjects.iter().take(SHOWN).cloned().collect::<Vec<_>>();
            write!(out, " ({}", shown.join(", "))?;
            if self.subjects.len() > SHOWN {
                write!(out, " and {} more", self.subjects.len() - SHOWN)?;
            }
            write!(out, ")")?;
        }
        Ok(())
    }
}

/// Notes while a scene is read: the same text about many subjects becomes one note.
#[derive(Debug, Default)]
pub(super) struct Notes(BTreeMap<Key, Subjects>);

/// What notes are sorted by, and how they are distinguished.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    kind: NoteKind,
    /// Of a line of a file: its place.
    place: Option<(String, usize, usize)>,
    text: String,
}

#[derive(Debug, Default)]
struct Subjects {
    list: Vec<String>,
    known: HashSet<String>,
}

impl Notes {
    /// Adds a note about `subject`; an empty subject is the whole scene.
    pub(super) fn add(
        &mut self,
        kind: NoteKind,
        text: impl Into<String>,
        subject: impl Into<String>,
    ) {
        self.insert(Key { kind, place: None, text: text.into() }, subject.into());
    }

    /// Adds a note about a line of a file.
    pub(super) fn add_at(
        &mut self,
        kind: NoteKind,
        file: &Path,
        (line, column): (usize, usize),
        message: &str,
    ) {
        let file = file.display().to_string();
        let text = format!("{file}:{line}:{column}: {message}");
        self.insert(Key { kind, place: Some((file, line, column)), text }, String::new());
    }

    fn insert(&mut self, key: Key, subject: String) {
        let subjects = self.0.entry(key).or_default();
        if !subject.is_empty() && subjects.known.insert(subject.clone()) {
            subjects.list.push(subject);
        }
    }

    pub(super) fn into_list(self) -> Vec<Note> {
        let notes = self.0.into_iter();
        notes
            .map(|(Key { kind, text, .. }, subjects)| Note { kind, text, subjects: subjects.list })
            .collect()
    }
}

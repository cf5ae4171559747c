//! What the user is told about a scene.

use std::collections::BTreeMap;
use std::fmt;

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
pub(super) struct Notes(BTreeMap<(NoteKind, String), Vec<String>>);

impl Notes {
    /// Adds a note about `subject`; an empty subject is the whole scene.
    pub(super) fn add(
        &mut self,
        kind: NoteKind,
        text: impl Into<String>,
        subject: impl Into<String>,
    ) {
        let subjects = self.0.entry((kind, text.into())).or_default();
        let subject = subject.into();
        if !subject.is_empty() && !subjects.contains(&subject) {
            subjects.push(subject);
        }
    }

    pub(super) fn into_list(self) -> Vec<Note> {
        self.0.into_iter().map(|((kind, text), subjects)| Note { kind, text, subjects }).collect()
    }
}

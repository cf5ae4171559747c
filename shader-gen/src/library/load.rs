//! Reading a library.

use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::place::{DECLARATION, Places};
use super::{Library, Pass, PresetFile};
use crate::error::{Code, Diagnostic, Report};
use crate::link::Graph;
use crate::parse::{Module, parse};
use crate::source::{Sources, modules_below, relative};

impl Library {
    /// Reads `library.toml` at `path` (or in the folder `path`) and every `.wesl` file below its source folder.
    ///
    /// # Errors
    ///
    /// Everything that is wrong with the declaration and with the files as such; what only a variant can show is left
    /// to [`crate::generate`].
    pub fn load(path: &Path) -> Result<Self, Report> {
        let path = if path.is_dir() { path.join("library.toml") } else { path.to_owned() };
        let root = path.parent().unwrap_or(Path::new("")).to_owned();
        let mut sources = Sources::default();
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) => {
                let diagnostic =
                    Diagnostic::new(Code::Read, format!("{}: {error}", path.display()));
                return Err(Report::new(vec![diagnostic], Arc::new(sources)));
            }
        };
        sources.add(relative(&root, &path), text.as_str());
        Self::from_parts(&text, &root, sources)
    }

    fn from_parts(text: &str, root: &Path, mut sources: Sources) -> Result<Self, Report> {
        let mut library: Self = match toml::from_str(text) {
            Ok(library) => library,
            Err(error) => {
                let mut diagnostic = Diagnostic::new(Code::Declaration, error.message());
                if let Some(range) = error.span() {
                    diagnostic = diagnostic.at(DECLARATION, range, "here");
                }
                return Err(Report::new(vec![diagnostic], Arc::new(sources)));
            }
        };
        let mut errors = Vec::new();
        let places = Places::new(text);
        library.read_presets(root, &places, &mut sources, &mut errors);
        library.read_frame(root, &places, &mut sources, &mut errors);
        library.read_inputs(root, &places, &mut sources, &mut errors);
        library.check(&places, &mut errors);
        library.check_frame(&sources, &mut errors);
        let folder = root.join(&library.library.source);
        let modules = library.read_modules(root, &folder, &places, &mut sources, &mut errors);
        let sources = Arc::new(sources);
        let unread = errors.iter().any(|error| matches!(error.code, Code::Read | Code::Syntax));
        library.check_modules(&modules, &places, &mut errors);
        library.graph = Arc::new(Graph::new(modules, !unread, &mut errors));
        library.check_pass_names(&places, unread, &mut errors);
        library.sources = sources;
        if errors.is_empty() { Ok(library) } else { Err(Report::new(errors, library.sources)) }
    }

    /// Adds the presets of the file that the header names; one that does not exist has none.
    fn read_presets(
        &mut self,
        root: &Path,
        places: &Places<'_>,
        sources: &mut Sources,
        errors: &mut Vec<Diagnostic>,
    ) {
        let Some(name) = &self.library.presets else { return };
        let path = root.join(name);
        let wrong = |why: String| {
            let error = Diagnostic::new(Code::Read, format!("{}: {why}", relative(root, &path)));
            places.mark(error, &["library", "presets"], "read from here")
        };
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return,
            Err(error) => return errors.push(wrong(error.to_string())),
        };
        match PresetFile::read(&text) {
            Ok(file) => {
                sources.add(relative(root, &path), text.as_str());
                self.preset.extend(file.preset);
            }
            Err(error) => errors.push(wrong(error.message().to_owned())),
        }
    }

    /// The files that were read: `library.toml`, the presets, the frame and the examples of its inputs if there are any, then the modules.
    #[must_use]
    pub fn sources(&self) -> &Arc<Sources> {
        &self.sources
    }

    pub(crate) fn graph(&self) -> &Graph {
        &self.graph
    }

    /// The pass called `name`.
    #[must_use]
    pub fn find_pass(&self, name: &str) -> Option<&Pass> {
        self.pass.iter().find(|pass| pass.name == name)
    }

    /// Every flag that some value sets, sorted.
    #[must_use]
    pub fn flags(&self) -> BTreeSet<&str> {
        let values = self.axis.values().flat_map(|axis| &axis.value);
        values.flat_map(|value| &value.flags).map(String::as_str).collect()
    }

    fn read_modules(
        &self,
        root: &Path,
        folder: &Path,
        places: &Places<'_>,
        sources: &mut Sources,
        errors: &mut Vec<Diagnostic>,
    ) -> Vec<Module> {
        let unreadable = |path: &Path, error: &std::io::Error| {
            places.mark(
                Diagnostic::new(Code::Read, format!("{}: {error}", relative(root, path))),
                &["library", "source"],
                "read from here",
            )
        };
        let files: Vec<PathBuf> = match modules_below(folder) {
            Ok(files) => files,
            Err(error) => {
                errors.push(unreadable(folder, &error));
                return Vec::new();
            }
        };
        let mut modules = Vec::new();
        for file in files {
            match fs::read_to_string(&file) {
                Ok(text) => {
                    let path = relative(folder, &file);
                    let path = path.trim_end_matches(".wesl");
                    let index = sources.add(relative(root, &file), text.as_str());
                    modules.push(parse(index, path, &text, errors));
                }
                Err(error) => errors.push(unreadable(&file, &error)),
            }
        }
        modules
    }
}

//! Reading a library.

use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;

use super::document::Read;
use super::overlay::called;
use super::place::Places;
use super::{Library, Overlay, Pass, PresetFile};
use crate::error::{Code, Diagnostic, Report};
use crate::link::Graph;
use crate::parse::{Module, parse};
use crate::source::{Sources, find, modules_below, read, relative};

impl Library {
    /// Reads `library.toml` at `path` (or in the folder `path`) and every `.wesl` file below its source folder.
    ///
    /// # Errors
    ///
    /// Everything that is wrong with the declaration and with the files as such; what only a variant can show is left
    /// to [`crate::generate`].
    pub fn load(path: &Path) -> Result<Self, Report> {
        Self::load_with(path, &[])
    }

    /// The same with other folders laid over it, in their order: each has a `library.toml` with a table `[library]` of the
    /// form of [`Overlay`].
    ///
    /// # Errors
    ///
    /// As [`Self::load`], and all that clashes.
    pub fn load_with(path: &Path, over: &[PathBuf]) -> Result<Self, Report> {
        let (mut sources, mut texts, mut roots, mut errors) =
            (Sources::default(), Vec::new(), Vec::new(), Vec::new());
        for (index, path) in [path].into_iter().chain(over.iter().map(PathBuf::as_path)).enumerate()
        {
            let path = if path.is_dir() { path.join("library.toml") } else { path.to_owned() };
            let root = path.parent().unwrap_or(Path::new("")).to_owned();
            match read(&path) {
                Ok(text) => {
                    let shown = relative(&root, &path);
                    let shown =
                        if index == 0 { shown } else { format!("{}/{shown}", called(&root)) };
                    texts.push((sources.add(shown, text.as_str()), text));
                    roots.push(root);
                }
                Err(error) => {
                    let text = format!("{}: {error}", path.display());
                    errors.push(Diagnostic::new(Code::Read, text));
                }
            }
        }
        if !errors.is_empty() {
            return Err(Report::new(errors, Arc::new(sources)));
        }
        Self::from_parts(&texts, &roots, sources)
    }

    fn from_parts(
        texts: &[(usize, String)],
        roots: &[PathBuf],
        mut sources: Sources,
    ) -> Result<Self, Report> {
        let presets = match presets(&texts[0], &roots[0], &mut sources) {
            Ok(presets) => presets,
            Err(error) => return Err(Report::new(vec![error], Arc::new(sources))),
        };
        // The presets are the library's own: they come before what is laid over it.
        let all = texts[..1].iter().chain(&presets).chain(&texts[1..]);
        let files: Vec<_> = all.map(|(file, text)| (*file, text.as_str())).collect();
        let laid = Read::new(&files).and_then(|mut read| {
            let headers = read.take("library").split_off(presets.iter().count());
            Ok((headers, read.laid()?))
        });
        let parsed = laid.and_then(|(headers, places)| {
            let library = places.parsed::<Self>().map_err(|error| vec![error])?;
            Ok((headers, places, library))
        });
        let mut errors = Vec::new();
        let (headers, places, mut library) = match parsed {
            Ok(parsed) => parsed,
            Err(errors) => return Err(Report::new(errors, Arc::new(sources))),
        };
        for ((header, root), (file, _)) in headers.iter().zip(&roots[1..]).zip(&texts[1..]) {
            library.overlays.extend(Overlay::new(header, root, *file, &mut errors));
        }
        if !errors.is_empty() {
            return Err(Report::new(errors, Arc::new(sources)));
        }
        if !library.is_bounded(&places, &mut errors) {
            return Err(Report::new(errors, Arc::new(sources)));
        }
        let root = &roots[0];
        library.flag_calls();
        library.read_frame(root, &places, &headers, &mut sources, &mut errors);
        library.read_inputs(root, &places, &mut sources, &mut errors);
        library.check(&places, &mut errors);
        library.check_frame(&sources, &mut errors);
        let folder = root.join(&library.library.source);
        let mut modules = library.read_modules(root, &folder, &places, &mut sources, &mut errors);
        for (overlay, header) in library.overlays.iter_mut().zip(&headers) {
            overlay.read_modules(header, &mut modules, &mut sources, &mut errors);
        }
        let calls = library.call_module(&modules, &places, &mut sources, &mut errors);
        modules.extend(calls);
        let sources = Arc::new(sources);
        let unread = errors.iter().any(|error| matches!(error.code, Code::Read | Code::Syntax));
        library.check_modules(&modules, &places, &mut errors);
        library.graph = Arc::new(Graph::new(modules, !unread, &mut errors));
        library.check_pass_names(&places, unread, &mut errors);
        library.sources = sources;
        if errors.is_empty() { Ok(library) } else { Err(Report::new(errors, library.sources)) }
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
        let source = &self.library.source;
        let found = find(root, source).and_then(|folder| modules_below(&folder));
        let files: Vec<PathBuf> = match found {
            Ok(files) => files,
            Err(error) => {
                errors.push(unreadable(folder, &error));
                return Vec::new();
            }
        };
        let mut modules = Vec::new();
        for file in files {
            match read(&file) {
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

/// The file of presets that the header of a library names, with its index; one that does not exist has none.
fn presets(
    (file, text): &(usize, String),
    root: &Path,
    sources: &mut Sources,
) -> Result<Option<(usize, String)>, Diagnostic> {
    #[derive(Deserialize)]
    struct Alone {
        library: Named,
    }
    #[derive(Deserialize)]
    struct Named {
        presets: Option<String>,
    }
    // What is wrong with the library itself, its reader says.
    let named = toml::from_str(text).ok().and_then(|Alone { library }| library.presets);
    let Some(name) = named else { return Ok(None) };
    let shown = relative(root, &root.join(&name));
    let text = match find(root, &name).and_then(|path| read(&path)) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => {
            let error = Diagnostic::new(Code::Read, format!("{shown}: {error}"));
            let place = Places::of(&[(*file, text.as_str())]);
            return Err(place.mark(error, &["library", "presets"], "read from here"));
        }
    };
    let file = sources.add(shown, text.as_str());
    match PresetFile::read(&text) {
        Ok(_) => Ok(Some((file, text))),
        Err(error) => {
            let range = error.span().unwrap_or_default();
            Err(Diagnostic::new(Code::Declaration, error.message()).at(file, range, "here"))
        }
    }
}

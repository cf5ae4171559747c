//! The modules of a variant: what its pass imports, with conditions decided and every kept byte as it was.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::ops::Range;

use crate::condition::Condition;
use crate::error::{Code, Diagnostic};
use crate::library::Library;
use crate::link::{Candidate, Graph};
use crate::parse::{Declaration, Module};
use crate::resolve::resolve;
use crate::source::Span;

/// A text, and where each stretch of it comes from.
#[derive(Clone, Debug, Default)]
pub struct Text {
    /// The text.
    pub text: String,
    /// `(first byte in the text, source)`, ascending; what is not from a source is between them.
    segments: Vec<(usize, Span)>,
}

impl Text {
    pub(crate) fn followed_by(mut self, other: Self) -> Self {
        self.text.push('\n');
        let shift = self.text.len();
        self.text.push_str(&other.text);
        self.segments.extend(other.segments.into_iter().map(|(start, span)| (start + shift, span)));
        self
    }

    fn push(&mut self, file: usize, source: &str, range: Range<usize>) {
        self.segments.push((self.text.len(), Span::new(file, range.clone())));
        self.text.push_str(&source[range]);
    }

    /// Where the stretch `range` of the text comes from.
    #[must_use]
    pub fn origin(&self, range: Range<usize>) -> Option<Span> {
        let index = self.segments.partition_point(|(start, _)| *start <= range.start);
        let (start, span) = self.segments.get(index.checked_sub(1)?)?;
        let first = span.start + (range.start - start);
        let last = (span.start + (range.end.max(range.start) - start)).min(span.end);
        (first <= span.end).then(|| Span::new(span.file, first..last.max(first)))
    }
}

/// A declaration that a variant's modules hold.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) module: usize,
    pub(crate) declaration: usize,
    /// The bytes that stay.
    ranges: Vec<Range<usize>>,
    /// Indices of the pieces that it names, each with the place where it does first, in their order.
    pub(crate) names: Vec<(usize, usize)>,
}

/// The maximum length of a chain of declarations that each use the next.
const MAXIMUM_CHAIN: usize = 200;

/// The pieces of a text in their order, and how many of them stand above the functions.
pub(crate) struct Order {
    /// Indices of pieces.
    pub(crate) pieces: Vec<usize>,
    /// How many of them, from the first one on, are the host's: overrides, bindings with their structs, entry points.
    pub(crate) interface: usize,
}

impl Order {
    /// The pieces that `keep` marks, as modules import each other, what is imported first.
    pub(crate) fn of_imports(keep: &[bool]) -> Self {
        let pieces = (0..keep.len()).filter(|piece| keep[*piece]).collect();
        Self { pieces, interface: 0 }
    }
}

/// A declaration that a variant does without.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Omitted {
    /// Its name.
    pub name: String,
    /// `function`, `struct`, `alias`, `const`, `override`, `var`.
    pub kind: String,
    /// Why the variant does without it.
    pub reason: String,
}

/// All declarations of the modules that a variant imports, conditions decided.
#[derive(Clone, Debug)]
pub struct Assembled<'a> {
    library: &'a Library,
    roots: Vec<usize>,
    /// Modules in their order in the text: what is imported comes before what imports it.
    order: Vec<usize>,
    pieces: Vec<Piece>,
    directives: Vec<(usize, Vec<Range<usize>>)>,
    /// Indices of the pieces that the roots declare or import by name.
    imported: Vec<usize>,
}

impl<'a> Assembled<'a> {
    /// Gathers `roots` (indices of modules) and what they import when `flags` hold.
    ///
    /// # Errors
    ///
    /// A name that is declared twice, or used where conditions leave nothing that it could stand for.
    pub(crate) fn new(
        library: &'a Library,
        roots: &[usize],
        flags: &BTreeSet<&str>,
    ) -> Result<Self, Vec<Diagnostic>> {
        let graph = library.graph();
        let order = graph.closure(roots, |condition| holds(condition, flags));
        let mut assembled = Self {
            library,
            roots: roots.to_vec(),
            order,
            pieces: Vec::new(),
            directives: Vec::new(),
            imported: Vec::new(),
        };
        let mut errors = Vec::new();
        let mut indices = HashMap::new();
        let mut first: HashMap<&str, (usize, &Range<usize>)> = HashMap::new();
        for &index in &assembled.order {
            let module = &graph.modules()[index];
            for directive in
                module.directives.iter().filter(|item| holds(item.condition.as_ref(), flags))
            {
                let source = library.sources().text(module.file);
                assembled.directives.push((module.file, resolve(source, directive, &[], flags)));
            }
            let source = library.sources().text(module.file);
            for (number, declaration) in module.declarations.iter().enumerate() {
                if !holds(declaration.item.condition.as_ref(), flags) {
                    continue;
                }
                indices.insert((index, number), assembled.pieces.len());
                assembled.pieces.push(Piece {
                    module: index,
                    declaration: number,
                    ranges: resolve(source, &declaration.item, &declaration.references, flags),
                    names: Vec::new(),
                });
                let Some((name, range)) = &declaration.name else {
                    continue;
                };
                if let Some((file, before)) = first.insert(name, (module.file, range)) {
                    errors.push(
                        Diagnostic::new(Code::Duplicate, format!("`{name}` is declared twice"))
                            .at(module.file, range.clone(), "again here")
                            .at(file, before.clone(), "first here")
                            .help("names are not mangled, so that each has to be the only one of its kind"),
                    );
                }
            }
        }
        for number in 0..assembled.pieces.len() {
            let piece = &assembled.pieces[number];
            let mut names = Vec::new();
            for link in graph.links(piece.module, piece.declaration) {
                let Some(&at) =
                    link.at.iter().find(|at| piece.ranges.iter().any(|range| range.contains(at)))
                else {
                    continue;
                };
                let target = link.candidates.iter().find_map(|candidate| {
                    is_taken(graph, piece.module, *candidate, flags)
                        .then(|| indices.get(&(candidate.module, candidate.declaration)))?
                });
                match target {
                    Some(target) => names.push((at, *target)),
                    None => {
                        errors.push(missing(graph, piece.module, &link.name, at, &link.candidates))
                    }
                }
            }
            assembled.pieces[number].names = names;
        }
        for &root in roots {
            let names = graph.scope_of(root);
            let taken = names.filter(|candidate| is_taken(graph, root, *candidate, flags));
            let pieces = taken.filter_map(|name| indices.get(&(name.module, name.declaration)));
            assembled.imported.extend(pieces);
        }
        errors.extend(assembled.too_deep());
        if errors.is_empty() { Ok(assembled) } else { Err(errors) }
    }

    /// The first declaration with a chain of more than [`MAXIMUM_CHAIN`] others below it, into which pruning and naga recurse.
    /// Circles are left to naga.
    fn too_deep(&self) -> Option<Diagnostic> {
        let mut depths = vec![None; self.pieces.len()];
        for start in 0..self.pieces.len() {
            let mut open = vec![(start, 0)];
            while let Some((piece, next)) = open.last_mut() {
                let names = &self.pieces[*piece].names;
                if let Some((_, name)) = names.get(*next) {
                    *next += 1;
                    // What is open is part of a circle; it has the depth 0 until it is known.
                    if depths[*name].is_none() {
                        depths[*name] = Some(0);
                        open.push((*name, 0));
                    }
                    continue;
                }
                let below = names.iter().filter_map(|(_, name)| depths[*name]).max();
                let depth = below.map_or(0, |below| below + 1);
                depths[*piece] = Some(depth);
                if depth > MAXIMUM_CHAIN {
                    let piece = &self.pieces[*piece];
                    let text =
                        format!("more than {MAXIMUM_CHAIN} declarations, each used by the next");
                    let range = self.declaration(piece).item.whole.clone();
                    let error = Diagnostic::new(Code::Declaration, text);
                    return Some(error.at(self.file(piece), range, "up to this one"));
                }
                open.pop();
            }
        }
        None
    }

    /// Indices of the pieces that the roots declare or import by name.
    pub(crate) fn imported(&self) -> impl Iterator<Item = usize> {
        self.imported.iter().copied()
    }

    pub(crate) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    pub(crate) fn declaration(&self, piece: &Piece) -> &'a Declaration {
        self.library.graph().declaration(piece.module, piece.declaration)
    }

    /// Index of the file that `piece` is from.
    pub(crate) fn file(&self, piece: &Piece) -> usize {
        self.library.graph().modules()[piece.module].file
    }

    /// Index of the piece that declares `name`.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.pieces.iter().position(|piece| {
            let declared = &self.declaration(piece).name;
            declared.as_ref().is_some_and(|(declared, _)| declared == name)
        })
    }

    /// The pieces of `order`, one after the other, after all directives.
    pub(crate) fn text(&self, order: &Order) -> Text {
        let mut text = Text::default();
        self.write_directives(&mut text);
        self.write_pieces(order, &mut text);
        text
    }

    /// The pieces of `order`, without directives.
    pub(crate) fn rest(&self, order: &Order) -> Text {
        let mut text = Text::default();
        self.write_pieces(order, &mut text);
        text
    }

    fn write_directives(&self, text: &mut Text) {
        let sources = self.library.sources();
        let mut directives: Vec<String> = Vec::new();
        for (file, ranges) in &self.directives {
            let source = sources.text(*file);
            let directive: String = ranges.iter().map(|range| &source[range.clone()]).collect();
            if !directives.contains(&directive) {
                for range in ranges {
                    text.push(*file, source, range.clone());
                }
                text.text.push('\n');
                directives.push(directive);
            }
        }
    }

    fn write_pieces(&self, order: &Order, text: &mut Text) {
        let graph = self.library.graph();
        let sources = self.library.sources();
        let mut before: Option<&Piece> = None;
        let mut sections = HashSet::new();
        for (number, piece) in order.pieces.iter().map(|piece| &self.pieces[*piece]).enumerate() {
            let module = &graph.modules()[piece.module];
            let source = sources.text(module.file);
            if !text.text.is_empty() {
                let tight = before.is_some_and(|before| {
                    let both = [before, piece].map(|piece| self.declaration(piece));
                    both.iter().all(|declaration| declaration.binding.is_some())
                        || before.module == piece.module
                            && is_tight(module, source, before.declaration..piece.declaration)
                });
                // Directives end with their line.
                let first = before.is_none();
                text.text.push_str(if tight || first { "\n" } else { "\n\n" });
            }
            let start = module.declarations[piece.declaration].item.whole.start;
            let section = module.sections.iter().rfind(|section| section.start < start);
            if let Some(section) = section
                && number >= order.interface
                && sections.insert((module.file, section.start))
            {
                text.push(module.file, source, section.clone());
                text.text.push_str("\n\n");
            }
            for range in &piece.ranges {
                text.push(module.file, source, range.clone());
            }
            before = Some(piece);
        }
        text.text.push('\n');
    }

    /// What a text lacks that keeps the pieces for which `keep` says so, of all that the roots' modules could hold.
    pub(crate) fn omitted(
        &self,
        keep: &[bool],
        flags: &BTreeSet<&str>,
        whence: &str,
    ) -> Vec<Omitted> {
        let graph = self.library.graph();
        let held: HashMap<_, _> = self
            .pieces
            .iter()
            .zip(keep)
            .map(|(piece, keep)| ((piece.module, piece.declaration), *keep))
            .collect();
        let mut kept = HashSet::new();
        let mut omitted: Vec<Omitted> = Vec::new();
        for module in graph.closure(&self.roots, |_| true) {
            let is_imported = self.order.contains(&module);
            for (number, declaration) in graph.modules()[module].declarations.iter().enumerate() {
                let Some((name, _)) = &declaration.name else {
                    continue;
                };
                let reason = match (held.get(&(module, number)), &declaration.item.condition) {
                    (Some(true), _) => {
                        kept.insert(name.as_str());
                        continue;
                    }
                    (Some(false), _) => format!("not reachable from {whence}"),
                    (None, Some(condition)) if is_imported || !condition.holds(flags) => {
                        format!("{condition} does not hold")
                    }
                    (None, _) => format!("{} is not imported", graph.modules()[module].path),
                };
                omitted.push(Omitted {
                    name: name.clone(),
                    kind: declaration.kind.name().to_owned(),
                    reason,
                });
            }
        }
        omitted.retain(|omitted| !kept.contains(omitted.name.as_str()));
        omitted.sort();
        omitted.dedup_by(|a, b| a.name == b.name);
        omitted
    }
}

fn holds(condition: Option<&Condition>, flags: &BTreeSet<&str>) -> bool {
    condition.is_none_or(|condition| condition.holds(flags))
}

fn is_taken(graph: &Graph, user: usize, candidate: Candidate, flags: &BTreeSet<&str>) -> bool {
    candidate
        .import
        .is_none_or(|import| holds(graph.modules()[user].imports[import].condition.as_ref(), flags))
}

/// Whether the declarations of `module` from the first to the last of `range` stand on lines that follow each other.
fn is_tight(module: &Module, source: &str, range: Range<usize>) -> bool {
    range.start < range.end
        && range.clone().all(|number| {
            let gap = module.declarations[number].item.whole.end
                ..module.declarations[number + 1].item.whole.start;
            let gap = &source[gap];
            gap.trim().is_empty() && gap.bytes().filter(|byte| *byte == b'\n').count() <= 1
        })
}

fn missing(
    graph: &Graph,
    module: usize,
    name: &str,
    at: usize,
    candidates: &[Candidate],
) -> Diagnostic {
    let user = &graph.modules()[module];
    let file = user.file;
    let mut error =
        Diagnostic::new(Code::Import, format!("`{name}` is used where conditions leave it out"))
            .at(file, at..at + name.len(), "used here");
    for candidate in candidates {
        let module = &graph.modules()[candidate.module];
        let declaration = &module.declarations[candidate.declaration];
        if let Some((_, range)) = &declaration.name {
            let label = match &declaration.item.condition {
                Some(condition) => format!("declared if {condition}"),
                None => "declared here".to_owned(),
            };
            error = error.at(module.file, range.clone(), label);
        }
        if let Some(import) = candidate.import {
            let import = &user.imports[import];
            if let Some(condition) = &import.condition {
                error =
                    error.at(file, import.path_range.clone(), format!("imported if {condition}"));
            }
        }
    }
    // One import may bring several candidates.
    let mut reported = HashSet::new();
    error.labels.retain(|label| reported.insert(label.clone()));
    error
}

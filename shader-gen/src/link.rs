//! Names to declarations, across all files of a library and for all variants at once.

use std::collections::{BTreeSet, HashMap, HashSet};

use crate::condition::Condition;
use crate::error::{Code, Diagnostic};
use crate::parse::{Declaration, Import, Kind, Module};

/// The modules of a library with their names resolved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    modules: Vec<Module>,
    paths: HashMap<String, usize>,
    /// Per module and import: the module that it names.
    targets: Vec<Vec<Option<usize>>>,
    /// Per module and declaration: what its identifiers may stand for.
    links: Vec<Vec<Vec<Link>>>,
    /// Per module: what its names may stand for.
    scopes: Vec<HashMap<String, Vec<Candidate>>>,
}

/// An identifier in a declaration that names another declaration.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    /// The identifier.
    pub(crate) name: String,
    /// First bytes of its occurrences.
    pub(crate) at: Vec<usize>,
    /// What it may stand for; conditions decide.
    pub(crate) candidates: Vec<Candidate>,
}

/// A declaration that a name may stand for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    /// Module of the declaration.
    pub(crate) module: usize,
    /// Its index there.
    pub(crate) declaration: usize,
    /// Index of the import that brings it, in the module that uses the name.
    pub(crate) import: Option<usize>,
}

impl Graph {
    /// Links `modules`; with `resolve` unset some of them could not be read, and missing names are not complained of.
    pub(crate) fn new(modules: Vec<Module>, resolve: bool, errors: &mut Vec<Diagnostic>) -> Self {
        let paths = modules
            .iter()
            .enumerate()
            .map(|(index, module)| (module.path.clone(), index))
            .collect();
        let mut graph = Self { modules, paths, ..Self::default() };
        let mut found = Vec::new();
        for index in 0..graph.modules.len() {
            let targets = graph.modules[index].imports.iter().map(|import| {
                let target = graph.paths.get(&import.path).copied();
                if target.is_none() {
                    found.push(graph.unknown_module(index, import));
                }
                target
            });
            let targets = targets.collect();
            graph.targets.push(targets);
            let scope = graph.scope(index, &mut found);
            graph.scopes.push(scope);
        }
        let mut owners: HashMap<&str, usize> = HashMap::new();
        for (index, module) in graph.modules.iter().enumerate() {
            for (name, _) in
                module.declarations.iter().filter_map(|declaration| declaration.name.as_ref())
            {
                owners.entry(name).or_insert(index);
            }
        }
        for index in 0..graph.modules.len() {
            let link =
                |declaration: &Declaration| graph.link(index, declaration, &owners, &mut found);
            let links = graph.modules[index].declarations.iter().map(link).collect();
            graph.links.push(links);
        }
        // An unreadable file hides declarations; only what is certain is reported then.
        if resolve {
            errors.append(&mut found);
        }
        graph
    }

    /// The module at `path`, as in [`Module::path`].
    pub(crate) fn module(&self, path: &str) -> Option<usize> {
        self.paths.get(path).copied()
    }

    pub(crate) fn modules(&self) -> &[Module] {
        &self.modules
    }

    pub(crate) fn declaration(&self, module: usize, declaration: usize) -> &Declaration {
        &self.modules[module].declarations[declaration]
    }

    /// The imports of `module` with the modules that they name.
    pub(crate) fn imports(&self, module: usize) -> impl Iterator<Item = (&Import, usize)> {
        let targets = self.targets[module].iter();
        let imports = self.modules[module].imports.iter().zip(targets);
        imports.filter_map(|(import, target)| target.map(|target| (import, target)))
    }

    /// What the identifiers of a declaration may stand for.
    pub(crate) fn links(&self, module: usize, declaration: usize) -> &[Link] {
        &self.links[module][declaration]
    }

    /// What `name` may stand for in `module`.
    pub(crate) fn candidates(&self, module: usize, name: &str) -> &[Candidate] {
        self.scopes[module].get(name).map_or(&[], Vec::as_slice)
    }

    /// Everything that names in `module` may stand for.
    pub(crate) fn scope_of(&self, module: usize) -> impl Iterator<Item = Candidate> {
        self.scopes[module].values().flatten().copied()
    }

    /// Names of the entry points that `module` declares or imports.
    pub(crate) fn entry_points(&self, module: usize) -> BTreeSet<&str> {
        let is_entry_point = |candidates: &[Candidate]| {
            candidates.iter().any(|candidate| {
                self.declaration(candidate.module, candidate.declaration).kind == Kind::EntryPoint
            })
        };
        let scope = self.scopes[module].iter();
        scope
            .filter(|(_, candidates)| is_entry_point(candidates))
            .map(|(name, _)| name.as_str())
            .collect()
    }

    /// Names of the overrides that `module` and what it imports declare.
    pub(crate) fn overrides(&self, module: usize) -> BTreeSet<&str> {
        let all = self.closure(&[module], |_| true).into_iter();
        let declarations = all.flat_map(|module| &self.modules[module].declarations);
        let overrides = declarations.filter(|declaration| declaration.kind == Kind::Override);
        overrides.filter_map(|declaration| Some(declaration.name.as_ref()?.0.as_str())).collect()
    }

    /// `roots` and what they import where `is_taken` says so of an import's condition; what is imported comes before
    /// what imports it, and a cycle is cut where it is closed.
    pub(crate) fn closure(
        &self,
        roots: &[usize],
        is_taken: impl Fn(Option<&Condition>) -> bool,
    ) -> Vec<usize> {
        let mut order = Vec::new();
        let mut seen = HashSet::new();
        for &root in roots {
            self.visit(root, &is_taken, &mut seen, &mut order);
        }
        order
    }

    fn visit(
        &self,
        module: usize,
        is_taken: &impl Fn(Option<&Condition>) -> bool,
        seen: &mut HashSet<usize>,
        order: &mut Vec<usize>,
    ) {
        if seen.insert(module) {
            for (import, target) in self.imports(module) {
                if is_taken(import.condition.as_ref()) {
                    self.visit(target, is_taken, seen, order);
                }
            }
            order.push(module);
        }
    }

    fn unknown_module(&self, module: usize, import: &Import) -> Diagnostic {
        let known = self.modules.iter().map(|module| module.path.as_str());
        Diagnostic::unknown("module", &import.path, known).at(
            self.modules[module].file,
            import.path_range.clone(),
            "imported here",
        )
    }

    fn scope(
        &self,
        module: usize,
        errors: &mut Vec<Diagnostic>,
    ) -> HashMap<String, Vec<Candidate>> {
        let mut scope: HashMap<String, Vec<Candidate>> = HashMap::new();
        let mut add = |name: &str, from: usize, import: Option<usize>| {
            let mut found = false;
            for (declaration, declared) in self.modules[from].declarations.iter().enumerate() {
                if declared.name.as_ref().is_some_and(|(declared, _)| declared == name) {
                    found = true;
                    scope.entry(name.to_owned()).or_default().push(Candidate {
                        module: from,
                        declaration,
                        import,
                    });
                }
            }
            found
        };
        let own: BTreeSet<_> = declared_names(&self.modules[module]).collect();
        for name in own {
            add(name, module, None);
        }
        let imports = self.modules[module].imports.iter().zip(&self.targets[module]);
        for (index, (import, target)) in imports.enumerate() {
            let Some(target) = *target else {
                continue;
            };
            for (name, range) in &import.names {
                if !add(name, target, Some(index)) {
                    let known = declared_names(&self.modules[target]);
                    errors.push(
                        Diagnostic::unknown(&format!("name in `{}`", import.path), name, known).at(
                            self.modules[module].file,
                            range.clone(),
                            "imported here",
                        ),
                    );
                }
            }
        }
        scope
    }

    fn link(
        &self,
        module: usize,
        declaration: &Declaration,
        owners: &HashMap<&str, usize>,
        errors: &mut Vec<Diagnostic>,
    ) -> Vec<Link> {
        let mut links: Vec<Link> = Vec::new();
        for (name, range) in &declaration.references {
            if let Some(link) = links.iter_mut().find(|link| link.name == *name) {
                link.at.push(range.start);
                continue;
            }
            let candidates = self.candidates(module, name);
            if candidates.is_empty() {
                if let Some(owner) = owners.get(name.as_str()) {
                    let path = self.modules[*owner].path.replace('/', "::");
                    errors.push(
                        Diagnostic::new(Code::Import, format!("`{name}` is not imported"))
                            .at(self.modules[module].file, range.clone(), "used here")
                            .help(format!("import package::{path}::{{{name}}};")),
                    );
                }
                continue;
            }
            links.push(Link {
                name: name.clone(),
                at: vec![range.start],
                candidates: candidates.to_vec(),
            });
        }
        links
    }
}

fn declared_names(module: &Module) -> impl Iterator<Item = &str> {
    let names = module.declarations.iter().filter_map(|declaration| declaration.name.as_ref());
    names.map(|(name, _)| name.as_str())
}

//! The order of the house: how large crates and files are, which crate may use which, and that files of a crate do not
//! use each other in circles.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// The crates, each with those that it may use: dependencies point upwards in this list only.
const CRATES: [(&str, &[&str]); 17] = [
    ("graph", &[]),
    ("seal", &[]),
    ("fuzz", &[]),
    ("shader-gen", &["graph", "seal"]),
    ("shaders", &[]),
    ("start", &[]),
    ("oracle", &[]),
    ("results", &["oracle"]),
    ("runtime", &["graph", "seal", "shaders"]),
    ("scene", &[]),
    ("renderer", &["graph", "oracle", "runtime", "scene", "shader-gen", "shaders"]),
    (
        "measure",
        &["graph", "oracle", "renderer", "results", "runtime", "scene", "shader-gen", "shaders"],
    ),
    ("report", &["graph", "oracle", "results", "scene", "seal", "shader-gen"]),
    ("cost", &[]),
    ("consumers", &["cost", "report", "results", "seal", "shader-gen"]),
    (
        "xtask",
        &[
            "consumers",
            "cost",
            "graph",
            "measure",
            "oracle",
            "renderer",
            "report",
            "results",
            "runtime",
            "scene",
            "shader-gen",
            "shaders",
        ],
    ),
    (
        "tests",
        &[
            "consumers",
            "graph",
            "measure",
            "oracle",
            "renderer",
            "report",
            "results",
            "runtime",
            "scene",
            "seal",
            "shader-gen",
            "shaders",
        ],
    ),
];
/// Crates below a number of lines, their tests included.
const LINES: [(&str, usize); 1] = [("xtask", 2500)];
/// Lines of a file; files of tests alone may have more.
const FILE_LINES: usize = 600;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The Rust files of a folder and of those below it, with their texts.
fn files(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let entries = fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path());
    let mut entries: Vec<PathBuf> = entries.collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            // What a crate builds beside itself is no part of it.
            if !path.ends_with("target") && !path.ends_with("packages") {
                found.extend(files(&path));
            }
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            found.push((path, text));
        }
    }
    found
}

#[test]
fn crates_and_files_are_small() {
    for (name, most) in LINES {
        let lines: usize =
            files(&repository().join(name)).iter().map(|one| one.1.lines().count()).sum();
        assert!(lines <= most, "{name} has {lines} lines, at most {most}");
    }
    for (name, _) in CRATES.iter().filter(|one| one.0 != "tests") {
        let folder = repository().join(name);
        for (path, text) in files(&folder) {
            let place = path.strip_prefix(&folder).unwrap();
            let of_tests = place.starts_with("tests") || place.ends_with("tests.rs");
            let lines = text.lines().count();
            let place = place.display();
            assert!(of_tests || lines <= FILE_LINES, "{name}/{place} has {lines} lines");
        }
    }
}

/// The crates of the house that a manifest names in a section of dependencies.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let mut section = "";
    let mut found = BTreeSet::new();
    for line in manifest.lines().map(str::trim) {
        if line.starts_with('[') {
            section = line;
        } else if ["[dependencies]", "[build-dependencies]"].contains(&section)
            && let Some(rest) = line.strip_prefix("sglow-")
        {
            let name = rest.split(['.', ' ', '=']).next().unwrap_or_default();
            found.insert(name.to_owned());
        }
    }
    found
}

#[test]
fn crates_use_each_other_in_one_direction() {
    for (at, (name, allowed)) in CRATES.iter().enumerate() {
        let manifest = fs::read_to_string(repository().join(name).join("Cargo.toml")).unwrap();
        let used = dependencies(&manifest);
        for one in &used {
            assert!(allowed.contains(&one.as_str()), "{name} must not use {one}");
        }
        for one in *allowed {
            let place = CRATES.iter().position(|known| known.0 == *one);
            assert!(
                place.is_some_and(|place| place < at),
                "{name} would use {one}, which is below it"
            );
        }
    }
    let workspace = fs::read_to_string(repository().join("Cargo.toml")).unwrap();
    let members = workspace.lines().find(|line| line.starts_with("members")).unwrap();
    let members: BTreeSet<&str> = members.split('"').skip(1).step_by(2).collect();
    let known: BTreeSet<&str> = CRATES.iter().map(|one| one.0).collect();
    assert_eq!(members, known, "every crate has its place in the order");
}

/// All packages that a package depends on by the lock file, itself among them, those of its tests included.
fn closure(lock: &str, package: &str) -> BTreeSet<String> {
    let mut uses = BTreeMap::<&str, Vec<&str>>::new();
    let mut name = "";
    for line in lock.lines().map(str::trim) {
        if let Some(rest) = line.strip_prefix("name = ") {
            name = rest.trim_matches('"');
        } else if let Some(rest) = line.strip_prefix('"') {
            let used = rest.split(['"', ' ']).next().unwrap_or_default();
            uses.entry(name).or_default().push(used);
        }
    }
    let mut found = BTreeSet::new();
    let mut open = vec![package];
    while let Some(next) = open.pop() {
        if found.insert(next.to_owned()) {
            open.extend(uses.get(next).into_iter().flatten());
        }
    }
    found
}

#[test]
fn what_needs_no_device_has_none() {
    let lock = fs::read_to_string(repository().join("Cargo.lock")).unwrap();
    for name in ["graph", "seal", "shader-gen", "oracle", "results", "scene", "report", "consumers"]
    {
        let all = closure(&lock, &format!("sglow-{name}"));
        assert!(all.len() > 1 && !all.contains("wgpu"), "{name} compiles wgpu");
    }
    assert!(closure(&lock, "sglow-measure").contains("wgpu"), "the control has none");
}

/// A module by the names on the way to it; the root has none.
type Module = Vec<String>;

/// What a source names of its own crate.
#[derive(Debug, Default, PartialEq)]
struct Named {
    /// Paths, and whether each is a re-export.
    paths: Vec<(Vec<String>, bool)>,
    /// Modules that only tests have.
    test_modules: Vec<String>,
}

impl Named {
    fn of(text: &str) -> Self {
        let mut named = Self::default();
        named.read(text.parse().unwrap());
        named
    }

    fn read(&mut self, stream: TokenStream) {
        let tokens: Vec<TokenTree> = stream.into_iter().collect();
        let mut at = 0;
        while at < tokens.len() {
            if let Some(after) = self.test_item(&tokens, at) {
                at = after;
            } else if is(&tokens, at, "use") {
                let public = at > 0 && (is(&tokens, at - 1, "pub") || restricted(&tokens, at));
                let end = (at..tokens.len()).find(|&end| punct(&tokens, end) == Some(';'));
                let end = end.unwrap_or(tokens.len());
                self.tree(&tokens[at + 1..end], &[], public);
                at = end + 1;
            } else if let Some((path, after)) = path(&tokens, at) {
                self.paths.push((path, false));
                at = after;
            } else {
                // What is quoted is code of another crate.
                let quoted =
                    at > 1 && punct(&tokens, at - 1) == Some('!') && is(&tokens, at - 2, "quote");
                if let TokenTree::Group(group) = &tokens[at]
                    && !quoted
                {
                    self.read(group.stream());
                }
                at += 1;
            }
        }
    }

    /// Behind an item that only tests have.
    fn test_item(&mut self, tokens: &[TokenTree], at: usize) -> Option<usize> {
        let TokenTree::Group(attribute) = tokens.get(at + 1)? else { return None };
        let text = attribute.stream().to_string().replace(' ', "");
        if punct(tokens, at) != Some('#') || text != "cfg(test)" {
            return None;
        }
        let ends = |end: &usize| match &tokens[*end] {
            TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
            TokenTree::Punct(mark) => mark.as_char() == ';',
            _ => false,
        };
        let end = (at + 2..tokens.len()).find(ends)?;
        if let Some(name) = (at + 2..end).find(|&at| is(tokens, at, "mod")) {
            self.test_modules.push(tokens[name + 1].to_string());
        }
        Some(end + 1)
    }

    /// The leaves of a tree of `use`.
    fn tree(&mut self, tokens: &[TokenTree], before: &[String], public: bool) {
        for part in
            tokens.split(|token| matches!(token, TokenTree::Punct(mark) if mark.as_char() == ','))
        {
            let mut path = before.to_vec();
            for token in part {
                match token {
                    TokenTree::Ident(name) if name == "as" => break,
                    TokenTree::Ident(name) => path.push(name.to_string()),
                    TokenTree::Punct(mark) if mark.as_char() == '*' => path.push("*".to_owned()),
                    TokenTree::Group(group) => {
                        let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                        self.tree(&inner, &path, public);
                        path.clear();
                        break;
                    }
                    _ => {}
                }
            }
            if path.len() > before.len() {
                self.paths.push((path, public));
            }
        }
    }
}

fn is(tokens: &[TokenTree], at: usize, word: &str) -> bool {
    matches!(tokens.get(at), Some(TokenTree::Ident(name)) if name == word)
}

fn punct(tokens: &[TokenTree], at: usize) -> Option<char> {
    match tokens.get(at) {
        Some(TokenTree::Punct(mark)) => Some(mark.as_char()),
        _ => None,
    }
}

/// Whether `pub(…)` stands before.
fn restricted(tokens: &[TokenTree], at: usize) -> bool {
    at > 1
        && matches!(&tokens[at - 1], TokenTree::Group(group) if group.delimiter() == Delimiter::Parenthesis)
        && is(tokens, at - 2, "pub")
}

/// A path of at least two names, and what is behind it.
fn path(tokens: &[TokenTree], at: usize) -> Option<(Vec<String>, usize)> {
    let mut path = Vec::new();
    let mut next = at;
    while let Some(TokenTree::Ident(name)) = tokens.get(next) {
        path.push(name.to_string());
        next += 1;
        if (punct(tokens, next), punct(tokens, next + 1)) != (Some(':'), Some(':')) {
            break;
        }
        next += 2;
    }
    (path.len() > 1).then_some((path, next))
}

/// Which module uses which, by their sources.
fn edges(sources: &BTreeMap<Module, String>) -> BTreeMap<Module, BTreeSet<Module>> {
    let named: BTreeMap<&Module, Named> =
        sources.iter().map(|(module, text)| (module, Named::of(text))).collect();
    let of_tests = |module: &Module| {
        (1..=module.len()).any(|length| {
            let parent = named.get(&module[..length - 1].to_vec());
            parent.is_some_and(|parent| parent.test_modules.contains(&module[length - 1]))
        })
    };
    let exists = |path: &[String]| sources.contains_key(path);
    // From the path as it stands in a module to names from the root.
    let absolute = |module: &Module, path: &[String]| -> Option<Module> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => Some(rest.to_vec()),
            "self" => Some([module, rest].concat()),
            "super" => {
                let mut base = module.clone();
                let ups = path.iter().take_while(|name| *name == "super").count();
                base.truncate(base.len().checked_sub(ups)?);
                Some([&base, &path[ups..]].concat())
            }
            _ => {
                let child = [module.as_slice(), std::slice::from_ref(first)].concat();
                exists(&child).then(|| [module.as_slice(), path].concat())
            }
        }
    };
    // The module that an item of a path stands in; what is exported again stands where it comes from.
    let resolve = |mut path: Module| -> Module {
        for _ in 0..8 {
            let length =
                (0..=path.len()).rev().find(|&length| exists(&path[..length])).unwrap_or(0);
            let (module, item) = (path[..length].to_vec(), path.get(length));
            let again = item.and_then(|item| {
                let exports = named[&module].paths.iter().filter(|one| one.1);
                let mut exports = exports.filter_map(|one| absolute(&module, &one.0));
                exports.find(|one| one.last() == Some(item) && one.len() > 1)
            });
            match again {
                Some(again) if again != path => path = again,
                _ => return module,
            }
        }
        path
    };
    let mut edges = BTreeMap::new();
    for (module, named) in &named {
        let mut used = BTreeSet::new();
        if !of_tests(module) {
            let own = named.paths.iter().filter(|one| !one.1);
            used.extend(own.filter_map(|one| absolute(module, &one.0)).map(resolve));
            used.remove(*module);
        }
        edges.insert((*module).clone(), used);
    }
    edges
}

/// Modules that use each other, by what each reaches.
fn circles(edges: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<BTreeSet<Module>> {
    let modules: Vec<&Module> = edges.keys().collect();
    let number: BTreeMap<&Module, usize> = modules.iter().copied().zip(0..).collect();
    let uses: Vec<Vec<usize>> =
        edges.values().map(|used| used.iter().map(|one| number[one]).collect()).collect();
    let reached: Vec<Vec<bool>> = (0..modules.len())
        .map(|from| {
            let mut found = vec![false; modules.len()];
            let mut open = uses[from].clone();
            while let Some(next) = open.pop() {
                if !std::mem::replace(&mut found[next], true) {
                    open.extend(&uses[next]);
                }
            }
            found
        })
        .collect();
    let circle = |one: usize| -> BTreeSet<Module> {
        let both = |other: &usize| reached[one][*other] && reached[*other][one];
        (0..modules.len()).filter(both).map(|at| modules[at].clone()).collect()
    };
    let circles: BTreeSet<_> = (0..modules.len()).map(circle).collect();
    circles.into_iter().filter(|circle| circle.len() > 1).collect()
}

/// The modules of a crate, with their texts.
fn modules(name: &str) -> BTreeMap<Module, String> {
    let folder = repository().join(name).join("src");
    let module = |(path, text): (PathBuf, String)| {
        let place = path.strip_prefix(&folder).unwrap().with_extension("");
        let mut names: Module =
            place.iter().map(|name| name.to_string_lossy().into_owned()).collect();
        if ["lib", "main", "mod"].iter().any(|root| names.last().is_some_and(|name| name == root)) {
            names.pop();
        }
        (names, text)
    };
    files(&folder).into_iter().map(module).collect()
}

#[test]
fn files_do_not_use_each_other_in_circles() {
    for (name, _) in CRATES.iter().filter(|one| one.0 != "shaders") {
        let circles = circles(&edges(&modules(name)));
        assert!(circles.is_empty(), "files of {name} use each other in circles: {circles:#?}");
    }
}

#[test]
fn a_circle_is_found_and_what_is_none_is_not() {
    let of = |sources: &[(&str, &str)]| {
        let module = |path: &str| {
            path.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect()
        };
        let sources = sources.iter().map(|&(path, text)| (module(path), text.to_owned()));
        circles(&edges(&sources.collect())).len()
    };
    let both = [
        ("", "mod one; mod other;"),
        ("one", "use crate::other::Thing; pub struct Own;"),
        ("other", "pub struct Thing; fn f() { let _ = super::one::Own; }"),
    ];
    assert_eq!(of(&both), 1);
    let parent = [
        ("", "pub mod page;"),
        ("page", "mod part; fn f() { part::section(); } pub fn whole() {}"),
        ("page::part", "use super::whole; pub fn section() {}"),
    ];
    assert_eq!(of(&parent), 1);
    let tests = [
        ("", "mod one; mod other;"),
        ("one", "pub struct Own; #[cfg(test)] mod tests { use crate::other::Thing; }"),
        ("other", "use crate::one::{self, Own}; pub struct Thing;"),
    ];
    assert_eq!(of(&tests), 0);
    let exports = [
        ("", "mod one; mod other; pub use one::Own; pub(crate) use other::Thing;"),
        ("one", "use crate::Thing; pub struct Own;"),
        ("other", "pub struct Thing;"),
    ];
    assert_eq!(of(&exports), 0);
}

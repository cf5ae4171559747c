//! Functions for hosts that bring their own passes: all of them in one text, and in modules that import each other. No flag
//! holds in them, and they have neither bindings nor entry points.

use std::collections::{BTreeMap, BTreeSet};

use crate::assemble::{Assembled, Order};
use crate::deep::deep;
use crate::error::{Code, Diagnostic, Report};
use crate::library::{FunctionLibrary, Library};
use crate::parse::Kind;
use crate::prune::reachable;
use crate::validate::validate;

/// The functions that the `[package]` table offers, each once in either form.
#[derive(Clone, Debug, Default)]
pub struct Functions {
    /// WGSL: all of them, and what they need.
    pub whole: String,
    /// The same by module, in the order of the table.
    pub modules: Vec<FunctionModule>,
}

/// A module of functions.
#[derive(Clone, Debug)]
pub struct FunctionModule {
    /// Its name.
    pub name: String,
    /// WESL: what it imports of its neighbours, and its own declarations.
    pub text: String,
}

/// Generates the function libraries of the `[package]` table; none if it has none.
///
/// # Errors
///
/// What is wrong with any of them; that they need bindings, overrides or entry points, too, or what none of them has.
pub fn functions(library: &Library) -> Result<Option<Functions>, Report> {
    if library.package.lib.is_empty() {
        return Ok(None);
    }
    deep(|| generated(library))
        .map(Some)
        .map_err(|errors| Report::new(errors, library.sources().clone()))
}

fn generated(library: &Library) -> Result<Functions, Vec<Diagnostic>> {
    let graph = library.graph();
    let roots = |of: &FunctionLibrary| -> Vec<usize> {
        let path = |module: &String| graph.module(module.trim_end_matches(".wesl"));
        of.modules.iter().filter_map(path).collect()
    };
    let declared = &library.package.lib;
    let mut owners: BTreeMap<usize, &FunctionLibrary> = BTreeMap::new();
    for of in declared {
        owners.extend(roots(of).into_iter().map(|module| (module, of)));
    }
    let all: Vec<usize> = declared.iter().flat_map(roots).collect();
    let assembled = Assembled::new(library, &all, &BTreeSet::new())?;
    let pieces = assembled.pieces();
    let offered = |index: &usize| owners.contains_key(&pieces[*index].module);
    let keep = reachable(&assembled, (0..pieces.len()).filter(offered));
    check(&assembled, &keep, &owners)?;
    let whole = assembled.text(&Order::of_imports(&keep));
    validate(&whole, &BTreeSet::new()).map_err(|error| vec![*error])?;
    let modules = declared.iter().map(|of| {
        let own: Vec<bool> = (0..pieces.len())
            .map(|piece| {
                keep[piece]
                    && owners.get(&pieces[piece].module).is_some_and(|owner| owner.name == of.name)
            })
            .collect();
        let mut imports: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        let used = (0..pieces.len()).filter(|piece| own[*piece]);
        for (_, used) in used.flat_map(|piece| &pieces[piece].names).filter(|(_, used)| !own[*used])
        {
            if let Some(owner) = owners.get(&pieces[*used].module)
                && let Some((name, _)) = &assembled.declaration(&pieces[*used]).name
            {
                imports.entry(&owner.name).or_default().insert(name);
            }
        }
        let mut text: String = imports
            .into_iter()
            .map(|(module, names)| {
                let names: Vec<_> = names.into_iter().collect();
                let line = format!("import super::{module}::{{{}}};\n", names.join(", "));
                if line.len() <= 120 {
                    return line;
                }
                format!("import super::{module}::{{\n    {},\n}};\n", names.join(",\n    "))
            })
            .collect();
        if !text.is_empty() {
            text.push('\n');
        }
        text.push_str(assembled.text(&Order::of_imports(&own)).text.trim_start_matches('\n'));
        FunctionModule { name: of.name.clone(), text }
    });
    let modules = modules.collect();
    Ok(Functions { whole: whole.text, modules })
}

/// Everything that stays can stand in a function library, and belongs to one.
fn check(
    assembled: &Assembled<'_>,
    keep: &[bool],
    owners: &BTreeMap<usize, &FunctionLibrary>,
) -> Result<(), Vec<Diagnostic>> {
    let mut errors = Vec::new();
    for (piece, _) in assembled.pieces().iter().zip(keep).filter(|(_, keep)| **keep) {
        let declaration = assembled.declaration(piece);
        let Some((name, range)) = &declaration.name else {
            continue;
        };
        let kind = declaration.kind.name();
        let owner = owners.get(&piece.module);
        if matches!(declaration.kind, Kind::EntryPoint | Kind::Variable | Kind::Override) {
            let error = Diagnostic::new(
                Code::Declaration,
                format!("a function library cannot hold {kind} `{name}`"),
            );
            let error = error
                .at(assembled.file(piece), range.clone(), "declared here")
                .help("hand it over as a parameter");
            errors.push(match owner {
                Some(owner) => error.help(format!("in the function library `{}`", owner.name)),
                None => error,
            });
        } else if owner.is_none() {
            errors.push(
                Diagnostic::new(
                    Code::Declaration,
                    format!("function libraries need {kind} `{name}`, and none of them has it"),
                )
                .at(assembled.file(piece), range.clone(), "declared here")
                .help("name its module in a `[[package.lib]]`"),
            );
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

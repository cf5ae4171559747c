//! What entry points do not reach is taken out of the text, and naga proves that nothing else was.
//!
//! Which declarations stay is decided on the text: those that an entry point names, and those that these name. That is
//! more than naga's intermediate representation (IR) could say, for naga folds constants and aliases away that the text
//! still needs. naga then decides whether the outcome is right: see [`prove`].

use std::collections::BTreeSet;
use std::fmt::{Debug, Write};

use naga::compact::{KeepUnused, compact};
use naga::{Block, Span, Statement};

use crate::assemble::{Assembled, Order, Text};
use crate::order::of_reading;
use crate::parse::Kind;

/// What a pruned text is compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Whole {
    /// The module of the pass with what it imports, name by name, as WESL has it. Every generation does this.
    #[default]
    Imports,
    /// All of every module that is imported from, however little of it is. Takes almost twice as long.
    Modules,
}

/// The texts of a variant before and after pruning.
#[derive(Clone, Debug)]
pub struct Pruned {
    /// What the entry points reach.
    pub text: Text,
    /// All there was: first what stays, in the same order, so that naga numbers it alike, then the rest. WGSL does not
    /// care about the order of declarations. None if there is no rest.
    pub unpruned: Option<Text>,
    /// Per piece of the assembly whether it stays.
    pub(crate) keep: Vec<bool>,
}

/// Takes out whole declarations, with their comments, that none of `entry_points` reaches.
pub(crate) fn prune(assembled: &Assembled<'_>, entry_points: &[String], whole: Whole) -> Pruned {
    let keep = reachable(assembled, entry_points.iter().filter_map(|name| assembled.find(name)));
    let mut rest = match whole {
        Whole::Imports => reachable(assembled, assembled.imported()),
        Whole::Modules => vec![true; keep.len()],
    };
    rest.iter_mut().zip(&keep).for_each(|(rest, keep)| *rest &= !keep);
    let order = of_reading(assembled, &keep, entry_points);
    let text = assembled.text(&order);
    let unpruned = rest
        .contains(&true)
        .then(|| text.clone().followed_by(assembled.rest(&Order::of_imports(&rest))));
    Pruned { text, unpruned, keep }
}

/// Which pieces `roots` reach. An assertion stays where all that it names stays.
pub(crate) fn reachable(
    assembled: &Assembled<'_>,
    roots: impl IntoIterator<Item = usize>,
) -> Vec<bool> {
    let mut pending: Vec<usize> = roots.into_iter().collect();
    let pieces = assembled.pieces();
    let mut keep = vec![false; pieces.len()];
    while let Some(piece) = pending.pop() {
        if !std::mem::replace(&mut keep[piece], true) {
            pending.extend(pieces[piece].names.iter().map(|(_, name)| *name));
        }
    }
    for (index, piece) in pieces.iter().enumerate() {
        if assembled.declaration(piece).kind == Kind::Assertion {
            keep[index] = piece.names.iter().all(|(_, name)| keep[*name]);
        }
    }
    keep
}

/// How a pruned text differs from what it was pruned from.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Difference {
    /// naga finds something in the pruned text that no entry point reaches.
    #[error("{kind} `{name}` is left although no entry point reaches it")]
    Left {
        /// What it is.
        kind: &'static str,
        /// Its name.
        name: String,
    },
    /// The IR of the pruned text is not the compacted IR of the unpruned text.
    #[error("the {part} of the pruned text are not those of the unpruned text")]
    Changed {
        /// The part of the IR that differs.
        part: &'static str,
    },
}

/// Proves that `pruned` is `unpruned` without what `entry_points` do not reach: its IR is the compacted IR of
/// `unpruned`, and holds no function, variable or override that compaction would remove. Without `unpruned` the text is
/// as it was, and only the latter is to be shown.
///
/// Both modules must be valid, and declare what they have in common in the same order.
///
/// # Errors
///
/// The first difference.
pub fn prove(
    pruned: &naga::Module,
    unpruned: Option<naga::Module>,
    entry_points: &[String],
) -> Result<(), Difference> {
    let mut kept = compacted(pruned.clone(), pruned, entry_points);
    for (kind, before, after) in [
        ("function", function_names(pruned), function_names(&kept)),
        ("var", variable_names(pruned), variable_names(&kept)),
        ("override", override_names(pruned), override_names(&kept)),
        ("entry point", entry_point_names(pruned), entry_point_names(&kept)),
    ] {
        if let Some(name) = before.difference(&after).next() {
            let name = (*name).to_owned();
            return Err(Difference::Left { kind, name });
        }
    }
    let Some(unpruned) = unpruned else {
        return Ok(());
    };
    let mut whole = compacted(unpruned, pruned, entry_points);
    forget_places(&mut kept);
    forget_places(&mut whole);
    let naga::Module {
        types,
        special_types,
        constants,
        overrides,
        global_variables,
        global_expressions,
        functions,
        entry_points,
        diagnostic_filters,
        diagnostic_filter_leaf,
        // Comments are no part of what a shader does.
        doc_comments: _,
    } = &whole;
    let same = [
        ("types", same(&kept.types, types)),
        ("special types", same(&kept.special_types, special_types)),
        ("constants", same(&kept.constants, constants)),
        ("overrides", same(&kept.overrides, overrides)),
        ("variables", same(&kept.global_variables, global_variables)),
        ("constant expressions", same(&kept.global_expressions, global_expressions)),
        ("functions", same(&kept.functions, functions)),
        ("entry points", same(&kept.entry_points, entry_points)),
        // Filters of functions that were taken out come last and are of no account.
        (
            "diagnostic filters",
            kept.diagnostic_filters
                .iter()
                .zip(diagnostic_filters.iter())
                .all(|((_, a), (_, b))| same(a, b))
                && kept.diagnostic_filters.len() <= diagnostic_filters.len(),
        ),
        ("diagnostic directives", same(&kept.diagnostic_filter_leaf, diagnostic_filter_leaf)),
    ];
    match same.into_iter().find(|(_, same)| !same) {
        Some((part, _)) => Err(Difference::Changed { part }),
        None => Ok(()),
    }
}

/// `module` with what `entry_points` need of it. Compaction never removes a named constant; those that `pruned` does
/// not name lose their names first, so that only what is used of them stays.
fn compacted(
    mut module: naga::Module,
    pruned: &naga::Module,
    entry_points: &[String],
) -> naga::Module {
    let names: BTreeSet<_> =
        pruned.constants.iter().filter_map(|(_, constant)| constant.name.as_deref()).collect();
    for (_, constant) in module.constants.iter_mut() {
        if constant.name.as_deref().is_some_and(|name| !names.contains(name)) {
            constant.name = None;
        }
    }
    module.entry_points.retain(|entry_point| entry_points.contains(&entry_point.name));
    compact(&mut module, KeepUnused::No);
    module
}

/// Statements know where in the text they stand, which is no part of what they do.
fn forget_places(module: &mut naga::Module) {
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    let entry_points = module.entry_points.iter_mut().map(|entry_point| &mut entry_point.function);
    for function in functions.chain(entry_points) {
        forget_places_in(&mut function.body);
    }
}

fn forget_places_in(block: &mut Block) {
    for (statement, place) in block.span_iter_mut() {
        if let Some(place) = place {
            *place = Span::UNDEFINED;
        }
        match statement {
            Statement::Block(block) => forget_places_in(block),
            Statement::If { accept, reject, .. } => {
                forget_places_in(accept);
                forget_places_in(reject);
            }
            Statement::Switch { cases, .. } => {
                cases.iter_mut().for_each(|case| forget_places_in(&mut case.body));
            }
            Statement::Loop { body, continuing, .. } => {
                forget_places_in(body);
                forget_places_in(continuing);
            }
            _ => {}
        }
    }
}

/// Whether two parts of the IR are the same in every field.
fn same<T: Debug>(a: &T, b: &T) -> bool {
    let mut expected = String::new();
    // Writing to memory cannot fail.
    let _ = write!(expected, "{a:?}");
    let mut rest = Rest(&expected);
    write!(rest, "{b:?}").is_ok() && rest.0.is_empty()
}

/// Accepts exactly the text that it holds.
struct Rest<'a>(&'a str);

impl Write for Rest<'_> {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.0 = self.0.strip_prefix(text).ok_or(std::fmt::Error)?;
        Ok(())
    }
}

fn function_names(module: &naga::Module) -> BTreeSet<&str> {
    module.functions.iter().filter_map(|(_, function)| function.name.as_deref()).collect()
}

fn variable_names(module: &naga::Module) -> BTreeSet<&str> {
    module.global_variables.iter().filter_map(|(_, variable)| variable.name.as_deref()).collect()
}

fn override_names(module: &naga::Module) -> BTreeSet<&str> {
    module.overrides.iter().filter_map(|(_, item)| item.name.as_deref()).collect()
}

fn entry_point_names(module: &naga::Module) -> BTreeSet<&str> {
    module.entry_points.iter().map(|entry_point| entry_point.name.as_str()).collect()
}

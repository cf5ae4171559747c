//! From a library and a list of variants to texts that are pruned, proved and valid.

use rayon::prelude::*;

use crate::assemble::Assembled;
use crate::deep::deep;
use crate::error::{Code, Diagnostic, Report, merge};
use crate::library::{Library, Pass};
use crate::matrix::Variant;
use crate::parse::Kind;
use crate::prune::{Difference, Whole, prove, prune};
use crate::validate::{Validated, validate};

/// Generates `variants`, on all cores, in their order, each compared with what it imports.
///
/// # Errors
///
/// As [`variants_against`].
pub fn variants(library: &Library, variants: &[Variant]) -> Result<Vec<Validated>, Report> {
    variants_against(library, variants, Whole::Imports)
}

/// Generates `variants`, on all cores, in their order, each compared with `whole`.
///
/// # Errors
///
/// Everything that is wrong with any of them; what several share is reported once.
pub fn variants_against(
    library: &Library,
    variants: &[Variant],
    whole: Whole,
) -> Result<Vec<Validated>, Report> {
    let results: Vec<_> =
        deep(|| variants.par_iter().map(|variant| one(library, variant, whole)).collect());
    let mut validated = Vec::new();
    let mut errors = Vec::new();
    for (variant, result) in variants.iter().zip(results) {
        match result {
            Ok(one) => validated.push(one),
            Err(found) => errors.extend(found.into_iter().map(|error| (variant.id(), error))),
        }
    }
    if errors.is_empty() {
        Ok(validated)
    } else {
        Err(Report::new(merge(errors), library.sources().clone()))
    }
}

fn one(library: &Library, variant: &Variant, whole: Whole) -> Result<Validated, Vec<Diagnostic>> {
    let graph = library.graph();
    let pass = library.find_pass(&variant.pass);
    let root = pass.and_then(|pass| graph.module(pass.source.trim_end_matches(".wesl")));
    let (Some(pass), Some(root)) = (pass, root) else {
        let known = library.pass.iter().map(|pass| pass.name.as_str());
        return Err(vec![Diagnostic::unknown("pass", &variant.pass, known)]);
    };
    let flags = library.flags_of(variant);
    let requires = library.requires(variant);
    let assembled = Assembled::new(library, &[root], &flags)?;
    let left_out = pass.entry_points.iter().filter(|name| assembled.find(name).is_none());
    let left_out: Vec<_> = left_out.map(|name| without_entry_point(library, root, name)).collect();
    if !left_out.is_empty() {
        return Err(left_out);
    }
    let pruned = prune(&assembled, &pass.entry_points, whole);
    check_overrides(&assembled, &pruned.keep, pass)?;
    let single = |error: Box<Diagnostic>| vec![*error];
    let (module, info) = validate(&pruned.text, &requires).map_err(single)?;
    let unpruned = match &pruned.unpruned {
        Some(text) => Some(validate(text, &requires).map_err(single)?.0),
        None => None,
    };
    prove(&module, unpruned, &pass.entry_points)
        .map_err(|difference| vec![refused(&assembled, &difference)])?;
    let omitted = assembled.omitted(&pruned.keep, &flags, &pass.entry_points.join(", "));
    Ok(Validated { variant: variant.clone(), text: pruned.text.text, module, info, omitted })
}

fn without_entry_point(library: &Library, root: usize, name: &str) -> Diagnostic {
    let graph = library.graph();
    let error = Diagnostic::new(Code::Import, format!("conditions leave entry point `{name}` out"));
    graph.candidates(root, name).iter().fold(error, |error, candidate| {
        match &graph.declaration(candidate.module, candidate.declaration).name {
            Some((_, range)) => error.at(
                graph.modules()[candidate.module].file,
                range.clone(),
                "its condition, or that of its import, does not hold",
            ),
            None => error,
        }
    })
}

fn refused(assembled: &Assembled<'_>, difference: &Difference) -> Diagnostic {
    let diagnostic = Diagnostic::new(Code::Pruning, difference.to_string());
    let Difference::Left { name, .. } = difference else {
        return diagnostic;
    };
    let piece = assembled.find(name).map(|index| &assembled.pieces()[index]);
    let named = piece.and_then(|piece| Some((piece, assembled.declaration(piece).name.as_ref()?)));
    match named {
        Some((piece, (_, range))) => diagnostic
            .at(assembled.file(piece), range.clone(), "declared here")
            .help("its name is used where nothing comes of it; leave that out"),
        None => diagnostic,
    }
}

/// Every override that stays has a description and a range.
fn check_overrides(
    assembled: &Assembled<'_>,
    keep: &[bool],
    pass: &Pass,
) -> Result<(), Vec<Diagnostic>> {
    let mut errors = Vec::new();
    for (piece, _) in assembled.pieces().iter().zip(keep).filter(|(_, keep)| **keep) {
        let declaration = assembled.declaration(piece);
        if let Some((name, range)) = &declaration.name
            && declaration.kind == Kind::Override
            && !pass.overrides.iter().any(|declared| declared.name == *name)
        {
            errors.push(
                Diagnostic::new(Code::Declaration, format!("pass `{}` does not declare override `{name}`", pass.name))
                    .at(assembled.file(piece), range.clone(), "declared here")
                    .help("give its description and its range in a `[[pass.override]]` of the library's declaration"),
            );
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

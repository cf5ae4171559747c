//! The names of the distinct layouts that a struct has in different variants.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::names::pascal;
use crate::library::Library;
use crate::manifest::{self, FieldType, Layout};

/// A layout with its name in Rust.
pub(super) struct Named {
    pub(super) rust: String,
    pub(super) layout: Arc<Layout>,
    /// The values that lead to it, where the struct has other layouts too.
    pub(super) condition: Option<String>,
}

/// Equal in memory; descriptions do not count.
pub(super) fn same_layout(a: &Layout, b: &Layout) -> bool {
    a.name == b.name
        && a.size == b.size
        && a.fields.len() == b.fields.len()
        && a.fields.iter().zip(&b.fields).all(|(a, b)| {
            a.name == b.name && a.offset == b.offset && same_type(&a.r#type, &b.r#type)
        })
}

fn same_type(a: &FieldType, b: &FieldType) -> bool {
    match (a, b) {
        (FieldType::Struct(a), FieldType::Struct(b)) => same_layout(a, b),
        (
            FieldType::Array { element: a, length: a_length, stride: a_stride },
            FieldType::Array { element: b, length: b_length, stride: b_stride },
        ) => a_length == b_length && a_stride == b_stride && same_type(a, b),
        (a, b) => a == b,
    }
}

/// Gives a name to each distinct layout of a struct.
///
/// One layout keeps the struct's name. Of several, each is called after the values that lead to it: of the smallest set
/// of axes that tells the layouts apart, the first such values in the library's order. So a value that is added to an
/// axis later renames nothing.
pub(super) fn name_layouts(
    library: &Library,
    name: &str,
    uses: &[(&manifest::Described, &Arc<Layout>)],
) -> Vec<Named> {
    let mut distinct: Vec<&Arc<Layout>> = Vec::new();
    let indices: Vec<usize> = uses
        .iter()
        .map(|(_, layout)| {
            distinct.iter().position(|known| same_layout(known, layout)).unwrap_or_else(|| {
                distinct.push(layout);
                distinct.len() - 1
            })
        })
        .collect();
    let base = if name.starts_with(|c: char| c.is_ascii_uppercase()) && !name.contains('_') {
        name.to_owned()
    } else {
        pascal(name)
    };
    if let [layout] = distinct.as_slice() {
        return vec![Named { rust: base, layout: Arc::clone(layout), condition: None }];
    }
    let choices = telling_choices(library, uses, &indices);
    let rank = |choice: &str, value: &str| match choice {
        PASS => library.pass.iter().position(|pass| pass.name == value),
        axis => library
            .axis
            .get(axis)
            .and_then(|axis| axis.value.iter().position(|known| known.name == value)),
    };
    let mut named: Vec<_> = distinct
        .iter()
        .enumerate()
        .map(|(index, layout)| {
            let mut combinations: Vec<Vec<&str>> = uses
                .iter()
                .zip(&indices)
                .filter(|(_, of)| **of == index)
                .map(|((variant, _), _)| {
                    choices.iter().map(|choice| chosen(variant, choice)).collect()
                })
                .collect();
            combinations.sort_by_key(|values| {
                choices
                    .iter()
                    .zip(values)
                    .map(|(choice, value)| rank(choice, value))
                    .collect::<Vec<_>>()
            });
            combinations.dedup();
            let suffix: String = combinations.iter().take(1).flatten().map(|v| pascal(v)).collect();
            let conditions = combinations.iter().map(|values| {
                let pairs = choices.iter().zip(values).filter(|(_, value)| !value.is_empty());
                let pairs = pairs.map(|(choice, value)| format!("{choice} = {value}"));
                pairs.collect::<Vec<_>>().join(", ")
            });
            Named {
                rust: base.clone() + &suffix,
                layout: Arc::clone(layout),
                condition: Some(conditions.collect::<Vec<_>>().join("; or ")),
            }
        })
        .collect();
    named.sort_by(|a, b| a.rust.cmp(&b.rust));
    named
}

/// Stands for a variant's pass among its axes.
const PASS: &str = "pass";

/// A variant's value, or nothing where its pass lacks the axis.
fn chosen<'a>(variant: &'a manifest::Described, choice: &str) -> &'a str {
    if choice == PASS { &variant.pass } else { variant.axes.get(choice).map_or("", String::as_str) }
}

/// The smallest set of axes, the first in the library's order, whose values determine the layout; with the pass as the
/// last resort.
fn telling_choices<'a>(
    library: &'a Library,
    uses: &[(&manifest::Described, &Arc<Layout>)],
    indices: &[usize],
) -> Vec<&'a str> {
    let mut candidates: Vec<&str> = Vec::new();
    for pass in &library.pass {
        if uses.iter().any(|(variant, _)| variant.pass == pass.name) {
            for axis in &pass.axes {
                if !candidates.contains(&axis.as_str()) {
                    candidates.push(axis);
                }
            }
        }
    }
    candidates.push(PASS);
    let tells = |choices: &[&str]| {
        let mut seen: BTreeMap<Vec<&str>, usize> = BTreeMap::new();
        uses.iter().zip(indices).all(|((variant, _), index)| {
            let values = choices.iter().map(|choice| chosen(variant, choice)).collect();
            *seen.entry(values).or_insert(*index) == *index
        })
    };
    let mut sets: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..candidates.len() {
        sets = sets
            .iter()
            .flat_map(|set| {
                let next = set.last().map_or(0, |last| last + 1);
                (next..candidates.len()).map(move |index| [set.as_slice(), &[index]].concat())
            })
            .collect();
        for set in &sets {
            let choices: Vec<_> =
                set.iter().filter_map(|index| candidates.get(*index).copied()).collect();
            if tells(&choices) {
                return choices;
            }
        }
    }
    candidates
}

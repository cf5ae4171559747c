//! What pruning has left out of each variant: a file beside the manifest.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::shared::key;
use crate::validate::Validated;

/// Declarations of the library that variants do without, by the reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Omissions {
    /// The version of the manifest's format that it belongs to.
    pub schema_version: u32,
    /// By reason what is left out, each as `function name` by what it is. Where different things have the same reason, those
    /// after the first have `:2`, `:3` and so on behind it.
    pub left_out: BTreeMap<String, Vec<String>>,
    /// For each variant the keys of all that it does without.
    pub variants: BTreeMap<String, Vec<String>>,
}

impl Omissions {
    /// What these variants do without.
    #[must_use]
    pub fn of(validated: &[Validated]) -> Self {
        let mut found = Self {
            schema_version: super::SCHEMA_VERSION,
            left_out: BTreeMap::new(),
            variants: BTreeMap::new(),
        };
        let mut sorted: Vec<_> = validated.iter().map(|one| (one.variant.id(), one)).collect();
        sorted.sort_by(|a, b| a.0.cmp(&b.0));
        for (id, one) in sorted {
            let mut by_reason = BTreeMap::<&str, Vec<String>>::new();
            for omitted in &one.omitted {
                let declaration = format!("{} {}", omitted.kind, omitted.name);
                by_reason.entry(&omitted.reason).or_default().push(declaration);
            }
            let keys = by_reason.into_iter();
            let keys = keys.map(|(reason, names)| key(&mut found.left_out, reason, names));
            found.variants.insert(id, keys.collect());
        }
        found
    }
}

//! The texts of a package for people: what it has, what changed, its licences.

use super::error::Error;
use super::options::Parts;
use crate::library::Library;
use crate::manifest::{Manifest, Operations};

pub(super) fn readme(library: &Library, manifest: &Manifest) -> String {
    let mut text = format!(
        "# {} {}\n\n{}.\n\n\
         Every file here is generated; `SHA256SUMS` has their hashes. `manifest.json` says of each variant what it binds, \
         needs and promises (its form: `manifest.schema.json`). What several variants have in common stands once, under `shared`; \
         variants refer to it by key: a name, with `:2` and so on behind it where different things have the same. `omitted.json` says what pruning has left out of each variant: for each the keys of \
         `left_out`, which has the declarations by reason.\n\n\
         A shader in `wgsl/` is whole: hand its text to the device, make the bind groups of `bindings`, and set its \
         `overrides` as constants of the pipeline. Buffers have the layout of `structs`; the units and ranges of all \
         inputs stand in `contract` and at the top of each shader.",
        manifest.package, manifest.version, manifest.description
    );
    if !library.examples.is_empty() {
        text.push_str(
            " `inputs.json` has for what a host computes (`input` in the frame) some arguments and results, to test a host with.",
        );
    }
    if !manifest.libraries.is_empty() {
        text.push_str(
            &format!(
                " `wgsl/{}.wgsl` has the functions without bindings, for passes of your own; `wgsl/lib/` has the same as \
                 modules of WESL.",
                library.library.name
            ),
        );
    }
    if manifest.targets.iter().any(|target| target == "spirv") {
        text.push_str(
            " `spirv/` has the same variants as SPIR-V 1.3, overrides at their defaults; clip space is WebGPU's (y up).",
        );
    }
    if manifest.targets.iter().any(|target| target == "rust") {
        text.push_str(" `rust/lib.rs` has the choices as types, the structs, and the bind-group layouts for wgpu.");
    }
    text.push('\n');
    if let Some(made_for) = &manifest.made_for {
        text.push_str(&format!("\n## Made for {}\n\n", made_for.input));
        for assumed in &made_for.assumed {
            text.push_str(&format!(
                "- {}: {} ({}), by which the rule {} leaves things out\n",
                assumed.fact,
                if assumed.holds { "yes" } else { "no" },
                assumed.evidence,
                assumed.rule
            ));
        }
        text.push_str("\nOf an input of which this is not so the package does not show all; `left_out` in the manifest says what.\n");
    }
    for pass in &manifest.passes {
        let variants: Vec<_> =
            manifest.variants.iter().filter(|variant| variant.pass == pass.name).collect();
        if variants.is_empty() {
            continue;
        }
        text.push_str(&format!("\n## {}\n\n{}.\n\n", pass.name, capital(&pass.description)));
        text.push_str("| variant | entry points | binds | texture loads + samples | buffer reads | scalar operations: once | each turn of its loops |\n");
        text.push_str("|---|---|---|---|---|---|---|\n");
        for variant in variants {
            let costs = || variant.cost.values();
            let sum = |of: fn(Operations) -> u64| costs().map(|cost| of(cost.text())).sum::<u64>();
            let turns = costs().flat_map(|cost| &cost.loops).map(|one| one.turn.scalars());
            let turns: Vec<_> = turns.map(|turn| turn.to_string()).collect();
            text.push_str(&format!(
                "| [`{id}`]({path}) | {} | {} | {} + {} | {} | {} | {} |\n",
                variant
                    .entry_points
                    .iter()
                    .map(|key| format!("`{}`", key.split(':').next().unwrap_or(key)))
                    .collect::<Vec<_>>()
                    .join(", "),
                variant.bindings.len(),
                sum(|text| text.texture_loads),
                sum(|text| text.texture_samples),
                sum(|text| text.buffer_reads),
                costs().map(|cost| cost.once.scalars()).sum::<u64>(),
                turns.join(", "),
                id = variant.id,
                path = variant
                    .files
                    .iter()
                    .find(|file| file.target == "wgsl")
                    .map_or("", |file| &file.path),
            ));
        }
    }
    text.push_str(
        "\nThe numbers are static: a call counts what it calls, a branch counts all its sides. Loads and reads count each \
         loop once; scalar operations are apart for each loop, without the loops inside it, whose nesting `cost` in the \
         manifest has. They compare texts, not run times.\n",
    );
    text
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map(|first| first.to_uppercase().to_string() + letters.as_str())
        .unwrap_or_default()
}

pub(super) fn changelog(parts: &Parts<'_>) -> String {
    let version = &parts.library.library.version;
    parts
        .changelog
        .map_or_else(|| format!("# Changelog\n\n## {version}\n\n- First version.\n"), str::to_owned)
}

/// The licences of a library by the name of their file.
pub(super) fn licenses(library: &Library) -> Result<Vec<(&'static str, String)>, Error> {
    let words = library.library.license.split(|c: char| c.is_whitespace() || "()".contains(c));
    let names = words.filter(|word| !["", "OR", "AND", "WITH"].contains(word));
    names
        .map(|name| match name {
            "MIT" => {
                let text = include_str!("LICENSE-MIT");
                Ok(("LICENSE-MIT", text.replace("{name}", &library.library.name)))
            }
            "Apache-2.0" => Ok(("LICENSE-APACHE", include_str!("LICENSE-APACHE").to_owned())),
            other => Err(Error::License(other.to_owned())),
        })
        .collect()
}

//! What a host has to know of each variant, with what the variants of a pass share.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::described::Described;
use super::names::ident;
use crate::manifest::{self, Stage};

pub(super) type Signature<'a> = Vec<(&'a str, Stage, Option<[u32; 3]>)>;

/// What the variants of a pass have in common: each distinct list once, in the order of its first variant.
pub(super) struct Shared<'a> {
    pub(super) entry_points: Vec<Signature<'a>>,
    pub(super) layouts: Vec<(&'a [manifest::Binding], Vec<String>)>,
}

impl<'a> Shared<'a> {
    pub(super) fn of(pass: &str, variants: &[Described<'a>]) -> Self {
        let mut shared = Self { entry_points: Vec::new(), layouts: Vec::new() };
        for Described { variant, .. } in variants.iter().filter(|of| of.variant.pass == pass) {
            let signature = signature(variant);
            if !shared.entry_points.contains(&signature) {
                shared.entry_points.push(signature);
            }
            let id = format!("`{}`", variant.id);
            let same = |bindings: &[manifest::Binding]| same_bindings(bindings, &variant.bindings);
            match shared.layouts.iter_mut().find(|(bindings, _)| same(bindings)) {
                Some((_, ids)) => ids.push(id),
                None => shared.layouts.push((&variant.bindings, vec![id])),
            }
        }
        shared
    }
}

fn signature(variant: &manifest::Described) -> Signature<'_> {
    let entry_points = variant.entry_points.iter();
    entry_points.map(|of| (of.name.as_str(), of.stage, of.workgroup_size)).collect()
}

/// Equal in all that a host needs; descriptions do not count.
fn same_bindings(a: &[manifest::Binding], b: &[manifest::Binding]) -> bool {
    let key = |of: &manifest::Binding| {
        (of.group, of.binding, of.name.clone(), of.visibility.clone(), of.resource.clone())
    };
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| key(a) == key(b))
}

pub(super) fn variant_entry(described: &Described<'_>, variants: &[Described<'_>]) -> TokenStream {
    let variant = described.variant;
    let shared = Shared::of(&variant.pass, variants);
    let signature = signature(variant);
    let entry_points = shared.entry_points.iter().position(|of| *of == signature);
    let layout = shared.layouts.iter().position(|(of, _)| same_bindings(of, &variant.bindings));
    let module = ident(&variant.pass);
    let entry_points = format_ident!("ENTRY_POINTS_{}", entry_points.unwrap_or_default());
    let names = format_ident!("NAMES_{}", layout.unwrap_or_default());
    let layout = format_ident!("LAYOUT_{}", layout.unwrap_or_default());
    let id = &variant.id;
    quote! {
        Variant {
            id: #id,
            pass: #module::PASS,
            entry_points: #module::#entry_points,
            bind_groups: #module::#layout,
            binding_names: #module::#names,
        }
    }
}

pub(super) fn embedded_entry(variant: &manifest::Described) -> Option<TokenStream> {
    let file = variant.files.iter().find(|file| file.target == "wgsl")?;
    let (id, module, sha256) = (&variant.id, ident(&variant.pass), &file.sha256);
    let path = format!("../{}", file.path);
    Some(quote! {
        Embedded { id: #id, pass: #module::PASS, text: include_str!(#path), sha256: #sha256 }
    })
}

pub(super) fn by_group(bindings: &[manifest::Binding]) -> Vec<Vec<&manifest::Binding>> {
    let count = bindings.iter().map(|binding| binding.group + 1).max().unwrap_or(0);
    let of = |group| bindings.iter().filter(|binding| binding.group == group).collect();
    (0..count).map(of).collect()
}

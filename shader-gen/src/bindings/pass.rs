//! A pass as a module: the typed key of its variants, their entry points, layouts and overrides.

use std::collections::BTreeMap;

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::described::Described;
use super::layout::{entry, stages};
use super::names::{doc, escape, ident, type_ident};
use super::variant::{Shared, by_group};
use crate::library::{Library, Pass};

pub(super) fn pass_module(
    library: &Library,
    pass: &Pass,
    variants: &[Described<'_>],
) -> TokenStream {
    let module = ident(&pass.name);
    let ty = type_ident(&pass.name);
    let name = &pass.name;
    let about = doc(&pass.description);
    let shared = Shared::of(&pass.name, variants);
    let entry_points = shared.entry_points.iter().enumerate().map(|(index, entry_points)| {
        let name = format_ident!("ENTRY_POINTS_{index}");
        let entry_points = entry_points.iter().map(|(name, stage, size)| {
            let stage = stages(&[*stage]);
            let size = option(size.map(|size| {
                let size = size.map(Literal::u32_unsuffixed);
                quote!([#(#size),*])
            }));
            quote!(super::EntryPoint { name: #name, stage: #stage, workgroup_size: #size })
        });
        quote!(pub(super) const #name: &[super::EntryPoint] = &[#(#entry_points),*];)
    });
    let layouts = shared.layouts.iter().enumerate().map(|(index, (bindings, ids))| {
        let constant = format_ident!("LAYOUT_{index}");
        let names = format_ident!("NAMES_{index}");
        let groups = by_group(bindings);
        let entries = groups.iter().map(|group| {
            let entries = group.iter().map(|binding| entry(binding));
            quote!(&[#(#entries),*])
        });
        let binding_names = groups.iter().map(|group| {
            let names = group.iter().map(|binding| &binding.name);
            quote!(&[#(#names),*])
        });
        let about = format!(" {}.", ids.join(", "));
        quote! {
            #[doc = #about]
            pub(super) const #constant: &[&[wgpu::BindGroupLayoutEntry]] = &[#(#entries),*];
            pub(super) const #names: &[&[&str]] = &[#(#binding_names),*];
        }
    });
    let overrides = overrides(&pass.name, variants);
    let key = variant_key(library, pass, &ty);
    quote! {
        #about
        pub mod #module {
            /// The name of the pass.
            pub const PASS: &str = #name;

            #overrides
            #key
            #(#entry_points)*
            #(#layouts)*
        }
    }
}

fn overrides(pass: &str, variants: &[Described<'_>]) -> TokenStream {
    let found: BTreeMap<_, _> = variants
        .iter()
        .filter(|described| described.variant.pass == pass)
        .flat_map(|described| &described.variant.overrides)
        .map(|found| (found.name.as_str(), found))
        .collect();
    let entries = found.values().map(|found| {
        let number = |number: &Option<serde_json::Number>| {
            let number = number.as_ref().and_then(serde_json::Number::as_f64);
            option(number.map(|number| {
                let number = Literal::f64_unsuffixed(number);
                quote!(#number)
            }))
        };
        let (name, default) = (&found.name, number(&found.default));
        let (minimum, maximum) = (number(&found.minimum), number(&found.maximum));
        quote! {
            super::Override { name: #name, default: #default, minimum: #minimum, maximum: #maximum }
        }
    });
    let about = found.values().map(|found| {
        let line = escape(&format!(" - `{}`: {}", found.name, found.description));
        quote!(#[doc = #line])
    });
    let separator = (!found.is_empty()).then(|| quote!(#[doc = ""]));
    quote! {
        /// The numbers that may be set when a pipeline of this pass is made.
        #separator
        #(#about)*
        pub const OVERRIDES: &[super::Override] = &[#(#entries),*];
    }
}

/// The typed key of a pass's variants.
fn variant_key(library: &Library, pass: &Pass, ty: &Ident) -> TokenStream {
    let name = &pass.name;
    let axes: Vec<_> =
        pass.axes.iter().filter_map(|axis| library.axis.get_key_value(axis)).collect();
    let fields: Vec<_> = axes.iter().map(|(name, _)| ident(name)).collect();
    let types: Vec<_> = axes.iter().map(|(name, _)| type_ident(name)).collect();
    let abouts = axes.iter().map(|(_, axis)| doc(&axis.description));
    let about = format!(" A variant of the pass `{name}`, legal or not.");
    let definition = if axes.is_empty() {
        quote!(pub struct #ty;)
    } else {
        quote!(pub struct #ty { #(#abouts pub #fields: super::#types),* })
    };
    let implied = axes.iter().filter(|(_, axis)| axis.implied).count();
    let (named, implied) = fields.split_at(fields.len() - implied);
    let mut id = if named.is_empty() {
        quote!(String::from(PASS))
    } else {
        let format = format!("{{PASS}}{}", "-{}".repeat(named.len()));
        quote!(format!(#format, #(self.#named),*))
    };
    if !implied.is_empty() {
        let types = &types[named.len()..];
        id = quote! {
            let mut id = #id;
            #(if self.#implied != super::#types::default() {
                id.push('-');
                id.push_str(&self.#implied.to_string());
            })*
            id
        };
    }
    let value = if axes.is_empty() { quote!(Self) } else { quote!(Self { #(#fields),* }) };
    let mut collect = quote!(all.push(#value););
    for (field, ty) in fields.iter().zip(&types).rev() {
        collect = quote!(for #field in super::#ty::ALL { #collect });
    }
    let all = if axes.is_empty() {
        quote!(vec![Self])
    } else {
        quote! {
            let mut all = Vec::new();
            #collect
            all.retain(|variant| variant.is_legal());
            all
        }
    };
    let rules = library.exclusion.iter().filter(|rule| match &rule.pass {
        Some(of) => of == name,
        None => rule.when.keys().all(|axis| pass.axes.contains(axis)),
    });
    let rules = rules.map(|rule| {
        let conditions = rule.when.iter().map(|(axis, values)| {
            let (field, ty) = (ident(axis), type_ident(axis));
            let values = values.iter().map(|value| type_ident(value));
            quote!(matches!(self.#field, #(super::#ty::#values)|*))
        });
        let (name, reason) = (&rule.name, &rule.reason);
        quote! {
            if #(#conditions)&&* {
                return Some(super::Exclusion { name: #name, reason: #reason });
            }
        }
    });
    quote! {
        #[doc = #about]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #definition

        impl #ty {
            /// Every legal variant.
            pub fn all() -> Vec<Self> {
                #all
            }

            /// Pass and values joined by `-`, without the defaults of axes that are implied.
            pub fn id(self) -> String {
                #id
            }

            /// The rule that excludes it, if it is illegal.
            pub const fn excluded(self) -> Option<super::Exclusion> {
                #(#rules)*
                None
            }

            /// Whether no rule excludes it.
            pub const fn is_legal(self) -> bool {
                self.excluded().is_none()
            }

            /// What a host has to know of it, if the package has it.
            pub fn variant(self) -> Option<&'static super::Variant> {
                super::variant(&self.id())
            }
        }
    }
}

fn option(value: Option<TokenStream>) -> TokenStream {
    value.map_or_else(|| quote!(None), |value| quote!(Some(#value)))
}

//! What a library's frame gives to the Rust bindings: the settings that it leaves open, and the names of what it declares.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};
use sglow_graph::description::{Number, Parameter, ParameterType};

use super::follow;
use super::names::{doc, ident, type_ident};
use crate::library::{Frame, Library};

/// Combinations of values that are looked at for names: each pair of axes.
const TOGETHER: usize = 2;

/// Everything; nothing of a library without a frame.
pub(super) fn items(library: &Library) -> TokenStream {
    let Some(frame) = library.frame() else { return TokenStream::new() };
    let (settings, names) = (settings(library, frame), names(frame));
    quote!(#settings #names)
}

/// A macro that makes a struct of settings: a field for each axis and parameter that is one, beside fields of the host's.
fn settings(library: &Library, frame: &Frame) -> TokenStream {
    let axes: Vec<_> = library.axis.iter().filter(|(_, axis)| axis.setting).collect();
    let is_setting = |(_, parameter): &(&String, &Parameter)| !parameter.host;
    let parameters: Vec<_> = frame.description.parameter.iter().filter(is_setting).collect();
    let axis_names: Vec<_> = axes.iter().map(|(name, _)| name.as_str()).collect();
    let axis_fields: Vec<_> = axes.iter().map(|(name, _)| ident(name)).collect();
    let axis_types: Vec<_> = axes.iter().map(|(name, _)| type_ident(name)).collect();
    let axis_docs = axes.iter().map(|(_, axis)| doc(&axis.description));
    let names: Vec<_> = parameters.iter().map(|(name, _)| name.as_str()).collect();
    let fields: Vec<_> = parameters.iter().map(|(name, _)| ident(name)).collect();
    let docs =
        parameters.iter().map(|(_, one)| doc(&format!("{}: {}", one.description, one.range())));
    let kinds: Vec<_> = parameters
        .iter()
        .map(|(_, one)| if one.kind == ParameterType::Whole { quote!(u32) } else { quote!(f32) })
        .collect();
    let variants = parameters.iter().map(|(_, one)| {
        if one.kind == ParameterType::Whole { quote!(Whole) } else { quote!(Real) }
    });
    let variants: Vec<_> = variants.collect();
    let (follows, of_passes) =
        (follow::of_settings(library, frame), follow::of_passes(library, frame));
    let defaults = parameters.iter().map(|(_, one)| match (one.default, one.kind) {
        (Number::Whole(number), ParameterType::Whole) => {
            let number = Literal::u64_unsuffixed(number);
            quote!(#number)
        }
        (number, _) => {
            let number = Literal::f64_unsuffixed(number.real());
            quote!(#number)
        }
    });
    quote! {
        /// A number that is set.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Number {
            /// A whole number.
            Whole(u32),
            /// A real number.
            Real(f32),
        }

        impl core::fmt::Display for Number {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                match self {
                    Self::Whole(number) => number.fmt(f),
                    Self::Real(number) => number.fmt(f),
                }
            }
        }

        /// Makes a struct of settings: a public field for each axis and each parameter that a person or an engine sets, behind
        /// fields of one's own with their defaults.
        #[macro_export]
        macro_rules! settings {
            (
                $(#[$meta:meta])*
                pub struct $name:ident { $($(#[$about:meta])* pub $own:ident: $ty:ty = $value:expr,)* }
            ) => {
                $(#[$meta])*
                pub struct $name {
                    $($(#[$about])* pub $own: $ty,)*
                    #(#axis_docs pub #axis_fields: $crate::#axis_types,)*
                    #(#docs pub #fields: #kinds,)*
                }

                impl Default for $name {
                    fn default() -> Self {
                        Self {
                            $($own: $value,)*
                            #(#axis_fields: $crate::#axis_types::default(),)*
                            #(#fields: #defaults,)*
                        }
                    }
                }

                impl $name {
                    /// The names of the axes.
                    pub const AXES: &'static [&'static str] = &[#(#axis_names),*];
                    #follows
                    /// The names of the parameters.
                    pub const PARAMETERS: &'static [&'static str] = &[#(#names),*];

                    /// The name of the value on an axis; nothing if there is no such axis.
                    pub fn axis(&self, name: &str) -> Option<&'static str> {
                        Some(match name {
                            #(#axis_names => self.#axis_fields.name(),)*
                            _ => return None,
                        })
                    }

                    /// Sets an axis by the name of a value; nothing if there is no such axis.
                    pub fn set_axis(
                        &mut self,
                        name: &str,
                        value: &str,
                    ) -> Option<Result<(), $crate::UnknownValue>> {
                        Some(match name {
                            #(#axis_names => value.parse().map(|value| self.#axis_fields = value),)*
                            _ => return None,
                        })
                    }

                    /// The value of a parameter; nothing if there is no such parameter.
                    pub fn number(&self, name: &str) -> Option<$crate::Number> {
                        Some(match name {
                            #(#names => $crate::Number::#variants(self.#fields),)*
                            _ => return None,
                        })
                    }

                    /// Sets a parameter by its text; nothing if there is no such parameter, false if the text is no number of its
                    /// kind. Whether it is in its range is not looked at.
                    pub fn set_number(&mut self, name: &str, text: &str) -> Option<bool> {
                        Some(match name {
                            #(#names => text.parse().map(|number| self.#fields = number).is_ok(),)*
                            _ => return None,
                        })
                    }
                }

                #of_passes
            };
        }
    }
}

/// Names by what they name, so that a host spells none by hand.
fn names(frame: &Frame) -> TokenStream {
    let description = &frame.description;
    // Of steps by evaluation, which knows where they are; resources are named where they are described.
    let named = description.resource.iter();
    let mut resources: BTreeMap<String, String> =
        named.map(|(name, resource)| (name.clone(), resource.part.clone())).collect();
    let mut parts = BTreeSet::new();
    for configuration in frame.configurations(TOGETHER) {
        let Ok(frame) = description.evaluate(&configuration) else { continue };
        for resource in frame.resources {
            let name = resource.name.trim_end_matches(".0").trim_end_matches(".1").to_owned();
            resources.insert(name, resource.part.clone());
            parts.insert(resource.part);
        }
        parts.extend(frame.steps.into_iter().map(|step| step.part));
    }
    parts.retain(|part| !part.is_empty());
    let parts = parts.into_iter().map(|part| (part, "A part of the frame".to_owned()));
    let resources = resources
        .into_iter()
        .map(|(name, part)| (name, format!("A resource of the part `{part}`")));
    let inputs =
        description.input.iter().map(|(name, one)| (name.clone(), one.description.clone()));
    let parameters =
        description.parameter.iter().map(|(name, one)| (name.clone(), one.description.clone()));
    let lists = description.draws.iter().map(|(name, one)| (name.clone(), one.description.clone()));
    let modules = [
        ("part", "Parts of the frame", parts.collect::<Vec<_>>()),
        ("resource", "Resources", resources.collect()),
        ("input", "What a host computes", inputs.collect()),
        ("parameter", "Numbers that are set", parameters.collect()),
        ("list", "Lists of draws of a host", lists.collect()),
    ];
    let modules = modules.into_iter().map(|(module, about, names)| {
        let (module, about) = (format_ident!("{module}"), doc(about));
        let constants = names.into_iter().map(|(name, description)| {
            let (constant, about) = (ident(&name.to_uppercase()), doc(&description));
            quote!(#about pub const #constant: &str = #name;)
        });
        quote!(#about pub mod #module { #(#constants)* })
    });
    quote! {
        /// The names of what the frame declares.
        pub mod frame { #(#modules)* }
    }
}

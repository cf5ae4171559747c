//! What follows from settings: the values of axes that others decide, and with them the variants of passes.

use proc_macro2::TokenStream;
use quote::quote;
use sglow_graph::Formula;

use super::names::{ident, type_ident};
use crate::frame::authored::Choice;
use crate::library::{Frame, Library, Pass};

/// Items of an `impl` of settings: the axes that methods are compared by, the values on an axis, and the values that follow
/// from others.
pub(super) fn of_settings(library: &Library, frame: &Frame) -> TokenStream {
    let axes = || library.axis.iter().filter(|(_, axis)| axis.setting);
    let compared = axes().filter(|(_, axis)| axis.compared).map(|(name, _)| name);
    let names = axes().map(|(name, _)| name);
    let values = axes().map(|(_, axis)| {
        let values = axis.value.iter().map(|value| value.name.as_str());
        quote!(&[#(#values),*])
    });
    let followed = axes().filter(|(name, _)| frame.authored.choose.contains_key(*name));
    let (followed, chosen): (Vec<_>, Vec<_>) =
        followed.map(|(name, _)| (ident(name), value(library, frame, name, &quote!(self)))).unzip();
    quote! {
        /// The axes by which methods are compared; the others are what the scene or the host has.
        pub const COMPARED: &'static [&'static str] = &[#(#compared),*];

        /// The names of the values on an axis, in the library's order; none if there is no such axis.
        pub fn values(axis: &str) -> &'static [&'static str] {
            match axis {
                #(#names => #values,)*
                _ => &[],
            }
        }

        /// The same with the values that follow from others in every frame.
        #[must_use]
        pub fn followed(mut self) -> Self {
            #(self.#followed = #chosen;)*
            self
        }
    }
}

/// The variant of each pass whose axes are settings or follow from them; a step may choose other values.
pub(super) fn of_passes(library: &Library, frame: &Frame) -> TokenStream {
    let is_known = |axis: &String| {
        let setting = library.axis.get(axis).is_some_and(|axis| axis.setting);
        setting || frame.authored.choose.contains_key(axis)
    };
    let known = |pass: &&Pass| !pass.axes.is_empty() && pass.axes.iter().all(is_known);
    let passes = library.pass.iter().filter(known).map(|pass| {
        let (module, ty) = (ident(&pass.name), type_ident(&pass.name));
        let fields = pass.axes.iter().map(|axis| ident(axis));
        let values = pass.axes.iter().map(|axis| value(library, frame, axis, &quote!(settings)));
        quote! {
            impl From<&$name> for $crate::#module::#ty {
                fn from(settings: &$name) -> Self {
                    Self { #(#fields: #values),* }
                }
            }
        }
    });
    quote!(#(#passes)*)
}

/// The value on an axis by the settings `of`.
fn value(library: &Library, frame: &Frame, axis: &str, of: &TokenStream) -> TokenStream {
    let (field, ty) = (ident(axis), type_ident(axis));
    let named = |name: &str| {
        let value = type_ident(name);
        quote!($crate::#ty::#value)
    };
    let setting = library.axis.get(axis).is_some_and(|axis| axis.setting);
    let otherwise = if setting { quote!(#of.#field) } else { quote!($crate::#ty::default()) };
    let cases = match frame.authored.choose.get(axis) {
        None => return otherwise,
        Some(Choice::Always(name)) => return named(name),
        Some(Choice::Cases(cases)) => cases,
    };
    // From the last case on, each is the alternative of the one before it.
    cases.iter().rev().fold(otherwise, |otherwise, case| {
        let value = named(&case.value);
        match case.when.as_ref().map(|when| when.parse()) {
            None => value,
            Some(Ok(when)) => match condition(library, &when, of) {
                Some(when) => quote!(if #when { #value } else { #otherwise }),
                // A condition on a parameter or a fact is known in a frame alone.
                None => otherwise,
            },
            Some(Err(_)) => otherwise,
        }
    })
}

/// A condition of axes; nothing if it names anything else.
fn condition(library: &Library, formula: &Formula, of: &TokenStream) -> Option<TokenStream> {
    let operation = match formula {
        Formula::Is { is: [axis, value] } if library.axis.get(axis)?.setting => {
            let (field, ty, value) = (ident(axis), type_ident(axis), type_ident(value));
            return Some(quote!(matches!(#of.#field, $crate::#ty::#value)));
        }
        Formula::Apply(operation) => operation.first_key_value()?,
        _ => return None,
    };
    match (operation.0.as_str(), &operation.1[..]) {
        ("!", [a]) => condition(library, a, of).map(|a| quote!(!(#a))),
        ("&&", [a, b]) => {
            let (a, b) = (condition(library, a, of)?, condition(library, b, of)?);
            Some(quote!((#a) && (#b)))
        }
        ("||", [a, b]) => {
            let (a, b) = (condition(library, a, of)?, condition(library, b, of)?);
            Some(quote!((#a) || (#b)))
        }
        _ => None,
    }
}

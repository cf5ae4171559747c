//! An axis as an enumeration.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::names::{doc, type_ident};
use crate::library::Axis;

pub(super) fn axis_type(name: &str, axis: &Axis) -> TokenStream {
    let ty = type_ident(name);
    let about = doc(&axis.description);
    let count = Literal::usize_unsuffixed(axis.value.len());
    let values: Vec<_> = axis.value.iter().map(|value| type_ident(&value.name)).collect();
    let names: Vec<_> = axis.value.iter().map(|value| value.name.as_str()).collect();
    let variants = axis.value.iter().zip(&values).map(|(value, ident)| {
        let about = doc(&value.description);
        let default = (value.name == axis.default).then(|| quote!(#[default]));
        quote!(#about #default #ident)
    });
    quote! {
        #about
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum #ty { #(#variants),* }

        impl #ty {
            /// The name of the axis.
            pub const AXIS: &str = #name;
            /// Every value, in the library's order.
            pub const ALL: [Self; #count] = [#(Self::#values),*];

            /// The name of the value.
            pub const fn name(self) -> &'static str {
                match self { #(Self::#values => #names),* }
            }
        }

        impl core::fmt::Display for #ty {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.pad(self.name())
            }
        }

        impl core::str::FromStr for #ty {
            type Err = UnknownValue;

            fn from_str(name: &str) -> Result<Self, UnknownValue> {
                Self::ALL.into_iter().find(|value| value.name() == name).ok_or_else(|| UnknownValue {
                    axis: Self::AXIS,
                    value: name.to_owned(),
                    known: Self::ALL.map(Self::name).to_vec(),
                })
            }
        }
    }
}

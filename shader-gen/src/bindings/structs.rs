//! Structs in buffers, with explicit padding and an assertion of their layout.

use std::collections::BTreeMap;
use std::sync::Arc;

use naga::{Scalar, ScalarKind, VectorSize};
use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::described::Described;
use super::error::Error;
use super::layout_names::{Named, name_layouts, same_layout};
use super::names::{escape, ident};
use crate::library::Library;
use crate::manifest::{self, FieldType, Layout};

/// Every struct of every variant, by its name in the text; each distinct layout once.
pub(super) struct Structs {
    pub(super) by_name: BTreeMap<String, Vec<Named>>,
}

impl Structs {
    pub(super) fn of(library: &Library, variants: &[Described<'_>]) -> Self {
        let mut found: BTreeMap<String, Vec<(&manifest::Described, &Arc<Layout>)>> =
            BTreeMap::new();
        for described in variants {
            for layout in described.layouts {
                found.entry(layout.name.clone()).or_default().push((described.variant, layout));
            }
        }
        let by_name = found.into_iter().map(|(name, uses)| {
            let named = name_layouts(library, &name, &uses);
            (name, named)
        });
        Self { by_name: by_name.collect() }
    }

    fn rust_name(&self, layout: &Layout) -> Ident {
        let named = self.by_name.get(&layout.name);
        let named = named.and_then(|all| all.iter().find(|of| same_layout(&of.layout, layout)));
        ident(named.map_or(layout.name.as_str(), |named| named.rust.as_str()))
    }

    pub(super) fn tokens(&self) -> Result<TokenStream, Error> {
        let all = self.by_name.values().flatten();
        let definitions: TokenStream =
            all.map(|named| self.definition(named)).collect::<Result<_, _>>()?;
        let equal = (!definitions.is_empty()).then(|| {
            quote! {
                /// Does not compile where a layout is not that of the shaders.
                const fn equal(here: usize, shaders: usize) {
                    assert!(here == shaders, "the layout of a struct is not that of the shaders");
                }
            }
        });
        Ok(quote!(#equal #definitions))
    }

    fn definition(&self, named: &Named) -> Result<TokenStream, Error> {
        let layout = &named.layout;
        let ty = ident(&named.rust);
        let mut fields = Vec::new();
        let mut asserts = Vec::new();
        let mut tail = None;
        let mut end = 0;
        let mut padding = 0;
        let mut pad = |from: u32, to: u32, fields: &mut Vec<TokenStream>| {
            if to > from {
                let name = format_ident!("_padding_{padding}");
                let bytes = Literal::u32_unsuffixed(to - from);
                fields.push(quote! {
                    /// Not read by the shaders.
                    pub #name: [u8; #bytes]
                });
                padding += 1;
            }
        };
        for field in &layout.fields {
            pad(end, field.offset, &mut fields);
            if let FieldType::Array { element, length: None, .. } = &field.r#type {
                tail = Some((field.offset, element));
                end = field.offset;
                break;
            }
            let name = ident(&field.name);
            let rust = self.rust_type(&field.r#type, &format!("{}.{}", layout.name, field.name))?;
            let what = format!("`{}` at byte {}", field.r#type, field.offset);
            let about = if field.description.is_empty() {
                format!(" {what}.")
            } else {
                escape(&format!(" {} ({what})", sentence(&field.description)))
            };
            fields.push(quote!(#[doc = #about] pub #name: #rust));
            let offset = Literal::u32_unsuffixed(field.offset);
            asserts.push(quote!(equal(core::mem::offset_of!(#ty, #name), #offset);));
            end = field.offset + field.size;
        }
        if fields.is_empty() {
            return Ok(TokenStream::new());
        }
        let size = tail.as_ref().map_or(layout.size, |(offset, _)| *offset);
        pad(end, size, &mut fields);
        let mut about = Vec::new();
        if !layout.description.is_empty() {
            about.push(escape(&format!(" {}", sentence(&layout.description))));
        }
        match &named.condition {
            Some(condition) => {
                about.push(format!(" `{}` of the variants with {condition}.", layout.name));
            }
            None if about.is_empty() => about.push(format!(" `{}` of the shaders.", layout.name)),
            None => {}
        }
        if let Some((_, element)) = tail {
            about.push(format!(" Followed by as many `{element}` as the buffer holds."));
        }
        let about = about.iter().enumerate().map(|(index, line)| {
            let blank = (index > 0).then(|| quote!(#[doc = ""]));
            quote!(#blank #[doc = #line])
        });
        let size = Literal::u32_unsuffixed(size);
        Ok(quote! {
            #(#about)*
            #[repr(C)]
            #[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
            pub struct #ty { #(#fields),* }

            impl Default for #ty {
                /// All bytes zero.
                fn default() -> Self {
                    bytemuck::Zeroable::zeroed()
                }
            }

            const _: () = {
                equal(size_of::<#ty>(), #size);
                #(#asserts)*
            };
        })
    }

    fn rust_type(&self, ty: &FieldType, place: &str) -> Result<TokenStream, Error> {
        let scalar = |scalar: &Scalar| {
            rust_scalar(*scalar)
                .ok_or_else(|| Error::Scalar { place: place.to_owned(), ty: ty.to_string() })
        };
        let array = |element: TokenStream, count: u32| {
            let count = Literal::u32_unsuffixed(count);
            quote!([#element; #count])
        };
        Ok(match ty {
            FieldType::Scalar(of) | FieldType::Atomic(of) => scalar(of)?,
            FieldType::Vector(size, of) => array(scalar(of)?, *size as u32),
            FieldType::Matrix { columns, rows, scalar: of } => {
                array(array(scalar(of)?, slots(*rows)), *columns as u32)
            }
            // Elements of three numbers lie four apart.
            FieldType::Array { element, length, .. } => {
                let element = match &**element {
                    FieldType::Vector(size, of) => array(scalar(of)?, slots(*size)),
                    element => self.rust_type(element, place)?,
                };
                array(element, length.unwrap_or_default())
            }
            FieldType::Struct(layout) => {
                let name = self.rust_name(layout);
                quote!(#name)
            }
        })
    }
}

/// How many numbers apart vectors of `size` lie within a matrix or an array.
fn slots(size: VectorSize) -> u32 {
    (size as u32).next_power_of_two()
}

/// A number in Rust; the 16 bits of an f16 are a `u16`.
fn rust_scalar(scalar: Scalar) -> Option<TokenStream> {
    Some(match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 2) => quote!(u16),
        (ScalarKind::Float, 4) => quote!(f32),
        (ScalarKind::Float, 8) => quote!(f64),
        (ScalarKind::Sint, 4) => quote!(i32),
        (ScalarKind::Sint, 8) => quote!(i64),
        (ScalarKind::Uint, 4) => quote!(u32),
        (ScalarKind::Uint, 8) => quote!(u64),
        _ => return None,
    })
}

fn sentence(text: &str) -> String {
    if text.ends_with(['.', ':', ')', ']']) { text.to_owned() } else { format!("{text}.") }
}

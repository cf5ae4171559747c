//! Names and documentation in Rust of what a library names and describes.

use proc_macro2::{Ident, Span, TokenStream};
use quote::{format_ident, quote};

/// `previous_kernel` and `previous-kernel` as `PreviousKernel`.
pub(super) fn pascal(name: &str) -> String {
    name.split(|c: char| !c.is_ascii_alphanumeric())
        .filter_map(|word| {
            let mut letters = word.chars();
            letters.next().map(|first| first.to_ascii_uppercase().to_string() + letters.as_str())
        })
        .collect()
}

/// An identifier even where the name is a keyword or starts with a digit.
pub(super) fn ident(name: &str) -> Ident {
    let name: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if syn::parse_str::<Ident>(&name).is_ok() {
        Ident::new(&name, Span::call_site())
    } else if name.starts_with(|c: char| c.is_ascii_digit())
        || ["self", "Self", "super", "crate", "_", ""].contains(&name.as_str())
    {
        format_ident!("_{name}")
    } else {
        Ident::new_raw(&name, Span::call_site())
    }
}

pub(super) fn type_ident(name: &str) -> Ident {
    ident(&pascal(name))
}

/// A description as documentation: a sentence with its full stop.
pub(super) fn doc(description: &str) -> TokenStream {
    let mut letters = description.trim().trim_end_matches('.').chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string()).unwrap_or_default();
    let text = escape(&format!(" {first}{}.", letters.as_str()));
    quote!(#[doc = #text])
}

/// Brackets outside of code would be read as links.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::new();
    let mut code = false;
    for letter in text.chars() {
        code ^= letter == '`';
        if !code && "[]<>".contains(letter) {
            escaped.push('\\');
        }
        escaped.push(letter);
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_rust_names() {
        let cases = [("kernel", "Kernel"), ("two-words", "TwoWords"), ("snake_case", "SnakeCase")];
        for (name, expected) in cases {
            assert_eq!(pascal(name), expected);
        }
        let cases = [("type", "r#type"), ("self", "_self"), ("4x4", "_4x4"), ("a-b", "a_b")];
        for (name, expected) in cases {
            assert_eq!(ident(name).to_string(), expected);
        }
    }

    #[test]
    fn documentation_has_no_links_that_nobody_meant() {
        assert_eq!(escape("in [0, 1], `[u8]`, <b>"), "in \\[0, 1\\], `[u8]`, \\<b\\>");
        assert_eq!(doc("as published.").to_string(), doc("as published").to_string());
    }
}

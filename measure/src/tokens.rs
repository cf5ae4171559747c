//! A source text without what does not change what it does: comments, blanks and what only its tests need.
//!
//! `build.rs` takes part of the hash that measured results depend on from here, so that a comment discards no result.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// The tokens of a Rust source, without comments, documentation and items of tests; the text as it is where it is no Rust.
pub(crate) fn tokens(text: &str) -> String {
    match text.parse::<TokenStream>() {
        Ok(stream) => kept(stream).to_string(),
        Err(_) => text.to_owned(),
    }
}

fn kept(stream: TokenStream) -> TokenStream {
    let mut kept = Vec::new();
    let mut rest = stream.into_iter().peekable();
    let mut skips_item = false;
    while let Some(token) = rest.next() {
        if let TokenTree::Punct(mark) = &token
            && mark.as_char() == '#'
        {
            let inner =
                matches!(rest.peek(), Some(TokenTree::Punct(mark)) if mark.as_char() == '!');
            let bang = inner.then(|| rest.next()).flatten();
            if let Some(TokenTree::Group(group)) = rest.peek()
                && group.delimiter() == Delimiter::Bracket
            {
                let attribute = group.stream().to_string().replace(' ', "");
                let documents = attribute.starts_with("doc=");
                skips_item |= bang.is_none() && attribute == "cfg(test)";
                let group = rest.next();
                if !documents && !skips_item {
                    kept.push(token);
                    kept.extend(bang);
                    kept.extend(group);
                }
                continue;
            }
            kept.push(token);
            kept.extend(bang);
            continue;
        }
        if skips_item {
            // An item ends with its body or a semicolon.
            skips_item = match &token {
                TokenTree::Group(group) => group.delimiter() != Delimiter::Brace,
                TokenTree::Punct(mark) => mark.as_char() != ';',
                _ => true,
            };
            continue;
        }
        kept.push(match token {
            TokenTree::Group(group) => {
                let within = kept_group(&group);
                TokenTree::Group(within)
            }
            other => other,
        });
    }
    kept.into_iter().collect()
}

fn kept_group(group: &proc_macro2::Group) -> proc_macro2::Group {
    proc_macro2::Group::new(group.delimiter(), kept(group.stream()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_tests_change_nothing_and_code_does() {
        let scene = "//! A box.\n/// Its width.\nconst WIDTH: f32 = 2.0; // metres\nfn side() { /* as wide */ WIDTH; }\n";
        let same = [
            "const WIDTH: f32 = 2.0;\nfn side() { WIDTH; }",
            "/// Other words.\nconst WIDTH : f32 =\n    2.0;\nfn side() {\n    // Why.\n    WIDTH;\n}\n",
            "const WIDTH: f32 = 2.0;\nfn side() { WIDTH; }\n#[cfg(test)]\nmod tests { fn more() {} }\n",
            "#[cfg(test)]\nuse std::fs;\nconst WIDTH: f32 = 2.0;\nfn side() { WIDTH; }\n",
        ];
        for other in same {
            assert_eq!(tokens(scene), tokens(other), "{other}");
        }
        for other in [
            scene.replace("2.0", "2.5"),
            scene.replace("fn side", "#[inline] fn side"),
            scene.replace("WIDTH;", "\"// WIDTH\";"),
        ] {
            assert_ne!(tokens(scene), tokens(&other), "{other}");
        }
        // What is no Rust counts as it is.
        assert_ne!(tokens("name = \"a\" # )"), tokens("name = \"a\" # ) "));
    }

    #[test]
    fn the_scenes_own_sources_are_read() {
        let text = include_str!("../../scene/src/builtin/cornell.rs");
        let commented = text.replace("\nfn ", "\n// A comment.\nfn ");
        assert!(commented != text && tokens(&commented) == tokens(text));
        assert!(tokens(text).len() < text.len());
    }
}

//! Limits of nesting: far above what shaders written by hand need, and low enough that recursive readers, here and in naga, do
//! not run out of stack.

use crate::error::{Code, Diagnostic};
use crate::token::{Token, TokenKind};

/// The maximum depth of brackets.
const BRACKETS: usize = 64;

/// The maximum number of operators between two separators (`,`, `;` or a brace): each may nest one deeper than the one before.
const OPERATORS: usize = 512;

/// The maximum number of branches after an `if` or an `@if`, each of which nests in the one before.
const BRANCHES: usize = 100;

/// The first place of `code` that nests too deep.
pub(super) fn too_deep(file: usize, text: &str, code: &[Token]) -> Option<Diagnostic> {
    let fault = |token: &Token, what: &str, limit: usize| {
        Diagnostic::new(Code::Syntax, format!("more than {limit} {what}"))
            .at(file, token.range(), "here")
            .help("take it apart: into functions, or with `let`")
    };
    // Of each open bracket, and outside of all: how many branches its current `if` has.
    let mut branches = vec![0_usize];
    let mut operators = 0_usize;
    let mut before = "";
    for token in code {
        let word = &text[token.range()];
        match (token.kind, word) {
            (TokenKind::Symbol(b'(' | b'[' | b'{'), _) => {
                branches.push(0);
                if branches.len() > BRACKETS + 1 {
                    return Some(fault(token, "nested brackets", BRACKETS));
                }
            }
            (TokenKind::Symbol(b')' | b']' | b'}'), _) if branches.len() > 1 => {
                branches.pop();
            }
            (TokenKind::Symbol(_), _) => operators += 1,
            (TokenKind::Word, "if") if before != "else" => {
                set(&mut branches, |_| 0);
            }
            (TokenKind::Word, "else" | "elif")
                if set(&mut branches, |count| count + 1) > BRANCHES =>
            {
                return Some(fault(token, "branches of one `if`", BRANCHES));
            }
            _ => {}
        }
        if matches!(word, "," | ";" | "{" | "}") {
            operators = 0;
        }
        if operators > OPERATORS {
            return Some(fault(token, "operators in one expression", OPERATORS));
        }
        before = word;
    }
    None
}

/// Changes the last of the numbers, and returns it.
fn set(numbers: &mut [usize], change: impl FnOnce(usize) -> usize) -> usize {
    numbers.last_mut().map_or(0, |last| {
        *last = change(*last);
        *last
    })
}

#[cfg(test)]
mod tests {
    use crate::parse::parse;

    /// The first error of a text.
    fn said(text: &str) -> Option<String> {
        let mut errors = Vec::new();
        parse(0, "a", text, &mut errors);
        errors.into_iter().next().map(|error| error.message)
    }

    #[test]
    fn what_nests_too_deep_is_refused_before_it_is_read() {
        let nested = |open: &str, close: &str, count: usize| {
            format!("fn f() {{ let x = {}a{}; }}", open.repeat(count), close.repeat(count))
        };
        let blocks = |count: usize| format!("fn f() {}{}", "{".repeat(count), "}".repeat(count));
        let branches =
            |count: usize| format!("fn f() {{ if a {{}} {} }}", "else if b {} ".repeat(count));
        let conditions = |count: usize| {
            format!("@if(a) const x = 1; {}", "@elif(b) const x = 1; ".repeat(count))
        };
        let flags = |count: usize| format!("@if({}a) const x = 1;", "!".repeat(count));
        for (good, wrong, what) in [
            (nested("(", ")", 63), nested("(", ")", 20_000), "brackets"),
            (nested("a[", "]", 63), nested("a[", "]", 20_000), "brackets"),
            (blocks(64), blocks(30_000), "brackets"),
            (nested("-", "", 500), nested("-", "", 60_000), "operators"),
            (nested("1 + ", "", 500), nested("1 + ", "", 15_000), "operators"),
            (nested("", ".x", 500), nested("", ".x", 30_000), "operators"),
            (branches(100), branches(5_000), "branches"),
            (conditions(100), conditions(3_000), "branches"),
            (flags(500), flags(60_000), "operators"),
            (
                "@if(((a))) const x = 1;".to_owned(),
                format!("@if{}", "(".repeat(60_000)),
                "brackets",
            ),
        ] {
            assert_eq!(said(&good), None, "{}", &good[..40.min(good.len())]);
            let text = said(&wrong).unwrap();
            assert!(text.contains(what), "{text}");
        }
        // Branches of one `if` behind the other are no such thing.
        let many = format!("fn f() {{ {} }}", "if a {} else {} ".repeat(1000));
        assert_eq!(said(&many), None);
    }
}

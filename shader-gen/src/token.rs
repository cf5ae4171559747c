//! Tokens of WGSL and WESL, just fine enough to find where things begin and end.

use std::ops::Range;

use crate::error::{Code, Diagnostic};

/// What a [`Token`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TokenKind {
    /// An identifier or a keyword.
    Word,
    /// A number.
    Number,
    /// One byte of punctuation.
    Symbol(u8),
    /// A line or block comment, block comments nest.
    Comment,
}

/// A token and the bytes that it takes.
#[derive(Clone, Copy, Debug)]
pub struct Token {
    /// What it is.
    pub kind: TokenKind,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Token {
    /// The bytes that it takes.
    #[must_use]
    pub fn range(&self) -> Range<usize> {
        self.start..self.end
    }

    /// Whether it is the symbol `symbol`.
    #[must_use]
    pub fn is(&self, symbol: u8) -> bool {
        self.kind == TokenKind::Symbol(symbol)
    }
}

/// Splits `text`, the text of `file`, into tokens; what is wrong goes to `errors`.
pub fn tokenize(file: usize, text: &str, errors: &mut Vec<Diagnostic>) -> Vec<Token> {
    let bytes = text.as_bytes();
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let rest = &text[at..];
        let (kind, length) = if byte.is_ascii_whitespace() {
            at += 1;
            continue;
        } else if rest.starts_with("//") {
            let end = rest.find('\n').unwrap_or(rest.len());
            (TokenKind::Comment, rest[..end].trim_end_matches('\r').len())
        } else if rest.starts_with("/*") {
            let length = block_comment(rest).unwrap_or_else(|| {
                errors.push(
                    Diagnostic::new(Code::Syntax, "a comment that does not end")
                        .at(file, at..at + 2, "begins here")
                        .help("end it with `*/`; block comments nest"),
                );
                rest.len()
            });
            (TokenKind::Comment, length)
        } else if byte.is_ascii_digit()
            || byte == b'.' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit)
        {
            let length = number(rest.as_bytes());
            if is_hexadecimal_float(&rest[..length]) {
                errors.push(
                    Diagnostic::new(Code::Syntax, "a hexadecimal floating-point literal")
                        .at(file, at..at + length, "a known reader of WESL gets these wrong")
                        .help("write it in decimal"),
                );
            }
            (TokenKind::Number, length)
        } else if let length @ 1.. = word(rest) {
            (TokenKind::Word, length)
        } else {
            let length = rest.chars().next().map_or(1, char::len_utf8);
            (TokenKind::Symbol(byte), length)
        };
        tokens.push(Token { kind, start: at, end: at + length });
        at += length;
    }
    tokens
}

fn word(rest: &str) -> usize {
    let is_word = |c: char| c == '_' || c.is_alphanumeric();
    rest.find(|c| !is_word(c)).unwrap_or(rest.len())
}

/// Length of the block comment that `rest` begins with, if it ends.
fn block_comment(rest: &str) -> Option<usize> {
    let bytes = rest.as_bytes();
    let mut depth = 0usize;
    let mut at = 0;
    while at + 1 < bytes.len() {
        match &bytes[at..at + 2] {
            b"/*" => depth += 1,
            b"*/" => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            return Some(at);
        }
    }
    None
}

/// Length of the number that `rest` begins with.
fn number(rest: &[u8]) -> usize {
    let hexadecimal = matches!(rest, [b'0', b'x' | b'X', ..]);
    let exponent: &[u8] = if hexadecimal { b"pP" } else { b"eE" };
    let mut at = if hexadecimal { 2 } else { 0 };
    while let Some(&byte) = rest.get(at) {
        let sign = matches!(byte, b'+' | b'-') && exponent.contains(&rest[at - 1]);
        if !(byte.is_ascii_alphanumeric() || byte == b'.' || sign) {
            break;
        }
        at += 1;
    }
    at
}

fn is_hexadecimal_float(number: &str) -> bool {
    let number = number.to_ascii_lowercase();
    number.starts_with("0x") && number.contains(['.', 'p'])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(text: &str) -> Vec<&str> {
        let mut errors = Vec::new();
        let tokens = tokenize(0, text, &mut errors);
        assert_eq!(errors, []);
        tokens.iter().map(|token| &text[token.range()]).collect()
    }

    #[test]
    fn comments_nest_and_end_with_the_line() {
        assert_eq!(
            texts("a /* b /* c */ d */ e // f\ng"),
            ["a", "/* b /* c */ d */", "e", "// f", "g"]
        );
    }

    #[test]
    fn numbers_keep_their_sign_and_suffix() {
        assert_eq!(texts("1e-3f+0x1eu-.5h*2"), ["1e-3f", "+", "0x1eu", "-", ".5h", "*", "2"]);
    }

    #[test]
    fn members_are_no_numbers() {
        assert_eq!(texts("a.x2.y"), ["a", ".", "x2", ".", "y"]);
    }

    #[test]
    fn an_endless_comment_is_reported() {
        let mut errors = Vec::new();
        tokenize(0, "a /* b /* c */", &mut errors);
        assert_eq!(errors.len(), 1);
    }

    #[test]
    fn a_hexadecimal_float_is_reported() {
        let mut errors = Vec::new();
        tokenize(0, "0x1p+1 0x1.8 0x1f 0xep", &mut errors);
        assert_eq!(errors.len(), 3);
    }
}

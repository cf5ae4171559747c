//! OBJ and MTL as text: encodings, line ends, continued lines, comments, tokens with their places.
//!
//! Files are bytes: a comment or a name may hold any. A line ends with LF, CR LF or CR; a backslash before its end
//! continues it. A `#` at the start of a token begins a comment.

use std::borrow::Cow;
use std::path::PathBuf;

use crate::SceneError;
use crate::note::{NoteKind, Notes};

/// The most faults of a file that are kept; more are counted.
const MOST_FAULTS: usize = 100;

/// The bytes of a file without its byte order mark; UTF-16 becomes UTF-8.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, [u8]> {
    let wide = |rest: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = rest.as_chunks::<2>().0.iter().map(|pair| unit(*pair));
        let decoded =
            char::decode_utf16(units).map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER));
        Cow::Owned(decoded.collect::<String>().into_bytes())
    };
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => Cow::Borrowed(rest),
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        _ => Cow::Borrowed(bytes),
    }
}

/// Bytes as text: UTF-8, or else Latin-1.
pub(super) fn text(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// A word of a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'a> {
    pub(super) bytes: &'a [u8],
    /// Where it starts in the file's bytes.
    start: usize,
    /// One-based, and where that line starts.
    line: usize,
    line_start: usize,
}

impl Token<'_> {
    /// The word as text.
    pub(super) fn text(&self) -> String {
        text(self.bytes)
    }

    /// The word as a finite number. The error says what it is instead.
    pub(super) fn number(&self) -> Result<f64, String> {
        let number = std::str::from_utf8(self.bytes).ok().and_then(|text| text.parse::<f64>().ok());
        match number {
            // What overflows an f32 is infinite to everything that follows.
            Some(number) if (number as f32).is_finite() => Ok(number),
            Some(_) => Err(format!("`{}` is not a finite number", self.shown())),
            None => Err(format!("`{}` is not a number", self.shown())),
        }
    }

    /// The word for a message, not all of a long one.
    pub(super) fn shown(&self) -> String {
        const SHOWN: usize = 40;
        let text = self.text();
        let mut shown: String = text.chars().take(SHOWN).flat_map(char::escape_debug).collect();
        if text.chars().nth(SHOWN).is_some() {
            shown.push('…');
        }
        shown
    }
}

/// A line, or several that continue each other.
#[derive(Clone, Debug)]
pub(super) struct Line<'a> {
    all: &'a [u8],
    /// At least one.
    pub(super) tokens: Vec<Token<'a>>,
    /// Where the last line ends, comment included.
    end: usize,
}

impl<'a> Line<'a> {
    /// What comes first, in lower case: files are not of one mind.
    pub(super) fn keyword(&self) -> String {
        self.tokens.first().map_or_else(String::new, Token::text).to_lowercase()
    }

    /// What comes after the first token.
    pub(super) fn arguments(&self) -> &[Token<'a>] {
        self.tokens.get(1..).unwrap_or(&[])
    }

    /// The text from argument number `from` to number `to`, that included, with the blanks between.
    pub(super) fn span(&self, from: usize, to: usize) -> String {
        let arguments = self.arguments();
        let (Some(first), Some(last)) = (arguments.get(from), arguments.get(to)) else {
            return String::new();
        };
        if first.line != last.line {
            let words: Vec<_> = arguments[from..=to].iter().map(Token::text).collect();
            return words.join(" ");
        }
        text(self.all.get(first.start..last.start + last.bytes.len()).unwrap_or_default())
    }

    /// All arguments as one text.
    pub(super) fn rest(&self) -> String {
        self.span(0, self.arguments().len().saturating_sub(1))
    }

    /// The same with what looks like a comment: names such as `Material #25` are not of one mind with them.
    pub(super) fn rest_with_comment(&self) -> String {
        let last = self.tokens.last().map_or(0, |token| token.start + token.bytes.len());
        let behind = self.all.get(last..self.end).unwrap_or_default().trim_ascii_end();
        format!("{}{}", self.rest(), text(behind)).trim().to_owned()
    }

    /// One-based line and column of the first token.
    pub(super) fn place(&self) -> (usize, usize) {
        self.tokens.first().map_or((1, 1), |token| place(self.all, token))
    }

    /// One-based line and column of an argument, or of the line's end behind the last one.
    pub(super) fn place_of(&self, argument: usize) -> (usize, usize) {
        let Some(token) = self.arguments().get(argument) else {
            let Some(last) = self.tokens.last() else { return (1, 1) };
            let (line, column) = place(self.all, last);
            return (line, column + text(last.bytes).chars().count());
        };
        place(self.all, token)
    }
}

fn place(all: &[u8], token: &Token<'_>) -> (usize, usize) {
    let before = all.get(token.line_start..token.start).unwrap_or_default();
    (token.line, text(before).chars().count() + 1)
}

/// The lines of a file that are not empty.
pub(super) struct Lines<'a> {
    all: &'a [u8],
    at: usize,
    line: usize,
    line_start: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0, line: 1, line_start: 0 }
    }

    /// The length of the line end at `at`, 0 if there is none.
    fn line_end(&self, at: usize) -> usize {
        match (self.all.get(at), self.all.get(at + 1)) {
            (Some(b'\r'), Some(b'\n')) => 2,
            (Some(b'\r' | b'\n'), _) => 1,
            _ => 0,
        }
    }

    fn start_line(&mut self, length: usize) {
        self.at += length;
        self.line += 1;
        self.line_start = self.at;
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        let mut tokens = Vec::new();
        while let Some(&byte) = self.all.get(self.at) {
            let ends = self.line_end(self.at);
            if ends > 0 {
                let end = self.at;
                self.start_line(ends);
                if !tokens.is_empty() {
                    return Some(Line { all: self.all, tokens, end });
                }
                continue;
            }
            match byte {
                b' ' | b'\t' | 0x0b | 0x0c | 0 => self.at += 1,
                b'#' => {
                    while self.at < self.all.len() && self.line_end(self.at) == 0 {
                        self.at += 1;
                    }
                }
                b'\\' if self.line_end(self.at + 1) > 0 => {
                    let ends = self.line_end(self.at + 1);
                    self.start_line(1 + ends);
                }
                _ => {
                    let start = self.at;
                    let within = |at: usize| match self.all.get(at) {
                        None | Some(b' ' | b'\t' | 0x0b | 0x0c | b'\r' | b'\n' | 0) => false,
                        Some(b'\\') => self.line_end(at + 1) == 0,
                        Some(_) => true,
                    };
                    let mut end = start + 1;
                    while within(end) {
                        end += 1;
                    }
                    self.at = end;
                    tokens.push(Token {
                        bytes: &self.all[start..end],
                        start,
                        line: self.line,
                        line_start: self.line_start,
                    });
                }
            }
        }
        let end = self.all.len();
        (!tokens.is_empty()).then_some(Line { all: self.all, tokens, end })
    }
}

/// The lines of a file that cannot be read, each at the cost of that line alone.
#[derive(Debug)]
pub(super) struct Faults {
    file: PathBuf,
    kept: Vec<((usize, usize), String)>,
    more: usize,
}

impl Faults {
    pub(super) fn new(file: impl Into<PathBuf>) -> Self {
        Self { file: file.into(), kept: Vec::new(), more: 0 }
    }

    /// Keeps one, with its place.
    pub(super) fn add(&mut self, place: (usize, usize), message: impl Into<String>) {
        if self.kept.len() < MOST_FAULTS {
            self.kept.push((place, message.into()));
        } else {
            self.more += 1;
        }
    }

    /// As notes, each with its place.
    pub(super) fn note(&self, notes: &mut Notes) {
        for (place, message) in &self.kept {
            notes.add_at(NoteKind::Ignored, &self.file, *place, message);
        }
        if self.more > 0 {
            let text =
                format!("{}: {} more lines that cannot be read", self.file.display(), self.more);
            notes.add(NoteKind::Ignored, text, "");
        }
    }

    /// As errors, where nothing is left of the file without them.
    pub(super) fn into_errors(self) -> Vec<SceneError> {
        let file = self.file;
        let kept = self.kept.into_iter();
        kept.map(|((line, column), message)| SceneError::Line {
            file: file.clone(),
            line,
            column,
            message,
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(bytes: &[u8]) -> Vec<Vec<String>> {
        let decoded = decode(bytes);
        Lines::new(&decoded).map(|line| line.tokens.iter().map(Token::text).collect()).collect()
    }

    #[test]
    fn lines_end_and_continue_in_every_way() {
        for end in ["\n", "\r\n", "\r"] {
            let text = ["# über", "", "a\tb", " c \\", "  d#1 # e \\", "f\\", ""].join(end);
            let expected: [&[&str]; 3] = [&["a", "b"], &["c", "d#1"], &["f"]];
            assert_eq!(words(text.as_bytes()), expected, "{end:?}");
        }
        assert_eq!(words(b"\\"), [["\\"]]);
        assert_eq!(words(b"a\\b c"), [["a\\b", "c"]]);
    }

    #[test]
    fn encodings_are_told_apart() {
        let wide = |order: fn(u16) -> [u8; 2]| -> Vec<u8> {
            "\u{feff}a ü".encode_utf16().flat_map(order).collect()
        };
        for bytes in [
            b"a \xfc".to_vec(),
            "a ü".as_bytes().to_vec(),
            "\u{feff}a ü".as_bytes().to_vec(),
            wide(u16::to_le_bytes),
            wide(u16::to_be_bytes),
        ] {
            assert_eq!(words(&bytes), [["a", "ü"]], "{bytes:?}");
        }
    }

    #[test]
    fn places_are_those_an_editor_shows() {
        let lines: Vec<_> = Lines::new("\n\tä b\\\n  c d\nlast".as_bytes()).collect();
        let places: Vec<_> = (0..4).map(|argument| lines[0].place_of(argument)).collect();
        assert_eq!((lines[0].place(), places), ((2, 2), vec![(2, 4), (3, 3), (3, 5), (3, 6)]));
        assert_eq!(lines[1].place(), (4, 1));
        assert_eq!((lines[0].rest(), lines[0].span(1, 2)), ("b c d".to_owned(), "c d".to_owned()));
    }

    #[test]
    fn names_keep_their_blanks_and_what_looks_like_a_comment() {
        let line = Lines::new(b"usemtl  Material  #25 \r\n").next().unwrap();
        assert_eq!(
            (line.rest(), line.rest_with_comment()),
            ("Material".into(), "Material  #25".into())
        );
    }
}

//! The outline of a source file: imports, declarations and conditions, with the bytes that each takes.
//!
//! The subset of WESL: `import package::a::b::{c};` at the top; `@if(…)`, `@elif(…)` and `@else` before imports,
//! directives, declarations, struct members and statements. Everything else is left to naga.

mod body;
mod condition;
mod extent;
mod module;
mod nesting;

use std::ops::Range;

use crate::condition::Condition;
use crate::error::{Code, Diagnostic};
use crate::token::{Token, TokenKind, tokenize};

/// The outline of one file.
#[derive(Clone, Debug, Default)]
pub struct Module {
    /// Index of its file.
    pub file: usize,
    /// Its path below the folder of sources, without extension: `a/b`.
    pub path: String,
    /// What it imports.
    pub imports: Vec<Import>,
    /// `enable`, `requires` and `diagnostic` directives.
    pub directives: Vec<Item>,
    /// Declarations in their order.
    pub declarations: Vec<Declaration>,
    /// Comments that stand by themselves; each belongs to all that follows up to the next one.
    pub sections: Vec<Range<usize>>,
}

/// `import package::a::b::{c, d};`
#[derive(Clone, Debug)]
pub struct Import {
    /// When it is taken.
    pub condition: Option<Condition>,
    /// The module, as in [`Module::path`].
    pub path: String,
    /// Where the path stands.
    pub path_range: Range<usize>,
    /// Names that are imported, with their places.
    pub names: Vec<(String, Range<usize>)>,
}

/// Something that is kept or left out as a whole.
#[derive(Clone, Debug)]
pub struct Item {
    /// When it is kept.
    pub condition: Option<Condition>,
    /// All of it, its leading comments and a comment behind it on the same line included.
    pub whole: Range<usize>,
    /// What goes even when it is kept (the condition's attribute and the space behind it), and what stands inside of it
    /// under a condition of its own.
    pub edits: Vec<Edit>,
    /// The blocks in it that conditions are about, inner ones before those that hold them.
    pub blocks: Vec<Block>,
}

/// A stretch of bytes that may have to go.
#[derive(Clone, Debug)]
pub struct Edit {
    /// It stays when this holds; without a condition it always goes.
    pub keep_if: Option<Condition>,
    /// The bytes.
    pub range: Range<usize>,
}

/// The braces of `@if(…) { … }`. When the condition holds they have nothing left to say; they go, and the statements
/// within stand where the block stood, unless that would change what a name means.
#[derive(Clone, Debug)]
pub struct Block {
    /// When the block is kept.
    pub condition: Condition,
    /// From its opening brace to its closing one.
    pub range: Range<usize>,
    /// The bytes that go with each brace.
    pub braces: [Range<usize>; 2],
    /// First bytes of the lines between the braces.
    pub lines: Vec<usize>,
    /// How many spaces each of these lines is indented by the block.
    pub indent: usize,
    /// What its own statements declare, those of blocks within not included.
    pub declares: Vec<(String, Range<usize>)>,
    /// The block around it; of a function's own block with the function's head.
    pub around: Range<usize>,
}

/// A declaration at module scope.
#[derive(Clone, Debug)]
pub struct Declaration {
    /// Its name; `const_assert` has none.
    pub name: Option<(String, Range<usize>)>,
    /// What it declares.
    pub kind: Kind,
    /// Its bytes and conditions.
    pub item: Item,
    /// Group and number of a variable that is bound; the greatest number for what is no plain number.
    pub binding: Option<(u32, u32)>,
    /// Where the block of a function begins; the end of any other declaration.
    pub body: usize,
    /// Words inside of it, except for members behind a `.` and names of attributes.
    pub references: Vec<(String, Range<usize>)>,
}

/// What a [`Declaration`] declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `fn` with a stage attribute.
    EntryPoint,
    /// `fn`
    Function,
    /// `struct`
    Struct,
    /// `alias`
    Alias,
    /// `const`
    Constant,
    /// `override`
    Override,
    /// `var`
    Variable,
    /// `const_assert`
    Assertion,
}

impl Kind {
    /// How WGSL calls it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::EntryPoint => "entry point",
            Self::Function => "function",
            Self::Struct => "struct",
            Self::Alias => "alias",
            Self::Constant => "const",
            Self::Override => "override",
            Self::Variable => "var",
            Self::Assertion => "const_assert",
        }
    }
}

/// Reads the outline of `text`; what is wrong goes to `errors`, after which the outline is of no use.
pub fn parse(file: usize, path: &str, text: &str, errors: &mut Vec<Diagnostic>) -> Module {
    let tokens = tokenize(file, text, errors);
    let code: Vec<Token> =
        tokens.iter().copied().filter(|token| token.kind != TokenKind::Comment).collect();
    if let Some(error) = nesting::too_deep(file, text, &code) {
        errors.push(error);
        return Module { file, path: path.to_owned(), ..Module::default() };
    }
    let comments: Vec<Token> =
        tokens.into_iter().filter(|token| token.kind == TokenKind::Comment).collect();
    let mut parser = Parser {
        file,
        text,
        code,
        comments,
        at: 0,
        chain: None,
        edits: Vec::new(),
        blocks: Vec::new(),
        scope: Scope::default(),
    };
    let mut module = Module { file, path: path.to_owned(), ..Module::default() };
    if let Err(error) = parser.module(&mut module) {
        errors.push(*error);
    }
    module
}

type Parse<T> = Result<T, Box<Diagnostic>>;

/// A name with its place.
type Name = (String, Range<usize>);

/// The attributes before a node.
#[derive(Default)]
struct Attributes {
    condition: Option<Condition>,
    is_entry_point: bool,
    group: Option<u32>,
    binding: Option<u32>,
}

struct Parser<'a> {
    file: usize,
    text: &'a str,
    code: Vec<Token>,
    comments: Vec<Token>,
    at: usize,
    /// In the list that is being read: what an `@else` that comes now would be the opposite of.
    chain: Option<Condition>,
    /// Edits inside the declaration that is being read.
    edits: Vec<Edit>,
    /// Blocks inside of it that conditions are about.
    blocks: Vec<Block>,
    /// The block that is being read.
    scope: Scope,
}

/// A block that is being read.
#[derive(Default)]
struct Scope {
    /// What its statements have declared.
    declares: Vec<(String, Range<usize>)>,
    /// The blocks in it that conditions are about, by index.
    blocks: Vec<usize>,
}

impl<'a> Parser<'a> {
    fn peek(&self) -> Option<Token> {
        self.code.get(self.at).copied()
    }

    fn next_is(&self, symbol: u8) -> bool {
        self.peek().is_some_and(|token| token.is(symbol))
    }

    fn word(&self) -> &'a str {
        match self.peek() {
            Some(token) if token.kind == TokenKind::Word => &self.text[token.range()],
            _ => "",
        }
    }

    /// What is wrong with the token that comes next.
    fn fault(&self, message: impl Into<String>) -> Diagnostic {
        let end = self.text.len();
        let (range, label) = match self.peek() {
            Some(token) => (token.range(), "found this"),
            None => (end..end, "the file ends here"),
        };
        Diagnostic::new(Code::Syntax, message).at(self.file, range, label)
    }

    fn error<T>(&self, message: impl Into<String>) -> Parse<T> {
        Err(Box::new(self.fault(message)))
    }

    fn expect(&mut self, symbol: u8, whence: &str) -> Parse<Token> {
        match self.peek() {
            Some(token) if token.is(symbol) => {
                self.at += 1;
                Ok(token)
            }
            _ => self.error(format!("expected `{}` {whence}", char::from(symbol))),
        }
    }

    fn expect_word(&mut self, what: &str) -> Parse<(String, Range<usize>)> {
        match self.peek() {
            Some(token) if token.kind == TokenKind::Word => {
                self.at += 1;
                Ok((self.text[token.range()].to_owned(), token.range()))
            }
            _ => self.error(format!("expected {what}")),
        }
    }

    fn path_separator(&mut self) -> bool {
        let found = matches!(
            self.code.get(self.at..self.at + 2),
            Some([a, b]) if a.is(b':') && b.is(b':') && a.end == b.start
        );
        if found {
            self.at += 2;
        }
        found
    }
}

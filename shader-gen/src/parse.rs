//! The outline of a source file: imports, declarations and conditions, with the bytes that each takes.
//!
//! The subset of WESL: `import package::a::b::{c};` at the top; `@if(…)`, `@elif(…)` and `@else` before imports,
//! directives, declarations, struct members and statements. Everything else is left to naga.

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
}

/// A stretch of bytes that may have to go.
#[derive(Clone, Debug)]
pub struct Edit {
    /// It stays when this holds; without a condition it always goes.
    pub keep_if: Option<Condition>,
    /// The bytes.
    pub range: Range<usize>,
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
    /// Identifiers inside of it, except for members behind a `.` and names of attributes.
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
    let comments: Vec<Token> =
        tokens.into_iter().filter(|token| token.kind == TokenKind::Comment).collect();
    let mut parser = Parser { file, text, code, comments, at: 0, chain: None, edits: Vec::new() };
    let mut module = Module { file, path: path.to_owned(), ..Module::default() };
    if let Err(error) = parser.module(&mut module) {
        errors.push(*error);
    }
    module
}

type Parse<T> = Result<T, Box<Diagnostic>>;

/// The attributes before a node.
struct Attributes {
    condition: Option<Condition>,
    is_entry_point: bool,
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

    // ------------------------------------------------------------ the file

    fn module(&mut self, module: &mut Module) -> Parse<()> {
        while let Some(first) = self.peek() {
            if first.is(b';') {
                self.at += 1;
                continue;
            }
            self.edits.clear();
            let attributes = self.attributes()?;
            let keyword = self.word();
            let kind = match keyword {
                "import" => {
                    if !module.declarations.is_empty() || !module.directives.is_empty() {
                        return self.error("imports come before directives and declarations");
                    }
                    module.imports.push(self.import(attributes.condition)?);
                    continue;
                }
                "enable" | "requires" | "diagnostic" => {
                    if !module.declarations.is_empty() {
                        return self.error("directives come before declarations");
                    }
                    self.skip_to(b';')?;
                    let item = self.item(attributes.condition, first);
                    module.directives.push(item);
                    continue;
                }
                "fn" if attributes.is_entry_point => Kind::EntryPoint,
                "fn" => Kind::Function,
                "struct" => Kind::Struct,
                "alias" => Kind::Alias,
                "const" => Kind::Constant,
                "override" => Kind::Override,
                "var" => Kind::Variable,
                "const_assert" => Kind::Assertion,
                _ => return self.error("expected an import, a directive or a declaration"),
            };
            let first_token = self.at;
            self.at += 1;
            let name = self.declaration(kind)?;
            let item = self.item(attributes.condition, first);
            let references = self.references(first_token, name.as_ref())?;
            module.declarations.push(Declaration { name, kind, item, references });
        }
        let standing: Vec<_> = self
            .comments
            .iter()
            .map(Token::range)
            .filter(|comment| {
                let inside = |item: &Item| {
                    item.whole.start <= comment.start && comment.end <= item.whole.end
                };
                self.begins_line(comment.start)
                    && !module.declarations.iter().any(|declaration| inside(&declaration.item))
                    && !module.directives.iter().any(inside)
            })
            .collect();
        for comment in standing {
            match module.sections.last_mut() {
                Some(last) if self.is_next_line(last.end..comment.start) => last.end = comment.end,
                _ => module.sections.push(comment),
            }
        }
        Ok(())
    }

    /// What has just been read from `first` on, with its comments.
    fn item(&mut self, condition: Option<Condition>, first: Token) -> Item {
        let end = self.code[self.at - 1].end;
        let whole = self.leading(first.start)..self.trailing(end);
        let mut edits = std::mem::take(&mut self.edits);
        edits.sort_by_key(|edit| (edit.range.start, std::cmp::Reverse(edit.range.end)));
        Item { condition, whole, edits }
    }

    fn import(&mut self, condition: Option<Condition>) -> Parse<Import> {
        self.at += 1;
        let start = self.peek().map_or(self.text.len(), |token| token.start);
        if self.word() != "package" {
            return Err(Box::new(
                self.fault("expected `package`")
                    .help("a path is written from the top, as in `import package::a::b::{c};`"),
            ));
        }
        self.at += 1;
        let mut path = Vec::new();
        let mut names = Vec::new();
        let mut end = start;
        while self.path_separator() {
            if self.next_is(b'{') {
                self.at += 1;
                while !self.next_is(b'}') {
                    names.push(self.expect_word("a name to import")?);
                    self.no_alias()?;
                    if !self.next_is(b'}') {
                        self.expect(b',', "between imported names")?;
                    }
                }
                self.at += 1;
                break;
            }
            let (name, range) = self.expect_word("a module or a name")?;
            path.push((name, range));
            end = self.code[self.at - 1].end;
        }
        self.no_alias()?;
        if names.is_empty() {
            names.extend(path.pop());
            end = path.last().map_or(start, |(_, range)| range.end);
        }
        if path.is_empty() {
            return Err(Box::new(
                self.fault("an import names a module and something in it")
                    .help("write `import package::a::b::{c};`"),
            ));
        }
        self.expect(b';', "after an import")?;
        let parts: Vec<_> = path.into_iter().map(|(name, _)| name).collect();
        Ok(Import { condition, path: parts.join("/"), path_range: start..end, names })
    }

    fn no_alias(&self) -> Parse<()> {
        if self.word() == "as" {
            return Err(Box::new(
                self.fault("an import cannot rename").help("names are the same everywhere"),
            ));
        }
        Ok(())
    }

    /// Reads a declaration after its keyword and returns its name.
    fn declaration(&mut self, kind: Kind) -> Parse<Option<(String, Range<usize>)>> {
        if kind == Kind::Assertion {
            self.skip_to(b';')?;
            return Ok(None);
        }
        if kind == Kind::Variable && self.next_is(b'<') {
            self.skip_to(b'>')?;
        }
        let name = self.expect_word("a name")?;
        match kind {
            Kind::Function | Kind::EntryPoint => {
                self.skip_to_brace()?;
                self.block()?;
            }
            Kind::Struct => self.members()?,
            _ => self.skip_to(b';')?,
        }
        Ok(Some(name))
    }

    fn references(
        &self,
        first: usize,
        name: Option<&(String, Range<usize>)>,
    ) -> Parse<Vec<(String, Range<usize>)>> {
        let mut references = Vec::new();
        let mut start = first;
        // The attributes before the keyword may name constants, as in `@workgroup_size(SIZE)`.
        while start > 0 && !matches!(self.code[start - 1].kind, TokenKind::Symbol(b';' | b'}')) {
            start -= 1;
        }
        for index in start..self.at {
            let token = self.code[index];
            let before = index.checked_sub(1).map(|before| self.code[before]);
            let is_name = name.is_some_and(|(_, range)| range.start == token.start);
            if token.kind != TokenKind::Word
                || is_name
                || before.is_some_and(|before| before.is(b'.') || before.is(b'@'))
            {
                continue;
            }
            let word = &self.text[token.range()];
            if word == "package" && self.code.get(index + 1).is_some_and(|next| next.is(b':')) {
                return Err(Box::new(
                    Diagnostic::new(Code::Syntax, "a path outside of an import")
                        .at(self.file, token.range(), "found this")
                        .help("import the name at the top of the file"),
                ));
            }
            references.push((word.to_owned(), token.range()));
        }
        Ok(references)
    }

    // ------------------------------------------------------------ conditions

    /// Reads attributes; a condition's own bytes become an edit.
    fn attributes(&mut self) -> Parse<Attributes> {
        let previous = self.chain.take();
        let mut attributes = Attributes { condition: None, is_entry_point: false };
        while self.next_is(b'@') {
            let start = self.at;
            self.at += 1;
            let (name, range) = self.expect_word("the name of an attribute")?;
            let conditional = matches!(name.as_str(), "if" | "elif" | "else");
            if conditional && attributes.condition.is_some() {
                return Err(Box::new(
                    Diagnostic::new(Code::Syntax, "a second condition before the same thing")
                        .at(self.file, range, "a second one")
                        .help("join them with `&&`"),
                ));
            }
            if matches!(name.as_str(), "elif" | "else") && previous.is_none() {
                return Err(Box::new(
                    Diagnostic::new(Code::Syntax, format!("`@{name}` without an `@if` before it"))
                        .at(self.file, range, "nothing to be the opposite of")
                        .help("it stands directly behind what the `@if` is about"),
                ));
            }
            match name.as_str() {
                "if" => {
                    let condition = self.condition()?;
                    self.chain = Some(condition.clone());
                    attributes.condition = Some(condition);
                }
                "elif" => {
                    let condition = self.condition()?;
                    let before = previous.clone().unwrap_or(Condition::Literal(false));
                    self.chain = Some(before.clone().or(condition.clone()));
                    attributes.condition = Some(before.not().and(condition));
                }
                "else" => attributes.condition = previous.clone().map(Condition::not),
                _ => {
                    attributes.is_entry_point |=
                        matches!(name.as_str(), "compute" | "vertex" | "fragment");
                    if self.next_is(b'(') {
                        self.at += 1;
                        self.skip_to(b')')?;
                    }
                }
            }
            if conditional {
                let start = self.code[start].start;
                let end = self.code[self.at - 1].end;
                let rest = &self.text[end..];
                let space = rest.len() - rest.trim_start().len();
                self.edits.push(Edit { keep_if: None, range: start..end + space });
            }
        }
        Ok(attributes)
    }

    fn condition(&mut self) -> Parse<Condition> {
        self.expect(b'(', "before a condition")?;
        let condition = self.disjunction()?;
        self.expect(b')', "after a condition")?;
        Ok(condition)
    }

    fn double(&mut self, symbol: u8) -> bool {
        let found = matches!(self.code.get(self.at..self.at + 2), Some([a, b]) if a.is(symbol) && b.is(symbol));
        if found {
            self.at += 2;
        }
        found
    }

    fn disjunction(&mut self) -> Parse<Condition> {
        let mut condition = self.conjunction()?;
        while self.double(b'|') {
            condition = condition.or(self.conjunction()?);
        }
        Ok(condition)
    }

    fn conjunction(&mut self) -> Parse<Condition> {
        let mut condition = self.negation()?;
        while self.double(b'&') {
            condition = condition.and(self.negation()?);
        }
        Ok(condition)
    }

    fn negation(&mut self) -> Parse<Condition> {
        if self.next_is(b'!') {
            self.at += 1;
            return Ok(self.negation()?.not());
        }
        if self.next_is(b'(') {
            return self.condition();
        }
        let (name, range) = self.expect_word("a flag, `true` or `false`")?;
        Ok(match name.as_str() {
            "true" => Condition::Literal(true),
            "false" => Condition::Literal(false),
            _ => Condition::Flag(name, range),
        })
    }

    // ------------------------------------------------------------ inside declarations

    /// Skips to behind the next `symbol` outside of brackets.
    fn skip_to(&mut self, symbol: u8) -> Parse<()> {
        self.skip(&[symbol])?;
        self.at += 1;
        Ok(())
    }

    /// Skips to the brace that opens a block.
    fn skip_to_brace(&mut self) -> Parse<()> {
        self.skip(b"{")
    }

    /// Skips to the next of `symbols` outside of brackets.
    fn skip(&mut self, symbols: &[u8]) -> Parse<()> {
        let opening = self.at;
        let mut depth = 0usize;
        while let Some(token) = self.peek() {
            match token.kind {
                TokenKind::Symbol(symbol) if depth == 0 && symbols.contains(&symbol) => {
                    return Ok(());
                }
                TokenKind::Symbol(b'(' | b'[') => depth += 1,
                TokenKind::Symbol(b')' | b']') if depth > 0 => depth -= 1,
                TokenKind::Symbol(b'{' | b'}' | b';' | b')' | b']') if depth == 0 => break,
                TokenKind::Symbol(b'{' | b'}') => break,
                TokenKind::Symbol(b'@') => {
                    self.at += 1;
                    if matches!(self.word(), "if" | "elif" | "else") {
                        return Err(Box::new(self.fault("a condition in the middle of something").help("a condition stands before an import, a directive, a declaration, a struct member or a statement")));
                    }
                    continue;
                }
                _ => {}
            }
            self.at += 1;
        }
        let expected: Vec<_> =
            symbols.iter().map(|symbol| format!("`{}`", char::from(*symbol))).collect();
        let expected = expected.join(" or ");
        let fault = self.fault(format!("expected {expected}"));
        Err(Box::new(match self.code.get(opening) {
            Some(first) => fault.at(self.file, first.range(), "of what begins here"),
            None => fault,
        }))
    }

    fn members(&mut self) -> Parse<()> {
        self.expect(b'{', "before the members of a struct")?;
        let outer = self.chain.take();
        while !self.next_is(b'}') {
            let Some(first) = self.peek() else {
                return self.error("expected `}` after the members of a struct");
            };
            let attributes = self.attributes()?;
            self.expect_word("a member")?;
            self.expect(b':', "after a member's name")?;
            self.skip_type()?;
            if self.next_is(b',') {
                self.at += 1;
            }
            self.conditional(attributes.condition, first);
        }
        self.at += 1;
        self.chain = outer;
        Ok(())
    }

    /// Skips a type to the `,` or `}` behind it.
    fn skip_type(&mut self) -> Parse<()> {
        let mut templates = 0usize;
        loop {
            self.skip(b",<>}")?;
            match self.peek() {
                Some(token) if token.is(b'<') => templates += 1,
                Some(token) if token.is(b'>') => templates = templates.saturating_sub(1),
                Some(token) if token.is(b',') && templates > 0 => {}
                _ => return Ok(()),
            }
            self.at += 1;
        }
    }

    fn block(&mut self) -> Parse<()> {
        let opening = self.expect(b'{', "before a block")?;
        let outer = self.chain.take();
        while !self.next_is(b'}') {
            let Some(first) = self.peek() else {
                let fault = self.fault("a block that does not end");
                return Err(Box::new(fault.at(self.file, opening.range(), "it begins here")));
            };
            if first.is(b';') {
                self.at += 1;
                continue;
            }
            let attributes = self.attributes()?;
            self.statement()?;
            self.conditional(attributes.condition, first);
        }
        self.at += 1;
        self.chain = outer;
        Ok(())
    }

    fn statement(&mut self) -> Parse<()> {
        match self.word() {
            "if" => loop {
                self.skip_to_brace()?;
                self.block()?;
                if self.word() != "else" {
                    return Ok(());
                }
                self.at += 1;
            },
            "for" => {
                // Its header holds semicolons inside of parentheses.
                self.skip_to_brace()?;
                self.block()
            }
            "while" | "switch" | "loop" | "continuing" | "case" | "default" => {
                self.skip_to_brace()?;
                self.block()
            }
            _ if self.next_is(b'{') => self.block(),
            _ => self.skip_to(b';'),
        }
    }

    /// Turns what has just been read from `first` on into an edit if it has a condition.
    fn conditional(&mut self, condition: Option<Condition>, first: Token) {
        let Some(condition) = condition else {
            return;
        };
        let end = self.code[self.at - 1].end;
        self.edits.push(Edit {
            keep_if: Some(condition),
            range: self.lines(self.leading(first.start)..self.trailing(end)),
        });
    }

    // ------------------------------------------------------------ comments

    /// Where the comments begin that stand directly before `start`, each at the beginning of its line.
    fn leading(&self, mut start: usize) -> usize {
        let before = self.comments.partition_point(|comment| comment.start < start);
        for comment in self.comments[..before].iter().rev() {
            if !self.is_next_line(comment.end..start) || !self.begins_line(comment.start) {
                break;
            }
            start = comment.start;
        }
        start
    }

    /// Where the comment ends that stands behind `end` on the same line, as the last thing on it.
    fn trailing(&self, end: usize) -> usize {
        let next = self.comments.partition_point(|comment| comment.start < end);
        match self.comments.get(next) {
            Some(comment)
                if self.text[end..comment.start].chars().all(|c| matches!(c, ' ' | '\t'))
                    && self.text[comment.end..]
                        .trim_start_matches([' ', '\t', '\r'])
                        .starts_with('\n') =>
            {
                comment.end
            }
            _ => end,
        }
    }

    /// Whether `gap` is white space with exactly one line break.
    fn is_next_line(&self, gap: Range<usize>) -> bool {
        let gap = &self.text[gap];
        gap.trim().is_empty() && gap.bytes().filter(|byte| *byte == b'\n').count() == 1
    }

    fn begins_line(&self, start: usize) -> bool {
        let line = self.text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        self.text[line..start].trim().is_empty()
    }

    /// `range` with its indentation and line break if nothing else stands on its lines; otherwise with the space
    /// behind it.
    fn lines(&self, range: Range<usize>) -> Range<usize> {
        let rest = &self.text[range.end..];
        let space = rest.len() - rest.trim_start_matches([' ', '\t', '\r']).len();
        let after = range.end + space;
        if self.begins_line(range.start) && self.text[after..].starts_with('\n') {
            let line = self.text[..range.start].rfind('\n').map_or(0, |newline| newline + 1);
            return line..after + 1;
        }
        range.start..after
    }
}

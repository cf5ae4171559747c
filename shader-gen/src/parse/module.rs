//! What stands at module scope: imports, directives and declarations.

use std::ops::Range;

use super::{Declaration, Import, Item, Kind, Module, Name, Parse, Parser};
use crate::condition::Condition;
use crate::error::{Code, Diagnostic};
use crate::token::{Token, TokenKind};

impl Parser<'_> {
    pub(super) fn module(&mut self, module: &mut Module) -> Parse<()> {
        while let Some(first) = self.peek() {
            if first.is(b';') {
                self.at += 1;
                continue;
            }
            self.edits.clear();
            self.blocks.clear();
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
            let (name, body) = self.declaration(kind)?;
            let item = self.item(attributes.condition, first);
            let references = self.references(first_token, name.as_ref())?;
            let binding = attributes.group.zip(attributes.binding);
            let body = body.unwrap_or(item.whole.end);
            module.declarations.push(Declaration { name, kind, item, binding, body, references });
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
        let blocks = std::mem::take(&mut self.blocks);
        Item { condition, whole, edits, blocks }
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

    /// Reads a declaration after its keyword; returns its name and, of a function, where its block begins.
    fn declaration(&mut self, kind: Kind) -> Parse<(Option<Name>, Option<usize>)> {
        if kind == Kind::Assertion {
            self.skip_to(b';')?;
            return Ok((None, None));
        }
        if kind == Kind::Variable && self.next_is(b'<') {
            self.skip_to(b'>')?;
        }
        let name = self.expect_word("a name")?;
        let mut body = None;
        match kind {
            Kind::Function | Kind::EntryPoint => {
                let head = self.code[self.at - 1].start;
                self.skip_to_brace()?;
                body = self.peek().map(|brace| brace.start);
                self.block(head)?;
            }
            Kind::Struct => self.members()?,
            _ => self.skip_to(b';')?,
        }
        Ok((Some(name), body))
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
}

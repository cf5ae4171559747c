//! What stands inside of declarations: statements and the members of structs.

use std::ops::Range;

use super::{Block, Edit, Parse, Parser};
use crate::condition::Condition;
use crate::token::{Token, TokenKind};

impl Parser<'_> {
    /// Skips to behind the next `symbol` outside of brackets.
    pub(super) fn skip_to(&mut self, symbol: u8) -> Parse<()> {
        self.skip(&[symbol])?;
        self.at += 1;
        Ok(())
    }

    /// Skips to the brace that opens a block.
    pub(super) fn skip_to_brace(&mut self) -> Parse<()> {
        self.skip(b"{")
    }

    /// Skips to the next of `symbols` outside of brackets.
    pub(super) fn skip(&mut self, symbols: &[u8]) -> Parse<()> {
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

    pub(super) fn members(&mut self) -> Parse<()> {
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
    pub(super) fn skip_type(&mut self) -> Parse<()> {
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

    /// Reads a block. What it declares has the scope that begins at `around`, or with the block itself.
    pub(super) fn block(&mut self, around: usize) -> Parse<Vec<(String, Range<usize>)>> {
        let opening = self.expect(b'{', "before a block")?;
        let outer = self.chain.take();
        let outer_scope = std::mem::take(&mut self.scope);
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
            let begin = self.code[self.at.min(self.code.len() - 1)];
            let declares = self.statement()?;
            if begin.is(b'{')
                && let Some(condition) = &attributes.condition
            {
                self.braces(condition.clone(), first, begin, declares);
            }
            self.conditional(attributes.condition, first);
        }
        self.at += 1;
        self.chain = outer;
        let scope = std::mem::replace(&mut self.scope, outer_scope);
        for block in scope.blocks {
            self.blocks[block].around = around..self.code[self.at - 1].end;
        }
        Ok(scope.declares)
    }

    /// Reads a statement; of a block that stands by itself returns what it declares.
    fn statement(&mut self) -> Parse<Vec<(String, Range<usize>)>> {
        let begin = self.peek().map_or(self.text.len(), |token| token.start);
        match self.word() {
            "if" => loop {
                self.skip_to_brace()?;
                self.block(begin)?;
                if self.word() != "else" {
                    return Ok(Vec::new());
                }
                self.at += 1;
            },
            // The header of `for` holds semicolons inside of parentheses.
            "for" | "while" | "switch" | "loop" | "continuing" | "case" | "default" => {
                self.skip_to_brace()?;
                self.block(begin)?;
                Ok(Vec::new())
            }
            "let" | "var" | "const" => {
                self.at += 1;
                if self.next_is(b'<') {
                    self.skip_to(b'>')?;
                }
                let declared = self.expect_word("a name")?;
                self.scope.declares.push(declared);
                self.skip_to(b';')?;
                Ok(Vec::new())
            }
            _ if self.next_is(b'{') => self.block(begin),
            _ => {
                self.skip_to(b';')?;
                Ok(Vec::new())
            }
        }
    }

    /// Remembers the block that has just been read, from its brace `opening` on, under a condition that begins with
    /// `first`.
    fn braces(
        &mut self,
        condition: Condition,
        first: Token,
        opening: Token,
        declares: Vec<(String, Range<usize>)>,
    ) {
        let closing = self.code[self.at - 1];
        let between = opening.end..closing.start;
        let lines: Vec<_> = self.text[between.clone()]
            .match_indices('\n')
            .map(|(newline, _)| between.start + newline + 1)
            .collect();
        let indent = |start: usize| {
            let rest = &self.text[start..];
            rest.len() - rest.trim_start_matches(' ').len()
        };
        let line = self.text[..first.start].rfind('\n').map_or(0, |newline| newline + 1);
        let inner = lines.iter().find(|line| !self.text[**line..].starts_with('\n'));
        let indent = inner.map_or(0, |inner| indent(*inner).saturating_sub(indent(line)));
        self.scope.blocks.push(self.blocks.len());
        self.blocks.push(Block {
            condition,
            range: opening.start..closing.end,
            braces: [self.lines(first.start..opening.end), self.lines_before(closing.range())],
            lines,
            indent,
            declares,
            around: 0..0,
        });
    }

    /// Turns what has just been read from `first` on into an edit if it has a condition.
    pub(super) fn conditional(&mut self, condition: Option<Condition>, first: Token) {
        let Some(condition) = condition else {
            return;
        };
        let end = self.code[self.at - 1].end;
        self.edits.push(Edit {
            keep_if: Some(condition),
            range: self.lines(self.leading(first.start)..self.trailing(end)),
        });
    }
}

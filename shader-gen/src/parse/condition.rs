//! Attributes before a node, conditions among them.

use super::{Attributes, Edit, Parse, Parser};
use crate::condition::Condition;
use crate::error::{Code, Diagnostic};

impl Parser<'_> {
    /// Reads attributes; a condition's own bytes become an edit.
    pub(super) fn attributes(&mut self) -> Parse<Attributes> {
        let previous = self.chain.take();
        let mut attributes = Attributes::default();
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
                        let start = self.code[self.at].end;
                        self.at += 1;
                        self.skip_to(b')')?;
                        let value = &self.text[start..self.code[self.at - 1].start];
                        let value =
                            || value.trim().trim_end_matches('u').parse().unwrap_or(u32::MAX);
                        match name.as_str() {
                            "group" => attributes.group = Some(value()),
                            "binding" => attributes.binding = Some(value()),
                            _ => {}
                        }
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

    pub(super) fn condition(&mut self) -> Parse<Condition> {
        self.expect(b'(', "before a condition")?;
        let condition = self.disjunction()?;
        self.expect(b')', "after a condition")?;
        Ok(condition)
    }

    pub(super) fn double(&mut self, symbol: u8) -> bool {
        let found = matches!(self.code.get(self.at..self.at + 2), Some([a, b]) if a.is(symbol) && b.is(symbol));
        if found {
            self.at += 2;
        }
        found
    }

    pub(super) fn disjunction(&mut self) -> Parse<Condition> {
        let mut condition = self.conjunction()?;
        while self.double(b'|') {
            condition = condition.or(self.conjunction()?);
        }
        Ok(condition)
    }

    pub(super) fn conjunction(&mut self) -> Parse<Condition> {
        let mut condition = self.negation()?;
        while self.double(b'&') {
            condition = condition.and(self.negation()?);
        }
        Ok(condition)
    }

    pub(super) fn negation(&mut self) -> Parse<Condition> {
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
}

//! From the text of a formula to its tree.

use crate::formula::{FUNCTION, Node, OPERATIONS, Operation};

/// Parses a whole text.
pub(crate) fn parse(text: &str) -> Result<Node, String> {
    let text = text.trim();
    let mut parser = Parser { text, rest: text, depth: 0 };
    let node = parser.binary(0)?;
    if parser.rest.is_empty() { Ok(node) } else { Err(parser.expected("an operator or the end")) }
}

/// What is left of a text. It never begins with a space after a token was taken.
struct Parser<'a> {
    text: &'a str,
    rest: &'a str,
    depth: u32,
}

impl<'a> Parser<'a> {
    fn expected(&self, what: &str) -> String {
        let next = self.rest.chars().next();
        let found = next.map_or("the end".to_owned(), |next| format!("`{next}`"));
        let column = self.text.len() - self.rest.len() + 1;
        format!("expected {what} at character {column}, found {found}")
    }

    fn take(&mut self, token: &str) -> bool {
        let rest = self.rest.trim_start().strip_prefix(token);
        self.rest = rest.unwrap_or(self.rest).trim_start();
        rest.is_some()
    }

    fn demand(&mut self, token: &str) -> Result<(), String> {
        if self.take(token) { Ok(()) } else { Err(self.expected(&format!("`{token}`"))) }
    }

    /// The longest run of characters of a kind.
    fn run(&mut self, of: fn(char) -> bool) -> &'a str {
        let end = self.rest.find(|next| !of(next)).unwrap_or(self.rest.len());
        let (run, rest) = self.rest.split_at(end);
        self.rest = rest.trim_start();
        run
    }

    fn operator(&mut self, level: usize) -> Option<&'static Operation> {
        // The first that fits is the longest one.
        let operation = OPERATIONS.iter().find(|of| self.rest.starts_with(of.symbol))?;
        (operation.level == level && self.take(operation.symbol)).then_some(operation)
    }

    fn binary(&mut self, level: usize) -> Result<Node, String> {
        if level == FUNCTION {
            self.depth += 1;
            if self.depth > 64 {
                return Err("too many brackets".to_owned());
            }
            let operand = self.operand();
            self.depth -= 1;
            return operand;
        }
        let mut left = self.binary(level + 1)?;
        while let Some(operation) = self.operator(level) {
            left = if self.take("'") {
                let value = self.run(|next| next != '\'').to_owned();
                self.demand("'")?;
                match (left, operation.symbol) {
                    (Node::Name(axis), "==") => Node::Is(axis, value),
                    (Node::Name(axis), "!=") => {
                        Node::Apply(named("!")?, vec![Node::Is(axis, value)])
                    }
                    _ => {
                        return Err(format!("expected `axis == '{value}'` or `axis != '{value}'`"));
                    }
                }
            } else {
                Node::Apply(operation, vec![left, self.binary(level + 1)?])
            };
        }
        Ok(left)
    }

    fn operand(&mut self) -> Result<Node, String> {
        if self.take("!") {
            return Ok(Node::Apply(named("!")?, vec![self.binary(FUNCTION)?]));
        }
        if self.take("(") {
            let inner = self.binary(0)?;
            self.demand(")")?;
            return Ok(inner);
        }
        let word = self.run(|next| next.is_ascii_alphanumeric() || next == '_');
        if word.starts_with(|first: char| first.is_ascii_digit()) {
            let number = word.parse().map(Node::Number);
            return number.map_err(|_| format!("`{word}` is no whole number of 64 bits"));
        }
        if word.is_empty() {
            return Err(self.expected("a number, a name or a bracket"));
        }
        if !self.take("(") {
            return Ok(Node::Name(word.to_owned()));
        }
        let (operation, mut arguments) = (named(word)?, vec![self.binary(0)?]);
        while self.take(",") {
            arguments.push(self.binary(0)?);
        }
        self.demand(")")?;
        if arguments.len() == operation.arity {
            return Ok(Node::Apply(operation, arguments));
        }
        Err(format!("`{word}` takes {} arguments, not {}", operation.arity, arguments.len()))
    }
}

/// The function of a name.
fn named(name: &str) -> Result<&'static Operation, String> {
    let found = OPERATIONS.iter().find(|of| of.level == FUNCTION && of.symbol == name);
    found.ok_or_else(|| format!("`{name}` is no function"))
}

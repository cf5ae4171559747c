//! From the text of a formula to its tree.

use serde::{Deserialize, Serialize};
use sglow_graph::Formula;

/// A formula as a person writes it: a text, or a whole number.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Form", into = "String")]
pub struct Text(pub String);

#[derive(Deserialize)]
#[serde(untagged, expecting = "a formula: a text or a whole number of at least 0")]
enum Form {
    Text(String),
    Number(u64),
}

impl From<Form> for Text {
    fn from(form: Form) -> Self {
        match form {
            Form::Text(text) => Self(text),
            Form::Number(number) => Self(number.to_string()),
        }
    }
}

impl From<Text> for String {
    fn from(text: Text) -> Self {
        text.0
    }
}

/// Operators from the loosest to the tightest; in a level no one stands before one that begins with it.
const LEVELS: [&[&str]; 6] = [
    &["||"],
    &["&&"],
    &["==", "!=", "<=", ">=", "<", ">"],
    &["<<", ">>"],
    &["+", "-"],
    &["*", "/", "%"],
];

/// Functions, and how many arguments they take.
const FUNCTIONS: [(&str, usize); 7] = [
    ("min", 2),
    ("max", 2),
    ("div_ceil", 2),
    ("log2", 1),
    ("pow2_ceil", 1),
    ("bits", 1),
    ("select", 3),
];

/// The maximum length of a formula in characters.
const MAXIMUM_LENGTH: usize = 4096;

/// The maximum depth of operations. Each is two levels in JSON, of which serde_json reads 128.
const MAXIMUM_DEPTH: usize = 40;

/// How many operations nest in each other.
fn depth(of: &Formula) -> usize {
    let parts = operation(of).map_or(&[][..], |(_, parts)| parts);
    parts.iter().map(depth).max().unwrap_or(0) + usize::from(!parts.is_empty())
}

impl Text {
    /// The tree.
    ///
    /// # Errors
    ///
    /// What is no formula.
    pub fn parse(&self) -> Result<Formula, String> {
        let text = self.0.trim();
        if text.len() > MAXIMUM_LENGTH {
            return Err(format!("is longer than {MAXIMUM_LENGTH} characters"));
        }
        let mut parser = Parser { text, rest: text, depth: 0 };
        let tree = parser.binary(0)?;
        if !parser.rest.is_empty() {
            return Err(parser.expected("an operator or the end"));
        }
        if depth(&tree) > MAXIMUM_DEPTH {
            return Err(format!(
                "nests more than {MAXIMUM_DEPTH} operations; give parts of it names"
            ));
        }
        Ok(tree)
    }
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

    fn operator(&mut self, level: usize) -> Option<&'static str> {
        // `<<` is no `<`.
        let is_longer = |symbol: &str| {
            let shift = ["<<", ">>"].iter().any(|shift| self.rest.starts_with(shift));
            shift && matches!(symbol, "<" | ">")
        };
        let mut symbols = LEVELS[level].iter().copied();
        let symbol = symbols.find(|of| self.rest.starts_with(of) && !is_longer(of))?;
        self.take(symbol).then_some(symbol)
    }

    fn binary(&mut self, level: usize) -> Result<Formula, String> {
        if level == LEVELS.len() {
            self.depth += 1;
            if self.depth > 64 {
                return Err("too many brackets".to_owned());
            }
            let operand = self.operand();
            self.depth -= 1;
            return operand;
        }
        let mut left = self.binary(level + 1)?;
        while let Some(symbol) = self.operator(level) {
            left = if self.take("'") {
                let value = self.run(|next| next != '\'');
                self.demand("'")?;
                match (left, symbol) {
                    (Formula::Name { name }, "==") => is(&name, value),
                    (Formula::Name { name }, "!=") => apply("!", [is(&name, value)]),
                    _ => return Err("expected `axis == 'value'` or `axis != 'value'`".to_owned()),
                }
            } else {
                apply(symbol, [left, self.binary(level + 1)?])
            };
        }
        Ok(left)
    }

    fn operand(&mut self) -> Result<Formula, String> {
        if self.take("!") {
            return Ok(apply("!", [self.binary(LEVELS.len())?]));
        }
        if self.take("(") {
            let inner = self.binary(0)?;
            self.demand(")")?;
            return Ok(inner);
        }
        let word = self.run(|next| next.is_ascii_alphanumeric() || next == '_');
        if word.starts_with(|first: char| first.is_ascii_digit()) {
            let number = word.parse().map(Formula::Number);
            return number.map_err(|_| format!("`{word}` is no whole number of 64 bits"));
        }
        if word.is_empty() {
            return Err(self.expected("a number, a name or a bracket"));
        }
        if !self.take("(") {
            return Ok(name(word));
        }
        let known = FUNCTIONS.iter().find(|(name, _)| *name == word);
        let (_, count) = known.ok_or_else(|| format!("`{word}` is no function"))?;
        let mut arguments = vec![self.binary(0)?];
        while self.take(",") {
            arguments.push(self.binary(0)?);
        }
        self.demand(")")?;
        if arguments.len() == *count {
            return Ok(apply(word, arguments));
        }
        Err(format!("`{word}` takes {count} arguments, not {}", arguments.len()))
    }
}

/// The number of a name.
pub(crate) fn name(name: &str) -> Formula {
    Formula::Name { name: name.to_owned() }
}

/// Whether an axis has a value.
pub(crate) fn is(axis: &str, value: &str) -> Formula {
    Formula::Is { is: [axis.to_owned(), value.to_owned()] }
}

/// An operation with its arguments.
pub(crate) fn apply(symbol: &str, arguments: impl Into<Vec<Formula>>) -> Formula {
    Formula::Apply([(symbol.to_owned(), arguments.into())].into())
}

/// What holds if both hold; nothing stands for what always does.
pub(super) fn both(a: Option<Formula>, b: Option<Formula>) -> Option<Formula> {
    match (a, b) {
        (Some(a), Some(b)) => simple(apply("&&", [a, b])).condition(),
        (a, b) => a.or(b).and_then(Condition::condition),
    }
}

pub(super) fn not(of: Formula) -> Formula {
    simple(apply("!", [of]))
}

/// A formula as a condition.
pub(super) trait Condition {
    /// Nothing if it always holds.
    fn condition(self) -> Option<Formula>;
    /// Whether it never holds.
    fn is_never(&self) -> bool;
}

impl Condition for Formula {
    fn condition(self) -> Option<Formula> {
        Some(self).filter(|of| !matches!(of, Formula::Number(1..)))
    }

    fn is_never(&self) -> bool {
        *self == Formula::Number(0)
    }
}

/// The operation of a formula, if it is one.
pub(super) fn operation(of: &Formula) -> Option<(&str, &[Formula])> {
    let Formula::Apply(operation) = of else { return None };
    operation.first_key_value().map(|(symbol, parts)| (symbol.as_str(), &parts[..]))
}

/// The same formula without what its constants decide. Its parts are simple.
pub(super) fn simple(of: Formula) -> Formula {
    use Formula::Number;
    let is_truth = |of: &Formula| {
        let truths = ["!", "&&", "||", "==", "!=", "<", "<=", ">", ">="];
        matches!(of, Formula::Is { .. })
            || operation(of).is_some_and(|(symbol, _)| truths.contains(&symbol))
    };
    let truth = |of: &Formula| match of {
        Number(number) => Number(u64::from(*number != 0)),
        of if is_truth(of) => of.clone(),
        of => apply("!=", [of.clone(), Number(0)]),
    };
    let Some((symbol, parts)) = operation(&of) else { return of };

    match (symbol, parts) {
        ("!", [Number(number)]) => Number(u64::from(*number == 0)),
        ("!", [inner]) => match operation(inner) {
            Some(("!", [inner])) => truth(inner),
            _ => of,
        },
        ("&&", [Number(0), _] | [_, Number(0)]) => Number(0),
        ("||", [Number(1..), _] | [_, Number(1..)]) => Number(1),
        ("&&", [Number(_), part] | [part, Number(1..)]) => truth(part),
        ("||", [Number(_), part] | [part, Number(0)]) => truth(part),
        ("select", [Number(0), _, part]) | ("select", [Number(1..), part, _]) => part.clone(),
        ("select", [_, a, b]) if a == b => a.clone(),
        ("+", [Number(0), part] | [part, Number(0)]) => part.clone(),
        ("*", [Number(1), part] | [part, Number(1)]) => part.clone(),
        ("/", [part, Number(1)]) => part.clone(),
        ("min" | "max", [a, b]) if a == b => a.clone(),
        ("*", [Number(0), _] | [_, Number(0)]) => Number(0),
        ("==", [Number(a), Number(b)]) => Number(u64::from(a == b)),
        ("%", [Number(a), Number(b @ 1..)]) => Number(a % b),
        _ => of,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_are_bounded() {
        let parsed = |text: String| Text(text).parse();
        let nested = |depth: usize| format!("{}1{}", "max(a, ".repeat(depth), ")".repeat(depth));
        assert!(parsed(nested(MAXIMUM_DEPTH)).is_ok());
        let text = parsed(nested(MAXIMUM_DEPTH + 1)).unwrap_err();
        assert!(text.contains("nests more than"), "{text}");
        assert!(parsed("a".repeat(MAXIMUM_LENGTH)).is_ok());
        let text = parsed("a".repeat(MAXIMUM_LENGTH + 1)).unwrap_err();
        assert!(text.contains("is longer than"), "{text}");
    }
}

//! Formulas of whole numbers: what they are, and what they come to.

use std::cell::Cell;
use std::fmt;

use serde::de::{self, Deserialize, Deserializer};
use serde::ser::{Serialize, SerializeMap, Serializer};

use crate::error::{At, Error, Problem};
use crate::parse::parse;

/// A formula as it was written, with its tree or with what is wrong with it.
///
/// In TOML a text or a number; in JSON `{ "text": …, "tree": … }`.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// The text.
    pub text: String,
    /// The tree, or why the text is no formula.
    pub tree: Result<Node, String>,
}

/// A part of a formula.
///
/// In JSON a number, a name as a string, or an object of one key: `{ "is": [axis, value] }` for an axis, else
/// `{ "+": [part, part] }` by the symbol of an operator or the name of a function.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// A number.
    Number(u64),
    /// A parameter, a let, a fact or the number of a round.
    Name(String),
    /// 1 if an axis has a value, else 0.
    Is(String, String),
    /// An operator or a function of its arguments.
    Apply(&'static Operation, Vec<Node>),
}

/// An operator or a function.
pub struct Operation {
    /// Its symbol or name.
    pub symbol: &'static str,
    /// How many arguments it has.
    pub arity: usize,
    /// How tightly an operator binds, from 0 on; [`FUNCTION`] for a function and for `!`.
    pub(crate) level: usize,
    apply: fn(u64, u64) -> Result<u64, &'static str>,
}

pub(crate) const FUNCTION: usize = 6;

const OVERFLOW: &str = "the result exceeds 64 bits";
const ZERO: &str = "division by zero";

/// All of them; no symbol stands before one that begins with it. Those that evaluate their arguments by need have no rule.
#[rustfmt::skip]
pub(crate) static OPERATIONS: [Operation; 23] = [
    operation("||", 2, 0, |a, _| Ok(a)),
    operation("&&", 2, 1, |a, _| Ok(a)),
    operation("==", 2, 2, |a, b| Ok(u64::from(a == b))),
    operation("!=", 2, 2, |a, b| Ok(u64::from(a != b))),
    operation("<=", 2, 2, |a, b| Ok(u64::from(a <= b))),
    operation(">=", 2, 2, |a, b| Ok(u64::from(a >= b))),
    operation("<<", 2, 3, |a, b| {
        let shifted = u32::try_from(b).ok().and_then(|by| a.checked_shl(by));
        shifted.filter(|shifted| shifted >> b == a).ok_or(OVERFLOW)
    }),
    operation(">>", 2, 3, |a, b| Ok(u32::try_from(b).ok().and_then(|by| a.checked_shr(by)).unwrap_or(0))),
    operation("<", 2, 2, |a, b| Ok(u64::from(a < b))),
    operation(">", 2, 2, |a, b| Ok(u64::from(a > b))),
    operation("+", 2, 4, |a, b| a.checked_add(b).ok_or(OVERFLOW)),
    operation("-", 2, 4, |a, b| a.checked_sub(b).ok_or("a negative difference")),
    operation("*", 2, 5, |a, b| a.checked_mul(b).ok_or(OVERFLOW)),
    operation("/", 2, 5, |a, b| a.checked_div(b).ok_or(ZERO)),
    operation("%", 2, 5, |a, b| a.checked_rem(b).ok_or(ZERO)),
    operation("!", 1, FUNCTION, |a, _| Ok(u64::from(a == 0))),
    operation("min", 2, FUNCTION, |a, b| Ok(a.min(b))),
    operation("max", 2, FUNCTION, |a, b| Ok(a.max(b))),
    operation("div_ceil", 2, FUNCTION, |a, b| if b == 0 { Err(ZERO) } else { Ok(a.div_ceil(b)) }),
    operation("log2", 1, FUNCTION, |a, _| a.checked_ilog2().map(u64::from).ok_or("the logarithm of 0")),
    operation("pow2_ceil", 1, FUNCTION, |a, _| a.checked_next_power_of_two().ok_or(OVERFLOW)),
    operation("bits", 1, FUNCTION, |a, _| Ok(u64::from(u64::BITS - a.leading_zeros()))),
    operation("select", 3, FUNCTION, |a, _| Ok(a)),
];

const fn operation(
    symbol: &'static str,
    arity: usize,
    level: usize,
    apply: fn(u64, u64) -> Result<u64, &'static str>,
) -> Operation {
    Operation { symbol, arity, level, apply }
}

impl fmt::Debug for Operation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.symbol)
    }
}

impl PartialEq for Operation {
    fn eq(&self, other: &Self) -> bool {
        self.symbol == other.symbol
    }
}

/// What names in a formula stand for.
pub(crate) trait Names {
    /// The number of a name.
    fn number(&self, name: &str, at: &At<'_>) -> Result<u64, Error>;
    /// Whether an axis has a value.
    fn is(&self, axis: &str, value: &str, at: &At<'_>) -> Result<bool, Error>;
}

impl Node {
    fn evaluate(&self, names: &dyn Names, at: &At<'_>) -> Result<u64, Error> {
        let (operation, arguments) = match self {
            Self::Number(number) => return Ok(*number),
            Self::Name(name) => return names.number(name, at),
            Self::Is(axis, value) => return names.is(axis, value, at).map(u64::from),
            Self::Apply(operation, arguments) => (operation, arguments),
        };
        let of = |index| arguments.get(index).map_or(Ok(0), |of: &Self| of.evaluate(names, at));
        let first = of(0)?;
        match operation.symbol {
            "&&" => Ok(u64::from(first != 0 && of(1)? != 0)),
            "||" => Ok(u64::from(first != 0 || of(1)? != 0)),
            "select" => of(if first != 0 { 1 } else { 2 }),
            symbol => {
                let second = of(1)?;
                let wrong =
                    |what| Problem::Arithmetic(format!("{what}: `{symbol}` of {first}, {second}"));
                (operation.apply)(first, second).map_err(|what| at.error(wrong(what)))
            }
        }
    }
}

thread_local! {
    static EVALUATED: Cell<u64> = const { Cell::new(0) };
}

/// How many formulas this thread has evaluated so far: what executes a frame evaluates none.
pub fn evaluated() -> u64 {
    EVALUATED.get()
}

impl Formula {
    /// The formula of a text.
    pub fn new(text: impl Into<String>) -> Self {
        let text = text.into();
        Self { tree: parse(&text), text }
    }

    pub(crate) fn evaluate(&self, names: &dyn Names, at: &At<'_>) -> Result<u64, Error> {
        EVALUATED.set(EVALUATED.get() + 1);
        match &self.tree {
            Ok(tree) => tree.evaluate(names, at),
            Err(message) => Err(at.error(Problem::Syntax(message.clone()))),
        }
    }
}

impl Serialize for Node {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(number) => number.serialize(serializer),
            Self::Name(name) => name.serialize(serializer),
            Self::Is(axis, value) => serializer.collect_map([("is", [axis, value])]),
            Self::Apply(operation, arguments) => {
                serializer.collect_map([(operation.symbol, arguments)])
            }
        }
    }
}

impl Serialize for Formula {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(2))?;
        map.serialize_entry("text", &self.text)?;
        map.serialize_entry("tree", &self.tree.as_ref().ok())?;
        map.end()
    }
}

#[cfg(feature = "schemars")]
impl schemars::JsonSchema for Formula {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Formula".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "A formula: its text, and its tree of numbers, names and objects of one operation",
            "type": "object",
            "required": ["text", "tree"],
            "properties": { "text": { "type": "string" }, "tree": { "type": ["integer", "string", "object"] } },
            "additionalProperties": false,
        })
    }
}

impl<'de> Deserialize<'de> for Formula {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // The text alone counts; the tree is for hosts that do not parse texts.
        #[derive(serde::Deserialize)]
        #[serde(untagged, expecting = "a formula: a text or a whole number of at least 0")]
        enum Form {
            Text(String),
            Number(u64),
            Parsed {
                text: String,
                #[serde(rename = "tree")]
                _tree: de::IgnoredAny,
            },
        }
        Ok(match Form::deserialize(deserializer)? {
            Form::Text(text) | Form::Parsed { text, .. } => Self::new(text),
            Form::Number(number) => Self::new(number.to_string()),
        })
    }
}

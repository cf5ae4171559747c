//! Formulas of whole numbers: what they are, and what they come to.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

/// A formula of whole numbers, as a tree.
///
/// In JSON a number or an object of one key: `{ "name": … }`, `{ "is": [axis, value] }`, else the symbol of an operator or the
/// name of a function with its arguments, as in `{ "+": [{ "name": "side" }, 1] }`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "a formula: a whole number of at least 0, a name, or an operation")]
pub enum Formula {
    /// A number.
    Number(u64),
    /// A parameter, a let, a fact or the number of a round.
    #[expect(missing_docs, reason = "said above")]
    Name { name: String },
    /// 1 if an axis has a value, else 0.
    #[expect(missing_docs, reason = "said above")]
    Is { is: [String; 2] },
    /// One operation by its symbol, with its arguments.
    Apply(BTreeMap<String, Vec<Formula>>),
}

impl fmt::Display for Formula {
    /// As one writes it, with all brackets.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(out),
            Self::Name { name } => name.fmt(out),
            Self::Is { is: [axis, value] } => write!(out, "{axis} == '{value}'"),
            Self::Apply(operation) => operation.iter().try_for_each(|(symbol, arguments)| {
                let arguments: Vec<_> = arguments.iter().map(ToString::to_string).collect();
                match &arguments[..] {
                    [a, b] if !symbol.starts_with(char::is_alphabetic) => {
                        write!(out, "({a} {symbol} {b})")
                    }
                    _ => write!(out, "{symbol}({})", arguments.join(", ")),
                }
            }),
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
    /// The number of a name.
    pub fn name(name: &str) -> Self {
        Self::Name { name: name.to_owned() }
    }

    /// Whether an axis has a value.
    pub fn is(axis: &str, value: &str) -> Self {
        Self::Is { is: [axis.to_owned(), value.to_owned()] }
    }

    /// An operation with its arguments.
    pub fn apply(symbol: &str, arguments: impl Into<Vec<Self>>) -> Self {
        Self::Apply([(symbol.to_owned(), arguments.into())].into())
    }
}

/// Counts one more.
pub(crate) fn count() {
    EVALUATED.set(EVALUATED.get() + 1);
}

const OVERFLOW: &str = "the result exceeds 64 bits";
/// There is no such operation of so many arguments.
pub(crate) const UNKNOWN: &str = "unknown operation";
const ZERO: &str = "division by zero";

/// What an operation makes of one number.
pub(crate) fn unary(symbol: &str, a: u64) -> Result<u64, &'static str> {
    match symbol {
        "!" => Ok(u64::from(a == 0)),
        "bits" => Ok(u64::from(u64::BITS - a.leading_zeros())),
        "log2" => a.checked_ilog2().map(u64::from).ok_or("the logarithm of 0"),
        "pow2_ceil" => a.checked_next_power_of_two().ok_or(OVERFLOW),
        _ => Err(UNKNOWN),
    }
}

/// What an operation makes of two numbers.
pub(crate) fn binary(symbol: &str, a: u64, b: u64) -> Result<u64, &'static str> {
    let by = u32::try_from(b).ok();
    match symbol {
        "==" => Ok(u64::from(a == b)),
        "!=" => Ok(u64::from(a != b)),
        "<=" => Ok(u64::from(a <= b)),
        ">=" => Ok(u64::from(a >= b)),
        "<" => Ok(u64::from(a < b)),
        ">" => Ok(u64::from(a > b)),
        "<<" => {
            let shifted = by.and_then(|by| a.checked_shl(by));
            shifted.filter(|shifted| shifted >> b == a).ok_or(OVERFLOW)
        }
        ">>" => Ok(by.and_then(|by| a.checked_shr(by)).unwrap_or(0)),
        "+" => a.checked_add(b).ok_or(OVERFLOW),
        "-" => a.checked_sub(b).ok_or("a negative difference"),
        "*" => a.checked_mul(b).ok_or(OVERFLOW),
        "/" => a.checked_div(b).ok_or(ZERO),
        "%" => a.checked_rem(b).ok_or(ZERO),
        "div_ceil" => {
            if b == 0 {
                Err(ZERO)
            } else {
                Ok(a.div_ceil(b))
            }
        }
        "min" => Ok(a.min(b)),
        "max" => Ok(a.max(b)),
        _ => Err(UNKNOWN),
    }
}

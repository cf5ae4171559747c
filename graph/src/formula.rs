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
#[expect(missing_docs, reason = "said of each kind")]
pub enum Formula {
    /// A number.
    Number(u64),
    /// A parameter, a let, a fact or the number of a round.
    Name { name: String },
    /// 1 if an axis has a value, else 0.
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
    pub(crate) static EVALUATED: Cell<u64> = const { Cell::new(0) };
}

/// How many formulas this thread has evaluated so far: what executes a frame evaluates none.
pub fn evaluated() -> u64 {
    EVALUATED.get()
}

const OVERFLOW: &str = "the result exceeds 64 bits";
const ZERO: &str = "division by zero";

/// What an operation makes of numbers.
pub(crate) fn apply(symbol: &str, numbers: &[u64]) -> Result<u64, &'static str> {
    let by = |b: u64| u32::try_from(b).ok();
    match (symbol, numbers) {
        ("!", &[a]) => Ok(u64::from(a == 0)),
        ("bits", &[a]) => Ok(u64::from(u64::BITS - a.leading_zeros())),
        ("log2", &[a]) => a.checked_ilog2().map(u64::from).ok_or("the logarithm of 0"),
        ("pow2_ceil", &[a]) => a.checked_next_power_of_two().ok_or(OVERFLOW),
        ("==", &[a, b]) => Ok(u64::from(a == b)),
        ("!=", &[a, b]) => Ok(u64::from(a != b)),
        ("<=", &[a, b]) => Ok(u64::from(a <= b)),
        (">=", &[a, b]) => Ok(u64::from(a >= b)),
        ("<", &[a, b]) => Ok(u64::from(a < b)),
        (">", &[a, b]) => Ok(u64::from(a > b)),
        ("<<", &[a, b]) => {
            by(b).and_then(|by| 1_u64.checked_shl(by)?.checked_mul(a)).ok_or(OVERFLOW)
        }
        (">>", &[a, b]) => Ok(by(b).and_then(|by| a.checked_shr(by)).unwrap_or(0)),
        ("+", &[a, b]) => a.checked_add(b).ok_or(OVERFLOW),
        ("-", &[a, b]) => a.checked_sub(b).ok_or("a negative difference"),
        ("*", &[a, b]) => a.checked_mul(b).ok_or(OVERFLOW),
        ("/", &[a, b]) => a.checked_div(b).ok_or(ZERO),
        ("%", &[a, b]) => a.checked_rem(b).ok_or(ZERO),
        ("div_ceil", &[_, 0]) => Err(ZERO),
        ("div_ceil", &[a, b]) => Ok(a.div_ceil(b)),
        ("min", &[a, b]) => Ok(a.min(b)),
        ("max", &[a, b]) => Ok(a.max(b)),
        _ => Err("unknown operation"),
    }
}

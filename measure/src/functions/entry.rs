//! An entry of the table of functions.

use crate::function::Function;

/// An entry whose oracle is generic: the same formula with and without its tolerance. It has the function's own name
/// unless it is given.
macro_rules! function {
    ($name:ident($($arguments:tt)*) -> [$($results:tt)*], $field:ident: $($rest:tt)*) => {
        crate::functions::entry::function!(
            $name($($arguments)*) -> [$($results)*], $name, $field: $($rest)*
        )
    };
    ($name:ident($($kind:ident @ $at:literal),*) -> [$($result:literal),+], $oracle:ident, $($rest:tt)*) => {
        crate::function::Function {
            results: &[$($result),+],
            arguments: &[$(crate::input::argument(crate::input::Kind::$kind, $at)),*],
            oracle: $oracle::<f64>,
            bounded: $oracle::<sglow_oracle::Bounded>,
            $($rest)*
            ..crate::functions::entry::plain(stringify!($name))
        }
    };
}
pub(crate) use function;

/// What most functions are: never negative, at most 1, without a reference of their own.
pub(crate) const fn plain(name: &'static str) -> Function {
    Function {
        name,
        results: &[],
        arguments: &[],
        oracle: |_| [0.0; 4],
        bounded: |_| [sglow_oracle::Bounded { value: 0.0, error: 0.0 }; 4],
        reference: None,
        slow_reference: false,
        peak: crate::function::unit,
        floor: 0.0,
        never_negative: true,
        monotone: None,
        literal: false,
    }
}

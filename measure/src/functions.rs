//! The table of functions: what each takes, its oracle and its truth. One file per folder of `shaders/src`.

mod asg;
mod brdf;
mod math;
mod sg;
mod vmf;
mod vsgl;

use crate::function::Function;

/// An entry whose oracle is generic: the same formula with and without its tolerance. It has the function's own name
/// unless it is given.
macro_rules! function {
    ($name:ident($($arguments:tt)*) -> [$($results:tt)*], $field:ident: $($rest:tt)*) => {
        crate::functions::function!(
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
            ..crate::functions::plain(stringify!($name))
        }
    };
}
pub(crate) use function;

/// What most functions are: never negative, at most 1, without a truth of their own.
pub(crate) const fn plain(name: &'static str) -> Function {
    Function {
        name,
        results: &[],
        arguments: &[],
        oracle: |_| [0.0; 4],
        bounded: |_| [sglow_oracle::Bounded { value: 0.0, error: 0.0 }; 4],
        truth: None,
        slow_truth: false,
        peak: crate::function::unit,
        floor: 0.0,
        never_negative: true,
        monotone: None,
        literal: false,
    }
}

/// Every function of the library.
#[must_use]
pub fn all() -> Vec<Function> {
    [
        math::FUNCTIONS,
        sg::FUNCTIONS,
        vmf::FUNCTIONS,
        asg::FUNCTIONS,
        brdf::FUNCTIONS,
        vsgl::FUNCTIONS,
    ]
    .concat()
}

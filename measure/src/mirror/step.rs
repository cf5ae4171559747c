//! What a mirrored function is made of.

use thiserror::Error;

use super::operation::Operation;

/// Why a function is not mirrored.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum MirrorError {
    /// The module has no such function.
    #[error("the module has no function '{name}'; it has: {}", known.join(", "))]
    NoFunction {
        /// What was requested.
        name: String,
        /// What there is.
        known: Vec<String>,
    },
    /// The function does something that is not mirrored.
    #[error("function '{function}' cannot be mirrored on the CPU: {what}")]
    Unsupported {
        /// The function.
        function: String,
        /// What it does.
        what: String,
    },
}

/// A scalar's place in the register file.
pub(super) type Register = u32;

/// An operation on scalars.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) operation: Operation,
    pub(super) to: Register,
    pub(super) operands: [Register; 3],
}

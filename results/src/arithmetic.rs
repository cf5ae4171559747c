//! What a driver may make of arithmetic that is written in a shader.

/// A way to evaluate floating-point arithmetic that GPU languages allow, or that drivers were seen to use.
///
/// No shading language of this project forbids reassociation: naga emits no `NoContraction`, and lavapipe turns
/// `(x + 1e8) - 1e8` into `x`. A function whose result moves beyond the language's grant between these depends on the
/// order of its operations, and has to be written in another form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Arithmetic {
    /// Every operation as it is written, correctly rounded.
    Written,
    /// Every `a * b + c` rounded once.
    Contracted,
    /// Sums and products in an order drawn by this seed, after taking apart parentheses; terms and factors that cancel
    /// are gone; a division is a product with the reciprocal.
    Reassociated(u64),
    /// Subnormal numbers are zero, before and after every operation.
    Flushed,
    /// Every operation off by up to what the Vulkan specification grants it, drawn by this seed.
    Granted(u64),
}

impl Arithmetic {
    /// One of each, and as many orders and errors as make a failure unlikely to hide.
    pub const ALL: [Self; 9] = [
        Self::Written,
        Self::Contracted,
        Self::Flushed,
        Self::Reassociated(1),
        Self::Reassociated(2),
        Self::Reassociated(3),
        Self::Reassociated(4),
        Self::Granted(1),
        Self::Granted(2),
    ];

    /// A name for tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Written => "as written",
            Self::Contracted => "contracted",
            Self::Reassociated(_) => "reassociated",
            Self::Flushed => "flushed",
            Self::Granted(_) => "granted",
        }
    }
}

//! naga's verdict on a finished text.

use crate::matrix::Variant;

/// A variant that is finished: pruned, proved equal to what it was pruned from, and valid.
#[derive(Clone, Debug)]
pub struct Validated {
    /// What it is.
    pub variant: Variant,
    /// The final WGSL, whole and commented.
    pub text: String,
    /// naga's representation of [`Validated::text`].
    pub module: naga::Module,
    /// naga's analysis of [`Validated::module`].
    pub info: naga::valid::ModuleInfo,
    /// Declarations of the library's modules that the text lacks, sorted by name.
    pub omitted: Vec<Omitted>,
}

/// A declaration that a variant does without.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Omitted {
    /// Its name.
    pub name: String,
    /// `function`, `struct`, `alias`, `const`, `override`, `var`.
    pub kind: String,
    /// Why the variant does without it.
    pub reason: String,
}

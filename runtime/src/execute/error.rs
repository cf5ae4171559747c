//! Errors of [`super::Executor`].

use std::collections::BTreeSet;

use thiserror::Error;

use crate::package::PackageError;
use crate::pipeline::PipelineError;

/// One thing that is wrong.
#[derive(Debug, Error)]
pub enum Fault {
    /// The package lacks a variant, or its text was changed.
    #[error("{error}; make it by: cargo xtask gen-shaders --out DIR{}", if set.is_empty() { String::new() } else { format!(" --set {set}") })]
    Variant {
        /// Why.
        error: PackageError,
        /// Its values on axes, as the command takes them.
        set: String,
    },
    /// A variant does not become a pipeline.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// The device refuses a resource.
    #[error("{what} cannot be made on this device: {message}")]
    Device {
        /// What was to be made.
        what: String,
        /// What the device says.
        message: String,
    },
    /// A resource is larger than this device allows.
    #[error("resource `{name}` is {kind}; this device allows {limit}")]
    Limit {
        /// The resource.
        name: String,
        /// What it has to be.
        kind: String,
        /// What would be right.
        limit: String,
    },
    /// The package does not say how a variant is bound.
    #[error(
        "the package {origin} does not say what variant '{variant}' binds; generate it again: cargo xtask gen-shaders --out DIR"
    )]
    NoInterface {
        /// The variant.
        variant: String,
        /// Where the package comes from.
        origin: String,
    },
    /// A step gives nothing for a binding, or something else than it takes.
    #[error("{place}: variant '{variant}' binds `{binding}`, {problem}")]
    Binding {
        /// The step.
        place: String,
        /// The variant.
        variant: String,
        /// The binding.
        binding: String,
        /// What is wrong with what is given.
        problem: String,
    },
    /// A member of a uniform has no value, or one of another type.
    #[error("{place}: uniform `{binding}` of variant '{variant}', member `{member}`: {problem}")]
    Member {
        /// The step.
        place: String,
        /// The variant.
        variant: String,
        /// The uniform.
        binding: String,
        /// The member.
        member: String,
        /// What is wrong.
        problem: String,
    },
    /// A step is not what it has to be.
    #[error("{place}: {problem}")]
    Step {
        /// The step.
        place: String,
        /// What is wrong.
        problem: String,
    },
    /// The host has left an input out.
    #[error("input `{name}` is left out; it is of type {kind}")]
    InputLeftOut {
        /// The input.
        name: String,
        /// What it has to be.
        kind: String,
    },
    /// The host gives something else than an input is.
    #[error("input `{name}` is {found}; it has to be of type {kind}")]
    Input {
        /// The input.
        name: String,
        /// What was given.
        found: String,
        /// What it has to be.
        kind: String,
    },
    /// The host has left a resource out.
    #[error("resource `{name}` is left out; it is {kind}")]
    ResourceLeftOut {
        /// The resource.
        name: String,
        /// What it has to be.
        kind: String,
    },
    /// The host gives something else than a resource is.
    #[error("resource `{name}` is {found}; it has to be {kind}")]
    Resource {
        /// The resource.
        name: String,
        /// What was given.
        found: String,
        /// What it has to be.
        kind: String,
    },
    /// The host has left a list of draws out.
    #[error("the list of draws `{name}` is left out")]
    ListLeftOut {
        /// The list.
        name: String,
    },
}

/// Everything that is wrong; never empty.
#[derive(Debug, Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct Faults(pub Vec<Fault>);

impl Faults {
    /// Each of them once: steps may share what is missing.
    pub(super) fn none_of(mut faults: Vec<Fault>) -> Result<(), Self> {
        let mut known = BTreeSet::new();
        faults.retain(|fault| known.insert(fault.to_string()));
        if faults.is_empty() { Ok(()) } else { Err(Self(faults)) }
    }
}

impl Fault {
    /// What the device says of something that is no variant.
    pub(super) fn of_device(what: &str, error: PipelineError) -> Self {
        match error {
            PipelineError::Refused { message, .. } => {
                Self::Device { what: what.to_owned(), message }
            }
            error => Self::Pipeline(error),
        }
    }
}

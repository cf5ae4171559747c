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
    /// A step is not what it has to be, or does not fit what its variant binds.
    #[error("{place}: {problem}")]
    Step {
        /// The step.
        place: String,
        /// What is wrong.
        problem: String,
    },
    /// The host leaves out an input, a resource or a list of draws, or supplies another one than that has to be.
    #[error("{name} is {found}; it has to be {expected}")]
    Supplied {
        /// What it is called.
        name: String,
        /// What it is.
        found: String,
        /// What would be right.
        expected: String,
    },
}

/// Everything that is wrong; never empty.
#[derive(Debug, Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct Faults(pub Vec<Fault>);

impl Faults {
    /// One thing that the host supplies and that has to be another.
    pub(crate) fn of(name: &str, found: String, expected: String) -> Self {
        Self(vec![Fault::Supplied { name: name.to_owned(), found, expected }])
    }

    /// Each of them once: steps may share what is missing.
    pub(super) fn none_of(mut faults: Vec<Fault>) -> Result<(), Self> {
        let mut known = BTreeSet::new();
        faults.retain(|fault| known.insert(fault.to_string()));
        if faults.is_empty() { Ok(()) } else { Err(Self(faults)) }
    }
}

impl Fault {
    pub(super) fn list_left_out(name: &str) -> Self {
        Self::Supplied {
            name: format!("list of draws `{name}`"),
            found: "left out".to_owned(),
            expected: "among the lists of the host".to_owned(),
        }
    }
}

//! What has become of the files of a package, and how they differ from what they should be.

use std::fmt;

/// What has become of the files of a package, each relative to its folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Written, because they were missing or different.
    pub written: Vec<String>,
    /// Left alone, because they were the same.
    pub unchanged: Vec<String>,
    /// Removed, because nothing generates them any more.
    pub removed: Vec<String>,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (written, removed) = (self.written.len(), self.removed.len());
        let total = written + self.unchanged.len();
        if written + removed == 0 {
            return write!(f, "{total} files, all as they should be");
        }
        write!(f, "{total} files, {written} written, {removed} removed")
    }
}

/// How a file differs from what it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Change {
    /// It is not there.
    Missing,
    /// Its hash is not the one in `SHA256SUMS`: it was changed after it was generated.
    ByHand,
    /// The sources have changed since it was generated.
    Outdated,
    /// It was generated once, but nothing generates it any more.
    Stale,
    /// It was never generated.
    Extra,
}

/// A file that is not what it should be.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Difference {
    /// Relative to the folder of the package.
    pub path: String,
    /// How it differs.
    pub change: Change,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.change {
            Change::Missing => "is missing",
            Change::ByHand => "was changed by hand",
            Change::Outdated => "is out of date",
            Change::Stale => "is no longer generated",
            Change::Extra => "is not part of the package",
        };
        write!(f, "{}: {what}", self.path)
    }
}

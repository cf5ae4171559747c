//! Progress of long measurements.

/// Receives the progress of long work.
pub trait Progress: Sync {
    /// What comes next, and of how many steps; 0 if nobody knows.
    fn start(&self, what: &str, steps: usize);
    /// How many steps are done.
    fn done(&self, steps: usize);
    /// A line that a user should read.
    fn note(&self, _text: &str) {}
    /// What was started has ended.
    fn end(&self) {}
}

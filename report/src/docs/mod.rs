//! Measured tables within documents that people write.

pub mod deviations;
pub mod frontier;
pub mod marks;
pub mod references;

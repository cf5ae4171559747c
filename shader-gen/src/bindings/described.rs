//! What bindings are made of.

use std::sync::Arc;

use crate::manifest::{self, Layout};

/// A variant with the layouts of the structs in its buffers.
pub struct Described<'a> {
    /// What the manifest says of it.
    pub variant: &'a manifest::Described,
    /// Its structs.
    pub layouts: &'a [Arc<Layout>],
}

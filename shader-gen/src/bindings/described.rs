//! The input of the generator of bindings.

use std::sync::Arc;

use crate::manifest::{self, Layout};

/// A variant with the layouts of the structs in its buffers.
pub struct Described<'a> {
    /// Its entry in the manifest.
    pub variant: &'a manifest::Described,
    /// Its structs.
    pub layouts: &'a [Arc<Layout>],
}

//! Threads for what recurses deeply.

use std::sync::OnceLock;

use rayon::{ThreadPool, ThreadPoolBuilder};

/// Bytes of the stack of a thread: naga recurses into nested expressions and blocks, with large stack frames.
const STACK: usize = 64 << 20;

/// Runs `work` on threads with [`STACK`], one for each core.
pub(crate) fn deep<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    static POOL: OnceLock<Option<ThreadPool>> = OnceLock::new();
    let pool = || ThreadPoolBuilder::new().stack_size(STACK).build().ok();
    match POOL.get_or_init(pool) {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

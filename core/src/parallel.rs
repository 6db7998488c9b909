//! The one door through which loops run in parallel: rayon natively, in order in the browser, the same answer on both.

/// Applies `work` to every item and keeps the order of the items.
#[cfg(not(target_arch = "wasm32"))]
pub fn map<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    use rayon::prelude::*;
    items.par_iter().map(work).collect()
}

/// Applies `work` to every item and keeps the order of the items.
#[cfg(target_arch = "wasm32")]
pub fn map<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    items.iter().map(work).collect()
}

/// Does the work with every [`map`] inside it running in order, on one thread: for times that mean something.
#[cfg(not(target_arch = "wasm32"))]
pub fn on_one_thread<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(work),
        // A machine that has no thread to spare has no other threads to disturb either.
        Err(_) => work(),
    }
}

/// Does the work, in order as always.
#[cfg(target_arch = "wasm32")]
pub fn on_one_thread<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    work()
}

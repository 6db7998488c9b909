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

/// What came of trying one item after the other: why those before the first that worked did not, and that one.
pub struct Tried<R, E> {
    /// In the order of the items.
    pub failed: Vec<E>,
    /// Index of the first item that worked, and what it gave.
    pub worked: Option<(usize, R)>,
}

/// Tries items in their order until one works. Further ones may be tried meanwhile; they are told when they are not
/// needed any more, and what comes of them is not told.
#[cfg(not(target_arch = "wasm32"))]
pub fn first<T: Sync, R: Send, E: Send>(
    items: &[T],
    work: impl Fn(&T, &(dyn Fn() -> bool + Sync)) -> Result<R, E> + Sync,
) -> Tried<R, E> {
    use rayon::prelude::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    let at_once = rayon::current_num_threads().max(1);
    let mut failed = Vec::new();
    for (number, some) in items.chunks(at_once).enumerate() {
        let best = AtomicUsize::new(usize::MAX);
        let tried = some.par_iter().enumerate().map(|(index, item)| {
            let is_beaten = || best.load(Ordering::Relaxed) < index;
            let result = (!is_beaten()).then(|| work(item, &is_beaten));
            if matches!(result, Some(Ok(_))) {
                best.fetch_min(index, Ordering::Relaxed);
            }
            result
        });
        let tried: Vec<Option<Result<R, E>>> = tried.collect();
        // Only what follows one that worked is left out.
        for (index, result) in tried.into_iter().flatten().enumerate() {
            match result {
                Ok(found) => return Tried { failed, worked: Some((number * at_once + index, found)) },
                Err(error) => failed.push(error),
            }
        }
    }
    Tried { failed, worked: None }
}

/// Tries items in their order until one works.
#[cfg(target_arch = "wasm32")]
pub fn first<T: Sync, R: Send, E: Send>(
    items: &[T],
    work: impl Fn(&T, &(dyn Fn() -> bool + Sync)) -> Result<R, E> + Sync,
) -> Tried<R, E> {
    let mut failed = Vec::new();
    for (index, item) in items.iter().enumerate() {
        match work(item, &|| false) {
            Ok(found) => return Tried { failed, worked: Some((index, found)) },
            Err(error) => failed.push(error),
        }
    }
    Tried { failed, worked: None }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_that_works_is_told_whatever_others_do_meanwhile() {
        let items: Vec<usize> = (0..40).collect();
        for wanted in [0, 1, 7, 39, 40] {
            let tried = first(&items, |&item, _| if item >= wanted { Ok(item) } else { Err(item) });
            assert_eq!(tried.failed, items[..wanted.min(40)]);
            assert_eq!(tried.worked, items.get(wanted).map(|&item| (item, item)));
        }
    }

    #[test]
    fn the_same_is_told_on_one_thread() {
        let work = |&item: &u32, _: &(dyn Fn() -> bool + Sync)| if item % 3 == 2 { Ok(item) } else { Err(item) };
        let told = |tried: Tried<u32, u32>| (tried.failed, tried.worked);
        let items = [0, 1, 3, 4, 5, 8];
        assert_eq!(told(first(&items, work)), told(on_one_thread(|| first(&items, work))));
    }
}

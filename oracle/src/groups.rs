//! Work on a picture's surfaces in groups, on all cores, that can be followed and stopped.

use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

/// What `work` makes of `surfaces`, in their order; it is given groups of at most `size`, each with the number of its
/// first surface.
///
/// `progress` is called from several threads with the number of surfaces done so far, and says whether to go on;
/// `None` if it said no.
pub(crate) fn in_groups<S: Sync, T: Clone + Send>(
    surfaces: &[S],
    size: usize,
    progress: &(dyn Fn(usize) -> bool + Sync),
    work: impl Fn(usize, &[S]) -> Vec<T> + Sync,
) -> Option<Vec<T>> {
    let (done, go_on) = (AtomicUsize::new(0), AtomicBool::new(true));
    let groups: Vec<Vec<T>> = surfaces
        .par_chunks(size)
        .enumerate()
        .map(|(number, group)| {
            if !go_on.load(Ordering::Relaxed) {
                return Vec::new();
            }
            let made = work(number * size, group);
            if !progress(done.fetch_add(group.len(), Ordering::Relaxed) + group.len()) {
                go_on.store(false, Ordering::Relaxed);
            }
            made
        })
        .collect();
    go_on.into_inner().then(|| groups.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_come_in_order_and_stop_on_request() {
        let numbers: Vec<usize> = (0..1000).collect();
        let most = AtomicUsize::new(0);
        let report = |done| {
            most.fetch_max(done, Ordering::Relaxed);
            true
        };
        let same = |first: usize, group: &[usize]| {
            assert_eq!(first, group[0]);
            group.to_vec()
        };
        assert_eq!(in_groups(&numbers, 7, &report, same), Some(numbers.clone()));
        assert_eq!(most.into_inner(), 1000);
        assert_eq!(in_groups(&numbers, 7, &|_| false, same), None);
        assert_eq!(in_groups(&[], 7, &|_| false, same), Some(Vec::new()));
    }
}

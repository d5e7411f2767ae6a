//! Work on kernels on all cores.
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// What `work` makes of each item, in order. All cores share the items, each taking the next one when it is done with one: one kernel may
/// take as long to compile as ten others together. A panic of `work` goes on in the caller.
pub fn on_all_cores<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::with_capacity(items.len()));
    let run = || {
        while let Some((i, item)) = {
            let i = next.fetch_add(1, Ordering::Relaxed);
            items.get(i).map(|item| (i, item))
        } {
            let result = work(item);
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            done.push((i, result));
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 1..cores.min(items.len()) {
            scope.spawn(run);
        }
        run();
    });
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_stand_in_the_order_of_their_items() {
        let items: Vec<usize> = (0..100).collect();
        // The first is done last, where there is a second core.
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let others = AtomicUsize::new(0);
        let squares = on_all_cores(&items, |&i| {
            while i == 0 && cores > 1 && others.load(Ordering::Relaxed) < 99 {
                std::thread::yield_now();
            }
            others.fetch_add(1, Ordering::Relaxed);
            i * i
        });
        let expected: Vec<usize> = (0..100).map(|i| i * i).collect();
        assert_eq!(squares, expected);
        assert!(on_all_cores(&[], |(): &()| ()).is_empty());
    }
}

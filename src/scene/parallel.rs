//! A small ordered parallel map on scoped threads, enough for textures.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

/// `f` of every item, in order, on as many threads as the machine has; `on_done` hears the running count.
pub(super) fn parallel_map<T, R>(items: &[T], f: impl Fn(&T) -> R + Sync, on_done: &mut dyn FnMut(usize)) -> Vec<R>
where
    T: Sync,
    R: Send,
{
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(items.len());
    let next = AtomicUsize::new(0);
    let mut results: Vec<Option<R>> = items.iter().map(|_| None).collect();
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        for _ in 0..threads {
            let (sender, next, f) = (sender.clone(), &next, &f);
            scope.spawn(move || {
                while let Some((i, item)) =
                    Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|i| Some((i, items.get(i)?)))
                {
                    if sender.send((i, f(item))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        for (done, (i, result)) in receiver.iter().enumerate() {
            results[i] = Some(result);
            on_done(done + 1);
        }
    });
    // A worker that panicked makes the scope panic above, so every slot is filled here.
    results.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_order_and_reports_progress() {
        let items: Vec<u32> = (0..100).collect();
        let mut last = 0;
        let out = parallel_map(&items, |x| x * 2, &mut |done| last = done);
        assert_eq!(out, (0..100).map(|x| x * 2).collect::<Vec<_>>());
        assert_eq!(last, 100);
        assert!(parallel_map(&[0u32; 0], |x| *x, &mut |_| ()).is_empty());
    }
}

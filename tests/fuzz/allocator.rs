//! Counts the memory that the program has in use, so that a small file that asks for much is noticed.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

static IN_USE: AtomicUsize = AtomicUsize::new(0);
static MOST_IN_USE: AtomicUsize = AtomicUsize::new(0);

/// More than any file of the corpus may lead to, and less than what troubles the machine: beyond, allocations fail.
const LIMIT_BYTES: usize = 3 << 30;

/// The system's allocator, counting.
pub struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn add(bytes: usize) -> bool {
    let now = IN_USE.fetch_add(bytes, Relaxed) + bytes;
    MOST_IN_USE.fetch_max(now, Relaxed);
    now <= LIMIT_BYTES
}

// SAFETY: every call is passed on as it came to the system's allocator, or answered with null, which means that there is
// no memory. Counting touches atomics alone.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let fits = add(layout.size());
        // SAFETY: the caller keeps the contract of `alloc`.
        let memory = if fits { unsafe { System.alloc(layout) } } else { std::ptr::null_mut() };
        if memory.is_null() {
            IN_USE.fetch_sub(layout.size(), Relaxed);
        }
        memory
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        let fits = add(layout.size());
        // SAFETY: the caller keeps the contract of `alloc_zeroed`.
        let memory = if fits { unsafe { System.alloc_zeroed(layout) } } else { std::ptr::null_mut() };
        if memory.is_null() {
            IN_USE.fetch_sub(layout.size(), Relaxed);
        }
        memory
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller keeps the contract of `dealloc`, and all memory is the system's.
        unsafe { System.dealloc(memory, layout) }
    }
}

/// What `work` returns, and the most bytes that were in use at once meanwhile, beyond those in use before.
pub fn measure<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = IN_USE.load(Relaxed);
    MOST_IN_USE.store(before, Relaxed);
    let result = work();
    (result, MOST_IN_USE.load(Relaxed).saturating_sub(before))
}

//! An allocator that counts its calls and the bytes in use, thread by thread. For test files that are about nothing else.
#![allow(
    dead_code,
    reason = "each test file is a crate of its own and uses a part"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

struct Counting;

thread_local! {
    static CALLS: Cell<u64> = const { Cell::new(0) };
    static BYTES: Cell<isize> = const { Cell::new(0) };
}

static CALLS_OF_ALL: AtomicU64 = AtomicU64::new(0);

/// A call that takes `more` bytes.
fn count(more: isize) {
    CALLS_OF_ALL.fetch_add(1, Relaxed);
    // A thread that is shutting down has no counter any more, and runs no test.
    let _ = CALLS.try_with(|calls| calls.set(calls.get() + 1));
    let _ = BYTES.try_with(|bytes| bytes.set(bytes.get() + more));
}

// SAFETY: every call goes to the system allocator unchanged; counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller's promises are those of `System`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: as above; `pointer` came from `System`.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size as isize - layout.size() as isize);
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Calls to the allocator made by this thread during `work`.
pub fn allocator_calls(work: impl FnOnce()) -> u64 {
    let before = CALLS.get();
    work();
    CALLS.get() - before
}

/// Calls made by all threads meanwhile: for a test that runs alone.
pub fn allocator_calls_of_all_threads(work: impl FnOnce()) -> u64 {
    let before = CALLS_OF_ALL.load(Relaxed);
    work();
    CALLS_OF_ALL.load(Relaxed) - before
}

/// What `make` makes, and the bytes that are in use for it.
pub fn held<T>(make: impl FnOnce() -> T) -> (T, usize) {
    let before = BYTES.get();
    let made = make();
    (made, (BYTES.get() - before).unsigned_abs())
}

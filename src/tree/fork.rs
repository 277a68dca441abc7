//! Runs parts of a computation on threads, if that pays.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::ops::Range;

/// Least number of triangles that is worth a thread.
const LEAST_TRIANGLES: usize = 4096;

/// Limits of a parallel computation: the maximum number of threads, and the maximum number of
/// pieces into which it may still be cut.
#[derive(Clone, Copy)]
pub(crate) struct Pieces {
    threads: usize,
    count: usize,
}

impl Pieces {
    /// Limits for a mesh of `triangles` and at most `threads` threads. There are more pieces than
    /// threads, because pieces differ in cost.
    pub fn new(threads: usize, triangles: usize) -> Self {
        if threads < 2 || !cfg!(feature = "parallel") {
            return Self::ONE;
        }
        Self {
            threads,
            count: threads
                .saturating_mul(4)
                .min(triangles / LEAST_TRIANGLES)
                .max(1),
        }
    }

    /// A computation in one piece.
    pub const ONE: Self = Self {
        threads: 1,
        count: 1,
    };

    /// Size of the pieces of a slice of this length, at least 1.
    pub fn size(self, length: usize) -> usize {
        length.div_ceil(self.count).max(1)
    }

    pub fn count(self) -> usize {
        self.count
    }

    /// Runs both closures, in parallel if pieces are left. Each closure gets pieces in proportion
    /// to its entry in `sizes`.
    pub fn join(self, sizes: [usize; 2], a: impl FnOnce(Self) + Send, b: impl FnOnce(Self) + Send) {
        if self.count < 2 {
            a(self);
            return b(self);
        }
        let share = (self.count as u128 * sizes[0] as u128
            / (sizes[0] as u128 + sizes[1] as u128).max(1)) as usize;
        let share = share.clamp(1, self.count - 1);
        let of = |count| Self { count, ..self };
        let both: [Box<dyn FnOnce() + Send>; 2] = [
            Box::new(|| a(of(share))),
            Box::new(|| b(of(self.count - share))),
        ];
        self.each(both.into(), |one| one());
    }

    /// Runs all tasks. Each thread takes the next task when it has finished one.
    pub fn each<T: Send>(self, tasks: Vec<T>, work: impl Fn(T) + Sync) {
        let threads = self.threads.min(tasks.len());
        if threads < 2 {
            tasks.into_iter().for_each(work)
        } else {
            share(threads, tasks, &work)
        }
    }
}

/// Cuts a slice into disjoint pieces, in its order.
pub(crate) fn split<T>(
    mut slice: &mut [T],
    ranges: impl Iterator<Item = Range<usize>>,
) -> Vec<&mut [T]> {
    let mut begin = 0;
    let mut pieces = Vec::new();
    for range in ranges {
        let (piece, rest) = slice
            .split_at_mut(range.start - begin)
            .1
            .split_at_mut(range.len());
        (slice, begin) = (rest, range.end);
        pieces.push(piece);
    }
    pieces
}

#[cfg(not(feature = "parallel"))]
fn share<T>(_: usize, tasks: Vec<T>, work: &impl Fn(T)) {
    tasks.into_iter().for_each(work);
}

#[cfg(feature = "parallel")]
fn share<T: Send>(threads: usize, tasks: Vec<T>, work: &(impl Fn(T) + Sync)) {
    let tasks = std::sync::Mutex::new(tasks.into_iter());
    let next = || tasks.lock().ok()?.next();
    let run = || {
        while let Some(task) = next() {
            work(task);
        }
    };
    let done = crossbeam_utils::thread::scope(|scope| {
        for _ in 1..threads {
            // If a thread cannot be spawned, the others do its share.
            let _ = scope.builder().spawn(|_| run());
        }
        run();
    });
    done.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
}

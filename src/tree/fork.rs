//! Two halves of a computation, at the same time where that pays.

/// How many pieces, to be computed in threads, what is left may be cut into.
#[derive(Clone, Copy)]
pub(super) struct Pieces(usize);

/// Fewer triangles are not worth a thread.
const LEAST_TRIANGLES: usize = 4096;

impl Pieces {
    /// For `triangles` and at most `threads` threads. More pieces than threads, because pieces are not alike.
    pub fn new(threads: usize, triangles: usize) -> Self {
        if threads < 2 || !cfg!(feature = "parallel") {
            return Self(1);
        }
        Self(threads.saturating_mul(4).min(triangles / LEAST_TRIANGLES).max(1))
    }

    pub fn is_one(self) -> bool {
        self.0 == 1
    }

    /// Runs both, which have the given sizes, and shares the pieces between them.
    pub fn join<A: Send, B: Send>(
        self,
        sizes: [usize; 2],
        a: impl FnOnce(Self) -> A + Send,
        b: impl FnOnce(Self) -> B + Send,
    ) -> (A, B) {
        if self.0 < 2 {
            return (a(self), b(self));
        }
        let share = (self.0 as u128 * sizes[0] as u128 / (sizes[0] as u128 + sizes[1] as u128).max(1)) as usize;
        let share = share.clamp(1, self.0 - 1);
        in_threads(|| a(Self(share)), || b(Self(self.0 - share)))
    }
}

#[cfg(not(feature = "parallel"))]
fn in_threads<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    (a(), b())
}

#[cfg(feature = "parallel")]
fn in_threads<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    use std::sync::Mutex;
    // A thread that the system refuses would take `a` with it.
    let slot = Mutex::new(Some(a));
    let take = || slot.lock().ok().and_then(|mut slot| slot.take()).map(|a| a());
    let both = crossbeam_utils::thread::scope(|scope| {
        let thread = scope.builder().spawn(|_| take());
        let b = b();
        let a = match thread {
            Ok(thread) => thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
            Err(_) => None,
        };
        (a, b)
    });
    let (a, b) = both.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    (a.or_else(take).expect("taken once, by the thread or here"), b)
}

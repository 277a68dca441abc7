//! Ctrl-C during a call, which does not have the interpreter's lock.

use punctual::Clock;
use punctual::clock::SystemClock;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::cell::Cell;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Time between two looks whether the user cancels a call.
pub const BETWEEN_LOOKS: Duration = Duration::from_millis(50);

/// Whether a call is cancelled, for all of its threads. As their clock, it is that of the system.
#[derive(Default)]
pub struct Interrupt {
    is_set: AtomicBool,
    /// What the handler of the signal raised.
    raised: Mutex<Option<PyErr>>,
}

impl Interrupt {
    pub fn is_set(&self) -> bool {
        self.is_set.load(Ordering::Relaxed)
    }

    /// Ends the call, with an error if the interpreter has one.
    pub fn set(&self, raised: Option<PyErr>) {
        *self.raised.lock().unwrap_or_else(PoisonError::into_inner) = raised;
        self.is_set.store(true, Ordering::Relaxed);
    }

    /// The answer of the call, unless the user cancelled it.
    pub fn end<R>(self, answer: R) -> PyResult<R> {
        self.raised
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
            .map_or(Ok(answer), Err)
    }
}

impl Clock for Interrupt {
    fn now(&self) -> Duration {
        SystemClock::default().now()
    }

    fn is_cancelled(&self) -> bool {
        self.is_set()
    }
}

/// How far a call with many items is: a callable that is told how many are done, and of how many.
#[derive(Default)]
pub struct Progress {
    callback: Option<Py<PyAny>>,
    done: AtomicUsize,
    total: usize,
}

impl Progress {
    pub fn new(callback: Option<Py<PyAny>>, total: usize) -> Self {
        Self {
            callback,
            total,
            ..Self::default()
        }
    }

    pub fn add(&self, items: usize) {
        self.done.fetch_add(items, Ordering::Relaxed);
    }

    pub fn tell(&self, py: Python<'_>) -> PyResult<()> {
        let Some(callback) = &self.callback else {
            return Ok(());
        };
        let told = callback.call1(py, (self.done.load(Ordering::Relaxed), self.total));
        told.map(drop)
    }
}

/// The clock of the thread that made a call: it looks whether the user cancels it, and tells how far it is. Only the
/// interpreter's main thread can see whether it is cancelled; in others no look finds anything.
pub struct Attentive<'i> {
    interrupt: &'i Interrupt,
    progress: &'i Progress,
    /// The last look. None before the first: most calls are shorter than what this would take.
    looked: Cell<Option<Instant>>,
}

impl<'i> Attentive<'i> {
    pub fn new(interrupt: &'i Interrupt, progress: &'i Progress) -> Self {
        Self {
            interrupt,
            progress,
            looked: Cell::new(None),
        }
    }
}

impl Clock for Attentive<'_> {
    fn now(&self) -> Duration {
        self.interrupt.now()
    }

    fn is_cancelled(&self) -> bool {
        if self.interrupt.is_set() {
            return true;
        }
        let now = Instant::now();
        let last = self.looked.get().unwrap_or_else(|| {
            self.looked.set(Some(now));
            now
        });
        if now - last >= BETWEEN_LOOKS {
            let look = |py: Python<'_>| py.check_signals().and_then(|()| self.progress.tell(py));
            if let Err(raised) = Python::attach(look) {
                self.interrupt.set(Some(raised));
            }
            // The handlers may have taken their time.
            self.looked.set(Some(Instant::now()));
        }
        self.interrupt.is_set()
    }
}

/// Runs what ends soon after the clock says that it is cancelled, without the interpreter's lock.
pub fn cancellable<R: Send>(
    py: Python<'_>,
    run: impl FnOnce(&dyn Clock) -> R + Send,
) -> PyResult<R> {
    py.detach(|| {
        let interrupt = Interrupt::default();
        let answer = run(&Attentive::new(&interrupt, &Progress::default()));
        interrupt.end(answer)
    })
}

/// Runs what cannot be cancelled, such as the build of a tree, in a thread of its own. If the user cancels the call,
/// nobody waits
/// for that thread: it goes on to its end, and what it made is dropped.
pub fn in_background<R: Send + 'static>(
    py: Python<'_>,
    run: impl FnOnce() -> R + Send + 'static,
) -> PyResult<R> {
    py.detach(|| {
        let (made, result) = mpsc::channel();
        thread::Builder::new().spawn(move || made.send(run()))?;
        loop {
            match result.recv_timeout(BETWEEN_LOOKS) {
                Ok(result) => return Ok(result),
                Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals())?,
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(PyRuntimeError::new_err(
                        "the thread of the call ended early",
                    ));
                }
            }
        }
    })
}

//! Threads that run batches, and sleep between frames.
//!
//! A batch goes to a worker and comes back by value, and the bodies are shared. Queues and waits
//! allocate nothing.
//!
//! Waking a thread takes as long as a short frame. So a frame of many pairs wakes all threads when
//! it begins, and they poll for batches for a while before they sleep again.

use super::executor::Executor;
use crate::body::Bodies;
use crate::pair::batch::{Batch, Round, make_room_for_contacts, workspace};
use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::hint::spin_loop;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use core::time::Duration;
use crossbeam_queue::ArrayQueue;
use crossbeam_utils::sync::{Parker, Unparker};
use punctual::Workspace;
use punctual::engine::SYSTEM;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, Builder, JoinHandle};
use std::time::Instant;

/// How long a thread polls before it sleeps: a few times the time that waking it takes.
const LOOKOUT: Duration = Duration::from_micros(200);

/// Number of polls between two yields of the core to other threads.
const LOOKS: usize = 100;

#[derive(Debug)]
struct BatchTask {
    index: usize,
    batch: Batch,
    round: Round,
    bodies: Arc<Bodies>,
}

impl BatchTask {
    /// Drops the bodies before the batch is returned, so that the owner of the scene may change
    /// them. The caller waits for every batch, so even a panic is returned.
    fn run(mut self, scratch: &mut Box<Workspace>) -> Ended {
        catch_unwind(AssertUnwindSafe(move || {
            self.batch.run(&self.bodies, scratch, &self.round, &SYSTEM);
            (self.index, self.batch)
        }))
    }
}

/// The result of a batch.
type Ended = thread::Result<(usize, Batch)>;

/// The state shared by the threads.
#[derive(Debug)]
struct Shared {
    batches: ArrayQueue<BatchTask>,
    ended: ArrayQueue<Ended>,
    caller: Unparker,
    /// Number of threads that have begun.
    begun: AtomicUsize,
    /// True if no more batches will come.
    closed: AtomicBool,
}

impl Shared {
    /// Runs batches until no more will come.
    fn work(&self, scratch: &Mutex<Box<Workspace>>) {
        self.begun.fetch_add(1, Ordering::Release);
        while !self.closed.load(Ordering::Acquire) {
            let Some(task) = poll(|| self.batches.pop()) else {
                thread::park();
                continue;
            };
            let is_room = self.ended.push(task.run(&mut lock(scratch))).is_ok();
            debug_assert!(is_room, "more results than batches");
            self.caller.unpark();
        }
    }
}

/// The first result of `find` within [`LOOKOUT`].
fn poll<R>(find: impl Fn() -> Option<R>) -> Option<R> {
    let began = Instant::now();
    while began.elapsed() < LOOKOUT {
        for _ in 0..LOOKS {
            let found = find();
            if found.is_some() {
                return found;
            }
            spin_loop();
        }
        thread::yield_now();
    }
    None
}

/// A panic under this lock leaves a workspace that the next run overwrites.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[derive(Debug)]
pub(crate) struct Workers {
    shared: Arc<Shared>,
    caller: Mutex<Parker>,
    /// Number of batches that are not back yet.
    out: AtomicUsize,
    /// The threads, and a workspace for each.
    threads: Vec<JoinHandle<()>>,
    scratch: Vec<Arc<Mutex<Box<Workspace>>>>,
}

impl Workers {
    /// Starts threads that help the calling one, for rounds of at most `batches` batches.
    pub fn start(threads: usize, batches: usize) -> io::Result<Self> {
        let caller = Parker::new();
        let shared = Shared {
            batches: ArrayQueue::new(batches),
            ended: ArrayQueue::new(batches),
            caller: caller.unparker().clone(),
            begun: AtomicUsize::new(0),
            closed: AtomicBool::new(false),
        };
        let mut workers = Self {
            shared: Arc::new(shared),
            caller: Mutex::new(caller),
            out: AtomicUsize::new(0),
            threads: Vec::new(),
            scratch: Vec::new(),
        };
        for _ in 0..threads {
            let shared = Arc::clone(&workers.shared);
            let scratch = Arc::new(Mutex::new(workspace()));
            workers.scratch.push(Arc::clone(&scratch));
            let thread = Builder::new().name("punctual".into());
            let thread = thread.spawn(move || shared.work(&scratch))?;
            workers.threads.push(thread);
        }
        // The allocations of starting threads must not fall into a frame.
        while workers.shared.begun.load(Ordering::Acquire) < threads {
            thread::yield_now();
        }
        Ok(workers)
    }

    /// Makes room in the workspaces, between frames, for the contacts of meshes of at most this
    /// many triangles and vertices.
    pub fn make_room_for_contacts(&self, mesh: [usize; 2]) {
        for scratch in &self.scratch {
            make_room_for_contacts(&mut lock(scratch), mesh);
        }
    }

    /// Waits for a batch that a worker runs.
    fn wait(&self) -> Ended {
        loop {
            if let Some(ended) = poll(|| self.shared.ended.pop()) {
                return ended;
            }
            lock(&self.caller).park();
        }
    }
}

impl Executor for Workers {
    fn threads(&self) -> usize {
        self.threads.len() + 1
    }

    fn call(&self) {
        self.threads
            .iter()
            .for_each(|thread| thread.thread().unpark());
    }

    fn begin(&self, first: usize, batches: &mut [Batch], round: &Round, bodies: &Arc<Bodies>) {
        for (index, batch) in (first..)
            .zip(batches)
            .filter(|(_, batch)| !batch.is_empty())
        {
            let task = BatchTask {
                index,
                batch: core::mem::take(batch),
                round: *round,
                bodies: Arc::clone(bodies),
            };
            let is_room = self.shared.batches.push(task).is_ok();
            debug_assert!(is_room, "more tasks than batches");
            self.out.fetch_add(1, Ordering::Relaxed);
        }
        self.call();
    }

    fn finish(
        &self,
        batches: &mut [Batch],
        _: &Round,
        _: &Arc<Bodies>,
        scratch: &mut Box<Workspace>,
        back: &mut dyn FnMut(&mut Batch),
    ) {
        let mut panic = None;
        for _ in 0..self.out.swap(0, Ordering::Relaxed) {
            let ended = match self.shared.batches.pop() {
                Some(task) => task.run(scratch),
                None => self.wait(),
            };
            match ended {
                Ok((index, batch)) => {
                    batches[index] = batch;
                    back(&mut batches[index]);
                }
                Err(payload) => panic = Some(payload),
            }
        }
        if let Some(payload) = panic {
            resume_unwind(payload);
        }
    }
}

impl Drop for Workers {
    fn drop(&mut self) {
        self.shared.closed.store(true, Ordering::Release);
        self.call();
        for thread in self.threads.drain(..) {
            // A thread that panicked needs no further action.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair::batch::RoundKind;
    use crate::pair::state::{PairState, Turn};
    use crate::schedule::known::Known;
    use core::array::from_fn;
    use punctual::Mode;

    #[test]
    fn a_panic_in_a_turn_reaches_the_caller_and_leaves_no_tasks() {
        let workers = Workers::start(1, 4).unwrap();
        let (bodies, mut scratch) = (Arc::default(), workspace());
        let mut run = |frame| {
            let mut batches: [Batch; 4] = from_fn(|_| {
                let mut known = Known::new(1);
                let state = PairState {
                    completed: 7,
                    ..PairState::new(0)
                };
                known.note(&state, 7);
                let mut batch = Batch::new();
                batch.turns.push(Turn::new(known, Box::new(state)));
                batch
            });
            let round = Round {
                kind: RoundKind::Search,
                ..Round::to_the_end(frame, Mode::Any, None)
            };
            let run = || workers.run(&mut batches, &round, &bodies, &mut scratch);
            let ended = catch_unwind(AssertUnwindSafe(run));
            ended.map(|()| batches.map(|batch| batch.turns.len()))
        };
        for _ in 0..10 {
            // A frame before the one that completed the pair does not exist.
            assert!(run(5).is_err());
            assert_eq!(run(9).unwrap(), [1; 4]);
        }
    }
}

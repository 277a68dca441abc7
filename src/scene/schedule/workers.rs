//! Threads that run batches, and wait between frames.
//!
//! A batch goes to a worker and comes back by value, and the bodies are shared, so there is nothing to lock but the lists of
//! tasks. Locks, waits and lists allocate nothing, which is more than the channels of the standard library promise.

use crate::query::{SystemClock, Workspace};
use crate::scene::body::Bodies;
use crate::scene::pair::batch::{Batch, Round, workspace};
use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, Builder, JoinHandle};

#[derive(Debug)]
struct Task {
    index: usize,
    batch: Batch,
    round: Round,
    bodies: Arc<Bodies>,
}

impl Task {
    /// Lets go of the bodies before the batch is given back: the owner of the scene may then change them.
    fn run(mut self, scratch: &mut Box<Workspace>) -> (usize, Batch) {
        self.batch.run(&self.bodies, scratch, &self.round, &SystemClock);
        (self.index, self.batch)
    }
}

#[derive(Debug, Default)]
struct Tasks {
    /// The next one last.
    waiting: Vec<Task>,
    /// What became of those that workers took.
    ended: Vec<thread::Result<(usize, Batch)>>,
    /// Whether no more will come.
    closed: bool,
}

/// What the threads share.
#[derive(Debug, Default)]
struct Shared {
    tasks: Mutex<Tasks>,
    /// There are new tasks, or no more will come.
    begin: Condvar,
    /// A task has ended.
    end: Condvar,
}

impl Shared {
    /// No task runs under the lock, so no panic leaves the lists half changed.
    fn lock(&self) -> MutexGuard<'_, Tasks> {
        self.tasks.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a task; `None` if no more will come.
    fn next(&self) -> Option<Task> {
        let idle = |tasks: &mut Tasks| tasks.waiting.is_empty() && !tasks.closed;
        self.begin.wait_while(self.lock(), idle).unwrap_or_else(PoisonError::into_inner).waiting.pop()
    }

    /// Runs tasks until no more will come.
    fn work(&self) {
        let mut scratch = workspace();
        while let Some(task) = self.next() {
            // The caller waits for every task, so even a panic has to come back to it.
            let ended = catch_unwind(AssertUnwindSafe(|| task.run(&mut scratch)));
            self.lock().ended.push(ended);
            self.end.notify_one();
        }
    }
}

#[derive(Debug)]
pub(crate) struct Workers {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

impl Workers {
    /// Starts threads that help the calling one, for rounds of at most `batches` batches.
    pub fn start(threads: usize, batches: usize) -> io::Result<Self> {
        let mut workers = Self { shared: Arc::default(), threads: Vec::new() };
        let mut tasks = workers.shared.lock();
        (tasks.waiting, tasks.ended) = (Vec::with_capacity(batches), Vec::with_capacity(batches));
        drop(tasks);
        for _ in 0..threads {
            let shared = Arc::clone(&workers.shared);
            workers.threads.push(Builder::new().name("punctual".into()).spawn(move || shared.work())?);
        }
        Ok(workers)
    }

    /// Threads that take part, the calling one included.
    pub fn threads(&self) -> usize {
        self.threads.len() + 1
    }

    /// Runs all batches that are not empty.
    pub fn run(&self, batches: &mut [Batch], round: &Round, bodies: &Arc<Bodies>, scratch: &mut Box<Workspace>) {
        let Shared { begin, end, .. } = &*self.shared;
        let mut tasks = self.shared.lock();
        for (index, batch) in batches.iter_mut().enumerate().rev().filter(|(_, batch)| !batch.turns.is_empty()) {
            let batch = core::mem::take(batch);
            tasks.waiting.push(Task { index, batch, round: *round, bodies: Arc::clone(bodies) });
        }
        let mut away = tasks.waiting.len();
        drop(tasks);
        begin.notify_all();
        loop {
            // Taken in a statement of its own, so that the lock is not held while the task runs.
            let task = self.shared.lock().waiting.pop();
            let Some(task) = task else { break };
            let (index, batch) = task.run(scratch);
            batches[index] = batch;
            away -= 1;
        }
        let waiting = |tasks: &mut Tasks| tasks.ended.len() < away;
        let mut tasks = end.wait_while(self.shared.lock(), waiting).unwrap_or_else(PoisonError::into_inner);
        let mut panic = None;
        for ended in tasks.ended.drain(..) {
            match ended {
                Ok((index, batch)) => batches[index] = batch,
                Err(payload) => panic = Some(payload),
            }
        }
        drop(tasks);
        if let Some(payload) = panic {
            resume_unwind(payload);
        }
    }
}

impl Drop for Workers {
    fn drop(&mut self) {
        self.shared.lock().closed = true;
        self.shared.begin.notify_all();
        for thread in self.threads.drain(..) {
            // Nothing is left to do for one that panicked.
            let _ = thread.join();
        }
    }
}

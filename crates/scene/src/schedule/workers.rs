//! Threads that run batches, and sleep between frames.
//!
//! A batch goes to a worker and comes back by value, and the bodies are shared, so only the lists
//! of tasks need a lock. Locks, waits and lists allocate nothing; the channels of the standard
//! library do not promise that.
//!
//! Waking a thread takes as long as a short frame. So each frame wakes all threads when it begins,
//! and they poll for tasks for a while before they sleep again.

use super::crew::Crew;
use crate::body::Bodies;
use crate::pair::batch::{Batch, Round, make_room_for_contacts, workspace};
use alloc::boxed::Box;
use alloc::collections::VecDeque;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::hint::spin_loop;
use core::sync::atomic::{AtomicUsize, Ordering};
use core::time::Duration;
use crossbeam_utils::Backoff;
use punctual::Workspace;
use punctual::engine::SYSTEM;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::{self, Builder, JoinHandle};
use std::time::Instant;

/// How long a thread polls for tasks before it sleeps: a few times the time that waking it takes.
const LOOKOUT: Duration = Duration::from_micros(200);

/// Number of polls between two yields of the core to other threads.
const LOOKS: usize = 100;

#[derive(Debug)]
struct Task {
    index: usize,
    batch: Batch,
    round: Round,
    bodies: Arc<Bodies>,
}

/// A task with the workspace of the worker that runs it.
type Taken = (Task, Box<Workspace>);

impl Task {
    /// Drops the bodies before the batch is returned, so that the owner of the scene may change
    /// them.
    fn run(mut self, scratch: &mut Box<Workspace>) -> (usize, Batch) {
        self.batch.run(&self.bodies, scratch, &self.round, &SYSTEM);
        (self.index, self.batch)
    }
}

/// The result of a task.
type Ended = thread::Result<(usize, Batch)>;

/// The next action of the caller.
enum Next {
    Ended(Ended),
    Task(Task),
}

#[derive(Debug, Default)]
struct Tasks {
    waiting: VecDeque<Task>,
    /// One workspace for each worker that runs no task.
    scratch: Vec<Box<Workspace>>,
    /// Number of tasks that workers are running, and results of finished tasks.
    taken: usize,
    ended: Vec<Ended>,
    /// Number of calls so far, and number of workers that sleep until the next one.
    calls: usize,
    asleep: usize,
    /// True if the caller sleeps until a task ends.
    caller_sleeps: bool,
    /// Number of workers that have begun to wait for tasks.
    begun: usize,
    /// True if no more tasks will come.
    closed: bool,
}

/// The state shared by the threads.
#[derive(Debug, Default)]
struct Shared {
    tasks: Mutex<Tasks>,
    /// Signals new tasks, tasks to come soon, or that no more will come.
    begin: Condvar,
    /// Signals that a task has ended.
    end: Condvar,
    /// Copies of the numbers of waiting and of ended tasks, for polling without the lock.
    waiting: AtomicUsize,
    ended: AtomicUsize,
}

impl Shared {
    /// No task runs under the lock, so a panic cannot leave the lists inconsistent. The lock is
    /// held so briefly that spinning is cheaper than sleeping.
    fn lock(&self) -> MutexGuard<'_, Tasks> {
        let backoff = Backoff::new();
        loop {
            match self.tasks.try_lock() {
                Ok(tasks) => return tasks,
                Err(TryLockError::Poisoned(poisoned)) => return poisoned.into_inner(),
                Err(TryLockError::WouldBlock) => backoff.snooze(),
            }
        }
    }

    fn wake(&self, tasks: &Tasks) {
        if tasks.asleep > 0 {
            self.begin.notify_all();
        }
    }

    /// Takes a task for a worker, if there is one.
    fn take(&self, tasks: &mut Tasks) -> Option<Taken> {
        let task = tasks.waiting.pop_front()?;
        tasks.taken += 1;
        self.count(tasks);
        let scratch = tasks.scratch.pop().unwrap_or_else(workspace);
        Some((task, scratch))
    }

    /// Waits for a task; `None` if no more will come. `calls`: number of calls that the worker has
    /// seen.
    fn next(&self, calls: &mut usize) -> Option<Taken> {
        loop {
            look_out(|| self.waiting.load(Ordering::Acquire) > 0);
            let mut tasks = self.lock();
            tasks.asleep += 1;
            let idle = |tasks: &mut Tasks| {
                tasks.waiting.is_empty() && tasks.calls == *calls && !tasks.closed
            };
            tasks = self
                .begin
                .wait_while(tasks, idle)
                .unwrap_or_else(PoisonError::into_inner);
            tasks.asleep -= 1;
            *calls = tasks.calls;
            let task = self.take(&mut tasks);
            if task.is_some() || tasks.closed {
                return task;
            }
        }
    }

    /// The next action of the caller: runs a task; or takes back an ended one while the last tasks
    /// run; or waits. `None` if nothing is left.
    fn next_for_caller(&self, round: &Round) -> Option<Next> {
        let mut tasks = self.lock();
        // Workers take tasks from the front. Without a deadline the caller takes them from the
        // back, so that in most frames the same thread runs the same pairs.
        let task = if round.end.is_some() {
            tasks.waiting.pop_front()
        } else {
            tasks.waiting.pop_back()
        };
        if let Some(task) = task {
            self.count(&tasks);
            return Some(Next::Task(task));
        }
        if tasks.ended.is_empty() && tasks.taken > 0 {
            drop(tasks);
            look_out(|| self.ended.load(Ordering::Acquire) > 0);
            tasks = self.lock();
            tasks.caller_sleeps = true;
            tasks = self
                .end
                .wait_while(tasks, |tasks| tasks.ended.is_empty())
                .unwrap_or_else(PoisonError::into_inner);
            tasks.caller_sleeps = false;
        }
        let ended = tasks.ended.pop();
        self.count(&tasks);
        ended.map(Next::Ended)
    }

    fn count(&self, tasks: &Tasks) {
        self.waiting.store(tasks.waiting.len(), Ordering::Release);
        self.ended.store(tasks.ended.len(), Ordering::Release);
    }

    /// Runs tasks until no more will come.
    fn work(&self) {
        let (mut calls, mut next) = (0, None);
        self.lock().begun += 1;
        self.end.notify_one();
        while let Some((task, mut scratch)) = next.or_else(|| self.next(&mut calls)) {
            // The caller waits for every task, so even a panic must be returned to it.
            let ended = catch_unwind(AssertUnwindSafe(|| task.run(&mut scratch)));
            let mut tasks = self.lock();
            tasks.scratch.push(scratch);
            tasks.ended.push(ended);
            tasks.taken -= 1;
            self.count(&tasks);
            next = self.take(&mut tasks);
            if tasks.caller_sleeps {
                self.end.notify_one();
            }
        }
    }
}

/// Polls until `found` returns true, or for [`LOOKOUT`].
fn look_out(found: impl Fn() -> bool) {
    let began = Instant::now();
    while began.elapsed() < LOOKOUT {
        for _ in 0..LOOKS {
            if found() {
                return;
            }
            spin_loop();
        }
        thread::yield_now();
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
        let mut workers = Self {
            shared: Arc::default(),
            threads: Vec::new(),
        };
        let mut tasks = workers.shared.lock();
        (tasks.waiting, tasks.ended) = (
            VecDeque::with_capacity(batches),
            Vec::with_capacity(batches),
        );
        tasks.scratch.extend((0..threads).map(|_| workspace()));
        drop(tasks);
        for _ in 0..threads {
            let shared = Arc::clone(&workers.shared);
            workers.threads.push(
                Builder::new()
                    .name("punctual".into())
                    .spawn(move || shared.work())?,
            );
        }
        // Waits for the threads, so that allocations of the system at their start do not fall into
        // a frame.
        let tasks = workers.shared.lock();
        drop(
            workers
                .shared
                .end
                .wait_while(tasks, |tasks| tasks.begun < threads)
                .unwrap_or_else(PoisonError::into_inner),
        );
        Ok(workers)
    }
}

impl Workers {
    /// Makes room in the workspaces, between frames, for the contacts of meshes of at most this
    /// many triangles and vertices.
    pub fn make_room_for_contacts(&self, mesh: [usize; 2]) {
        for scratch in &mut self.shared.lock().scratch {
            make_room_for_contacts(scratch, mesh);
        }
    }
}

impl Crew for Workers {
    fn threads(&self) -> usize {
        self.threads.len() + 1
    }

    fn call(&self) {
        let mut tasks = self.shared.lock();
        tasks.calls += 1;
        self.shared.wake(&tasks);
    }

    fn begin(&self, first: usize, batches: &mut [Batch], round: &Round, bodies: &Arc<Bodies>) {
        let mut tasks = self.shared.lock();
        for (index, batch) in (first..)
            .zip(batches)
            .filter(|(_, batch)| !batch.is_empty())
        {
            let batch = core::mem::take(batch);
            tasks.waiting.push_back(Task {
                index,
                batch,
                round: *round,
                bodies: Arc::clone(bodies),
            });
        }
        self.shared.count(&tasks);
        self.shared.wake(&tasks);
    }

    fn finish(
        &self,
        batches: &mut [Batch],
        round: &Round,
        _: &Arc<Bodies>,
        scratch: &mut Box<Workspace>,
        back: &mut dyn FnMut(&mut Batch),
    ) {
        let mut panic = None;
        while let Some(next) = self.shared.next_for_caller(round) {
            let ended = match next {
                Next::Ended(ended) => ended,
                Next::Task(task) => Ok(task.run(scratch)),
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
        self.shared.lock().closed = true;
        self.shared.begin.notify_all();
        for thread in self.threads.drain(..) {
            // A thread that panicked needs no further action.
            let _ = thread.join();
        }
    }
}

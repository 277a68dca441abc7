//! Threads that run batches, and are parked between frames.
//!
//! A batch goes to a worker and comes back by value, and the bodies are shared, so there is nothing to lock but the queues.

use super::batch::{Batch, Round, workspace};
use super::body::Bodies;
use crate::query::{SystemClock, Workspace};
use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use crossbeam_channel::{Receiver, Sender, bounded};
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::thread::{self, Builder, JoinHandle};

struct Task {
    index: usize,
    batch: Batch,
    round: Round,
    bodies: Arc<Bodies>,
    clock: SystemClock,
}

impl Task {
    /// Lets go of the bodies before the batch is given back: the owner of the scene may then change them.
    fn run(mut self, scratch: &mut Box<Workspace>) -> (usize, Batch) {
        self.batch.run(&self.bodies, scratch, &self.round, &self.clock);
        (self.index, self.batch)
    }
}

#[derive(Debug)]
pub(super) struct Workers {
    tasks: Option<Sender<Task>>,
    /// The same tasks, for the calling thread to take its part.
    rest: Receiver<Task>,
    /// What became of the tasks of the threads.
    done: Receiver<thread::Result<(usize, Batch)>>,
    threads: Vec<JoinHandle<()>>,
}

impl Workers {
    /// Starts threads that help the calling one, for rounds of at most `batches` batches.
    pub fn start(threads: usize, batches: usize) -> io::Result<Self> {
        let (tasks, rest) = bounded::<Task>(batches);
        let (finished, done) = bounded(batches);
        let mut workers = Self { tasks: Some(tasks), rest, done, threads: Vec::new() };
        for _ in 0..threads {
            let (tasks, finished) = (workers.rest.clone(), finished.clone());
            let work = move || {
                let mut scratch = workspace();
                for task in tasks {
                    // The caller waits for every task, so even a panic has to come back to it.
                    let ended = catch_unwind(AssertUnwindSafe(|| task.run(&mut scratch)));
                    if finished.send(ended).is_err() {
                        break;
                    }
                }
            };
            workers.threads.push(Builder::new().name("punctual".into()).spawn(work)?);
        }
        Ok(workers)
    }

    /// Threads that take part, the calling one included.
    pub fn threads(&self) -> usize {
        self.threads.len() + 1
    }

    /// Runs all batches that are not empty.
    pub fn run(
        &self,
        batches: &mut [Batch],
        round: &Round,
        bodies: &Arc<Bodies>,
        scratch: &mut Box<Workspace>,
        clock: SystemClock,
    ) {
        let Some(tasks) = &self.tasks else { return };
        let mut away = 0;
        for (index, batch) in batches.iter_mut().enumerate().filter(|(_, batch)| !batch.jobs.is_empty()) {
            let batch = core::mem::take(batch);
            let task = Task { index, batch, round: *round, bodies: Arc::clone(bodies), clock };
            if tasks.send(task).is_ok() {
                away += 1;
            }
        }
        while let Ok(task) = self.rest.try_recv() {
            let (index, batch) = task.run(scratch);
            batches[index] = batch;
            away -= 1;
        }
        let mut panic = None;
        for ended in self.done.iter().take(away) {
            match ended {
                Ok((index, batch)) => batches[index] = batch,
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
        self.tasks = None;
        for thread in self.threads.drain(..) {
            // Nothing is left to do for one that panicked.
            let _ = thread.join();
        }
    }
}

//! Threads that run chains, and are parked between frames.
//!
//! A chain goes to a worker and comes back by value, and the bodies are shared, so there is nothing to lock but the queues.

use super::body::Bodies;
use super::chain::{Chain, Round, workspace};
use crate::query::{SystemClock, Workspace};
use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use crossbeam_channel::{Receiver, Sender, bounded};
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::thread::{self, Builder, JoinHandle};

struct Job {
    index: usize,
    chain: Chain,
    round: Round,
    bodies: Arc<Bodies>,
    clock: SystemClock,
}

impl Job {
    /// Lets go of the bodies before the chain is given back: the owner of the scene may then change them.
    fn run(mut self, scratch: &mut Box<Workspace>) -> (usize, Chain) {
        self.chain.run(&self.bodies, scratch, &self.round, &self.clock);
        (self.index, self.chain)
    }
}

#[derive(Debug)]
pub(super) struct Workers {
    jobs: Option<Sender<Job>>,
    /// The same jobs, for the calling thread to take its part.
    rest: Receiver<Job>,
    /// What became of the jobs of the threads.
    done: Receiver<thread::Result<(usize, Chain)>>,
    threads: Vec<JoinHandle<()>>,
}

impl Workers {
    /// Starts threads that help the calling one, for rounds of at most `chains` chains.
    pub fn start(threads: usize, chains: usize) -> io::Result<Self> {
        let (jobs, rest) = bounded::<Job>(chains);
        let (finished, done) = bounded(chains);
        let mut workers = Self { jobs: Some(jobs), rest, done, threads: Vec::new() };
        for _ in 0..threads {
            let (jobs, finished) = (workers.rest.clone(), finished.clone());
            let work = move || {
                let mut scratch = workspace();
                for job in jobs {
                    // The caller waits for every job, so even a panic has to come back to it.
                    let ended = catch_unwind(AssertUnwindSafe(|| job.run(&mut scratch)));
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

    /// Runs all chains that are not empty.
    pub fn run(
        &self,
        chains: &mut [Chain],
        round: &Round,
        bodies: &Arc<Bodies>,
        scratch: &mut Box<Workspace>,
        clock: SystemClock,
    ) {
        let Some(jobs) = &self.jobs else { return };
        let mut away = 0;
        for (index, chain) in chains.iter_mut().enumerate().filter(|(_, chain)| !chain.items.is_empty()) {
            let chain = core::mem::take(chain);
            let job = Job { index, chain, round: *round, bodies: Arc::clone(bodies), clock };
            if jobs.send(job).is_ok() {
                away += 1;
            }
        }
        while let Ok(job) = self.rest.try_recv() {
            let (index, chain) = job.run(scratch);
            chains[index] = chain;
            away -= 1;
        }
        let mut panic = None;
        for ended in self.done.iter().take(away) {
            match ended {
                Ok((index, chain)) => chains[index] = chain,
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
        self.jobs = None;
        for thread in self.threads.drain(..) {
            // Nothing is left to do for one that panicked.
            let _ = thread.join();
        }
    }
}

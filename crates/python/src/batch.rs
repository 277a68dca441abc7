//! Many poses in one call, on as many threads as asked for.

use crate::errors::value_error;
use punctual::{PairMemory, Workspace};
use pyo3::prelude::*;
use std::sync::Mutex;
use std::thread;
use std::time::{Duration, Instant};

/// Poses that a thread takes at a time.
const BLOCK: usize = 16;

/// How often the calling thread looks whether the user wants to end the call.
const SIGNALS: Duration = Duration::from_millis(100);

/// What a thread of a batch needs.
pub struct Worker<'m> {
    pub workspace: Box<Workspace>,
    pub memory: Option<&'m mut PairMemory>,
}

pub fn check_threads(threads: usize) -> PyResult<()> {
    if threads == 0 { Err(value_error("threads is 0, expected at least 1")) } else { Ok(()) }
}

/// The workers for so many poses, the first for the calling thread. A memory goes along the poses in their order, so
/// there is one worker then.
pub fn workers(threads: usize, poses: usize, memory: Option<&mut PairMemory>) -> PyResult<Vec<Worker<'_>>> {
    check_threads(threads)?;
    if threads > 1 && memory.is_some() {
        return Err(value_error("memory goes along the poses one by one: it needs threads=1"));
    }
    let mut workers = vec![Worker { workspace: Box::new(Workspace::new()), memory }];
    let more = threads.min(poses.div_ceil(BLOCK)).saturating_sub(1);
    workers.extend((0..more).map(|_| Worker { workspace: Box::new(Workspace::new()), memory: None }));
    Ok(workers)
}

/// Calls `answer` for each number below `count`, without the interpreter's lock: the answers in order. Ends early at an
/// error, if the user asks for that (Ctrl-C) or there is no thread.
pub fn each<'m, R: Clone + Default + Send>(
    py: Python<'_>,
    count: usize,
    mut workers: Vec<Worker<'m>>,
    answer: impl Fn(&mut Worker<'m>, usize) -> PyResult<R> + Sync,
) -> PyResult<Vec<R>> {
    let mut rows = vec![R::default(); count];
    let blocks = Mutex::new(rows.chunks_mut(BLOCK).enumerate());
    let next = || blocks.lock().ok()?.next();
    // Leaves nothing to do for the others.
    let end = |_: &PyErr| while next().is_some() {};
    let work = |worker: &mut Worker<'m>, look: &mut dyn FnMut() -> PyResult<()>| {
        while let Some((block, rows)) = next() {
            for (row, at) in rows.iter_mut().zip(block * BLOCK..) {
                *row = answer(worker, at).inspect_err(end)?;
            }
            look().inspect_err(end)?;
        }
        Ok::<_, PyErr>(())
    };
    let mut looked = Instant::now();
    let mut look = || {
        if looked.elapsed() < SIGNALS {
            return Ok(());
        }
        looked = Instant::now();
        Python::attach(|py| py.check_signals())
    };
    py.detach(|| {
        thread::scope(|scope| {
            let (own, others) = workers.split_first_mut().ok_or_else(|| value_error("no worker"))?;
            let others = others
                .iter_mut()
                .map(|worker| thread::Builder::new().spawn_scoped(scope, || work(worker, &mut || Ok(()))));
            let others: Vec<_> = others.map(|other| Ok(other?)).collect::<PyResult<_>>().inspect_err(end)?;
            work(own, &mut look)?;
            for other in others {
                other.join().map_err(|_| value_error("a thread of the batch ended early"))??;
            }
            Ok::<_, PyErr>(())
        })
    })?;
    Ok(rows)
}

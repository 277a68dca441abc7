//! Many poses in one call, on as many threads as asked for.

use crate::errors::value_error;
use crate::interrupt::{Attentive, BETWEEN_LOOKS, Interrupt, Progress};
use punctual::{Clock, PairMemory, Workspace};
use pyo3::prelude::*;
use std::sync::Mutex;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;

/// Poses that a thread takes at a time.
const BLOCK: usize = 16;

/// What a thread of a batch needs.
pub struct Worker<'m> {
    pub workspace: Box<Workspace>,
    pub memory: Option<&'m mut PairMemory>,
}

pub fn check_threads(threads: usize) -> PyResult<()> {
    if threads == 0 {
        Err(value_error("threads is 0, expected at least 1"))
    } else {
        Ok(())
    }
}

/// The workers for so many poses, the first for the calling thread. A memory goes along the poses in their order, so
/// there is one worker then.
pub fn workers(
    threads: usize,
    poses: usize,
    memory: Option<&mut PairMemory>,
) -> PyResult<Vec<Worker<'_>>> {
    check_threads(threads)?;
    if threads > 1 && memory.is_some() {
        return Err(value_error(
            "memory goes along the poses one by one: it needs threads=1",
        ));
    }
    let mut workers = vec![Worker {
        workspace: Box::new(Workspace::new()),
        memory,
    }];
    let more = threads.min(poses.div_ceil(BLOCK)).saturating_sub(1);
    workers.extend((0..more).map(|_| Worker {
        workspace: Box::new(Workspace::new()),
        memory: None,
    }));
    Ok(workers)
}

/// Calls `answer` for each number below `count`, without the interpreter's lock: the answers in order. Tells `progress`
/// every 50 ms, and at the end. Ends early at an error, also of `progress`, if the user cancels the call (Ctrl-C) or
/// there is no thread.
pub fn each<'m, R: Clone + Default + Send>(
    py: Python<'_>,
    count: usize,
    progress: Option<Py<PyAny>>,
    mut workers: Vec<Worker<'m>>,
    answer: impl Fn(&mut Worker<'m>, &dyn Clock, usize) -> PyResult<R> + Sync,
) -> PyResult<Vec<R>> {
    let mut rows = vec![R::default(); count];
    let blocks = Mutex::new(rows.chunks_mut(BLOCK).enumerate());
    let (interrupt, progress) = (Interrupt::default(), Progress::new(progress, count));
    let work = |worker: &mut Worker<'m>, clock: &dyn Clock| {
        while let Some((block, rows)) = blocks.lock().ok().and_then(|mut blocks| blocks.next()) {
            if clock.is_cancelled() {
                break;
            }
            for (row, at) in rows.iter_mut().zip(block * BLOCK..) {
                *row = answer(worker, clock, at).inspect_err(|_| interrupt.set(None))?;
                progress.add(1);
                if interrupt.is_set() {
                    break;
                }
            }
        }
        Ok::<_, PyErr>(())
    };
    py.detach(|| {
        let clock = Attentive::new(&interrupt, &progress);
        thread::scope(|scope| {
            let (own, others) = workers
                .split_first_mut()
                .ok_or_else(|| value_error("no worker"))?;
            let (working, ended) = mpsc::channel::<()>();
            let spawn = |other| {
                let (working, work, interrupt) = (working.clone(), &work, &interrupt);
                thread::Builder::new().spawn_scoped(scope, move || {
                    let _working = working;
                    work(other, interrupt)
                })
            };
            let others: Result<Vec<_>, _> = others.iter_mut().map(spawn).collect();
            let others = others.inspect_err(|_| interrupt.set(None))?;
            drop(working);
            work(own, &clock)?;
            // The user may cancel what the others still do.
            while ended.recv_timeout(BETWEEN_LOOKS) == Err(RecvTimeoutError::Timeout) {
                let _ = clock.is_cancelled();
            }
            for other in others {
                other
                    .join()
                    .map_err(|_| value_error("a thread of the batch ended early"))??;
            }
            Ok::<_, PyErr>(())
        })
    })?;
    let rows = interrupt.end(rows)?;
    progress.tell(py)?;
    Ok(rows)
}

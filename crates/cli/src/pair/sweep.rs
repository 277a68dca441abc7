//! Sweeps over a pose list, and the file of found pairs.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use punctual::clock::SystemClock;
use punctual::intersection::Intersection;
use punctual::prediction::{Estimate, Prediction};
use punctual::{
    Answer, Budget, Mode, PairMemory, Pose, Query, StopReason, Tree, Verdict, Workspace,
};
use punctual_io::FileError;
use punctual_lab::files::Listed;
use punctual_lab::report::Failure;

use super::Args;
use super::calibration::CalibrationFile;

/// Pairs a workspace holds before they are taken out and the query resumed; 8 MB.
const FOUND_PAIRS: usize = 1 << 20;

/// Node pairs that wait in the queue, as in `Workspace::new`.
const QUEUE_PAIRS: usize = 4096;

/// What the first sweep answered for a pose, and the least time of all sweeps.
pub struct Row {
    pub outcome: Answer<Verdict>,
    pub upper_bound: u64,
    pub least: Duration,
    pub predicted: Prediction,
    pub estimate: Estimate,
}

/// Goes over the pose list: each sweep all poses once, so that no query finds its own tracks in the caches.
pub struct Sweeper<'a> {
    args: &'a Args,
    a: &'a Tree,
    b: &'a Tree,
    workspace: Workspace,
    /// For queries that are none of the program's own: their truth.
    aside: Workspace,
    memory: Option<PairMemory>,
    clock: SystemClock,
    /// Pairs of the query at hand, and those only.
    found: Vec<[u32; 2]>,
}

impl<'a> Sweeper<'a> {
    pub fn new(args: &'a Args, a: &'a Tree, b: &'a Tree) -> Self {
        let workspace = args
            .running
            .prepared(Workspace::with_capacity(QUEUE_PAIRS, FOUND_PAIRS));
        let (aside, clock) = (Workspace::new(), SystemClock::default());
        Self {
            args,
            a,
            b,
            workspace,
            aside,
            memory: None,
            clock,
            found: Vec::new(),
        }
    }

    pub fn first_sweep(
        &mut self,
        poses: &[Listed<Pose>],
        mut pairs_out: Option<&mut PairsFile>,
        mut calibration: Option<&mut CalibrationFile>,
    ) -> Result<Vec<Option<Row>>, Failure> {
        self.memory = self.args.memory.then(PairMemory::new);
        let mut rows = Vec::with_capacity(poses.len());
        for (i, listed) in poses.iter().enumerate() {
            let Ok(pose) = listed.entry else {
                rows.push(None);
                continue;
            };
            let memory = self.memory.clone();
            let (outcome, least) = self.answer(pose)?;
            // Only now, so that no prediction brings into the cache what the query is about to read.
            let query = self.query(pose);
            let upper_bound = query.certificate(&self.workspace)?.upper_bound();
            let predicted = query.predict(memory.as_ref());
            let mut estimate = query.estimate(&self.workspace, self.memory.as_ref())?;
            if let Some(file) = &mut calibration {
                let told = estimate.probability;
                estimate.probability = file.calibration.apply(told);
                if outcome.value == Verdict::Undecided {
                    file.calibration.learn(told, self.meets(pose));
                }
            }
            rows.push(Some(Row {
                outcome,
                upper_bound,
                least,
                predicted,
                estimate,
            }));
            if let Some(file) = &mut pairs_out {
                self.found.extend_from_slice(self.workspace.pairs());
                file.write(i, &mut self.found)?;
            }
        }
        Ok(rows)
    }

    pub fn sweep_again(
        &mut self,
        poses: &[Listed<Pose>],
        rows: &mut [Option<Row>],
    ) -> Result<(), Failure> {
        self.memory = self.args.memory.then(PairMemory::new);
        for (listed, row) in poses.iter().zip(rows) {
            if let (Ok(pose), Some(row)) = (&listed.entry, row) {
                row.least = row.least.min(self.answer(*pose)?.1);
            }
        }
        Ok(())
    }

    /// One query, timed from the pose to the outcome.
    fn answer(&mut self, pose: Pose) -> Result<(Answer<Verdict>, Duration), Failure> {
        self.found.clear();
        let start = Instant::now();
        let query = self.query(pose);
        let clock = self.clock;
        let budget = self.args.running.limits.budget();
        let mut outcome = query
            .with_memory(self.memory.as_mut())
            .run(&mut self.workspace, budget.clock(&clock));
        while outcome.stop == StopReason::PairsFull {
            self.found.extend(self.workspace.drain_pairs());
            let left = self
                .args
                .running
                .limits
                .budget_left(start.elapsed(), outcome.stats.work);
            outcome = query
                .with_memory(self.memory.as_mut())
                .resume(&mut self.workspace, left.clock(&clock))?;
        }
        Ok((outcome, start.elapsed()))
    }

    /// Whether the surfaces meet at a pose, found out aside.
    fn meets(&mut self, pose: Pose) -> bool {
        let outcome = Query::intersection(self.a, self.b, pose)
            .surfaces()
            .mode(Mode::Any)
            .run(&mut self.aside, Budget::unlimited());
        outcome.value != Verdict::Separated
    }

    fn query(&self, pose: Pose) -> Query<'a, Intersection> {
        self.args.query(self.a, self.b, pose)
    }
}

/// Where `--pairs-out` goes.
pub struct PairsFile {
    path: PathBuf,
    out: BufWriter<File>,
}

impl PairsFile {
    pub fn create(path: &Path) -> Result<Self, FileError> {
        let file = File::create(path).map_err(|error| FileError::from_io(path, &error))?;
        Ok(Self {
            path: path.to_owned(),
            out: BufWriter::new(file),
        })
    }

    fn write(&mut self, pose: usize, pairs: &mut [[u32; 2]]) -> Result<(), FileError> {
        pairs.sort_unstable();
        let written = pairs
            .iter()
            .try_for_each(|[a, b]| writeln!(self.out, "{pose},{a},{b}"));
        written.map_err(|error| FileError::from_io(&self.path, &error))
    }

    pub fn finish(mut self) -> Result<(), FileError> {
        self.out
            .flush()
            .map_err(|error| FileError::from_io(&self.path, &error))
    }
}

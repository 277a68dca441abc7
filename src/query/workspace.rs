//! Every buffer that a query needs, owned by the caller.

use super::corners::Corners;
use super::outcome::Stats;
use super::queue::{Front, PATHS};
use super::waiting::Waiting;
use crate::math::Pose;
use crate::math::lanes::Instructions;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use core::fmt;

/// The buffers of a query. Allocated once; no query allocates.
///
/// It carries capacity, the pairs that the last query found, and what that query left open for
/// [`crate::Query::resume`]; a fresh workspace and a used one give the same answers.
#[derive(Clone, Debug)]
pub struct Workspace {
    pub(super) instructions: Instructions,
    pub(super) front: Front,
    /// Triangle pairs (tree order) that wait for the filter, and those that are left in doubt by it.
    pub(super) waiting: Waiting,
    pub(super) doubtful: ArrayVec<[u32; 2], 8>,
    /// Triangles of A and of B in the exact test.
    pub(super) corners: [Corners; 2],
    /// Whether triangle pairs are being tested, until none is in doubt and less than a batch waits.
    pub(super) testing: bool,
    /// Whether the last batch had pairs in doubt, so that the search goes on elsewhere.
    pub(super) elsewhere: bool,
    /// Triangle pairs (tree order) that met in the frame before, where the paths lead.
    pub(super) witnesses: ArrayVec<[u32; 2], PATHS>,
    /// What the next frame will remember.
    pub(super) sample: Sample,
    pub(super) found: Vec<[u32; 2]>,
    pub(super) run: Run,
}

/// The state of the last query, besides its buffers.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Run {
    /// The trees, the pose and the options it belongs to.
    pub key: Option<Key>,
    /// Whether it was stopped by a budget or a full buffer, and so can be resumed.
    pub stopped: bool,
    pub stats: Stats,
    pub found: u64,
    /// First pair found: ids of the input meshes.
    pub witness: Option<[u32; 2]>,
    pub random: u64,
}

/// Some of the pairs that were found, in tree order: every `2^skips`-th, at least half as many as there is room for.
#[derive(Clone, Debug, Default)]
pub(super) struct Sample {
    pairs: ArrayVec<[u32; 2], PATHS>,
    skips: u32,
}

impl Sample {
    /// Takes note of the pair that was found after `before` others.
    #[inline(always)]
    pub fn note(&mut self, pair: [u32; 2], before: u64) {
        if before & ((1 << self.skips) - 1) == 0 {
            self.add(pair);
        }
    }

    fn add(&mut self, pair: [u32; 2]) {
        if self.pairs.is_full() {
            // The pair at hand is the next of those that stay.
            let mut stays = false;
            self.pairs.retain(|_| {
                stays = !stays;
                stays
            });
            self.skips += 1;
        }
        self.pairs.push(pair);
    }

    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    fn clear(&mut self) {
        self.pairs.clear();
        self.skips = 0;
    }
}

/// What two calls must have in common to be one query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Key {
    pub trees: [usize; 2],
    pub b_in_a: Pose,
    pub options: super::Options,
}

impl Workspace {
    /// Room for 4,096 queued node pairs and 65,536 found pairs, about 830 kB.
    #[must_use]
    pub fn new() -> Self {
        Self::with_capacity(4096, 65536)
    }

    /// Room for `queue` node pairs (a full queue goes depth-first and loses nothing) and `found` intersecting pairs (a
    /// full buffer stops the query with [`crate::StopReason::PairsFull`], to be drained and resumed).
    /// `16 queue + 8 found` bytes and about 240 kB.
    #[must_use]
    pub fn with_capacity(queue: usize, found: usize) -> Self {
        Self {
            instructions: Instructions::detect(),
            front: Front::new(queue),
            waiting: Waiting::new(),
            doubtful: ArrayVec::new(),
            corners: [Corners::EMPTY; 2],
            testing: false,
            elsewhere: false,
            witnesses: ArrayVec::new(),
            sample: Sample::default(),
            found: Vec::with_capacity(found.max(1)),
            run: Run::default(),
        }
    }

    /// Uses the portable kernels, whatever the machine offers: slower, the same bits.
    pub fn use_portable_kernels(&mut self) {
        self.instructions = Instructions::PORTABLE;
    }

    /// The intersecting pairs that the last query found: triangle of A, triangle of B, ids of the input meshes, in order
    /// of discovery; without those drained.
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.found
    }

    /// Takes the found pairs out, so that a query that stopped with [`crate::StopReason::PairsFull`] can be resumed.
    pub fn drain_pairs(&mut self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.found.drain(..)
    }

    /// Whether nothing is left open.
    pub(super) fn is_done(&self) -> bool {
        self.front.is_empty() && self.waiting.len() == 0 && self.doubtful.is_empty()
    }

    pub(super) fn clear(&mut self) {
        self.front.clear();
        self.waiting.clear();
        self.doubtful.clear();
        self.testing = false;
        self.elsewhere = false;
        self.witnesses.clear();
        self.sample.clear();
        self.found.clear();
        self.run = Run::default();
    }
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}

/// The workspace holds no stopped run of this query: another was run in it since, or none, or this one is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResumeError;

impl fmt::Display for ResumeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the workspace does not hold a run of this query (same trees, pose and options)")
    }
}

impl core::error::Error for ResumeError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_spread_over_all_that_was_found() {
        for found in [0, 1, 15, 16, 17, 32, 33, 1_000, 70_000] {
            let mut sample = Sample::default();
            (0..found).for_each(|i| sample.note([i, 0], i.into()));
            let pairs = sample.pairs();
            assert_eq!(pairs.len() == found as usize, found <= PATHS as u32, "{found}");
            assert!(pairs.len() >= PATHS / 2 || pairs.len() == found as usize);
            let step = pairs.get(1).map_or(1, |pair| pair[0]);
            assert!(pairs.iter().zip(0..).all(|(pair, i)| pair[0] == i * step), "{found}: {pairs:?}");
            assert!(found == 0 || pairs.len() as u32 * step >= found, "{found}: {pairs:?}");
        }
    }
}

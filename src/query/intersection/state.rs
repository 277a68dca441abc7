//! The pairs that an intersection query has found, and what it remembers of them.

use super::known;
use super::trace::Trace;
use crate::engine::frontier::PATHS;
use crate::engine::workspace::Workspace;
use crate::room::Room;
use arrayvec::ArrayVec;

/// The state of an intersection query in its workspace.
#[derive(Clone, Debug)]
pub(crate) struct IntersectionState {
    /// Ids of the input meshes.
    pub found: Room<[u32; 2]>,
    /// Triangle pairs (tree order) that intersected in the previous frame; the warm-start paths
    /// lead to them.
    pub witnesses: ArrayVec<[u32; 2], PATHS>,
    /// The pairs that the memory keeps for the next frame.
    pub sample: Sample,
    pub trace: Trace,
    /// Maximum number of pairs of a query about thickened surfaces, if the capacity allows it.
    pub limit: usize,
}

impl IntersectionState {
    pub fn new(found: usize) -> Self {
        Self {
            found: Room::new(found.max(1)),
            witnesses: ArrayVec::new(),
            sample: Sample::default(),
            trace: Trace::new(known::ROOM),
            limit: usize::MAX,
        }
    }

    /// True if there is no room for another pair.
    pub fn is_full(&self) -> bool {
        self.found.len() >= self.limit.min(self.found.capacity())
    }

    #[inline(always)]
    pub fn clear(&mut self) {
        self.found.clear();
        self.witnesses.clear();
        self.sample.clear();
        self.trace.clear();
    }
}

impl Workspace {
    /// The intersecting pairs that the last query found, without drained ones, in order of
    /// discovery: triangle of A, triangle of B, ids of the input meshes.
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.state.intersection.found
    }

    /// Removes and returns the found pairs, so that a query stopped with
    /// [`crate::StopReason::PairsFull`] can be resumed.
    pub fn drain_pairs(&mut self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.state.intersection.found.drain(..)
    }

    /// Reports a pair (tree order) of thickened surfaces, whose cores are this far apart.
    pub(crate) fn report_within(&mut self, pair: [u32; 2], ids: [u32; 2], distance: f64) {
        let state = &mut self.state.intersection;
        state.sample.note(pair, self.run.stats.found);
        self.run.stats.found += 1;
        if self.run.witness.is_none() {
            (self.run.witness, self.run.apart) = (Some(ids), distance);
        }
        state.found.push(ids);
    }

    /// A pair of triangles (tree order) that the last intersection query found to meet.
    #[inline]
    pub fn witness(&self) -> Option<[u32; 2]> {
        self.state.intersection.sample.pairs().first().copied()
    }
}

/// A sample of the pairs found, in tree order: every `2^skips`-th. Once it has been full, it is at
/// least half full.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sample {
    pairs: ArrayVec<[u32; 2], PATHS>,
    skips: u32,
}

impl Sample {
    /// Offers the pair that was found after `before` others.
    #[inline(always)]
    pub fn note(&mut self, pair: [u32; 2], before: u64) {
        if before & ((1 << self.skips) - 1) == 0 {
            self.add(pair);
        }
    }

    fn add(&mut self, pair: [u32; 2]) {
        if self.pairs.is_full() {
            // Keeps every second pair, beginning with the first; the new pair continues the
            // sequence.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_spread_over_all_that_was_found() {
        for found in [0, 1, 15, 16, 17, 32, 33, 1_000, 70_000] {
            let mut sample = Sample::default();
            (0..found).for_each(|i| sample.note([i, 0], i.into()));
            let pairs = sample.pairs();
            assert_eq!(
                pairs.len() == found as usize,
                found <= PATHS as u32,
                "{found}"
            );
            assert!(pairs.len() >= PATHS / 2 || pairs.len() == found as usize);
            let step = pairs.get(1).map_or(1, |pair| pair[0]);
            assert!(
                pairs.iter().zip(0..).all(|(pair, i)| pair[0] == i * step),
                "{found}: {pairs:?}"
            );
            assert!(
                found == 0 || pairs.len() as u32 * step >= found,
                "{found}: {pairs:?}"
            );
        }
    }
}

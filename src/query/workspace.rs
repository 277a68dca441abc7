//! All buffers of a query, owned by the caller.

use super::contained::Containment;
use super::corners::Corners;
use super::known;
use super::motion::state::MotionState;
use super::options::{ContactOptions, DistanceOptions, Options};
use super::outcome::{Stats, StopReason, Verdict};
use super::overlaps::{Overlaps, Reduction};
use super::point::PointBounds;
use super::point::state::{Phase, PointState};
use super::queue::{Frontier, PATHS};
use super::ray::state::{RayHit, RayState};
use super::search::Search;
use super::strategy::Strategy;
use super::trace::Trace;
use super::triangle_pairs::TrianglePairs;
use crate::contact::{Contact, ContactList, Manifold};
use crate::model::cost::CostModel;
use crate::room::Room;
use crate::tree::Tree;
use alloc::boxed::Box;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use core::fmt;
use core::time::Duration;
use punctual_geom::Pose;
use punctual_geom::lanes::Instructions;

/// The buffers of a query, allocated once. Only some first queries allocate more:
/// [`Query::run`](crate::Query::run).
///
/// It holds the pairs that the last query found, and the state that [`crate::Query::resume`]
/// continues from. A fresh workspace and a used one give the same answers. A clone has the same
/// contents and the same capacity.
///
/// It also learns the costs of queries on this machine ([`Workspace::cost_model`]).
#[derive(Clone, Debug)]
pub struct Workspace {
    pub(super) instructions: Instructions,
    pub(super) cost_model: CostModel,
    pub(super) frontier: Frontier,
    /// Triangle pairs (tree order) that wait for the filter, and those that it left in doubt.
    pub(super) waiting: Box<TrianglePairs>,
    pub(super) uncertain: ArrayVec<[u32; 2], 8>,
    /// Cached corners of triangles of A and of B for the tests in `f64`.
    pub(super) corners: [Corners; 2],
    /// True while triangle pairs are tested: until none is in doubt and less than a batch waits.
    pub(super) testing: bool,
    /// The last batch was inconclusive: take the next node pair from another part of the stack.
    pub(super) inconclusive: bool,
    /// Triangle pairs (tree order) that intersected in the previous frame; the warm-start paths
    /// lead to them.
    pub(super) witnesses: ArrayVec<[u32; 2], PATHS>,
    /// The pairs that the memory keeps for the next frame.
    pub(super) sample: Sample,
    /// The state of contact-curve tracing.
    pub(super) trace: Trace,
    /// The state of a distance query.
    pub(super) search: Search,
    /// The state of a motion query.
    pub(super) motion: MotionState,
    pub(super) rays: RayState,
    pub(super) points: PointState,
    pub(super) contacts: ContactList,
    pub(super) reduction: Reduction,
    pub(super) overlaps: Overlaps,
    pub(super) manifolds: Vec<Manifold>,
    pub(super) found: Room<[u32; 2]>,
    pub(super) run: Run,
}

/// The state of the last query, apart from its buffers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    /// The trees, the pose and the options of the query.
    pub key: Option<Key>,
    pub strategy: Strategy,
    /// True if a budget or a full buffer stopped it, so that it can be resumed.
    pub stopped: bool,
    /// Without the sum of the BV tests and the peak of the queue, which [`Workspace::stats`] adds.
    pub stats: Stats,
    /// The first pair found: ids of the input meshes.
    pub witness: Option<[u32; 2]>,
    pub containment: Containment,
}

impl Run {
    /// Starts a new run. Assigns field by field: storing zeros is faster than copying a constant.
    #[inline(always)]
    pub fn begin(&mut self, key: Key, strategy: Strategy) {
        self.key = Some(key);
        self.strategy = strategy;
        self.stopped = false;
        self.stats = Stats::default();
        self.witness = None;
        self.containment = Containment::Open;
    }

    /// Adds the time of a call, if it was measured.
    pub fn took(&mut self, elapsed: Option<Duration>) {
        if let Some(elapsed) = elapsed {
            let total = &mut self.stats.elapsed;
            *total = Some(total.unwrap_or_default().saturating_add(elapsed));
        }
    }

    /// The verdict of a run that ended for this reason.
    pub fn verdict(&self, stop: StopReason) -> Verdict {
        match (self.witness, stop) {
            (Some(witness), _) => Verdict::Intersecting { witness },
            (None, StopReason::Finished) => Verdict::Separated,
            _ => Verdict::Undecided,
        }
    }
}

/// A sample of the pairs found, in tree order: every `2^skips`-th. Once it has been full, it is at
/// least half full.
#[derive(Clone, Debug, Default)]
pub(super) struct Sample {
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

/// Identifies a query: calls with equal keys belong to one query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    pub trees: [usize; 2],
    pub b_in_a: Pose,
    pub asked: Asked,
}

impl Key {
    pub fn new(trees: [&Tree; 2], b_in_a: Pose, asked: Asked) -> Self {
        Self {
            trees: trees.map(Tree::identity),
            b_in_a,
            asked,
        }
    }
}

/// A question and its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    Intersection(Options),
    Distance(DistanceOptions),
    /// The options are in the [`MotionState`].
    Motion,
    Contacts(ContactOptions),
    Manifolds(ContactOptions, bool),
    /// The rays are in the [`RayState`].
    Ray,
    /// The points are in the [`PointState`].
    Points,
}

impl Workspace {
    /// Room for 4,096 queued node pairs and 65,536 found pairs, about 960 kB.
    #[must_use]
    pub fn new() -> Self {
        Self::with_capacity(4096, 65536)
    }

    /// Room for `queue` node pairs of distances and motions, and for `found` intersecting pairs:
    /// about 360 kB and `20 queue + 8 found` bytes. Intersections have a queue of 64 pairs of their
    /// own. With a full queue the query goes depth-first and loses nothing. A full buffer of pairs
    /// stops it with [`crate::StopReason::PairsFull`], to be drained and resumed.
    #[must_use]
    pub fn with_capacity(queue: usize, found: usize) -> Self {
        Self {
            instructions: Instructions::detect(),
            cost_model: CostModel::default(),
            frontier: Frontier::new(queue),
            waiting: Box::default(),
            uncertain: ArrayVec::new(),
            corners: [Corners::EMPTY; 2],
            testing: false,
            inconclusive: false,
            witnesses: ArrayVec::new(),
            sample: Sample::default(),
            trace: Trace::new(known::ROOM),
            search: Search::new(),
            motion: MotionState::NOTHING,
            rays: RayState::default(),
            points: PointState::default(),
            contacts: ContactList::default(),
            reduction: Reduction::default(),
            overlaps: Overlaps::default(),
            manifolds: Vec::new(),
            found: Room::new(found.max(1)),
            run: Run {
                key: None,
                strategy: Strategy::NONE,
                stopped: false,
                stats: Stats::default(),
                witness: None,
                containment: Containment::Open,
            },
        }
    }

    /// For experiments: uses the portable kernels on any machine; slower, with the same bits.
    pub fn use_portable_kernels(&mut self) {
        self.instructions = Instructions::PORTABLE;
    }

    /// The intersecting pairs that the last query found, without drained ones, in order of
    /// discovery: triangle of A, triangle of B, ids of the input meshes.
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.found
    }

    /// Removes and returns the found pairs, so that a query stopped with
    /// [`crate::StopReason::PairsFull`] can be resumed.
    pub fn drain_pairs(&mut self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.found.drain(..)
    }

    /// The contacts that the last query found, if it was a contact query, without drained ones:
    /// nearest first, at equal distance by the ids of their triangles.
    pub fn contacts(&self) -> impl ExactSizeIterator<Item = &Contact> + Clone {
        self.contacts.iter()
    }

    /// Removes and returns the contacts, nearest first, so that a query stopped with
    /// [`crate::StopReason::PairsFull`] can be resumed.
    pub fn drain_contacts(&mut self) -> impl ExactSizeIterator<Item = Contact> {
        self.contacts.drain()
    }

    /// The manifolds of the last query, if it was [one](crate::Query::manifolds), the deepest
    /// first. Those of a stopped query are incomplete.
    pub fn manifolds(&self) -> &[Manifold] {
        &self.manifolds
    }

    /// Reserves room for at least `contacts` contacts, 170 bytes each. If there is no room at all,
    /// the first contact query reserves room for 4,096. After more room is reserved, a query
    /// stopped with [`crate::StopReason::PairsFull`] can be resumed without draining.
    pub fn reserve_contacts(&mut self, contacts: usize) {
        self.contacts.reserve(contacts);
    }

    /// Reserves room for the manifolds of meshes of at most this many triangles and vertices, with
    /// at most `pairs` pairs of triangles that intersect: 4 bytes for each triangle, 36 for each
    /// vertex, and about 1.9 kB for each pair.
    pub fn reserve_manifolds(&mut self, pairs: usize, triangles: usize, vertices: usize) {
        self.reserve_contacts(pairs);
        self.reduction.skin.reserve();
        self.overlaps.reserve_for(pairs, [triangles, vertices]);
        let room = pairs.saturating_sub(self.manifolds.len());
        self.manifolds.reserve(room);
    }

    /// The hits that the last query found, if it asked for all hits of a ray, without drained ones:
    /// in order of discovery, which is nearly that of `t`.
    pub fn ray_hits(&self) -> &[RayHit] {
        &self.rays.hits
    }

    /// The hits that the last query found, if it was one of many rays
    /// ([`Query::rays`](super::Query::rays)): one for each ray done, in the order of the rays.
    /// `None` for a ray without a hit.
    pub fn first_hits(&self) -> &[Option<RayHit>] {
        &self.rays.first_hits
    }

    /// What the last query found about points, if it was one about points: one for each point done,
    /// in the order of the points.
    pub fn points(&self) -> &[PointBounds] {
        &self.points.found
    }

    /// Reserves room for the answers about at least this many points. The first query for a larger
    /// batch of points reserves room for it, and the first about an open solid 24 bytes for each
    /// vertex on an open edge.
    pub fn reserve_points(&mut self, points: usize) {
        self.points.reserve(points);
    }

    /// Reserves room to find out whether one solid is inside another.
    #[doc(hidden)]
    pub fn reserve_containment(&mut self) {
        self.points.reserve_stack();
    }

    /// Removes and returns the hits of a ray, so that a query stopped with
    /// [`crate::StopReason::PairsFull`] can be resumed.
    pub fn drain_ray_hits(&mut self) -> impl ExactSizeIterator<Item = RayHit> + '_ {
        self.rays.hits.drain(..)
    }

    /// Reserves room for at least `hits` hits of a ray, 24 bytes each, and for a batch of as many
    /// rays, 32 bytes each. The first query for all hits reserves room for 4,096 if there is none.
    /// The first query for a larger batch of rays reserves room for it.
    pub fn reserve_ray_hits(&mut self, hits: usize) {
        self.rays.hits.reserve_all(hits);
        self.rays.first_hits.reserve_all(hits);
    }

    /// The costs of a BV test, a triangle pair, an opened node pair and a query on this machine, in
    /// nanoseconds, as learned from runs with a budget of time. They decide the plan of a query
    /// with such a budget.
    pub fn cost_model(&self) -> CostModel {
        self.cost_model
    }

    /// Sets the costs, for example to those of [`CostModel::measure`]. Each query with a budget of
    /// time updates them.
    pub fn set_cost_model(&mut self, cost_model: CostModel) {
        self.cost_model = cost_model;
    }

    /// Forgets the run, so that none can be resumed.
    #[doc(hidden)]
    pub fn forget_run(&mut self) {
        self.run.key = None;
    }

    /// Work of the last query, including resumed calls.
    #[doc(hidden)]
    pub fn work(&self) -> u64 {
        self.run.stats.work
    }

    #[doc(hidden)]
    pub fn bv_tests(&self) -> u64 {
        self.run.stats.bv_tests
    }

    #[doc(hidden)]
    pub fn found(&self) -> u64 {
        self.run.stats.found
    }

    /// The verdict of the last query, which ended for this reason.
    #[doc(hidden)]
    pub fn verdict(&self, stop: StopReason) -> Verdict {
        self.run.verdict(stop)
    }

    /// A pair of triangles (tree order) that the last intersection query found to meet.
    #[doc(hidden)]
    #[inline]
    pub fn witness(&self) -> Option<[u32; 2]> {
        self.sample.pairs().first().copied()
    }

    /// Work of the last query.
    #[doc(hidden)]
    #[inline]
    pub fn stats(&self) -> Stats {
        Stats {
            queue_peak: self.frontier.peak(),
            ..self.run.stats
        }
    }

    /// [`Search::bound`] of the distance query.
    pub(super) fn bound(&mut self, current: f32, unit: f64) {
        self.search.bound(&self.frontier, current, unit);
    }

    /// True if nothing is left open.
    pub(super) fn is_done(&self) -> bool {
        self.frontier.is_empty()
            && self.waiting.is_empty()
            && self.uncertain.is_empty()
            && self.search.is_done()
            && self.motion.followed.is_none()
            && self.rays.candidates.is_empty()
            && self.rays.after == 0
            && self.points.phase == Phase::Idle
    }

    /// The triangle pairs (tree order) of an intersection query that wait for a test.
    pub(super) fn triangle_pairs(&self) -> impl Iterator<Item = [u32; 2]> {
        self.waiting
            .as_slice()
            .iter()
            .chain(&self.uncertain)
            .copied()
    }

    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.frontier.clear();
        self.waiting.clear();
        self.uncertain.clear();
        self.testing = false;
        self.inconclusive = false;
        self.witnesses.clear();
        self.sample.clear();
        self.trace.clear();
        self.search.clear();
        self.motion.followed = None;
        self.rays.clear();
        self.points.clear();
        self.contacts.clear();
        self.reduction.clear();
        self.manifolds.clear();
        self.found.clear();
    }
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}

/// The workspace holds no stopped run of this query: another query was run in it since, or none was
/// run, or this one is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResumeError;

impl fmt::Display for ResumeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "the workspace does not hold a run of this query (same trees, pose and options)",
        )
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

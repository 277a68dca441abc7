//! The state of a query about points: the current point, and what is known of those before it.

use super::PointBounds;
use super::near::Near;
use super::rim::{Seen, Turn};
use crate::engine::workspace::Workspace;
use crate::room::Room;
use crate::tree::solid::inside::{Count, Probe};
use crate::tree::{MAX_HEIGHT, WIDTH};
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use glam::DVec3;

/// Most nodes that wait while one is open.
const ROOM: usize = MAX_HEIGHT * (WIDTH - 1) + 1;

/// The step that the current point has reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// No point is left.
    Idle,
    /// Nothing was done about the current point yet.
    Start,
    /// A ray is followed.
    Ray,
    /// The boundary of an open surface is visited: vertices first, then edges, `done` of both
    /// together.
    Rim { done: usize },
    /// The nearest triangle is searched.
    Near,
}

/// The state of a query about points in its workspace.
#[derive(Clone, Debug)]
pub(crate) struct PointState {
    /// True if distances are asked for too.
    pub measures: bool,
    pub phase: Phase,
    /// True if a point of several components was inside.
    pub is_within: bool,
    pub point: DVec3,
    /// Number of points from the current one on.
    pub left: usize,
    /// The nodes that wait in a run about a pair, because the frontier of such a run holds node
    /// pairs. The first such run reserves room for all that can wait.
    pub(super) stack: Vec<u32>,
    /// Triangles (tree order) that wait for a test, each with the bits of its key.
    pub uncertain: ArrayVec<[u32; 2], WIDTH>,
    pub(super) probe: Probe,
    pub(super) count: Count,
    pub(super) seen: Vec<Seen>,
    pub(super) turn: Turn,
    pub(super) near: Near,
    /// Winding number and its error, once they are known.
    pub(super) winding: Option<(f64, f64)>,
    /// The points that are done.
    pub found: Room<PointBounds>,
}

impl Default for PointState {
    fn default() -> Self {
        Self {
            measures: false,
            phase: Phase::Idle,
            is_within: false,
            point: DVec3::ZERO,
            left: 0,
            stack: Vec::new(),
            uncertain: ArrayVec::new_const(),
            probe: Probe::NONE,
            count: Count::default(),
            seen: Vec::new(),
            turn: Turn::NONE,
            near: Near::NONE,
            winding: None,
            found: Room::default(),
        }
    }
}

impl PointState {
    #[inline(always)]
    pub fn clear(&mut self) {
        self.phase = Phase::Idle;
        self.left = 0;
        self.stack.clear();
        self.uncertain.clear();
        self.found.clear();
    }

    /// Prepares for `point`, the first of `count` points, and forgets the point before.
    pub fn begin(&mut self, count: usize, measures: bool, point: DVec3) {
        (self.measures, self.is_within) = (measures, false);
        (self.left, self.point) = (count, point);
        self.phase = if count > 0 { Phase::Start } else { Phase::Idle };
        (self.count, self.winding) = (Count::default(), None);
    }

    /// Makes room for all nodes that can wait in a run about a pair.
    pub fn reserve_stack(&mut self) {
        self.stack.reserve(ROOM);
    }

    /// Makes room for the bounds of this many points.
    pub fn reserve(&mut self, points: usize) {
        self.found.reserve_all(points);
    }
}

impl Workspace {
    /// The bounds that the last query found, if it was about points: one for each point done, in
    /// the order of the points.
    pub fn points(&self) -> &[PointBounds] {
        &self.state.points.found
    }

    /// Reserves room for the answers about at least this many points. The first query for a larger
    /// batch of points reserves room for it, and the first about an open solid 24 bytes for each
    /// vertex on an open edge.
    pub fn reserve_points(&mut self, points: usize) {
        self.state.points.reserve(points);
    }

    /// Reserves room to find out whether one solid is inside another.
    pub fn reserve_containment(&mut self) {
        self.state.points.reserve_stack();
    }
}

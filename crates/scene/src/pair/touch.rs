//! The known contacts of two bodies, kept from frame to frame.

use super::spent::Spent;
use super::state::PairState;
use super::travel::slack;
use crate::ask::contacts::ContactPoint;
use crate::body::{Bodies, Placed, margins, radii};
use crate::cost::WORK_PER_TOUCH;
use crate::id::PairKey;
use crate::room::{Room, reserve};
use alloc::boxed::Box;
use alloc::vec::Vec;
use arrayvec::ArrayVec;
use punctual::clock::ManualClock;
use punctual::contacts::Manifold;
use punctual::engine::{Deadline, Fixed, displacement, inherit};
use punctual::intersection::Operand;
use punctual_geom::{Pose, length};

/// Maximum number of pairs of triangles of a pair of bodies that intersect, and of points that are
/// kept.
pub(crate) const MOST_CONTACTS: usize = 512;
pub(crate) const MOST_POINTS: usize = 16;

/// Contacts are found anew once the surfaces have moved by this fraction of the skin.
const REUSED: f64 = 0.25;

/// A point keeps its id while it moves by less than this fraction of the size of the smaller body.
const REACH: f64 = 0.05;

/// The contacts of a pair.
#[derive(Clone, Debug)]
pub(crate) struct Touch {
    pub points: ArrayVec<ContactPoint, MOST_POINTS>,
    /// Every contact that no point stands for was at least this far apart; and true if none of them
    /// was within the margins.
    pub low: f64,
    pub is_whole: bool,
    /// The body that is inside the other, if one is.
    pub within: Option<Operand>,
    /// The triangles of the nearest contact, and an upper bound of their distance.
    pub nearest: Option<([u32; 2], f64)>,
    /// The pose of the second body in the frame of the first when this was found.
    b_in_a: Pose,
    /// The frame in which it was found; 0 if nothing is known.
    pub since: u64,
    /// The last frame that finished the question.
    pub completed: u64,
    /// Work of the last finished run; 0 if there was none.
    pub cost: u64,
    /// Work of the unfinished run.
    pub pending: Spent,
    next_id: u64,
}

impl Touch {
    fn new() -> Box<Self> {
        Box::new(Self {
            points: ArrayVec::new(),
            low: 0.0,
            is_whole: false,
            within: None,
            nearest: None,
            b_in_a: Pose::IDENTITY,
            since: 0,
            completed: 0,
            cost: 0,
            pending: Spent::default(),
            next_id: 0,
        })
    }

    /// Stores the manifolds of two bodies found in `frame`. Contacts not found are at least `low`
    /// apart. A body `within` the other has no points.
    pub fn update(
        &mut self,
        pair: [&Placed; 2],
        manifolds: &[Manifold],
        (low, within): (f64, Option<Operand>),
        b_in_a: &Pose,
        frame: u64,
    ) {
        let low = if within.is_some() { 0.0 } else { low };
        (self.low, self.b_in_a, self.since) = (low.min(margins(pair)), *b_in_a, frame);
        (self.is_whole, self.within) = (low == f64::INFINITY, within);
        let before = core::mem::take(&mut self.points);
        let to_b = b_in_a.inverse_unchecked();
        for (number, manifold) in (0..).zip(manifolds) {
            for point in manifold.points() {
                let found = ContactPoint {
                    manifold: number,
                    id: 0,
                    points: [point.points[0], to_b.transform_point(point.points[1])],
                    normal: point.normal,
                    distance: point.distance,
                };
                if self.points.try_push(found).is_err() {
                    self.low = self.low.min(point.distance.max(0.0));
                    self.is_whole = false;
                }
            }
        }
        if let Some((_, distance)) = self.nearest.filter(|_| self.points.is_empty()) {
            // Surfaces that are not oriented may be near each other without a contact. The nearest
            // triangles are known up to a thousandth of their distance.
            self.low = self.low.min(0.999 * distance - radii(pair));
        }
        let size = pair.map(|placed| length(placed.body.tree.mesh().aabb().extents()));
        self.inherit(before, REACH * size[0].min(size[1]));
    }

    /// Gives each point and manifold the id that it had in the frame before.
    fn inherit(&mut self, before: ArrayVec<ContactPoint, MOST_POINTS>, reach: f64) {
        let fixed = |point: &ContactPoint| Fixed {
            id: point.id,
            manifold: point.manifold,
            places: point.points,
        };
        let before: ArrayVec<Fixed, MOST_POINTS> = before.iter().map(fixed).collect();
        let mut now: ArrayVec<Fixed, MOST_POINTS> = self.points.iter().map(fixed).collect();
        let fresh = |_| {
            self.next_id += 1;
            self.next_id - 1
        };
        inherit(&mut now, &before, reach, fresh);
        for (point, now) in self.points.iter_mut().zip(&now) {
            (point.id, point.manifold) = (now.id, now.manifold);
        }
    }
}

impl Bodies {
    /// Upper bound of how far the surfaces of a pair have moved relative to each other since its
    /// contacts were found; infinite if that is unknown.
    pub fn drift(&self, key: PairKey, touch: &Touch, frame: u64) -> f64 {
        let Some([a, b]) = self.pair(key).filter(|_| touch.since > 0) else {
            return f64::INFINITY;
        };
        if touch.since >= self.last_change(key) {
            return 0.0;
        }
        if self.gone(key, touch.since, frame) == f64::INFINITY {
            return f64::INFINITY;
        }
        let moved = displacement(&b.body.tree, &touch.b_in_a, &a.relative(b));
        let rounding = [a, b].map(|placed| slack(&placed.body.tree, &placed.body.pose));
        moved + rounding[0] + rounding[1]
    }

    /// How far the surfaces of a pair have moved since its contacts were found, if these need not
    /// be found anew.
    pub fn small_drift(&self, key: PairKey, state: &PairState, frame: u64) -> Option<f64> {
        let touch = state.touch.as_ref()?;
        let is_whole = touch.since > 0 && touch.completed == touch.since;
        let skin = self.pair(key).map_or(0.0, margins);
        let drift = is_whole.then(|| self.drift(key, touch, frame));
        drift.filter(|drift| *drift <= REUSED * skin)
    }
}

/// Preallocated contact states for pairs.
#[derive(Debug, Default)]
pub(crate) struct Touches {
    #[allow(clippy::vec_box, reason = "they move in and out by their pointers")]
    free: Vec<Box<Touch>>,
    lent: usize,
    /// Number of pairs with room for contacts, and the number already made, which was paid for.
    room: Room,
    made: usize,
    /// The first id of pairs that get a state. It is above all ids of states that were returned
    /// before this frame. So ids do not depend on which pair gets which state, which in turn
    /// depends on the threads.
    next_id: u64,
    highest_id: u64,
}

impl Touches {
    /// True if pairs may have contact states.
    pub fn any(&self) -> bool {
        self.room.pairs > 0
    }

    /// Makes room for the contacts of at least this many pairs.
    pub fn ask(&mut self, pairs: usize) {
        self.room.ask(pairs.max(1));
        self.fill(&mut Deadline::at(None, u64::MAX, &ManualClock::new()));
    }

    /// Begins a frame.
    pub fn begin(&mut self) {
        self.next_id = self.highest_id;
    }

    /// Makes room for more pairs than are in use or soon will be.
    pub fn grow(&mut self, near: usize, young: bool, deadline: &mut Deadline) {
        if self.any() {
            self.room.grow(self.lent.max(near), young);
            self.fill(deadline);
        }
    }

    fn fill(&mut self, deadline: &mut Deadline) {
        reserve(&mut self.free, self.room.pairs);
        while self.made < self.room.pairs && deadline.has_room(WORK_PER_TOUCH) {
            deadline.spend(WORK_PER_TOUCH);
            self.made += 1;
            // Some may have been made on demand.
            if self.free.len() + self.lent < self.made {
                self.free.push(Touch::new());
            }
        }
    }

    pub fn lend(&mut self) -> Box<Touch> {
        self.lent += 1;
        let mut touch = self.free.pop().unwrap_or_else(Touch::new);
        touch.next_id = self.next_id;
        touch
    }

    pub fn take_back(&mut self, mut touch: Box<Touch>) {
        self.highest_id = self.highest_id.max(touch.next_id);
        touch.points.clear();
        (touch.since, touch.completed, touch.cost, touch.nearest) = (0, 0, 0, None);
        touch.within = None;
        touch.pending = Spent::default();
        self.lent -= 1;
        self.free.push(touch);
    }
}

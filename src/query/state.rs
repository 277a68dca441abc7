//! What the questions keep in the workspace between the calls of a run, beside the frontier.

use super::contacts::list::ContactList;
use super::distance::search::Search;
use super::intersection::state::IntersectionState;
use super::manifolds::state::ManifoldState;
use super::motion::state::MotionState;
use super::near_points::state::NearPoints;
use super::points::state::{Phase, PointState};
use super::rays::state::RayState;

/// One state a question. Questions that ask another one within their run use its state too.
#[derive(Clone, Debug)]
pub(crate) struct State {
    pub intersection: IntersectionState,
    pub distance: Search,
    pub contacts: ContactList,
    pub manifolds: ManifoldState,
    pub motion: MotionState,
    pub rays: RayState,
    pub points: PointState,
    pub near_points: NearPoints,
}

impl State {
    /// Room for `found` intersecting pairs.
    pub fn new(found: usize) -> Self {
        Self {
            intersection: IntersectionState::new(found),
            distance: Search::new(),
            contacts: ContactList::default(),
            manifolds: ManifoldState::default(),
            motion: MotionState::NOTHING,
            rays: RayState::default(),
            points: PointState::default(),
            near_points: NearPoints::default(),
        }
    }

    /// True if nothing is left open here.
    pub fn is_done(&self) -> bool {
        self.distance.is_done()
            && self.motion.followed.is_none()
            && self.rays.candidates.is_empty()
            && self.rays.after == 0
            && self.points.phase == Phase::Idle
    }

    #[inline(always)]
    pub fn clear(&mut self) {
        self.intersection.clear();
        self.distance.clear();
        self.contacts.clear();
        self.manifolds.clear();
        self.motion.followed = None;
        self.rays.clear();
        self.points.clear();
        self.near_points.clear();
    }
}

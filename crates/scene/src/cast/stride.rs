//! How far a body may move before a contact could be missed.

use super::{Region, Sight, Walk, What};
use crate::Scene;
use crate::body::BodyKind;
use crate::broad::bounds::thickened;
use crate::error::SceneError;
use crate::id::{BodyId, PairKey, bodies_of, pair_key};
use crate::pair::apart::STRETCH;
use crate::pair::near::gap;
use crate::pair::touch::Touch;
use core::cmp::Reverse;
use core::mem;
use punctual::clock::ManualClock;
use punctual::engine::Deadline;
use punctual_geom::{Aabb, length};

/// The surroundings of a body.
struct Around {
    sight: Sight,
    bounds: Aabb,
}

impl Region for Around {
    fn sight(&self) -> &Sight {
        &self.sight
    }

    fn bound(&self, bounds: &Aabb, _: bool) -> Option<f64> {
        Some(length(gap(&self.bounds, bounds)) * (1.0 - STRETCH))
    }
}

impl Scene {
    /// How far a body may move from its present pose before it could touch a body where no
    /// [contact point](Scene::contacts) stands, or sink into it there by more than `sink`; at most
    /// `stride`. For solvers, which hold back a body of whose surroundings too little is known. A
    /// negative `sink` is a distance to keep.
    ///
    /// **Promise.** Bodies whose contacts are [requested](Scene::find_contacts) sink into each
    /// other nowhere by more than `sink`, except where contact points stand, whatever the budgets
    /// of the frames, if
    /// - no point of the mesh of a moving body moves farther than this before you ask for all of
    ///   them again (a body that turns by `w` moves its points by at most `w` times its radius);
    /// - fixed bodies rest. Give [kinematic](crate::Body) ones their new poses before you ask.
    ///
    /// So if `sink` is less than the thickness of the bodies, none passes through another. Where
    /// contact points stand, the solver keeps bodies apart: they know how far
    /// ([`ContactPoint::at`]). If two bodies touch in so many places that the points left out may
    /// be sunk too ([`Contacts::low`] of a finished question is 0), these count as touching.
    ///
    /// Of each near body it takes what is proven: [`Contacts::low`] less [`Contacts::drift`], or
    /// the gap of their boxes. Of two moving bodies each may move half of that. It is 0 while
    /// nothing is known, or one is within the other; then give the body an importance, so that it
    /// goes first in the next frame. A [look-ahead](Scene::set_look_ahead) of about a stride lets
    /// bodies without contacts move farther. Pairs without contact requests, such as those of
    /// sensors, do not count.
    ///
    /// Takes time proportional to the near bodies, one search each. Within the room of
    /// [`Scene::reserve`] it does not allocate.
    ///
    /// ```
    /// use punctual::{Budget, Pose, Tree, shapes};
    /// use punctual_scene::{Body, Scene};
    /// use std::sync::Arc;
    ///
    /// let ball = Arc::new(Tree::new(shapes::icosphere(2)));
    /// let at = |z: f64| Pose::from_quat([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, z]).unwrap();
    /// let mut scene = Scene::new();
    /// scene.find_contacts();
    /// let floor = scene.insert(Body::fixed(Arc::clone(&ball), at(0.0)))?;
    /// let id = scene.insert(Body::moving(ball, at(2.2)).margin(0.01))?;
    /// scene.detect(Budget::unlimited());
    /// // The gap of .2, and .02.
    /// assert!((scene.may_move(id, 1.0, 0.02)? - 0.22).abs() < 0.01);
    /// assert_eq!(scene.may_move(id, 0.1, 0.02)?, 0.1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// [`Contacts::low`]: crate::Contacts::low
    /// [`Contacts::drift`]: crate::Contacts::drift
    /// [`ContactPoint::at`]: crate::ContactPoint::at
    ///
    /// # Errors
    /// If the body is not in the scene.
    pub fn may_move(&mut self, id: BodyId, stride: f64, sink: f64) -> Result<f64, SceneError> {
        let body = &self.bodies.get(id)?.body;
        let around = Around {
            sight: Sight {
                body: Some(id),
                ..Sight::default()
            },
            bounds: thickened(body.tree.aabb_at(&body.pose), body.margin),
        };
        let mut queue = mem::take(&mut self.casts.own.queue);
        let walk = Walk {
            bodies: &self.bodies,
            broad: &self.broad,
        };
        let clock = ManualClock::new();
        let unlimited = &mut Deadline::at(None, u64::MAX, &clock);
        walk.begin(&around, &mut queue, unlimited);
        let mut most = stride.max(0.0);
        while let Some(Reverse((bits, what))) = queue.pop()
            && 0.5 * (f64::from_bits(bits) + sink.min(0.0)) < most
        {
            match what {
                What::Node(node) => walk.open(&around, &mut queue, node),
                What::Body(other) => {
                    let key = pair_key(id.index, other);
                    if let Some(share) = self.share(key) {
                        let gap = f64::from_bits(bits);
                        let room = if gap > 0.0 {
                            self.room(key).max(gap)
                        } else {
                            self.room(key)
                        };
                        most = most.min((share * (room + sink)).max(0.0));
                    }
                }
            }
        }
        queue.clear();
        self.casts.own.queue = queue;
        Ok(most)
    }

    /// The part that a moving body may use of the room of a pair. `None` if the pair has no
    /// contacts.
    fn share(&self, key: PairKey) -> Option<f64> {
        let pair = self.bodies.pair(key)?;
        let fixed = pair.map(|placed| placed.body.kind == BodyKind::Fixed);
        let is_asked = fixed != [true; 2] && self.bodies.wants_contacts(key);
        is_asked.then_some(if fixed == [false; 2] { 0.5 } else { 1.0 })
    }

    /// How far two bodies may move relative to each other before they touch where no point stands;
    /// negative if they may have sunk in there, minus infinity if nothing is known.
    fn room(&self, key: PairKey) -> f64 {
        let [a, b] = bodies_of(key).map(|body| self.bodies.id(body));
        let Ok(found) = self.contacts(a, b) else {
            return f64::NEG_INFINITY;
        };
        let is_finished = |touch: &Touch| touch.completed == touch.since;
        let is_known = found.is_whole
            || found.low > 0.0
            || found.within.is_none() && self.pairs.touch(key).is_some_and(is_finished);
        if is_known {
            found.low - found.drift
        } else {
            f64::NEG_INFINITY
        }
    }
}

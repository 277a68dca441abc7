//! Distance bounds without a query: from the boxes of bodies, and from earlier proofs minus the
//! displacement since. The proofs are in `docs/numerics.md`.

use super::apart::{STRETCH, room};
use super::bounds::{Bounds, Near};
use super::state::PairState;
use super::travel::slack;
use crate::body::{Bodies, thickness};
use crate::id::{PairKey, bodies_of};
use glam::DVec3;
use punctual_geom::{Aabb, length};

impl Bodies {
    /// The known distance bounds of a pair in `frame`. The bodies last changed in `changed`.
    pub fn near(&self, key: PairKey, state: &PairState, changed: u64, frame: u64) -> Near {
        let (bounds, since, _) = state.proven();
        let is_of_query = since >= changed;
        let bounds = if is_of_query {
            bounds
        } else {
            self.carried(key, bounds, since, frame)
        };
        let low = bounds.low.max(self.boxes_apart(key)[0]);
        Near {
            bounds: Bounds { low, ..bounds },
            is_of_query,
        }
    }

    /// The distance bounds of a pair from its boxes alone.
    pub fn near_by_boxes(&self, key: PairKey) -> Near {
        let low = self.boxes_apart(key)[0];
        Near {
            bounds: Bounds {
                low,
                ..Bounds::NOTHING
            },
            is_of_query: false,
        }
    }

    /// The part of bounds, proven in frame `since`, that still holds in `frame`.
    pub fn carried(&self, key: PairKey, bounds: Bounds, since: u64, frame: u64) -> Bounds {
        let Some(pair) = self.pair(key) else {
            return Bounds::NOTHING;
        };
        let gone = self.gone(key, since, frame);
        if gone == f64::INFINITY {
            return Bounds::NOTHING;
        }
        let way = (gone - bounds.gone).next_up();
        let low = (room(pair, bounds.low) - way).max(0.0);
        let high = (bounds.high + thickness(pair) + way) * (1.0 + STRETCH) - thickness(pair);
        let rounding: f64 = pair
            .map(|placed| slack(&placed.body.tree, &placed.body.pose))
            .iter()
            .sum();
        Bounds {
            low,
            high: high + rounding,
            below: 0.0,
            ..bounds
        }
    }

    /// Bounds of the distance of a pair from its boxes.
    pub fn boxes_apart(&self, key: PairKey) -> [f64; 2] {
        let nothing = [0.0, f64::INFINITY];
        let Some(pair) = self.pair(key) else {
            return nothing;
        };
        if bodies_of(key)
            .into_iter()
            .any(|body| self.facts(body).is_changed())
        {
            return nothing;
        }
        let [x, y] = bodies_of(key).map(|body| self.bounds(body));
        if x.is_empty() || y.is_empty() {
            return [f64::INFINITY; 2];
        }
        let [gap, span] = [gap(x, y), span(x, y)].map(length);
        [
            (gap - STRETCH * (gap + thickness(pair))).max(0.0),
            span * (1.0 + STRETCH),
        ]
    }
}

/// Gap between two boxes along each axis; 0 if they overlap.
pub(crate) fn gap(x: &Aabb, y: &Aabb) -> DVec3 {
    (x.min - y.max).max(y.min - x.max).max(DVec3::ZERO)
}

/// Extent of both boxes together along each axis.
fn span(x: &Aabb, y: &Aabb) -> DVec3 {
    (x.max - y.min).max(y.max - x.min)
}

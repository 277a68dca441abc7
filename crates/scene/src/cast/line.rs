//! The parameter at which a ray of the scene enters a box.

use super::path::crossing;
use glam::DVec3;
use punctual_geom::tolerance::UNDERFLOW;
use punctual_geom::{Aabb, Ray, largest};

/// Widening of a box, relative to the largest coordinate of the ray's origin or of the box. It
/// covers the error of mapping the ray to the coordinates of a body and back. Either map multiplies
/// by an inverse matrix, whose entries have errors of less than 16 roundings. It maps points and
/// directions no farther than to where the ray passes the box. The margin of the box covers the
/// error from the translation of the body ([`crate::broad::bounds`]).
const MARGIN: f64 = 128.0 * f64::EPSILON;

/// Error of a reported parameter, in units of the size of coordinates over the largest component of
/// the direction: 1e-11 ([`punctual::rays::RayHit::t`]), for coordinates up to sqrt 3 larger and a
/// component up to sqrt 3 smaller in the frame of the body.
const SLACK: f64 = 4e-11;

/// A direction no longer than this is lost in absolute roundings: the ray counts as entering all
/// boxes at once.
const SHORTEST: f64 = 1e-290;

/// A ray of the scene.
pub(crate) struct Line {
    origin: DVec3,
    direction: DVec3,
    end: f64,
    limits: [f64; 2],
}

impl Line {
    pub fn new(ray: &Ray) -> Self {
        let end = if ray.is_segment() { 1.0 } else { f64::INFINITY };
        Self {
            origin: ray.origin(),
            direction: ray.direction(),
            end,
            limits: ray.limits(),
        }
    }

    /// A lower bound of the reported parameters of hits in a box; `None` if there can be none.
    pub fn enter(&self, bounds: &Aabb) -> Option<f64> {
        if bounds.is_empty() {
            return None;
        }
        let size = largest(self.origin.abs()) + largest(bounds.min.abs().max(bounds.max.abs()));
        let longest = largest(self.direction.abs());
        let (margin, slack) = (MARGIN * size + UNDERFLOW, SLACK * size / longest);
        if longest < SHORTEST || !slack.is_finite() {
            return Some(0.0);
        }
        let (low, high) = (
            bounds.min - self.origin - margin,
            bounds.max - self.origin + margin,
        );
        let rates = [-self.direction, self.direction];
        let [enter, leave] = crossing([low, -high], rates, self.end)?;
        let (enter, leave) = (enter - slack, leave + slack);
        let [from, to] = self.limits;
        let misses = enter > leave || enter > to || leave < from;
        // 0.0 instead of -0.0.
        (!misses).then(|| enter.max(0.0) + 0.0)
    }
}

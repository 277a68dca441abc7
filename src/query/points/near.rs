//! The distance of a point: bounds of boxes in `f32`, and of triangles in `f64`.
//!
//! A box is dropped if its squared distance is not below the square of the upper bound, or if it
//! lies behind a plane: through the nearest point found, perpendicular to the line from the point
//! to it. The first bound is sharp near the mesh. The second is sharp far from it, where the
//! distances of all boxes differ by less than their rounding. Proof of both: `docs/numerics.md`.

use crate::tree::{Node, Tree, WIDTH};
use glam::DVec3;
use punctual_geom::lanes::{Column, F8, Lanes, per_axis};
use punctual_geom::largest;
use punctual_geom::tolerance::ROUNDING;
use punctual_geom::triangle::distance::{Closest, closest_or_meeting, closest_to_point};
use wide::f32x4;

/// Bounds of the distance of a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    /// The least lower bound of the triangles tested.
    low: f64,
    pub high: f64,
    /// Triangle (tree order) and point at the distance `high`.
    pub nearest: (u32, DVec3),
    /// The point in unit coordinates, and the error of distances along an axis.
    origin: [f32; 3],
    margin: f32,
    /// Squared distance in units from which on nothing matters.
    pub cut: f32,
    /// Direction from the nearest point to the point. Boxes whose upper end along it is at most
    /// `behind` lie behind the plane through the nearest point.
    normal: [f32; 3],
    behind: f32,
}

/// Roundings of coordinates and boxes, for a point within the mesh's box.
const MARGIN: f32 = 128.0 * ROUNDING;

/// Roundings of a square, and of axes that are not exactly orthonormal.
const SHRINK: f32 = 1.0 - 64.0 * ROUNDING;

/// Largest distance in units at which `f32` is useful for boxes.
const LARGEST_REACH: f64 = 1e15;

/// Everything dropped behind a plane is at least this fraction of `high` away.
const DROPPED: f64 = 1.0 - 1e-13;

impl Near {
    pub const NONE: Self = Self {
        low: f64::INFINITY,
        high: f64::INFINITY,
        nearest: (0, DVec3::ZERO),
        origin: [0.0; 3],
        margin: 0.0,
        cut: f32::INFINITY,
        normal: [0.0; 3],
        behind: f32::NEG_INFINITY,
    };

    /// The state before any box is opened. The tree is not empty.
    pub fn new(tree: &Tree, point: DVec3) -> Self {
        let origin = tree.unit().point(point);
        let reach = largest(origin.abs());
        let mut near = Self::NONE;
        if reach < LARGEST_REACH {
            near.origin = origin.as_vec3().to_array();
            near.margin = MARGIN * (1.0 + reach as f32);
        } else {
            near.margin = f32::MAX;
        }
        let [corner, ..] = tree.corners(0);
        if let Some(first) = closest_to_point(&[corner; 3], point) {
            near.improve(tree, point, 0, &first);
        }
        near
    }

    /// Takes a triangle's bounds into account. Returns true if that took long.
    #[inline(always)]
    pub fn settle(&mut self, tree: &Tree, point: DVec3, triangle: u32) -> bool {
        let corners = tree.corners(triangle);
        let fast = closest_to_point(&corners, point);
        let found = match fast {
            Some(found) => found,
            None => closest_or_meeting(&corners, &[point; 3]),
        };
        self.low = self.low.min(found.low);
        if found.high < self.high {
            self.improve(tree, point, triangle, &found);
        }
        fast.is_none()
    }

    fn improve(&mut self, tree: &Tree, point: DVec3, triangle: u32, found: &Closest) {
        let [foot, _] = found.points;
        (self.high, self.nearest) = (found.high, (triangle, foot));
        let unit = tree.unit();
        let high = found.high * unit.scale();
        self.cut = ((high * high * (1.0 + 1e-6)) as f32).max(f32::MIN_POSITIVE);
        let way = point - foot;
        let length = largest(way.abs());
        let normal = (way / length).as_vec3();
        // Where the way is not known well, a plane proves nothing.
        if normal.is_finite() && length * unit.scale() > LEAST_WAY {
            self.normal = normal.to_array();
            let at = normal.as_dvec3().dot(unit.point(foot));
            self.behind = at as f32 - PLANE_MARGIN;
        } else {
            self.behind = f32::NEG_INFINITY;
        }
    }

    /// The lower bound of the distance when nothing is left to visit.
    pub fn finished(&self) -> f64 {
        self.low.min(self.high * DROPPED)
    }

    /// Lower bound of the distance if `open` is the least key of what is left.
    pub fn low(&self, tree: &Tree, open: f32) -> f64 {
        let low = libm::sqrt(f64::from(open)) * (1.0 - f64::EPSILON) * tree.unit().length();
        low.min(self.finished())
    }

    /// Lower bounds of the squared distances in units of the boxes of a node's children, and the
    /// mask of those that matter.
    #[inline(always)]
    pub fn keys<L: Lanes>(&self, lanes: L, node: &Node) -> ([f32; WIDTH], u32) {
        let seen = |v: [f32; 3]| {
            let [x, y, z] = per_axis!(k => node.rows[k] * f32x4::splat(v[k]));
            (x + y + z).to_array()
        };
        let (origin, normal) = (seen(self.origin), seen(self.normal));
        let zero = F8::splat(lanes, 0.0);
        let margin = F8::splat(lanes, self.margin);
        let (mut square, mut ahead) = (zero, zero);
        for k in 0..3 {
            let (center, half) = (
                F8::read(lanes, &node.center[k]),
                F8::read(lanes, &node.half[k]),
            );
            let gap = (center - F8::splat(lanes, origin[k])).abs() - half - margin;
            let gap = gap.max(zero);
            square = square + gap * gap;
            let normal = F8::splat(lanes, normal[k]);
            ahead = ahead + normal * center + normal.abs() * half;
        }
        let square = square * F8::splat(lanes, SHRINK);
        let near = square.less(F8::splat(lanes, self.cut));
        let chosen = near.and(F8::splat(lanes, self.behind).less(ahead)).mask();
        (square.store(), chosen & node.valid())
    }
}

/// Way to the point, in units, up to which its direction is too inexact.
const LEAST_WAY: f64 = 1e-9;

/// Twice the rounding, in units, of a projection on a direction whose largest component is 1.
const PLANE_MARGIN: f32 = 512.0 * ROUNDING;

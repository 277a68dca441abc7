//! A body of one point or one segment, such as the core of a ball or a capsule, against the boxes
//! of the other tree: lower bounds of distances in `f32`, eight boxes at a time.
//!
//! Only the nodes of the other tree are opened, and only along their own axes: the lone body needs
//! no box. A bound is the largest of three: of the gaps along the axes of a box, of the gap across
//! the segment and an axis, and of the gap along the direction between the closest points found.
//! Their proof: `docs/numerics.md`.

use crate::engine::boxes::RelativePose;
use crate::tree::{Node, Tree};
use glam::DVec3;
use punctual_geom::lanes::{Column, F8, Lanes, per_axis};
use punctual_geom::largest;
use punctual_geom::tolerance::ROUNDING;
use punctual_geom::triangle::distance::{Closest, closest_to_point};
use wide::f32x4;

/// A point or a segment, in the unit coordinates of the tree whose boxes it is compared with.
#[derive(Clone, Copy)]
pub(crate) struct Lone {
    /// True if it is A.
    pub is_a: bool,
    pub is_point: bool,
    middle: [f32; 3],
    /// From the middle to an end.
    half: [f32; 3],
    /// Direction from A to B, no longer than 1.
    along: [f32; 3],
    /// Bound of the errors along an axis.
    margin: f32,
    /// Length of the unit in A's units, and factor from squares to squares in A's units.
    unit: f32,
    square_unit: f32,
}

/// Roundings of coordinates and boxes, for a point within the tree's box.
const MARGIN: f64 = 128.0 * ROUNDING as f64;

/// Farther away, in units, the errors of boxes along their own axes are too large.
const MOST_REACH: f64 = 16.0;

/// Least squared length of an axis across the segment.
const LEAST_AXIS: f32 = 1e-12;

impl Lone {
    /// The lone body of two, if there is one and its bounds are useful.
    pub fn of(trees: [&Tree; 2], relative: &RelativePose) -> Option<Self> {
        let is_a = !is_lone(trees[1]);
        if is_a && !is_lone(trees[0]) || relative.shrink == 0.0 {
            return None;
        }
        let lone = trees[usize::from(!is_a)];
        let (linear, scale) = (relative.linear(), f64::from(relative.scale));
        let [ends @ .., _] = lone.corners(0).map(|corner| {
            let place = lone.unit().point(corner);
            if is_a {
                linear.transpose() * (place - relative.middle()) / (scale * scale)
            } else {
                linear * place + relative.middle()
            }
        });
        let (middle, half) = ((ends[0] + ends[1]) / 2.0, (ends[1] - ends[0]) / 2.0);
        let reach = largest(middle.abs()) + largest(half.abs());
        let unit = if is_a { scale } else { 1.0 };
        let error = f64::from(relative.triangles.position_error) / unit;
        let turned = MARGIN + f64::from(relative.rotation_error);
        // Also false for NaN.
        let is_near = reach <= MOST_REACH;
        is_near.then(|| Self {
            is_a,
            is_point: ends[0] == ends[1],
            middle: middle.as_vec3().to_array(),
            half: half.as_vec3().to_array(),
            along: [0.0; 3],
            margin: (MARGIN + turned * reach + error) as f32,
            unit: unit as f32,
            square_unit: (unit * unit) as f32 * relative.shrink * relative.shrink,
        })
    }

    /// Takes a direction from A to B, in A's unit coordinates, of length 1 or less.
    pub fn turn(&mut self, relative: &RelativePose, direction: DVec3) {
        let in_tree = if self.is_a {
            relative.linear().transpose() * direction / f64::from(relative.scale)
        } else {
            direction
        };
        self.along = (in_tree * SHORTER).as_vec3().to_array();
    }

    /// Keys of the boxes of a node's children, in A's units: squared lower bounds of distances, or
    /// minus the depth. `swell` is the factor of half extents.
    #[inline(always)]
    pub fn keys<L: Lanes>(&self, lanes: L, node: &Node, swell: f32) -> F8<L> {
        let of = |x: f32| F8::splat(lanes, x);
        let seen = |v: [f32; 3]| {
            let [x, y, z] = per_axis!(k => node.rows[k] * f32x4::splat(v[k]));
            (x + y + z).to_array()
        };
        let (middle, half, along) = (seen(self.middle), seen(self.half), seen(self.along));
        let (zero, margin) = (of(0.0), of(self.margin));
        let offset = per_axis!(k => of(middle[k]) - F8::read(lanes, &node.center[k]));
        let size = per_axis!(k => F8::read(lanes, &node.half[k]) * of(swell) + margin);
        let gaps = per_axis!(k => offset[k].abs() - size[k] - of(half[k].abs()));
        let [x, y, z] = per_axis!(k => gaps[k].max(zero));
        let mut square = x * x + y * y + z * z;
        if !self.is_point {
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                let [n, m] = [half[j], -half[i]];
                let length = n * n + m * m;
                if length > LEAST_AXIS {
                    let gap = (offset[i] * of(n) + offset[j] * of(m)).abs()
                        - (size[i] * of(n.abs()) + size[j] * of(m.abs()));
                    let gap = gap.max(zero);
                    square = square.max(gap * gap * of(1.0 / length));
                }
            }
        }
        let towards = if self.is_a { -1.0 } else { 1.0 };
        let mut ahead = of(-self.margin);
        for k in 0..3 {
            let beyond = offset[k] * of(towards * along[k]);
            ahead = ahead + beyond - (size[k] + of(half[k].abs())) * of(along[k].abs());
        }
        let ahead = ahead.max(zero);
        let depth = zero.max(zero - gaps[0].max(gaps[1]).max(gaps[2]));
        square.max(ahead * ahead) * of(self.square_unit) - depth * of(self.unit)
    }
}

impl Lone {
    /// The closest points of two triangles of which the lone body is a point.
    pub fn closest(&self, a: &[DVec3; 3], b: &[DVec3; 3]) -> Option<Closest> {
        if !self.is_a {
            return closest_to_point(a, b[0]);
        }
        let found = closest_to_point(b, a[0])?;
        let [of_b, of_a] = found.points;
        Some(Closest {
            points: [of_a, of_b],
            direction: -found.direction,
            ..found
        })
    }
}

/// Factor of directions, so that rounding makes none longer than 1.
const SHORTER: f64 = 1.0 - 1e-5;

/// True for the tree of one point or segment that is no cloud.
fn is_lone(tree: &Tree) -> bool {
    tree.mesh().len() == 1 && !tree.is_cloud() && {
        let [_, q, r] = tree.corners(0);
        q == r
    }
}

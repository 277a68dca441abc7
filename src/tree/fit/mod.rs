//! Boxes along the axes of their nodes, computed exactly from the corners of the triangles, eight
//! triangles at a time.
//!
//! An inner node need not visit every triangle of a large child. If a box already contains the box
//! of a subtree, nothing in that subtree can extend it. So whole subtrees are skipped, and the
//! result has the same bits as with all corners. Subtrees must be fitted before the nodes above
//! them.

pub(crate) mod alpha;
pub(crate) mod bounds;
pub(crate) mod profile;
pub(crate) mod refit;
pub(crate) mod scaled;
pub(crate) mod update;

use crate::tree::build::binary::Bounds;
use crate::tree::build::eight::Eight;
use crate::tree::unit::Triangle;
use crate::tree::wide::{Node, WIDTH, xyz};
use arrayvec::ArrayVec;
use glam::Vec3A;
use punctual_geom::lanes::{Column, F8, Lanes, V8, dot, greatest, least, per_axis};
use wide::f32x4;

/// A box along the axes of some node.
#[derive(Clone, Copy)]
pub(crate) struct Extent {
    min: Vec3A,
    max: Vec3A,
}

/// Margin of a subtree's box in the axes of a node above (unit coordinates). It exceeds the
/// distance by which rounding may move a corner in these axes, or in the axes of the box.
const MARGIN: f32 = 1e-5;

/// Subtrees with no more triangles than this are not worth skipping.
const SMALL: u32 = 128;

impl Extent {
    pub const EMPTY: Self = Self {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
    };

    /// The box around eight points.
    #[inline(always)]
    pub fn of<L: Lanes>(points: V8<L>) -> Self {
        Self {
            min: least(points).into(),
            max: greatest(points).into(),
        }
    }

    /// As the box of a primitive of a binary tree.
    pub fn bounds(&self, primitive: u32) -> Bounds {
        Bounds::new(primitive, self.min.to_array(), self.max.to_array())
    }

    #[inline(always)]
    pub fn add(&mut self, point: Vec3A) {
        (self.min, self.max) = (self.min.min(point), self.max.max(point));
    }

    /// The box between the images of both ends.
    #[inline(always)]
    pub fn map(self, of: impl Fn(Vec3A) -> Vec3A) -> Self {
        Self {
            min: of(self.min),
            max: of(self.max),
        }
    }

    #[inline(always)]
    pub fn center(&self) -> Vec3A {
        (self.min + self.max) * 0.5
    }

    #[inline(always)]
    pub fn half(&self) -> Vec3A {
        (self.max - self.min) * 0.5
    }

    #[inline(always)]
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Stores the ends of this box in the fields of `node` for its center and half extent.
    #[inline(always)]
    pub fn keep_in(&self, node: &mut Node) {
        node.own_center = f32x4::new(self.min.extend(0.0).to_array());
        node.own_half = f32x4::new(self.max.extend(0.0).to_array());
    }

    #[inline(always)]
    pub fn kept_in(node: &Node) -> Self {
        Self {
            min: Vec3A::from(xyz(node.own_center)),
            max: Vec3A::from(xyz(node.own_half)),
        }
    }

    /// The box of all triangles below `subtree` along the axes of `node`. `later` are the nodes
    /// from number `first` on.
    #[inline(always)]
    pub fn of_subtree<L: Lanes>(
        lanes: L,
        subtree: &Node,
        node: &Node,
        later: &[Node],
        first: usize,
        triangles: &[Triangle],
    ) -> Self {
        let all = &triangles[subtree.triangle_range()];
        if subtree.triangles <= SMALL {
            return Span::of_all(lanes, all, node).extent();
        }
        // Begins with triangles from all parts of the subtree, so that most of the others can be
        // skipped.
        let step = all.len() / WIDTH;
        let [a, b, c, d] = [&all[0], &all[step], &all[2 * step], &all[3 * step]];
        let [e, f, g, h] = [
            &all[4 * step],
            &all[5 * step],
            &all[6 * step],
            &all[7 * step],
        ];
        let mut extent = span(lanes, &Eight::of(lanes, [a, b, c, d, e, f, g, h]), node).extent();

        // The nodes whose children are still to be visited.
        let mut open = ArrayVec::<&Node, 128>::new();
        open.push(subtree);
        while let Some(inner) = open.pop() {
            let mut children = inner.valid();
            loop {
                children &= extent.reached_out_of(lanes, inner, node);
                if children == 0 {
                    break;
                }
                let child =
                    &later[inner.first_child as usize + children.trailing_zeros() as usize - first];
                children &= children - 1;
                if child.triangles <= SMALL || open.is_full() {
                    extent = extent.union(
                        Span::of_all(lanes, &triangles[child.triangle_range()], node).extent(),
                    );
                } else {
                    open.push(child);
                }
            }
        }
        extent
    }

    /// Bit mask of the children of `inner` whose boxes may extend beyond this box. This box has the
    /// axes of `node`.
    #[inline(always)]
    fn reached_out_of<L: Lanes>(&self, lanes: L, inner: &Node, node: &Node) -> u32 {
        let turn = node.axes().transpose() * inner.axes();
        let center = per_axis!(k => F8::read(lanes, &inner.center[k]));
        let half = per_axis!(k => F8::read(lanes, &inner.half[k]));
        let [x, y, z] = per_axis!(k => {
            let row = per_axis!(j => F8::splat(lanes, turn.col(j)[k]));
            let center = dot(row, center);
            let half = dot(per_axis!(j => row[j].abs()), half) + F8::splat(lanes, MARGIN);
            let (min, max) = (F8::splat(lanes, self.min[k]), F8::splat(lanes, self.max[k]));
            (center - half).less(min).or(max.less(center + half))
        });
        x.or(y).or(z).mask()
    }
}

/// The boxes of eight triangles along the axes of `node`.
#[inline(always)]
pub(crate) fn span<L: Lanes>(lanes: L, triangles: &Eight<L>, node: &Node) -> Span<L> {
    let [a, b, c] = triangles.corners();
    let ends = per_axis!(k => {
        let axis = per_axis!(j => F8::splat(lanes, node.rows[j].as_array()[k]));
        let (x, y, z) = (dot(axis, a), dot(axis, b), dot(axis, c));
        (x.min(y).min(z), x.max(y).max(z))
    });
    Span {
        min: per_axis!(k => ends[k].0),
        max: per_axis!(k => ends[k].1),
    }
}

/// Eight boxes, given by their ends.
#[derive(Clone, Copy)]
pub(crate) struct Span<L: Lanes> {
    pub min: V8<L>,
    pub max: V8<L>,
}

impl<L: Lanes> Span<L> {
    /// Boxes along the axes of `node` that together contain all `triangles`, of which there is at
    /// least one.
    #[inline(always)]
    fn of_all(lanes: L, triangles: &[Triangle], node: &Node) -> Self {
        let (Some(mut next), Some(last)) = (triangles.first_chunk(), triangles.last_chunk()) else {
            return span(lanes, &Eight::of_few(lanes, triangles), node);
        };
        // The last eight may overlap those before.
        let mut all = span(lanes, &Eight::of_chunk(lanes, last), node);
        let mut rest = triangles;
        while rest.len() > WIDTH {
            all = all.union(span(lanes, &Eight::of_chunk(lanes, next), node));
            rest = &rest[WIDTH..];
            next = rest.first_chunk().unwrap_or(last);
        }
        all
    }

    #[inline(always)]
    fn union(self, other: Self) -> Self {
        Self {
            min: per_axis!(k => self.min[k].min(other.min[k])),
            max: per_axis!(k => self.max[k].max(other.max[k])),
        }
    }

    /// The box around all eight.
    #[inline(always)]
    pub fn extent(self) -> Extent {
        Extent {
            min: Vec3A::from(least(self.min)),
            max: Vec3A::from(greatest(self.max)),
        }
    }
}

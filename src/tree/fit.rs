//! Boxes along the axes of their nodes, computed exactly from the corners of the triangles, eight triangles at a time.
//!
//! An inner node need not look at every triangle of a large child: what lies in the box of a subtree cannot extend a box that
//! holds it already, so whole subtrees are passed over, and the result is to the bit what all corners would give.
//! Subtrees must be fitted before what is above them.

use super::unit::Triangle;
use super::wide::{Node, WIDTH, xyz};
use crate::math::lanes::{F8, Lanes, V8, dot, per_axis};
use arrayvec::ArrayVec;
use core::ops::Range;
use glam::Vec3A;
use wide::f32x4;

/// A box along the axes of some node.
#[derive(Clone, Copy)]
pub(super) struct Extent {
    min: Vec3A,
    max: Vec3A,
}

/// More than rounding may move a corner along the axes of a node above or in its own box, unit coordinates.
const MARGIN: f32 = 1e-5;

/// Subtrees of no more triangles are not worth passing over.
const SMALL: u32 = 128;

impl Extent {
    pub const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

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
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The box of all triangles below `subtree` along the axes of `node`; `later` are the nodes from number `first` on.
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
        // Some triangles from everywhere, so that most of the rest can be passed over.
        let step = all.len() / WIDTH;
        let [a, b, c, d] = [&all[0], &all[step], &all[2 * step], &all[3 * step]];
        let [e, f, g, h] = [&all[4 * step], &all[5 * step], &all[6 * step], &all[7 * step]];
        let mut extent = Eight::of(lanes, [a, b, c, d, e, f, g, h]).span(lanes, node).extent();

        // What is still to be looked at, a range of siblings for each level.
        let mut ranges = ArrayVec::<Range<usize>, 128>::new();
        ranges.push(subtree.child_range());
        while let Some(range) = ranges.last_mut() {
            let Some(next) = range.next() else {
                ranges.pop();
                continue;
            };
            let next = &later[next - first];
            if extent.holds(next, node) {
                continue;
            }
            if next.triangles <= SMALL || ranges.is_full() {
                extent = extent.union(Span::of_all(lanes, &triangles[next.triangle_range()], node).extent());
            } else {
                ranges.push(next.child_range());
            }
        }
        extent
    }

    /// Whether the box of `inner` lies inside this one, which has the axes of `node`.
    #[inline(always)]
    fn holds(&self, inner: &Node, node: &Node) -> bool {
        let turn = node.axes().transpose() * inner.axes();
        let center = turn * Vec3A::from(xyz(inner.own_center));
        let half = turn.abs() * Vec3A::from(xyz(inner.own_half)) + Vec3A::splat(MARGIN);
        (self.min.cmple(center - half) & self.max.cmpge(center + half)).all()
    }
}

/// The corners of eight triangles.
#[derive(Clone, Copy)]
pub(super) struct Eight<L: Lanes>([V8<L>; 3]);

impl<L: Lanes> Eight<L> {
    #[inline(always)]
    fn of(lanes: L, [a, b, c, d, e, f, g, h]: [&Triangle; WIDTH]) -> Self {
        macro_rules! part {
            ($i:expr) => {
                F8::transpose(lanes, [&a.0[$i], &b.0[$i], &c.0[$i], &d.0[$i], &e.0[$i], &f.0[$i], &g.0[$i], &h.0[$i]])
            };
        }
        let [px, py, pz, ex] = part!(0);
        let [ey, ez, fx, fy] = part!(1);
        let [fz, ..] = part!(2);
        Self([[px, py, pz], [px + ex, py + ey, pz + ez], [px + fx, py + fy, pz + fz]])
    }

    /// Of up to eight triangles, at least one; the last again where there are no more.
    #[inline(always)]
    pub fn of_few(lanes: L, triangles: &[Triangle]) -> Self {
        let last = triangles.len() - 1;
        macro_rules! at {
            ($i:expr) => {
                &triangles[$i.min(last)]
            };
        }
        Self::of(lanes, [at!(0), at!(1), at!(2), at!(3), at!(4), at!(5), at!(6), at!(7)])
    }

    #[inline(always)]
    fn of_chunk(lanes: L, [a, b, c, d, e, f, g, h]: &[Triangle; WIDTH]) -> Self {
        Self::of(lanes, [a, b, c, d, e, f, g, h])
    }

    /// Their boxes along the axes of `node`.
    #[inline(always)]
    pub fn span(&self, lanes: L, node: &Node) -> Span<L> {
        let ends = per_axis!(k => {
            let axis = per_axis!(j => F8::splat(lanes, node.rotation[k].as_array()[j]));
            let (x, y, z) = (dot(axis, self.0[0]), dot(axis, self.0[1]), dot(axis, self.0[2]));
            (x.min(y).min(z), x.max(y).max(z))
        });
        Span { min: per_axis!(k => ends[k].0), max: per_axis!(k => ends[k].1) }
    }
}

/// Eight boxes by their ends.
#[derive(Clone, Copy)]
pub(super) struct Span<L: Lanes> {
    pub min: V8<L>,
    pub max: V8<L>,
}

impl<L: Lanes> Span<L> {
    /// Boxes along the axes of `node` that together hold all of at least one triangle.
    #[inline(always)]
    fn of_all(lanes: L, triangles: &[Triangle], node: &Node) -> Self {
        let (Some(mut next), Some(last)) = (triangles.first_chunk(), triangles.last_chunk()) else {
            return Eight::of_few(lanes, triangles).span(lanes, node);
        };
        // The last eight may overlap those before.
        let mut all = Eight::of_chunk(lanes, last).span(lanes, node);
        let mut rest = triangles;
        while rest.len() > WIDTH {
            all = all.union(Eight::of_chunk(lanes, next).span(lanes, node));
            rest = &rest[WIDTH..];
            next = rest.first_chunk().unwrap_or(last);
        }
        all
    }

    #[inline(always)]
    fn union(self, other: Self) -> Self {
        Self { min: per_axis!(k => self.min[k].min(other.min[k])), max: per_axis!(k => self.max[k].max(other.max[k])) }
    }

    /// The box around all eight.
    #[inline(always)]
    pub fn extent(self) -> Extent {
        let [x, y, z] = per_axis!(k => halves(self.min[k]));
        let [a, b, c, d] = f32x4::transpose([x[0].fast_min(x[1]), y[0].fast_min(y[1]), z[0].fast_min(z[1]), z[0]]);
        let min = a.fast_min(b).fast_min(c.fast_min(d));
        let [x, y, z] = per_axis!(k => halves(self.max[k]));
        let [a, b, c, d] = f32x4::transpose([x[0].fast_max(x[1]), y[0].fast_max(y[1]), z[0].fast_max(z[1]), z[0]]);
        let max = a.fast_max(b).fast_max(c.fast_max(d));
        Extent { min: Vec3A::from(xyz(min)), max: Vec3A::from(xyz(max)) }
    }
}

#[inline(always)]
pub(super) fn halves<L: Lanes>(x: F8<L>) -> [f32x4; 2] {
    let [a, b, c, d, e, f, g, h] = x.store();
    [f32x4::new([a, b, c, d]), f32x4::new([e, f, g, h])]
}

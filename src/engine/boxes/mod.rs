//! Boxes of two nodes, eight at a time, along the six face axes.
//!
//! A box with centre `c` and half extents `h`, seen from the orientation of a node of the other
//! side ([`View`]), lies within `M c + t ± (|M| h + m)`. `m` covers every rounding and is proven in
//! `docs/numerics.md`. So no overlap is lost; a box kept needlessly only costs time. The other nine
//! axes are in [`edge_axes`]. All lengths are in A's units.

pub(crate) mod close_boxes;
pub(crate) mod edge_axes;
pub(crate) mod flushing;
pub(crate) mod overlap;
pub(crate) mod relative_pose;

mod planes;

use crate::tree::{Node, WIDTH, xyz};
pub(crate) use planes::{Plane, Planes};
use punctual_geom::lanes::{Column, F8, Lanes, V8, dot, per_axis};
use punctual_geom::triangle::batch::Rows;
pub(crate) use relative_pose::RelativePose;
use relative_pose::View;
use wide::f32x4;

/// Eight boxes by centre and half extents, along the axes of their node.
#[derive(Clone, Copy)]
pub(crate) struct Boxes<L: Lanes> {
    pub center: V8<L>,
    pub half: V8<L>,
}

impl<L: Lanes> Boxes<L> {
    /// The children of `node`, whose unit has the length `scale`.
    #[inline(always)]
    pub(crate) fn children(lanes: L, node: &Node, scale: f32) -> Self {
        let scale = F8::splat(lanes, scale);
        Self {
            center: per_axis!(k => F8::read(lanes, &node.center[k]) * scale),
            half: per_axis!(k => F8::read(lanes, &node.half[k]) * scale),
        }
    }

    /// Multiplies the half extents by `factor`.
    #[inline(always)]
    pub(crate) fn swollen(self, lanes: L, factor: f32) -> Self {
        Self {
            half: per_axis!(k => self.half[k] * F8::splat(lanes, factor)),
            ..self
        }
    }

    #[inline(always)]
    pub(crate) fn slabs(&self) -> Slabs<L> {
        Slabs {
            along: per_axis!(k => self.center[k] + self.half[k]),
            against: per_axis!(k => self.half[k] - self.center[k]),
        }
    }

    /// Bounding boxes of these boxes along the axes of the other side.
    #[inline(always)]
    pub(crate) fn seen(&self, lanes: L, view: &View) -> Self {
        let [x, y, z] = per_axis!(k => self.seen_along(lanes, view, k));
        Self {
            center: [x.0, y.0, z.0],
            half: [x.1, y.1, z.1],
        }
    }

    /// Centers and half extents along axis `k` of the other side.
    #[inline(always)]
    pub(crate) fn seen_along(&self, lanes: L, view: &View, k: usize) -> (F8<L>, F8<L>) {
        let row = per_axis!(j => F8::splat(lanes, view.columns[j].as_array()[k]));
        let center = dot(row, self.center) + F8::splat(lanes, view.origin.as_array()[k]);
        let half = dot(per_axis!(j => row[j].abs()), self.half);
        (center, half + F8::splat(lanes, view.margin.as_array()[0]))
    }
}

/// Eight boxes by their upper ends on three axes, and the negatives of their lower ends. Depths
/// are sums of both, which, unlike differences, can take either operand from memory.
#[derive(Clone, Copy)]
pub(crate) struct Slabs<L: Lanes> {
    pub along: V8<L>,
    pub against: V8<L>,
}

impl<L: Lanes> Slabs<L> {
    /// A box given by its ends, eight times.
    #[inline(always)]
    pub(crate) fn of(lanes: L, along: [f32; 3], against: [f32; 3]) -> Self {
        Self {
            along: per_axis!(k => F8::splat(lanes, along[k])),
            against: per_axis!(k => F8::splat(lanes, against[k])),
        }
    }

    /// A box given by centre and half extents, eight times.
    #[inline(always)]
    pub(crate) fn of_box(lanes: L, center: f32x4, half: f32x4) -> Self {
        Self::of(lanes, xyz(center + half), xyz(half - center))
    }

    /// Overlap depth of the boxes of each lane, axis by axis; negative means a gap.
    #[inline(always)]
    pub(crate) fn depths(&self, other: &Self) -> V8<L> {
        per_axis!(k => (self.along[k] + other.against[k]).min(other.along[k] + self.against[k]))
    }

    /// The least of the depths along the axes.
    #[inline(always)]
    pub(crate) fn depth(&self, other: &Self) -> F8<L> {
        let [x, y, z] = self.depths(other);
        x.min(y).min(z)
    }
}

/// [`Slabs`], stored for access one at a time.
#[derive(Clone, Copy, Default)]
pub(crate) struct Stored {
    pub along: [[f32; 8]; 3],
    pub against: [[f32; 8]; 3],
}

impl Stored {
    #[inline(always)]
    pub fn put<L: Lanes>(&mut self, boxes: &Slabs<L>) {
        per_axis!(k => boxes.along[k].put(&mut self.along[k]));
        per_axis!(k => boxes.against[k].put(&mut self.against[k]));
    }

    #[inline(always)]
    pub fn load<L: Lanes>(&self, lanes: L) -> Slabs<L> {
        Slabs {
            along: per_axis!(k => F8::load(lanes, &self.along[k])),
            against: per_axis!(k => F8::load(lanes, &self.against[k])),
        }
    }

    /// Box `i`, eight times.
    #[inline(always)]
    pub fn at<L: Lanes>(&self, lanes: L, i: usize) -> Slabs<L> {
        Slabs::of(
            lanes,
            per_axis!(k => self.along[k][i]),
            per_axis!(k => self.against[k][i]),
        )
    }
}

/// Boxes of a node: along its own axes, and along those of the other node. If the question has one
/// more direction, also their ends along it, such that two of them sum to a depth.
#[derive(Clone, Copy)]
pub(crate) struct Extents<L: Lanes> {
    pub own: Slabs<L>,
    pub seen: Slabs<L>,
    pub ahead: F8<L>,
}

/// [`Extents`] of eight boxes, stored for access one at a time.
#[derive(Default)]
pub(crate) struct StoredExtents {
    own: Stored,
    seen: Stored,
    ahead: [f32; 8],
}

impl StoredExtents {
    #[inline(always)]
    pub(crate) fn of<L: Lanes>(boxes: &Extents<L>) -> Self {
        let mut stored = Self::default();
        stored.own.put(&boxes.own);
        stored.seen.put(&boxes.seen);
        boxes.ahead.put(&mut stored.ahead);
        stored
    }

    #[inline(always)]
    pub(crate) fn load<L: Lanes>(&self, lanes: L) -> Extents<L> {
        Extents {
            own: self.own.load(lanes),
            seen: self.seen.load(lanes),
            ahead: F8::load(lanes, &self.ahead),
        }
    }

    /// Box `i`, eight times.
    #[inline(always)]
    pub(crate) fn at<L: Lanes>(&self, lanes: L, i: usize) -> Extents<L> {
        Extents {
            own: self.own.at(lanes, i),
            seen: self.seen.at(lanes, i),
            ahead: F8::splat(lanes, self.ahead[i]),
        }
    }
}

/// A vector, eight times.
#[inline(always)]
pub(crate) fn splat<L: Lanes>(lanes: L, v: f32x4) -> V8<L> {
    per_axis!(k => F8::splat(lanes, v.as_array()[k]))
}

/// Two nodes, each with its view from the other and the length of its unit in A's units. Children
/// of the first, the opened node, are rows of a table of pairs; those of the other are columns.
#[derive(Clone, Copy)]
pub(crate) struct Facing<'n> {
    pub nodes: [&'n Node; 2],
    pub views: [&'n View; 2],
    pub scales: [f32; 2],
    /// True if the first node is of A.
    pub is_a: bool,
}

impl Facing<'_> {
    /// True if node `k` is of A.
    #[inline(always)]
    pub(crate) fn is_of_a(&self, k: usize) -> bool {
        self.is_a == (k == 0)
    }

    /// The own box of node `k`: centre and half extents, in A's units.
    #[inline(always)]
    pub(crate) fn own(&self, k: usize) -> (f32x4, f32x4) {
        let (node, scale) = (self.nodes[k], f32x4::splat(self.scales[k]));
        (node.own_center * scale, node.own_half * scale)
    }

    /// The boxes of the children of node `k`.
    #[inline(always)]
    pub(crate) fn children<L: Lanes>(&self, lanes: L, k: usize) -> Boxes<L> {
        Boxes::children(lanes, self.nodes[k], self.scales[k])
    }
}

/// Triangles of a leaf, and their view from the other node.
pub(crate) struct Triangles<'t> {
    pub rows: [&'t Rows; WIDTH],
    pub view: View,
    pub rotation_error: f32,
}

#[cfg(test)]
mod tests;
